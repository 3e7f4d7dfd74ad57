#!/usr/bin/env python3
"""Compares a table of Tremie with CalculiX (ccx), which must be installed: the ring of radii 6.5 and 11 mm, 3 mm high.

    calculix.py deck RING.inp [ELEMENTS_R ELEMENTS_Z]    write an input deck
    ccx RING                                             run it
    calculix.py compare RING.dat TABLE.json              forces of both, and the largest difference

TABLE.json: tremie rubber make-table ring.toml -o TABLE.json

CalculiX has no elements with mean dilatation; quadratic ones with reduced integration (CAX8R) do not lock either. Its
neo-Hookean energy is C10 (I1bar - 3) + (J - 1)^2 / D1, the same as G/2 and K/2.
"""

import json
import re
import sys

INNER, OUTER, HEIGHT = 6.5, 11.0, 3.0  # mm
SHEAR, BULK = 0.3, 8.0  # MPa
COMPRESSION, FRAMES = 0.48, 33


def deck(path, columns, rows):
    """Quadratic elements on a grid of half steps; forces in N, lengths in mm."""
    number = lambda i, j: 1 + i + j * (2 * columns + 1)
    at = lambda i, j: (INNER + (OUTER - INNER) * i / (2 * columns), HEIGHT * j / (2 * rows))
    used = [(i, j) for j in range(2 * rows + 1) for i in range(2 * columns + 1) if not (i % 2 and j % 2)]
    lines = ["*NODE, NSET=ALL"]
    lines += ["%d, %.12g, %.12g, 0." % (number(i, j), *at(i, j)) for i, j in used]
    lines.append("*ELEMENT, TYPE=CAX8R, ELSET=RING")
    corners = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1)]
    for row in range(rows):
        for column in range(columns):
            nodes = [number(2 * column + i, 2 * row + j) for i, j in corners]
            lines.append(", ".join(map(str, [1 + column + row * columns] + nodes)))
    for name, j in [("BOTTOM", 0), ("TOP", 2 * rows)]:
        lines.append("*NSET, NSET=" + name)
        lines += ["%d," % number(i, j) for i in range(2 * columns + 1)]
    step = 1.0 / (FRAMES - 1)
    lines += [
        "*MATERIAL, NAME=RUBBER",
        "*HYPERELASTIC, NEO HOOKE",
        "%.12g, %.12g" % (SHEAR / 2, 2 / BULK),
        "*SOLID SECTION, ELSET=RING, MATERIAL=RUBBER",
        "*BOUNDARY", "BOTTOM, 2, 2", "TOP, 1, 1",
        "*STEP, NLGEOM, INC=1000",
        "*STATIC, DIRECT", "%.12g, 1." % step,
        "*BOUNDARY", "TOP, 2, 2, %.12g" % -COMPRESSION,
        "*NODE PRINT, NSET=TOP, TOTALS=ONLY", "RF",
        "*NODE FILE, OUTPUT=2D", "U, RF",
        "*END STEP",
    ]
    with open(path, "w") as file:
        file.write("\n".join(lines) + "\n")


def totals(path):
    """(time, force along the axis) of each increment in a .dat file, which is that of a sector of two degrees."""
    text = open(path).read()
    pattern = r"total force \(fx,fy,fz\) for set TOP and time\s+(\S+)\s+(\S+)\s+(\S+)\s+(\S+)"
    return [(float(time), 180 * float(fy)) for time, _, fy, _ in re.findall(pattern, text)]


def interpolate(xs, ys, x):
    k = max(i for i in range(len(xs) - 1) if xs[i] <= x or i == 0)
    return ys[k] + (ys[k + 1] - ys[k]) * (x - xs[k]) / (xs[k + 1] - xs[k])


def compare(dat, table):
    table = json.load(open(table))
    largest = 0.0
    print("compression mm   CalculiX N   Tremie N   difference")
    for time, fy in totals(dat):
        compression, expected = 1e-3 * time * COMPRESSION, -fy
        found = interpolate(table["compression_m"], table["force_N"], compression)
        difference = found / expected - 1
        largest = max(largest, abs(difference))
        print("%14.4f %12.4f %10.4f %11.3f %%" % (1e3 * compression, expected, found, 100 * difference))
    print("largest difference %.3f %%" % (100 * largest))


if __name__ == "__main__":
    if len(sys.argv) >= 3 and sys.argv[1] == "deck":
        columns, rows = map(int, sys.argv[3:5]) if len(sys.argv) >= 5 else (36, 24)
        deck(sys.argv[2], columns, rows)
    elif len(sys.argv) == 4 and sys.argv[1] == "compare":
        compare(sys.argv[2], sys.argv[3])
    else:
        sys.exit(__doc__)
