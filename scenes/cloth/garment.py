#!/usr/bin/env python3
"""Writes garment.obj, beside this file: a poncho, for cloths that are no sheets.

A surface of revolution about y with a hole for the neck, made of rings of more and more points towards the hem. So the
points have from 3 to 7 neighbours, edges lie in all directions, and the mesh has two boundaries.
"""

import math
import pathlib

# Radius and height, m, of neck, shoulder, elbow and hem.
PROFILE = [(0.08, 1.47), (0.20, 1.46), (0.36, 1.40), (0.48, 1.15), (0.58, 0.85)]
RINGS = 28
NECK_POINTS, HEM_POINTS = 24, 120


def on_profile(fraction):
    """The point at a fraction of the way along the profile."""
    lengths = [math.dist(p, q) for p, q in zip(PROFILE, PROFILE[1:])]
    rest = fraction * sum(lengths)
    for p, q, length in zip(PROFILE, PROFILE[1:], lengths):
        if rest <= length or q == PROFILE[-1]:
            t = rest / length
            return p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])
        rest -= length


def zip_rings(inner, outer):
    """Triangles between two rings, each a list of point numbers: always forward along the ring that is behind."""
    triangles = []
    i = j = 0
    while i < len(inner) or j < len(outer):
        a, b = inner[i % len(inner)], outer[j % len(outer)]
        if (i + 1) * len(outer) <= (j + 1) * len(inner):
            i += 1
            triangles.append((a, inner[i % len(inner)], b))
        else:
            j += 1
            triangles.append((a, outer[j % len(outer)], b))
    return triangles


points, triangles, rings = [], [], []
for k in range(RINGS):
    radius, height = on_profile(k / (RINGS - 1))
    count = NECK_POINTS + (HEM_POINTS - NECK_POINTS) * k // (RINGS - 1)
    first = len(points) + 1  # OBJ numbers points from 1
    for n in range(count):
        angle = 2 * math.pi * n / count
        points.append((radius * math.cos(angle), height, radius * math.sin(angle)))
    rings.append(list(range(first, first + count)))
    if k > 0:
        triangles += zip_rings(rings[k - 1], rings[k])

lines = ["# A poncho. Written by garment.py; metres, y up."]
lines += ["v %.5f %.5f %.5f" % p for p in points]
lines += ["f %d %d %d" % t for t in triangles]
# Minus zero would depend on the mathematics library.
text = "\n".join(lines).replace("-0.00000", "0.00000") + "\n"
pathlib.Path(__file__).with_name("garment.obj").write_text(text, newline="\n")
