#!/usr/bin/env python3
"""Water heights of the dam break against a box, beside measured ones: prints the table of notes/production_fluid.md,
and draws them over time. From the repository, once it is built:

    make run SCENE=kleefsman_161 FRAMES=66 THREADS=1
    /usr/bin/python3 notes/experiments/kleefsman_heights.py build/frames/kleefsman_161 [heights.svg]

Reads phi from the frames. The height of a gauge is how much of its column of cells is liquid.
"""

import pathlib
import re
import sys

import matplotlib.pyplot as pyplot
import numpy as np

FRAME = 1 / 24  # s
MIDDLE = 0.5  # m, across the tank
# Where gauges stand along the tank, m, and what was measured there: SPHERIC test 2 (Kleefsman et al., J. Comput. Phys.
# 206, 2005), a few points of the official traces.
MOMENTS = [0.5, 1.0, 2.7]  # s
GAUGES = {0.496: [0.001, 0.149, 0.269], 0.992: [0.096, 0.179, 0.242], 1.488: [0.099, 0.155, 0.237]}
GAUGES[2.638] = [0.429, 0.279, 0.131]


def read_phi(path):
    """phi[z, y, x] at centres of cells, m, and the spacing, m, of a .vti file as common/levelset/vti.h writes it."""
    data = path.read_bytes()
    header, rest = data.split(b'<AppendedData encoding="raw">', 1)
    text = header.decode()
    extent = [int(n) for n in re.search(r'WholeExtent="([^"]*)"', text)[1].split()]
    spacing = float(re.search(r'Spacing="(\S+)', text)[1])
    nx, ny, nz = (extent[2 * axis + 1] + 1 for axis in range(3))
    begin = rest.index(b"_") + 1 + 8  # a mark, and the number of bytes
    return np.frombuffer(rest, "<f4", nx * ny * nz, begin).reshape(nz, ny, nx), spacing


def heights(path):
    phi, h = read_phi(path)
    columns = (phi[int(MIDDLE / h), :, int(x / h)] for x in GAUGES)
    return [h * np.clip(0.5 - column / h, 0, 1).sum() for column in columns]


def main():
    files = sorted(pathlib.Path(sys.argv[1]).glob("frame_*.vti"))
    found = np.array([heights(path) for path in files])
    times = FRAME * np.arange(len(files))
    print("| gauge at x, m |" + "".join(f" {t:.2f} s: computed | measured |" for t in MOMENTS))
    print("|---|" + "--:|--:|" * len(MOMENTS))
    for k, (x, measured) in enumerate(GAUGES.items()):
        computed = np.interp(MOMENTS, times, found[:, k])
        print(f"| {x} |" + "".join(f" {a:.3f} | {b:.3f} |" for a, b in zip(computed, measured)))
    if len(sys.argv) > 2:
        figure, axes = pyplot.subplots(2, 2, figsize=(8, 5), sharex=True, sharey=True, layout="constrained")
        for axis, (x, measured), computed in zip(axes.flat, GAUGES.items(), found.T):
            axis.plot(times, computed, label="computed")
            axis.plot(MOMENTS, measured, "ko", label="measured")
            axis.set_title(f"x = {x} m")
        for axis in axes[-1]:
            axis.set_xlabel("time, s")
        for axis in axes[:, 0]:
            axis.set_ylabel("height, m")
        axes[0, 0].legend()
        figure.savefig(sys.argv[2])


if __name__ == "__main__":
    main()
