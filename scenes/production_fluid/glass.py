#!/usr/bin/env python3
"""Writes glass.obj, beside this file: a tumbler, for water to be poured into.

A profile turned about the vertical axis: 19 cm high, 7.2 cm wide inside, with a wall of 9 mm, which is four cells of
glass_48, and a floor of 12 mm.
"""

import math
import pathlib

SEGMENTS = 72
MIDDLE = 0.05  # m, of the box, along x and z
OUTSIDE, INSIDE = 0.045, 0.036  # m, radii
FLOOR, HEIGHT = 0.012, 0.19  # m
FOOT, CORNER = 0.003, 0.008  # m, radii of the edge below and of the corner within
STEPS = 6  # of a quarter of a turn


def arc(radius, height, round, begin, end):
    """Points (radius, height) of an arc about a point of the profile, degrees from the horizontal."""
    count = STEPS * abs(end - begin) // 90
    angles = (math.radians(begin + (end - begin) * k / count) for k in range(count + 1))
    return [(radius + round * math.cos(a), height + round * math.sin(a)) for a in angles]


LIP = (OUTSIDE - INSIDE) / 2
profile = arc(OUTSIDE - FOOT, FOOT, FOOT, -90, 0)
profile += arc(INSIDE + LIP, HEIGHT - LIP, LIP, 0, 180)
profile += arc(INSIDE - CORNER, FLOOR + CORNER, CORNER, 0, -90)

points = [(MIDDLE, 0.0, MIDDLE), (MIDDLE, FLOOR, MIDDLE)]  # on the axis: below, and within
triangles = []
for i in range(SEGMENTS):
    turn = 2 * math.pi * i / SEGMENTS
    points += [(MIDDLE + r * math.cos(turn), y, MIDDLE + r * math.sin(turn)) for r, y in profile]
    # The two lines of the profile at this side, from OBJ's 1 on.
    here, there = (3 + len(profile) * k for k in (i, (i + 1) % SEGMENTS))
    triangles.append((1, here, there))
    for k in range(len(profile) - 1):
        a, b, c, d = here + k, there + k, there + k + 1, here + k + 1
        triangles += [(a, d, c), (a, c, b)]
    triangles.append((2, there + len(profile) - 1, here + len(profile) - 1))

lines = ["# A tumbler. Written by glass.py; metres."]
lines += ["v %.5f %.5f %.5f" % p for p in points]
lines += ["f %d %d %d" % t for t in triangles]
pathlib.Path(__file__).with_suffix(".obj").write_text("\n".join(lines) + "\n", newline="\n")
