#!/usr/bin/env python3
"""Writes hopper.stl [inch], choke.stl [mm] and bend.stl [m]: python3 parts.py

Each part is a closed profile of (distance, radius), swept round a path; its own frame begins where
its path does, at the middle of its upper flange. Circles are regular polygons of equal area.
"""

import math
import struct

CORNERS = 28
# A regular polygon whose corners lie on this radius has the area of a circle of radius 1.
EQUAL_AREA = math.sqrt(2 * math.pi / (CORNERS * math.sin(2 * math.pi / CORNERS)))

# Radii [mm].
BORE, PIPE, FLANGE = 6.0, 7.6, 11.0


def straight(s):
    """Straight down: centre, and two directions across the path."""
    return (0.0, 0.0, -s), (1.0, 0.0, 0.0), (0.0, -1.0, 0.0)


def bent(stub, radius):
    """Down for `stub`, a right angle of `radius`, then straight along +x."""

    def at(s):
        angle = min(max((s - stub) / radius, 0.0), math.pi / 2)
        before, after = min(s, stub), max(s - stub - radius * math.pi / 2, 0.0)
        centre = (radius * (1 - math.cos(angle)) + after, 0.0, -before - radius * math.sin(angle))
        return centre, (math.cos(angle), 0.0, math.sin(angle)), (0.0, -1.0, 0.0)

    return at


def sweep(path, profile):
    """Triangles of a closed profile swept round a path."""
    rings = []
    for s, r in profile:
        centre, u, v = path(s)
        ring = []
        for k in range(CORNERS):
            angle = 2 * math.pi * k / CORNERS
            a, b = r * EQUAL_AREA * math.cos(angle), r * EQUAL_AREA * math.sin(angle)
            ring.append(tuple(centre[i] + a * u[i] + b * v[i] for i in range(3)))
        rings.append(ring)
    triangles = []
    for j, ring in enumerate(rings):
        after = rings[(j + 1) % len(rings)]
        for k in range(CORNERS):
            n = (k + 1) % CORNERS
            triangles += [(ring[k], after[n], ring[n]), (ring[k], after[k], after[n])]
    return triangles


def hopper():
    """A cone with a rounded shoulder, 25 mm from the rim to the lower flange."""
    inner = [(0, 12.0), (8, 12.0), (9.5, 11.8), (11, 11.2), (19, 7.2), (20.5, 6.4), (22, BORE), (25, BORE)]
    outer = [(25, FLANGE), (22, FLANGE), (22, PIPE), (18.5, 9.2), (11, 12.6), (8, 13.2), (0, 13.2)]
    return sweep(straight, inner + outer)


def choke():
    """A throat of radius 4 mm, a cosine between two flanges, 12 mm long."""
    turn = [2 * math.pi * k / 16 for k in range(17)]
    inner = [(12 * t / (2 * math.pi), BORE - 2.0 * 0.5 * (1 - math.cos(t))) for t in turn]
    outer = [(12, FLANGE), (9, FLANGE), (9, PIPE), (3, PIPE), (3, FLANGE), (0, FLANGE)]
    return sweep(straight, inner + outer)


def bend():
    """A right angle of radius 10 mm below a flange, and 20 mm of pipe."""
    arc = 10 * math.pi / 2
    along = [3 + arc * k / 10 for k in range(11)]
    end = 3 + arc + 20
    inner = [(s, BORE) for s in [0, *along, end]]
    outer = [(s, PIPE) for s in [end, *reversed(along)]] + [(3, FLANGE), (0, FLANGE)]
    return sweep(bent(3, 10), inner + outer)


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def write(name, triangles, unit):
    """Binary STL of triangles [mm] in a unit of so many mm."""
    with open(name, "wb") as out:
        out.write(name.encode().ljust(80, b" ") + struct.pack("<I", len(triangles)))
        for p, q, r in triangles:
            n = cross([q[i] - p[i] for i in range(3)], [r[i] - p[i] for i in range(3)])
            length = math.hypot(*n)
            corners = [x / unit for corner in (p, q, r) for x in corner]
            out.write(struct.pack("<12fH", *(x / length for x in n), *corners, 0))


write("hopper.stl", hopper(), 25.4)
write("choke.stl", choke(), 1.0)
write("bend.stl", bend(), 1000.0)
