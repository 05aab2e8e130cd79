#!/usr/bin/env python3
"""Writes hare.obj, beside this file: a sitting hare, for rigid bodies to fall on.

A sphere of triangles around a point that all parts of the hare contain, long ellipsoids; each of its points is
moved outwards to where it leaves the farthest part, the parts blended a little. Its foot is flat.
"""

import math
import pathlib

CUTS = 4  # how often the icosahedron's triangles are cut into four
SCALE, FOOT = 2.0, 0.62  # m; how far below the point the ground is
BLEND = 12  # of the parts' distances, the mean of this power
BACK = 0.25  # how far an ellipsoid reaches behind the point
# Of each ellipsoid, the tip and the radius about the line to it.
PARTS = [
    ((0, -0.62, -0.3), 0.42),  # body
    ((0, 0.1, -0.75), 0.4),
    ((0, 0.45, 0.55), 0.24),  # head
    ((0.34, 1.25, -0.1), 0.1),  # ears
    ((-0.34, 1.25, -0.1), 0.1),
    ((0.3, -0.62, 0.6), 0.16),  # paws
    ((-0.3, -0.62, 0.6), 0.16),
    ((0.45, -0.6, -0.45), 0.2),
    ((-0.45, -0.6, -0.45), 0.2),
    ((0, -0.35, -0.95), 0.14),  # tail
]


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    length = math.sqrt(dot(a, a))
    return tuple(x / length for x in a)


def leaves(direction, tip, radius):
    """How far out a ray leaves an ellipsoid."""
    reach = math.sqrt(dot(tip, tip))
    half, centre = (reach + BACK) / 2, (reach - BACK) / 2
    along = dot(direction, unit(tip))
    a = (along / half) ** 2 + max(1 - along * along, 0) / radius**2
    b = along * centre / half**2
    return (b + math.sqrt(b * b + a * (1 - (centre / half) ** 2))) / a


def icosphere(cuts):
    g = (1 + math.sqrt(5)) / 2
    points = [unit(p) for s in (-1, 1) for t in (-g, g) for p in ((0, s, t), (s, t, 0), (t, 0, s))]
    near = lambda a, b: dot(points[a], points[b]) > 0.4  # of neighbours it is 1 / sqrt(5)
    triangles = []
    for a in range(12):
        for b in range(a + 1, 12):
            for c in range(b + 1, 12):
                if near(a, b) and near(b, c) and near(a, c):
                    outside = dot(cross(points[a], points[b]), points[c]) > 0
                    triangles.append((a, b, c) if outside else (a, c, b))
    for _ in range(cuts):
        middle = {}

        def between(a, b):
            key = min(a, b), max(a, b)
            if key not in middle:
                middle[key] = len(points)
                points.append(unit(tuple(x + y for x, y in zip(points[a], points[b]))))
            return middle[key]

        cut = []
        for a, b, c in triangles:
            d, e, f = between(a, b), between(b, c), between(c, a)
            cut += [(a, d, f), (d, b, e), (f, e, c), (d, e, f)]
        triangles = cut
    return points, triangles


directions, triangles = icosphere(CUTS)
lines = ["# A hare. Written by hare.py; metres."]
for d in directions:
    far = sum(leaves(d, *part) ** BLEND for part in PARTS) ** (1 / BLEND)
    height = max(far * d[1], -FOOT)
    lines.append("v %.4f %.4f %.4f" % (SCALE * far * d[0], SCALE * height + SCALE * FOOT, SCALE * far * d[2]))
lines += ["f %d %d %d" % tuple(i + 1 for i in t) for t in triangles]
pathlib.Path(__file__).with_name("hare.obj").write_text("\n".join(lines) + "\n", newline="\n")
