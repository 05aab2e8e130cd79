#!/usr/bin/env python3
"""Writes knot.obj, beside this file: a trefoil knot, for level sets of meshes.

A tube around a closed curve in the unit cube. Its sides are turned against the vertical, which the curve never is, so
that they meet again where it closes.
"""

import math
import pathlib

SEGMENTS, SIDES = 160, 10
SCALE, TUBE = 0.13, 0.065  # of the curve, which reaches 3 from its middle; m, the radius of the tube


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    return tuple(x / math.hypot(*a) for x in a)


points, triangles = [], []
for i in range(SEGMENTS):
    t = 2 * math.pi * i / SEGMENTS
    curve = (math.sin(t) + 2 * math.sin(2 * t), math.cos(t) - 2 * math.cos(2 * t), -math.sin(3 * t))
    along = unit((math.cos(t) + 4 * math.cos(2 * t), -math.sin(t) + 4 * math.sin(2 * t), -3 * math.cos(3 * t)))
    side = unit(cross(along, (0, 0, 1)))
    up = cross(side, along)
    for j in range(SIDES):
        u, v = TUBE * math.cos(2 * math.pi * j / SIDES), TUBE * math.sin(2 * math.pi * j / SIDES)
        points.append(tuple(0.5 + SCALE * c + u * s + v * w for c, s, w in zip(curve, side, up)))
        # The four points of this side, from OBJ's 1 on.
        k, l = (i + 1) % SEGMENTS, (j + 1) % SIDES
        a, b, c, d = i * SIDES + j + 1, k * SIDES + j + 1, k * SIDES + l + 1, i * SIDES + l + 1
        triangles += [(a, b, c), (a, c, d)]

lines = ["# A trefoil knot. Written by knot.py; metres."]
lines += ["v %.5f %.5f %.5f" % p for p in points]
lines += ["f %d %d %d" % t for t in triangles]
pathlib.Path(__file__).with_name("knot.obj").write_text("\n".join(lines) + "\n", newline="\n")
