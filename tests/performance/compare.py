#!/usr/bin/env python3
"""Tremie beside its peers on this machine, in turns: writes BENCHMARKS.md.

    python3 tests/performance/compare.py --tremie target/release/tremie

lbmpy is installed into an environment of its own (--peers), which needs Python 3.12 or newer and a C++ compiler with OpenMP.  Each
measurement of Tremie is followed by one of the peer: A B A B.  Medians and the median of the ratios of neighbours are told: the machine may be shared,
so that absolute figures drift.
"""

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys
from pathlib import Path

LBMPY = "lbmpy==2.1.1"
HERE = Path(__file__).parent
ROOT = HERE.parent.parent
PATTERNS = ["aa", "esopull"]
GOALS = {"bgk": 1.0, "les": 1.25}
NAMES = {"bgk": "BGK,", "les": "BGK with Smagorinsky,"}


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tremie", type=Path, default=ROOT / "target/release/tremie", help="the program")
    parser.add_argument("--peers", type=Path, default=ROOT / "target/peers", help="folder for the peer's environment")
    parser.add_argument("--python", default=sys.executable, help="Python for the peer, 3.12 or newer")
    parser.add_argument("--edges", type=int, nargs="+", default=[128, 192], help="cells along an edge of the box")
    parser.add_argument("--threads", type=int, nargs="+", default=sorted({1, os.cpu_count() or 1}))
    parser.add_argument("--repeats", type=int, default=7, help="pairs of measurements")
    parser.add_argument("--seconds", type=float, default=0.6, help="length of a measurement")
    parser.add_argument("--report", type=Path, default=Path(__file__).with_name("BENCHMARKS.md"))
    return parser.parse_args()


def environment(options):
    """The peer's Python, with the peer installed."""
    python = options.peers / "bin/python"
    if not python.exists():
        subprocess.run([options.python, "-m", "venv", str(options.peers)], check=True)
        subprocess.run([str(python), "-m", "pip", "install", "--quiet", LBMPY], check=True)
    return python


class Peer:
    """The peer's program, which keeps its kernels from one burst to the next."""

    def __init__(self, python, edge, threads):
        command = [str(python), str(HERE / "lattice_peer.py"), str(edge), str(max(threads))]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def rate(self, *words):
        print(*words, file=self.process.stdin, flush=True)
        answer = self.process.stdout.readline()
        if not answer:
            sys.exit("the peer has ended")
        return float(answer)

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def own(options, precision, model, edge, threads):
    """One measurement of Tremie: rate and share of the bandwidth in place."""
    words = ["lattice", precision, NAMES[model], "periodic"]
    sets = ["--threads", str(threads), "--edge", str(edge), "--repeats", "1", "--seconds", str(options.seconds), "--json"]
    told = subprocess.run([str(options.tremie), "bench", *words, *sets], check=True, capture_output=True, text=True)
    row = json.loads(told.stdout.splitlines()[0])
    return row["median"], row["share"]


def compare(options, python):
    rows = []
    for edge in options.edges:
        peer = Peer(python, edge, options.threads)
        for precision in ["f64", "f32"]:
            for model in ["bgk", "les"]:
                for threads in options.threads:
                    best = max(PATTERNS, key=lambda p: peer.rate(precision, model, p, threads, options.seconds))
                    pairs = []
                    for _ in range(options.repeats):
                        mine, share = own(options, precision, model, edge, threads)
                        pairs.append((mine, peer.rate(precision, model, best, threads, options.seconds), share))
                    median = statistics.median
                    row = {
                        "edge": edge, "precision": precision, "model": model, "threads": threads, "pattern": best,
                        "tremie": median(a for a, _, _ in pairs), "peer": median(b for _, b, _ in pairs),
                        "ratio": median(a / b for a, b, _ in pairs), "share": median(c for _, _, c in pairs),
                        "range": [min(a / b for a, b, _ in pairs), max(a / b for a, b, _ in pairs)],
                    }
                    rows.append(row)
                    print(json.dumps(row), flush=True)
        peer.close()
    return rows


def processor():
    """Its name, which kind it is, as names often do not say that, and the widest registers that kernels may use."""
    with open("/proc/cpuinfo") as info:
        said = dict(line.split(":", 1) for line in info.read().split("\n\n")[0].splitlines() if ":" in line)
    said = {key.strip(): value.strip() for key, value in said.items()}
    flags = said.get("flags", "").split()
    widest = next((name for flag, name in [("avx512f", "AVX-512"), ("avx2", "AVX2")] if flag in flags), "no AVX2")
    name = said.get("model name", platform.processor())
    return f"{name} (family {said.get('cpu family', '?')}, model {said.get('model', '?')}; {widest})"


def report(options, rows):
    version = subprocess.run([str(options.tremie), "--version"], capture_output=True, text=True).stdout.strip()
    lines = [
        "# Benchmarks", "",
        "Written by `python3 tests/performance/compare.py`. The unit is a million cell updates a second (MLUPS), D3Q19. Each rate",
        f"is the median of {options.repeats} pairs, measured in turn (Tremie, peer, Tremie, peer). The ratio is the median of the pairs' own",
        "ratios, with the least and the greatest. The peer runs the better of its two in-place schemes, AA and Esoteric pull.",
        "Only its sweep is timed, while Tremie's step closes periodic faces too. The share compares with the bandwidth of an",
        "update in place, measured in turn: 304 bytes an update in f64, 152 in f32.", "",
        f"Machine: {processor()}, {os.cpu_count()} cores, {platform.system()} {platform.release()}. {version}; {LBMPY.replace('==', ' ')}.", "",
        "| box | model | threads | Tremie | lbmpy | ratio | goal | share of bandwidth |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for row in rows:
        goal = GOALS[row["model"]]
        met = "reached" if row["ratio"] >= goal else "**not reached**"
        model = {"bgk": "BGK", "les": "BGK with Smagorinsky"}[row["model"]]
        low, high = row["range"]
        lines.append(f"| {row['edge']}³ {row['precision']} | {model} | {row['threads']} | {row['tremie']:.1f} | {row['peer']:.1f} ({row['pattern']}) | "
                     f"{row['ratio']:.2f} ({low:.2f} to {high:.2f}) | {goal:.2f}, {met} | {100 * row['share']:.0f} % |")
    # What compare_grains.py wrote stays.
    _, mark, rest = options.report.read_text().partition("\n## ") if options.report.exists() else ("", "", "")
    options.report.write_text("\n".join(lines) + "\n" + mark + rest)


def main():
    options = arguments()
    report(options, compare(options, environment(options)))


if __name__ == "__main__":
    main()
