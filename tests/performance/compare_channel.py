#!/usr/bin/env python3
"""Beads in a channel with a hopper, Tremie beside LIGGGHTS on this machine: writes its part of BENCHMARKS.md.

    python3 tests/performance/compare_channel.py --tremie target/release/tremie

LIGGGHTS is Debian's (apt-get install liggghts).  Tremie makes the start: beads packed over the open slit, at rest.  From it
both programs go on with the same springs, dashpots, friction and time step.  What leaves the slit is lost.  Profiles across the
channel are means over places and time: those of Tremie from its own tables, those of LIGGGHTS from its dumps.  Then both run
again, in turns, without any output, for the speed.
"""

import argparse
import csv
import json
import math
import os
import re
import shutil
import statistics
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parent.parent.parent
TITLE = "## A channel with a hopper"

# SI units. The scene of tests/validation/vertical-channel, without recycling and with more beads above the slit.
WIDTH, DEPTH, TOP, BED, EXIT, SLIT = 0.05, 0.009, 0.40, 0.38, 0.04, 0.013
ANGLE = math.radians(49.4)
GRAVITY, DENSITY, STIFFNESS, FRICTION, RESTITUTION = 9.81, 2600.0, 1e4, 0.092, 0.97
STEPS_PER_CONTACT = 15
SKIN, PEER_SKINS = 0.3, [0.0003, 0.0006, 0.0009]
# Profiles begin when the beads flow.
SETTLED, LENGTH = 0.1, 0.4
# Where the profiles are taken: heights, and bins across.
LOW, HIGH, BINS = 0.12, 0.18, 11
SAMPLE = 0.005
WINDOW = 50
# Part of its sliding that a contact without history may lose in a step, in Tremie: 1/4 of the mass of the sliding, 2/7 m*.
TANGENTIAL = 0.25 * 2 / 7


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tremie", type=Path, default=ROOT / "target/release/tremie", help="the program")
    parser.add_argument("--liggghts", default="liggghts", help="the peer")
    parser.add_argument("--threads", type=int, nargs="+", default=sorted({1, os.cpu_count() or 1}))
    parser.add_argument("--repeats", type=int, default=3, help="pairs of measurements")
    parser.add_argument("--steps", type=int, default=3000, help="steps that are timed")
    parser.add_argument("--report", type=Path, default=Path(__file__).with_name("BENCHMARKS.md"))
    return parser.parse_args()


def collision(mass):
    """Time of a collision of a reduced mass, and its dashpot over that mass."""
    log = math.log(RESTITUTION)
    rate = math.sqrt(STIFFNESS / mass)
    return math.sqrt(math.pi**2 + log**2) / rate, -2 * log * rate / math.sqrt(math.pi**2 + log**2)


BEAD = DENSITY * math.pi / 6 * 0.003**3
STEP = collision(BEAD * (2.872 / 3) ** 3 / 2)[0] / STEPS_PER_CONTACT


def manifest(bodies, until, threads, profiles=False, frames=None):
    text = f"""[run]
until = "{until!r} s"

[scene]
gravity = ["0 m/s2", "-{GRAVITY} m/s2", "0 m/s2"]

[scene.domain]
size = ["{WIDTH} m", "{TOP} m", "{DEPTH} m"]
z = "periodic"
material = "glass"

[scene.materials.glass]
density = "{DENSITY} kg/m3"

[[scene.hoppers]]
name = "outlet"
flow = "-y"
across = "x"
angle = "{math.degrees(ANGLE)} deg"
slit = "{SLIT} m"
exit = "{EXIT} m"

[[scene.outlets]]
name = "below"
beyond = {{ axis = "y", at = "0.01 m", side = "lower" }}

[[scene.probes]]
name = "slit"
section = {{ axis = "y", at = "{EXIT - 0.01} m" }}

[[scene.contacts]]
normal_stiffness = "{STIFFNESS} N/m"
friction = {FRICTION}
friction_history = false
restitution = {RESTITUTION}

[components]
grains = {{ program = "grains-dem", threads = {threads}, sync_iter = {WINDOW} }}
{'fields = "fields"' if frames else ''}

[settings.grains-dem]
time_step = "{STEP!r} s"
expected_speed = "1.2 m/s"
skin = {SKIN}
"""
    if profiles:
        text += f"""
[[scene.profiles]]
name = "across"
along = ["x"]
bins = [{BINS}]
min = ["0 m", "{LOW} m", "0 m"]
max = ["{WIDTH} m", "{HIGH} m", "{DEPTH} m"]
from = "{SETTLED} s"
every = "{SAMPLE} s"
"""
    if frames:
        text += '\n[settings.fields]\ncompression = "none"\n'
    text += f'\n[outputs]\nrecord = false\nsignals = "{SAMPLE} s"\nframes = "{frames or SAMPLE} s"\n'
    return text + bodies


PACKING = f"""
[[scene.bodies]]
name = "beads"
material = "glass"
packing = {{ min = ["0 m", "0.045 m", "0 m"], max = ["{WIDTH} m", "{BED} m", "{DEPTH} m"], fraction = 0.56, diameters = {{ normal = {{ mean = "3 mm", deviation = "0.064 mm", min = "2.872 mm", max = "3.128 mm" }} }} }}
"""


def tremie(options, folder, text):
    """Runs a manifest and gives the folder of its outputs."""
    path, out = Path(folder) / "channel.toml", Path(folder) / "out"
    shutil.rmtree(out, ignore_errors=True)
    path.write_text(text)
    told = subprocess.run([str(options.tremie), "run", str(path), "--out", str(out), "--quiet"], capture_output=True, text=True)
    if told.returncode != 0:
        sys.exit(told.stdout[-2000:] + told.stderr[-2000:])
    return out


def read_beads(path):
    """Radius, position, velocity and angular velocity of all bodies in a file of VTK without compression."""
    data = path.read_bytes()
    begin = data.index(b"_", data.index(b'<AppendedData encoding="raw">')) + 1
    arrays = {}
    for name, offset in re.findall(rb'<DataArray type="Float64" Name="(\w+)"[^>]* offset="(\d+)"', data[:begin]):
        at = begin + int(offset)
        (size,) = struct.unpack_from("<Q", data, at)
        arrays[name.decode()] = struct.unpack_from(f"<{size // 8}d", data, at + 8)
    threes = lambda name: [arrays[name][3 * k : 3 * k + 3] for k in range(len(arrays[name]) // 3)]
    return list(zip(arrays["radius"], threes("points"), threes("velocity"), threes("angular_velocity")))


def listed(beads):
    vector = lambda values, unit: "[" + ", ".join(f'"{v!r} {unit}"' for v in values) + "]"
    rows = [
        f'{{ position = {vector(x, "m")}, diameter = "{2 * r!r} m", velocity = {vector(v, "m/s")}, angular_velocity = {vector(w, "rad/s")} }},'
        for r, x, v, w in beads
    ]
    return '\n[[scene.bodies]]\nname = "beads"\nmaterial = "glass"\nspheres = [\n' + "\n".join(rows) + "\n]\n"


def data_file(beads):
    """The start in LIGGGHTS' format."""
    lines = ["beads", "", f"{len(beads)} atoms", "2 atom types", "", f"-0.001 {WIDTH + 0.001} xlo xhi", f"-0.001 {TOP} ylo yhi", f"0 {DEPTH} zlo zhi", "", "Atoms", ""]
    lines += [f"{k} 1 {2 * r!r} {DENSITY} {x[0]!r} {x[1]!r} {x[2] % DEPTH!r}" for k, (r, x, _, _) in enumerate(beads, 1)]
    lines += ["", "Velocities", ""]
    lines += [f"{k} " + " ".join(repr(c) for c in (*v, *w)) for k, (_, _, v, w) in enumerate(beads, 1)]
    return "\n".join(lines) + "\n"


def walls_file():
    """The hopper's two walls as triangles: small ones, and none on a periodic face, else Debian's LIGGGHTS stops with an assertion."""
    rise, along, across = (WIDTH - SLIT) / 2 * math.tan(ANGLE), 6, 2
    text = "solid hopper\n"
    for outer, inner in [(0.0, (WIDTH - SLIT) / 2), (WIDTH, (WIDTH + SLIT) / 2)]:
        at = lambda a, b: (outer + (inner - outer) * a / along, EXIT + rise * (1 - a / along), 1e-6 + (DEPTH - 2e-6) * b / across)
        for a in range(along):
            for b in range(across):
                corners = at(a, b), at(a + 1, b), at(a + 1, b + 1), at(a, b + 1)
                for triangle in [corners[:3], (corners[0], *corners[2:])]:
                    text += " facet normal 0 0 0\n  outer loop\n"
                    text += "".join(f"   vertex {x!r} {y!r} {z!r}\n" for x, y, z in triangle)
                    text += "  endloop\n endfacet\n"
    return text + "endsolid hopper\n"


def script(skin, runs):
    """The same scene for LIGGGHTS; its walls have infinite mass, as a second material."""
    pair, wall = (collision(mass)[1] for mass in (BEAD / 2, BEAD))
    model = "gran model hooke/stiffness tangential no_history"
    matrix = lambda a, b: f"2 {a!r} {b!r} {b!r} {a!r}"
    both = lambda name, a, b: f"fix {name} all property/global {name} peratomtypepair {matrix(a, b)}\n"
    return (
        "atom_style granular\natom_modify map array\nboundary f f p\nnewton off\ncommunicate single vel yes\nprocessors 1 * 1\n"
        f"units si\nread_data beads.data\nneighbor {skin} bin\nneigh_modify delay 0\n"
        + both("kn", STIFFNESS, STIFFNESS) + both("kt", STIFFNESS, STIFFNESS) + both("gamman", pair, wall)
        + both("gammat", TANGENTIAL / STEP, TANGENTIAL / STEP) + both("coefficientFriction", FRICTION, FRICTION)
        + f"pair_style {model}\npair_coeff * *\n"
        "fix hopper all mesh/surface file walls.stl type 2\n"
        f"fix inclined all wall/{model} mesh n_meshes 1 meshes hopper\n"
        f"fix left all wall/{model} primitive type 2 xplane 0.0\n"
        f"fix right all wall/{model} primitive type 2 xplane {WIDTH}\n"
        f"fix weight all gravity {GRAVITY} vector 0 -1 0\nfix motion all nve/sphere\ntimestep {STEP!r}\n"
        "thermo 100000\nthermo_modify lost ignore norm no\n" + runs
    )


def liggghts(options, folder, ranks, text):
    (Path(folder) / "in.channel").write_text(text)
    words = ["mpirun", "--allow-run-as-root", "--oversubscribe", "-np", str(ranks)] if ranks > 1 else []
    told = subprocess.run([*words, options.liggghts, "-in", "in.channel", "-log", "none"], cwd=folder, capture_output=True, text=True)
    if told.returncode != 0 or "ERROR" in told.stdout:
        sys.exit(told.stdout[-3000:] + told.stderr[-2000:])
    return told.stdout


def dumps(path):
    """Moments of a file of dumps: rows of id, x, y, vx, vy, radius."""
    moments, rows = [], None
    for line in path.read_text().splitlines():
        if line.startswith("ITEM: ATOMS"):
            rows = []
            moments.append(rows)
        elif line.startswith("ITEM"):
            rows = None
        elif rows is not None:
            rows.append([float(word) for word in line.split()])
    return moments


def profile_of_peer(moments):
    """Solid fraction, mean streamwise velocity and the two fluctuations by bins, as Tremie's profiles define them."""
    sums = [[0.0] * 6 for _ in range(BINS)]
    for rows in moments:
        for _, x, y, vx, vy, radius in rows:
            if LOW <= y < HIGH:
                row, mass = sums[min(int(x / WIDTH * BINS), BINS - 1)], radius**3
                for k, value in enumerate((1.0, vx, vy, vx * vx, vy * vy)):
                    row[k] += mass * value
    volume = len(moments) * WIDTH / BINS * (HIGH - LOW) * DEPTH
    profile = []
    for mass, ux, uy, xx, yy, _ in sums:
        u, v = ux / mass, uy / mass
        profile.append((4 / 3 * math.pi * mass / volume, v, math.sqrt(max(yy / mass - v * v, 0)), math.sqrt(max(xx / mass - u * u, 0))))
    return profile


def lost(moments):
    """Mass flow through the slit between first and last moment."""
    above = lambda rows: sum(4 / 3 * math.pi * DENSITY * row[5] ** 3 for row in rows if row[2] > EXIT - 0.01)
    return (above(moments[0]) - above(moments[-1])) / ((len(moments) - 1) * SAMPLE)


def mass_flow_of_tremie(out):
    """Mean over the run, from the mass that passed the section below the slit."""
    with open(out / "signals.csv") as file:
        rows = list(csv.DictReader(file))
    key = next(name for name in rows[0] if name.startswith("grains.slit.mass_passed"))
    time = next(name for name in rows[0] if name.startswith("time"))
    first = next(row for row in rows if float(row[time]) > SETTLED - 1e-9)
    return abs(float(rows[-1][key]) - float(first[key])) / (float(rows[-1][time]) - float(first[time]))


def profiles(options, folder, beads):
    """Both programs' profiles and mass flows."""
    threads = max(options.threads)
    out = tremie(options, folder, manifest(listed(beads), LENGTH, threads, profiles=True))
    with open(out / "profiles/across.csv") as file:
        rows = [{name.split(" ")[0]: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
    mine = [(row["solid_fraction"], row["velocity_y"], row["fluctuation_y"], row["fluctuation_x"]) for row in rows]
    every = round(SAMPLE / STEP)
    text = f"dump all all custom {every} dump.channel id x y vx vy radius\nrun {round(LENGTH / STEP)}\n"
    liggghts(options, folder, threads, script(max(PEER_SKINS), text))
    moments = dumps(Path(folder) / "dump.channel")[round(SETTLED / SAMPLE) :]
    return mine, profile_of_peer(moments[1:]), mass_flow_of_tremie(out), lost(moments)


def speeds(options, folder, beads):
    rows = []
    for threads in options.threads:
        def own():
            steps = options.steps
            out = tremie(options, folder, manifest(listed(beads), steps * STEP, threads))
            seconds = json.loads((out / "summary.json").read_text())["components"]["grains"]["compute"]
            return 1e-6 * len(beads) * steps / seconds

        def peer(skin):
            told = liggghts(options, folder, threads, script(skin, f"run {options.steps}\n"))
            return 1e-6 * len(beads) * options.steps / float(re.findall(r"Loop time of (\S+)", told)[-1])

        skin = max(PEER_SKINS, key=peer)
        pairs = [(own(), peer(skin)) for _ in range(options.repeats)]
        row = {"threads": threads, "skin": skin, "tremie": statistics.median(a for a, _ in pairs), "peer": statistics.median(b for _, b in pairs)}
        row["ratios"] = sorted(a / b for a, b in pairs)
        print(json.dumps(row), flush=True)
        rows.append(row)
    return rows


def report(options, count, found, rows):
    mine, peer, flow, of_peer = found
    version = re.findall(r"Version (\S+ \S+?)[,)]", subprocess.run([options.liggghts, "-h", "-log", "none"], cwd=tempfile.gettempdir(), capture_output=True, text=True).stdout)
    names = ["solid fraction", "speed down [cm/s]", "streamwise fluctuation [cm/s]", "transverse fluctuation [cm/s]"]
    scales = [1.0, -100.0, 100.0, 100.0]
    lines = [
        TITLE, "",
        f"Written by `python3 tests/performance/compare_channel.py`. {count:,} beads of 3 mm between smooth walls, in the reduced channel of",
        "[tests/validation/vertical-channel](tests/validation/vertical-channel), at 49.4 degrees. Both programs start from the same beads at rest, with the",
        f"same law: linear springs of {STIFFNESS:g} N/m, friction without history, {STEPS_PER_CONTACT} steps in the shortest collision. Means from {SETTLED} to {LENGTH} s over 60 mm of",
        f"height, in bins of one and a half diameters. {version[0] if version else 'LIGGGHTS of Debian'}.", "",
        "| x [mm] | " + " | ".join(f"{name} | LIGGGHTS" for name in names) + " |",
        "| --- |" + " --- | --- |" * len(names),
    ]
    for k, (a, b) in enumerate(zip(mine, peer)):
        cells = [f"{scale * value:.3g}" for pair, scale in zip(zip(a, b), scales) for value in pair]
        lines.append(f"| {1000 * WIDTH * (k + 0.5) / BINS:.1f} | " + " | ".join(cells) + " |")
    lines += ["", "| over all bins | mean of Tremie over that of LIGGGHTS | root mean square of the difference, of the mean |", "| --- | --- | --- |"]
    for k, name in enumerate(names):
        a, b = [row[k] for row in mine], [row[k] for row in peer]
        mean = sum(b) / BINS
        spread = math.sqrt(sum((x - y) ** 2 for x, y in zip(a, b)) / BINS) / abs(mean)
        lines.append(f"| {name.split(' [')[0]} | {sum(a) / sum(b):.3f} | {100 * spread:.1f} % |")
    lines += [f"| mass flow: {1000 * flow:.1f} and {1000 * of_peer:.1f} g/s | {flow / of_peer:.3f} | |", ""]
    lines += [
        "Between smooth walls the fluctuations are those of one plug whose speed changes in time, the same in all bins, of which the means hold a few",
        "swings. Runs of Tremie alone differ as much ([examples/vertical-channel](examples/vertical-channel/README.md)).", "",
    ]
    lines += [
        f"Speed in million bead-steps a second, median of {options.repeats} pairs in turn, over the first {options.steps} steps. LIGGGHTS lists neighbours as far beyond",
        "contact as is fastest for it (in brackets).", "",
        "| threads or ranks | Tremie | LIGGGHTS | ratio |", "| --- | --- | --- | --- |",
    ]
    for row in rows:
        low, middle, high = row["ratios"][0], statistics.median(row["ratios"]), row["ratios"][-1]
        lines.append(f"| {row['threads']} | {row['tremie']:.2f} | {row['peer']:.2f} ({1000 * row['skin']:g} mm) | {middle:.2f} ({low:.2f} to {high:.2f}) |")
    text = options.report.read_text() if options.report.exists() else "# Benchmarks\n"
    before, _, after = text.partition(TITLE)
    _, mark, rest = after.partition("\n## ")
    options.report.write_text(before.rstrip() + "\n\n" + "\n".join(lines) + "\n" + (mark + rest if mark else ""))


def main():
    options = arguments()
    with tempfile.TemporaryDirectory() as folder:
        out = tremie(options, folder, manifest(PACKING, WINDOW * STEP, max(options.threads), frames=WINDOW * STEP))
        beads = read_beads(min((out / "fields").glob("bodies_*.vtp")))
        (Path(folder) / "beads.data").write_text(data_file(beads))
        (Path(folder) / "walls.stl").write_text(walls_file())
        found = profiles(options, folder, beads)
        print(json.dumps(found), flush=True)
        report(options, len(beads), found, speeds(options, folder, beads))


if __name__ == "__main__":
    main()
