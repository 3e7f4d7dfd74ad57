#!/usr/bin/env python3
"""A column of water that collapses, Tremie beside OpenFOAM's interFoam on this machine, in turns: writes its part of BENCHMARKS.md.

    python3 tests/performance/compare_dam_break.py --tremie target/release/tremie

Needs interFoam and its examples (Debian's packages openfoam and openfoam-examples).  The case is the smooth-walled column of
Martin and Moyce, a = 57.15 mm wide and 2 a high: interFoam has the schemes and solvers of its own example `damBreak`, with
slip at the walls and a largest Courant number of 0.5; Tremie has its defaults.  Equal cells.  Times are those of whole programs but
for the mesh; each measurement of Tremie is followed by one of the peer.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parent.parent
TITLE = "## A column of water that collapses"
EXAMPLE = Path("/usr/share/doc/openfoam-examples/examples/multiphase/interFoam/laminar/damBreak/damBreak")
A = 0.05715
LENGTH, HEIGHT, UNTIL = 15, 2.5, 0.32
# Where the front is timed, and the experiment's time there.
FRONTS = [(4.134, 0.18053), (7.945, 0.30682)]
ROUNDS = 2
# Debian's package keeps its settings there.
os.environ.setdefault("WM_PROJECT_DIR", "/usr/share/openfoam")

HEADER = "FoamFile {{ version 2.0; format ascii; class {kind}; object {name}; }}\n"


def dictionary(path, kind, text):
    path.write_text(HEADER.format(kind=kind, name=path.name) + text)


def foam_case(folder, cells, threads):
    """The example's case, on our column."""
    shutil.copytree(EXAMPLE, folder, dirs_exist_ok=True)
    for packed in folder.rglob("*.gz"):
        subprocess.run(["gunzip", "-f", packed], check=True)
    # The example's own start, on its own mesh.
    (folder / "0" / "alpha.water.orig").unlink(missing_ok=True)
    x, z, h = LENGTH * A, HEIGHT * A, A / cells
    corners = [(0, 0, 0), (x, 0, 0), (x, z, 0), (0, z, 0), (0, 0, h), (x, 0, h), (x, z, h), (0, z, h)]
    vertices = " ".join(f"({a} {b} {c})" for a, b, c in corners)
    dictionary(folder / "system" / "blockMeshDict", "dictionary", f"""
scale 1; vertices ({vertices});
blocks (hex (0 1 2 3 4 5 6 7) ({LENGTH * cells} {int(HEIGHT * cells)} 1) simpleGrading (1 1 1));
edges (); mergePatchPairs ();
boundary (
  walls {{ type wall; faces ((0 4 7 3) (1 2 6 5) (0 1 5 4)); }}
  atmosphere {{ type patch; faces ((3 7 6 2)); }}
  sides {{ type empty; faces ((0 3 2 1) (4 5 6 7)); }}
);
""")
    dictionary(folder / "system" / "setFieldsDict", "dictionary", f"""
defaultFieldValues (volScalarFieldValue alpha.water 0);
regions (boxToCell {{ box (0 0 -1) ({A} {2 * A} 1); fieldValues (volScalarFieldValue alpha.water 1); }});
""")
    dictionary(folder / "system" / "controlDict", "dictionary", f"""
application interFoam; startFrom startTime; startTime 0; stopAt endTime; endTime {UNTIL}; deltaT 1e-4;
writeControl adjustableRunTime; writeInterval 0.01; purgeWrite 0; writeFormat ascii; writePrecision 6;
writeCompression off; timeFormat general; timePrecision 6; runTimeModifiable no; adjustTimeStep yes;
maxCo 0.5; maxAlphaCo 0.5; maxDeltaT 1;
""")
    dictionary(folder / "system" / "decomposeParDict", "dictionary", f"""
numberOfSubdomains {threads}; method simple; simpleCoeffs {{ n ({threads} 1 1); delta 0.001; }}
""")
    air = "atmosphere {{ type {0}; {1} }} sides {{ type empty; }}"
    (folder / "0").mkdir(exist_ok=True)
    dictionary(folder / "0" / "U", "volVectorField", f"""
dimensions [0 1 -1 0 0 0 0]; internalField uniform (0 0 0);
boundaryField {{ walls {{ type slip; }} {air.format("pressureInletOutletVelocity", "value uniform (0 0 0);")} }}
""")
    dictionary(folder / "0" / "p_rgh", "volScalarField", f"""
dimensions [1 -1 -2 0 0 0 0]; internalField uniform 0;
boundaryField {{ walls {{ type fixedFluxPressure; value uniform 0; }} {air.format("totalPressure", "p0 uniform 0;")} }}
""")
    dictionary(folder / "0" / "alpha.water", "volScalarField", f"""
dimensions [0 0 0 0 0 0 0]; internalField uniform 0;
boundaryField {{ walls {{ type zeroGradient; }} {air.format("inletOutlet", "inletValue uniform 0; value uniform 0;")} }}
""")
    for program in ["blockMesh", "setFields"] + (["decomposePar"] if threads > 1 else []):
        subprocess.run([program], cwd=folder, check=True, capture_output=True)


def foam(cells, threads):
    """Seconds of a run, and the times of the front [s]."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        foam_case(folder, cells, threads)
        command = ["interFoam"]
        if threads > 1:
            command = ["mpirun", "--allow-run-as-root", "-np", str(threads), "interFoam", "-parallel"]
        start = time.perf_counter()
        subprocess.run(command, cwd=folder, check=True, capture_output=True)
        took = time.perf_counter() - start
        if threads > 1:
            subprocess.run(["reconstructPar"], cwd=folder, check=True, capture_output=True)
        return took, passed(foam_fronts(folder, cells))


def foam_fronts(folder, cells):
    """Times, and the front in them, at half full cells."""
    fronts = []
    columns = LENGTH * cells
    for state in sorted((p for p in folder.iterdir() if re.fullmatch(r"[\d.]+", p.name)), key=lambda p: float(p.name)):
        text = (state / "alpha.water").read_text()
        values = re.search(r"nonuniform List<scalar>\s*\d+\s*\((.*?)\)", text, re.DOTALL)
        if values:
            wet = [k % columns for k, value in enumerate(values[1].split()) if float(value) > 0.5]
            fronts.append((float(state.name), (max(wet) + 1) / cells))
    return fronts


def passed(fronts):
    """Times at which the front passes the places, linear between the states."""
    found = []
    for place, _ in FRONTS:
        for (t0, x0), (t1, x1) in zip(fronts, fronts[1:]):
            if x0 < place <= x1:
                found.append(t0 + (t1 - t0) * (place - x0) / (x1 - x0))
                break
    return found


MANIFEST = """
[run]
until = "{until} s"
[scene]
gravity = ["0 m/s2", "0 m/s2", "-9.81 m/s2"]
[scene.domain]
size = ["{x} m", "{a} m", "{z} m"]
across = "y"
[scene.fluid]
density = "1000 kg/m3"
viscosity = "1 mPa s"
fill = [{{ max = ["{a} m", "{a} m", "{b} m"] }}]
[components]
fluid = {{ program = "fluid-pic", threads = {threads} }}
[settings.fluid-pic]
cell = "{h} m"
[outputs]
signals = "2 ms"
"""


def own(tremie, cells, threads):
    with tempfile.TemporaryDirectory() as name:
        manifest = Path(name) / "manifest.toml"
        manifest.write_text(MANIFEST.format(
            until=UNTIL, threads=threads, x=LENGTH * A, z=HEIGHT * A, a=A, b=2 * A, h=A / cells
        ))
        start = time.perf_counter()
        subprocess.run([tremie, "run", manifest, "--out", Path(name) / "run"], check=True, capture_output=True)
        took = time.perf_counter() - start
        lines = (Path(name) / "run" / "signals.csv").read_text().splitlines()
        head = lines[0].split(",")
        time_at, front_at = (next(k for k, h in enumerate(head) if h.startswith(name)) for name in ("time", "fluid.farthest_x"))
        rows = [line.split(",") for line in lines[1:]]
        return took, passed([(float(row[time_at]), float(row[front_at]) / A) for row in rows])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tremie", type=Path, default=ROOT / "target" / "release" / "tremie")
    parser.add_argument("--cells", type=int, nargs="+", default=[20, 40], help="cells across the column")
    parser.add_argument("--out", type=Path, default=Path(__file__).with_name("BENCHMARKS.md"), help="file whose section is written")
    arguments = parser.parse_args()
    if shutil.which("interFoam") is None or not EXAMPLE.exists():
        sys.exit("interFoam or its examples are missing: apt-get install openfoam openfoam-examples")
    version = re.search(r"Version:\s*(\S+)", (EXAMPLE / "system" / "fvSchemes").read_text())[1]
    lines = []
    for cells in arguments.cells:
        for threads in (1, 2):
            pairs = [(own(arguments.tremie, cells, threads), foam(cells, threads)) for _ in range(ROUNDS)]
            (ours, front), (theirs, other) = (min(pair[k] for pair in pairs) for k in (0, 1))
            times = " | ".join(f"{f:.3f} | {o:.3f}" for f, o in zip(front, other))
            lines.append(f"| {cells} | {threads} | {ours:.1f} | {theirs:.1f} | {theirs / ours:.1f} | {times} |")
    experiment = " and ".join(f"{time:.3f} s" for _, time in FRONTS)
    text = f"""{TITLE}

Written by `python3 tests/performance/compare_dam_break.py`: the column of Martin and Moyce (1952), a = 57.15 mm, to {UNTIL} s, with
Tremie's particle fluid and with OpenFOAM's interFoam ({version}) in the settings of its own example `damBreak`, slip at the walls and a
largest Courant number of 0.5. Equal cells; interFoam computes the air as well. The fronts pass 4.134 a and 7.945 a; in the
experiment at {experiment}. Whole programs but for the mesh; the faster of {ROUNDS} rounds in turns.

| cells across a | threads | Tremie [s] | interFoam [s] | ratio | front at 4.134 a [s] | interFoam | front at 7.945 a [s] | interFoam |
|---:|---:|---:|---:|---:|---:|---:|---:|---:|
{chr(10).join(lines)}
"""
    whole = arguments.out.read_text()
    start = whole.find(TITLE)
    if start < 0:
        whole = whole.rstrip() + "\n\n" + text
    else:
        end = whole.find("\n## ", start + 1)
        whole = whole[:start] + text + ("" if end < 0 else whole[end:])
    arguments.out.write_text(whole)
    print(text)


if __name__ == "__main__":
    main()
