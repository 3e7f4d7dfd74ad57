#!/usr/bin/env python3
"""A vortex that a shock runs over, Tremie beside AMRClaw on this machine: writes its part of BENCHMARKS.md.

    python3 tests/performance/compare_gas.py --tremie target/release/tremie

AMRClaw comes with clawpack's sources, which are fetched and compiled into a folder of their own (--peers); that needs gfortran.
Both programs compute the same inviscid gas, each at several spacings of its finest points and tolerances of its adaptive grid, on
one thread.  The error is that of the density at the end, against a run of AMRClaw with four times as many points as the finest of the cases.
"""

import argparse
import json
import math
import os
import re
import shutil
import statistics
import subprocess
import sys
import tarfile
import tempfile
import zlib
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parent.parent
TITLE = "## A shock that runs over a vortex"
PACKAGES = ["clawpack==5.13.0", "numpy==2.2.6"]

# Units: density and speed of sound ahead of the shock are 1. The domain is 2 by 1.
MACH, SHOCK, CENTRE, RADIUS, SPEED, END = 1.5, 0.4, 0.9, 0.1, 0.5, 0.6
PRESSURE = 1 / 1.4
# Where the densities are compared: 512 by 512 points about the vortex and the shock.
LEFT, RIGHT, SAMPLES = 0.5, 1.5, 512

# Finest spacing, and what each program holds against its threshold.
TREMIE = [(h, t) for h in (64, 128, 256) for t in (1e-2, 3e-3)]
PEER = [(h, t) for h in (64, 128, 256) for t in (0.03, 0.01)]
# The reference, for which AMRClaw takes a quarter of an hour.
FINEST = (1024, 0.01)


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tremie", type=Path, default=ROOT / "target/release/tremie", help="the program")
    parser.add_argument("--peers", type=Path, default=ROOT / "target/peers-gas", help="folder for the peer")
    parser.add_argument("--repeats", type=int, default=2, help="runs of each, in turns; the faster counts")
    parser.add_argument("--report", type=Path, default=Path(__file__).with_name("BENCHMARKS.md"))
    return parser.parse_args()


def environment(options):
    """A Python with numpy: this one, or one of the peer's folder, which then runs this script."""
    home = options.peers.absolute()
    python = home / "bin/python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", str(home)], check=True)
        subprocess.run([str(python), "-m", "pip", "install", "--quiet", PACKAGES[1]], check=True)
    if Path(sys.prefix).resolve() != home.resolve():
        os.execv(str(python), [str(python), *sys.argv])


QINIT = f"""
       subroutine qinit(meqn,mbc,mx,my,xlower,ylower,dx,dy,q,maux,aux)
       implicit double precision (a-h,o-z)
       dimension q(meqn, 1-mbc:mx+mbc, 1-mbc:my+mbc)
       dimension aux(*)
       common /cparam/  gamma
       g1 = gamma - 1.d0
       p0 = {PRESSURE!r}d0
       s = {MACH}d0**2
       dens = (gamma+1.d0)*s/(g1*s+2.d0)
       u1 = {MACH}d0*(1.d0-1.d0/dens)
       p1 = p0*(1.d0+2.d0*gamma/(gamma+1.d0)*(s-1.d0))
       do 15 i=1,mx
          x = xlower + (i-0.5d0)*dx
          do 15 j=1,my
             y = ylower + (j-0.5d0)*dy
             a = (x-{CENTRE}d0)/{RADIUS}d0
             b = (y-0.5d0)/{RADIUS}d0
             f = dexp(1.d0-a*a-b*b)
             c = 1.d0-0.5d0*g1*{SPEED}d0**2*f
             rho = c**(1.d0/g1)
             u = -{SPEED}d0*b*dsqrt(f)
             v = {SPEED}d0*a*dsqrt(f)
             p = p0*c**(gamma/g1)
             if (x .lt. {SHOCK}d0) then
                rho = dens
                u = u1
                v = 0.d0
                p = p1
             endif
             q(1,i,j) = rho
             q(2,i,j) = rho*u
             q(3,i,j) = rho*v
             q(4,i,j) = p/g1 + 0.5d0*rho*(u*u+v*v)
   15  continue
       return
       end
"""


class Peer:
    """AMRClaw, compiled for this case."""

    def __init__(self, options):
        self.home = options.peers.absolute()
        self.claw = self.home / PACKAGES[0].replace("==", "-")
        self.case = self.home / "case"
        if not self.claw.exists():
            words = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "-d", str(self.home), PACKAGES[0]]
            subprocess.run(words, check=True)
            tarfile.open(self.claw.with_name(self.claw.name + ".tar.gz")).extractall(self.home)
        if not (self.case / "xamr").exists():
            shutil.copytree(self.claw / "amrclaw/examples/euler_2d_quadrants", self.case, dirs_exist_ok=True)
            (self.case / "qinit.f").write_text(QINIT)
            subprocess.run(["make", ".exe"], cwd=self.case, env={**self.environment(), "FC": "gfortran", "FFLAGS": "-O3 -march=native"}, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def environment(self):
        return {**os.environ, "CLAW": str(self.claw), "PYTHONPATH": str(self.claw), "OMP_NUM_THREADS": "1"}

    def run(self, finest, tolerance):
        """Seconds, density at the samples, and cells in use at the end over those of the whole finest grid."""
        levels, coarsest = int(math.log2(finest / 32)) + 1, 32
        script = f"""
import sys
sys.path.insert(0, {str(self.case)!r})
from setrun import setrun
d = setrun()
c, a = d.clawdata, d.amrdata
c.lower, c.upper, c.num_cells = [0, 0], [2, 1], [{2 * coarsest}, {coarsest}]
c.num_output_times, c.tfinal, c.output_t0, c.output_format = 1, {END}, False, "binary64"
c.bc_lower, c.bc_upper = ["extrap", "wall"], ["extrap", "wall"]
c.dt_initial = 1e-4
a.amr_levels_max = {levels}
ratios = [2] * {levels - 1}
a.refinement_ratios_x = a.refinement_ratios_y = a.refinement_ratios_t = ratios
a.flag2refine_tol = {tolerance}
d.gaugedata.gauges = []
d.write()
"""
        for old in self.case.glob("fort.*"):
            old.unlink()
        subprocess.run([sys.executable, "-c", script], cwd=self.case, env=self.environment(), check=True, stdout=subprocess.DEVNULL)
        told = subprocess.run([str(self.case / "xamr")], cwd=self.case, env=self.environment(), capture_output=True, text=True)
        if told.returncode != 0:
            sys.exit(told.stdout[-2000:] + told.stderr[-2000:])
        timing = (self.case / "timing.txt").read_text()
        seconds = float(re.findall(r"Total time:\s+(\S+)", timing)[0])
        return seconds, *self.density(finest)

    def density(self, finest):
        import numpy

        head = (self.case / "fort.q0001").read_text().split()
        data = numpy.fromfile(self.case / "fort.b0001")
        fields, ghosts = 4, 2
        values = numpy.full((SAMPLES, SAMPLES), numpy.nan)
        level_at = numpy.zeros((SAMPLES, SAMPLES), int)
        numbers = [float(word) for word in head if re.fullmatch(r"[-+.\dEe]+", word)]
        at = cells = 0
        for k in range(0, len(numbers), 8):
            _, level, mx, my, x0, y0, dx, dy = numbers[k : k + 8]
            mx, my = int(mx), int(my)
            size = fields * (mx + 2 * ghosts) * (my + 2 * ghosts)
            rho = data[at : at + size].reshape(my + 2 * ghosts, mx + 2 * ghosts, fields)[:, :, 0]
            at += size
            # Cells that finer ones cover are not in use.
            cells += mx * my - (mx * my / 4 if level > 1 else 0)
            i = numpy.nonzero((XS >= x0) & (XS < x0 + mx * dx))[0]
            j = numpy.nonzero((YS >= y0) & (YS < y0 + my * dy))[0]
            if len(i) and len(j):
                found = bilinear(rho, (XS[i] - x0) / dx - 0.5 + ghosts, (YS[j] - y0) / dy - 0.5 + ghosts)
                place = numpy.ix_(j, i)
                better = level_at[place] < level
                values[place] = numpy.where(better, found, values[place])
                level_at[place] = numpy.where(better, level, level_at[place])
        return values, cells / (2 * finest * finest)


def bilinear(rho, x, y):
    import numpy

    i, j = x.astype(int), y.astype(int)
    f, g = (x - i)[None, :], (y - j)[:, None]
    at = lambda dj, di: rho[numpy.ix_(numpy.minimum(j + dj, rho.shape[0] - 1), numpy.minimum(i + di, rho.shape[1] - 1))]
    return (1 - g) * ((1 - f) * at(0, 0) + f * at(0, 1)) + g * ((1 - f) * at(1, 0) + f * at(1, 1))


def tremie(options, folder, finest, tolerance):
    """Seconds, density at the samples, and points in use at the end over those of the whole finest grid."""
    import numpy

    out, path = Path(folder) / "out", Path(folder) / "vortex.toml"
    shutil.rmtree(out, ignore_errors=True)
    path.write_text(f"""
[run]
until = "{END} s"

[scene.domain]
size = ["2 m", "1 m", "1 m"]
across = "y"
x = {{ lower = {{ pressure = "0 Pa", outflow = "absorbing" }}, upper = {{ pressure = "0 Pa", outflow = "absorbing" }} }}
z = "symmetry"

[scene.fluid]
density = "1 kg/m3"
viscosity = "1 uPa s"

[scene.fluid.gas]
pressure = "{PRESSURE!r} Pa"
temperature = "1 K"
sutherland = "0.368 K"
shock = {{ axis = "x", position = "{SHOCK} m", mach = {MACH} }}
vortex = {{ axis = "y", centre = ["{CENTRE} m", "0 m", "0.5 m"], radius = "{RADIUS} m", speed = "-{SPEED} m/s" }}

[components]
fluid = {{ program = "fluid-wavelet", threads = 1 }}
fields = "fields"

[settings.fluid-wavelet]
cell = "{1 / finest!r} m"
inviscid = true
tolerance = {tolerance!r}

[settings.fields]
compression = "none"

[outputs]
record = false
frames = "{END} s"
signals = "{END} s"
""")
    told = subprocess.run([str(options.tremie), "run", str(path), "--out", str(out), "--quiet"], capture_output=True, text=True)
    if told.returncode != 0:
        sys.exit(told.stdout[-2000:] + told.stderr[-2000:])
    summary = json.loads((out / "summary.json").read_text())
    file = sorted((out / "fields").glob("*.vti"))[-1]
    data = file.read_bytes()
    begin = data.index(b"_", data.index(b'<AppendedData encoding="raw">')) + 1
    text = data[:begin].decode()
    kind, offset = re.search(r'<DataArray type="Float(\d+)" Name="density"[^>]* offset="(\d+)"', text).groups()
    counts = [int(word) + 1 for word in re.search(r'WholeExtent="([^"]*)"', text).group(1).split()[1::2]]
    origin, spacing = ([float(word) for word in re.search(rf'{name}="([^"]*)"', text).group(1).split()] for name in ("Origin", "Spacing"))
    rho = numpy.frombuffer(data, f"<f{int(kind) // 8}", math.prod(counts), begin + int(offset) + 8).reshape(counts[2], counts[1], counts[0])[:, 0, :]
    values = bilinear(rho, (XS - origin[0]) / spacing[0], (YS - origin[2]) / spacing[2])
    return summary["components"]["fluid"]["compute"], values, summary["signals"]["fluid.share_of_points"]["last"]


def compare(options, folder):
    import numpy

    global XS, YS
    XS = LEFT + (numpy.arange(SAMPLES) + 0.5) / SAMPLES * (RIGHT - LEFT)
    YS = (numpy.arange(SAMPLES) + 0.5) / SAMPLES
    peer = Peer(options)
    programs = {"AMRClaw": (PEER, peer.run), "Tremie": (TREMIE, lambda h, t: tremie(options, folder, h, t))}
    # It takes long, and is kept from one call to the next.
    kept = peer.home / f"AMRClaw-{FINEST[0]}-{FINEST[1]}-{zlib.crc32(QINIT.encode()):08x}.npy"
    if not kept.exists():
        numpy.save(kept, peer.run(*FINEST)[1])
    reference = numpy.load(kept)
    rows = []
    for k in range(len(TREMIE)):
        took, found = {name: [] for name in programs}, {}
        for _ in range(options.repeats):
            for name, (cases, run) in programs.items():
                seconds, *found[name] = run(*cases[k])
                took[name].append(seconds)
        for name, (cases, _) in programs.items():
            values, share = found[name]
            error = float(abs(values - reference).mean())
            rows.append({"program": name, "finest": cases[k][0], "tolerance": cases[k][1], "seconds": min(took[name]), "error": error, "share": share})
            print(json.dumps(rows[-1]), flush=True)
    return rows


def at_equal_error(rows):
    """Time of AMRClaw over Tremie's at the same error, where both have one: along the fastest cases of each."""
    def front(name):
        points = sorted((row["error"], row["seconds"]) for row in rows if row["program"] == name)
        best, kept = math.inf, []
        for error, seconds in points:
            if seconds < best:
                best = seconds
                kept.append((error, seconds))
        return kept

    mine, peers = front("Tremie"), front("AMRClaw")
    found = []
    for error, seconds in mine:
        for (e0, s0), (e1, s1) in zip(peers, peers[1:]):
            if e0 <= error <= e1:
                part = math.log(error / e0) / math.log(e1 / e0)
                found.append((error, seconds, math.exp(math.log(s0) + part * math.log(s1 / s0))))
    return found


def report(options, rows):
    times = "one run of each," if options.repeats == 1 else f"the fastest of {options.repeats} runs of each,"
    lines = [
        TITLE, "",
        f"Written by `python3 tests/performance/compare_gas.py`. A shock of Mach {MACH} runs over a vortex without change of entropy, of radius",
        f"{RADIUS} and speed {SPEED} in units of the sound's speed, in inviscid gas; a domain of 2 by 1. Tremie on adaptive wavelets beside AMRClaw ({PACKAGES[0].replace('==', ' ')}), which",
        "refines by factors of 2 from 32 cells across the domain, with its own Roe solver and limiter (MC), compiled by gfortran -O3 for this processor. One thread;",
        f"{times} in turns. The tolerance is each program's own. The error is the mean of that of the density over {SAMPLES} x {SAMPLES} points",
        f"about vortex and shock, against a run of AMRClaw with {FINEST[0]} points across (tolerance {FINEST[1]:g}). Shares of points in use are of the whole",
        "finest grid.", "",
        "| program | finest points across | tolerance | share of points in use | time [s] | error |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for row in sorted(rows, key=lambda row: (row["program"], row["finest"], -row["tolerance"])):
        lines.append(f"| {row['program']} | {row['finest']} | {row['tolerance']:g} | {100 * row['share']:.1f} % | {row['seconds']:.2f} | {row['error']:.2e} |")
    lines += ["", "At equal error, by the fastest cases of each (AMRClaw's time between two of its own by powers):", ""]
    lines += ["| error | Tremie [s] | AMRClaw [s] | ratio |", "| --- | --- | --- | --- |"]
    for error, mine, other in at_equal_error(rows):
        lines.append(f"| {error:.2e} | {mine:.2f} | {other:.2f} | {other / mine:.2f} |")
    text = options.report.read_text() if options.report.exists() else "# Benchmarks\n"
    before, _, after = text.partition(TITLE)
    _, mark, rest = after.partition("\n## ")
    options.report.write_text(before.rstrip() + "\n\n" + "\n".join(lines) + "\n" + (mark + rest if mark else ""))


def main():
    options = arguments()
    environment(options)
    with tempfile.TemporaryDirectory() as folder:
        report(options, compare(options, folder))


if __name__ == "__main__":
    main()
