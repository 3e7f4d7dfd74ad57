#!/usr/bin/env python3
"""The pressure of a free surface with cut cells, Tremie beside PyAMG and PETSc on this machine, in turns: writes its part of
BENCHMARKS.md.

    python3 tests/performance/compare_pressure.py

PyAMG is installed into an environment of its own (--peers); PETSc is the system's (Debian: apt install python3-petsc4py
python3-scipy).  Tremie writes the equations of a tank with a wave on it and a lattice of fixed round bodies; all programs solve
the same ones, from zero, to 1e-8 of the largest right side, setup included, on one thread.  Each measurement of Tremie is
followed by one of each kind of the peers, three rounds; the fastest counts.
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

PACKAGES = ["pyamg==5.4.1", "numpy==2.4.6", "scipy==1.17.1"]
HERE = Path(__file__).parent
ROOT = HERE.parent.parent
TITLE = "## The pressure of a free surface"
KINDS = {"classical": "PyAMG, classical", "aggregation": "PyAMG, aggregation"}
OF_PETSC = {"gamg": "PETSc, GAMG", "boomeramg": "PETSc, BoomerAMG", "icc": "PETSc, ICC(0)"}
SYSTEM = "/usr/bin/python3"
ALONE = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
# Debian links none of its builds of PETSc to /usr/lib/petsc unless asked to.
BUILDS = sorted(Path("/usr/lib/petscdir").glob("petsc3*/*-real"))
ENVIRONMENT = {**({"PETSC_DIR": str(BUILDS[-1])} if BUILDS else {}), **os.environ, **ALONE}
ROUNDS = 3
BENCH = ["cargo", "bench", "-q", "-p", "tremie-fluid-pic", "--no-default-features", "--bench", "pressure", "--"]


def own(folder):
    """Milliseconds, iterations and cells by problem and threads."""
    told = subprocess.run([*BENCH, folder], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    found = {}
    for name, threads, took, iterations, cells in re.findall(
        r"(\S+) (\d) threads ([\d.]+) ms (\d+) iterations (\d+) cells", told
    ):
        found[name, int(threads)] = (float(took), int(iterations), int(cells))
    return found


class Peer:
    def __init__(self, python):
        self.process = subprocess.Popen(
            [python, HERE / "pressure_peer.py"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=ENVIRONMENT
        )

    def solve(self, kind, folder):
        print(kind, folder, file=self.process.stdin, flush=True)
        took, setup, iterations, _ = self.process.stdout.readline().split()
        return float(took), float(setup), int(iterations)


def install(folder):
    python = folder / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", folder], check=True)
        subprocess.run([python, "-m", "pip", "install", "-q", *PACKAGES], check=True)
    return python


def petsc():
    """The version of the system's PETSc."""
    ask = "import petsc4py; petsc4py.init(); from petsc4py import PETSc; print(*PETSc.Sys.getVersion(), sep='.')"
    told = subprocess.run([SYSTEM, "-c", ask], capture_output=True, text=True, env=ENVIRONMENT)
    if told.returncode != 0:
        sys.exit("PETSc is missing: apt install python3-petsc4py python3-scipy\n" + told.stderr)
    return told.stdout.strip()


def table(ours, theirs):
    kinds = {**KINDS, **OF_PETSC}
    names = "".join(f" {name} [ms] | iterations |" for name in kinds.values())
    lines = [
        f"| problem | cells | Tremie [ms] | two threads [ms] | iterations |{names} best peer over Tremie |",
        "|---|---:|---:|---:|---:|" + "---:|---:|" * len(kinds) + "---:|",
    ]
    for problem in dict.fromkeys(name for name, _ in ours):
        took, iterations, cells = ours[problem, 1]
        measured = [theirs[problem, kind] for kind in kinds]
        ratio = min(time for time, *_ in measured) / took
        columns = "".join(f" {time:.1f} | {steps} |" for time, _, steps in measured)
        lines.append(
            f"| {problem} | {cells} | {took:.1f} | {ours[problem, 2][0]:.1f} | {iterations} |{columns} {ratio:.1f} |"
        )
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--peers", type=Path, default=ROOT / "target" / "peers-pressure", help="folder of the peer's environment")
    parser.add_argument("--out", type=Path, default=HERE / "BENCHMARKS.md", help="file whose section is written")
    arguments = parser.parse_args()
    version = petsc()
    pyamg, system = Peer(install(arguments.peers)), Peer(SYSTEM)
    peers = {kind: pyamg for kind in KINDS} | {kind: system for kind in OF_PETSC}
    ours, theirs = {}, {}
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(ROUNDS):
            for key, measured in own(folder).items():
                ours[key] = min(ours.get(key, measured), measured)
            for name in dict.fromkeys(name for name, _ in ours):
                for kind, peer in peers.items():
                    measured = peer.solve(kind, f"{folder}/{name}")
                    theirs[name, kind] = min(theirs.get((name, kind), measured), measured)
    text = f"""{TITLE}

Written by `python3 tests/performance/compare_pressure.py`. The equations are those of a tank with a wave on it and a lattice of
fixed discs or balls that cut its cells. All solve the same equations from zero to 1e-8 of the largest right side, setup
included: Tremie by its multigrid-preconditioned conjugate gradients, {PACKAGES[0].replace("==", " ")} by its classical (Ruge and
Stüben) and its aggregation multigrid, PETSc {version} (Debian) by its GAMG, by hypre's BoomerAMG and by incomplete Cholesky
factors, all with conjugate gradients. Tremie's multigrid is geometric: it knows the grid, which
is what a fluid has. One thread; the fastest of {ROUNDS} rounds in turns.

{table(ours, theirs)}
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
