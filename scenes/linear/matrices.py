"""Writes truss.mtx and general.mtx, which are stored beside it: python3 scenes/linear/matrices.py"""

import math
import pathlib
import random

FOLDER = pathlib.Path(__file__).parent


def write(name, kind, rows, columns, comment, entries):
    lines = [f"%%MatrixMarket matrix coordinate real {kind}", f"% {comment}", f"{rows} {columns} {len(entries)}"]
    by_columns = sorted(entries.items(), key=lambda entry: (entry[0][1], entry[0][0]))
    lines += [f"{i + 1} {j + 1} {value:.9g}" for (i, j), value in by_columns]
    (FOLDER / name).write_text("\n".join(lines) + "\n")


def truss():
    """Bars between joints, at random places, that are near each other; the leftmost joints are held."""
    dice = random.Random(1)
    joints = sorted((dice.random(), dice.random()) for _ in range(150))
    held = 6
    order = list(range(held, len(joints)))
    dice.shuffle(order)  # so that numbers tell nothing of places
    number = {joint: 2 * k for k, joint in enumerate(order)}
    entries = {(2 * k + c, 2 * k + c): 0.01 for k in range(len(order)) for c in range(2)}  # an elastic ground
    for a in range(len(joints)):
        nearest = sorted(range(len(joints)), key=lambda b: math.dist(joints[a], joints[b]))[1:6]
        for b in nearest:
            length = math.dist(joints[a], joints[b])
            direction = [(joints[b][c] - joints[a][c]) / length for c in range(2)]
            for p, q, sign in ((a, a, 1), (b, b, 1), (a, b, -1), (b, a, -1)):
                if p in number and q in number:
                    for r in range(2):
                        for c in range(2):
                            i, j = number[p] + r, number[q] + c
                            if i >= j:
                                stiffness = sign * direction[r] * direction[c] / length / 10
                                entries[i, j] = entries.get((i, j), 0) + stiffness
    write("truss.mtx", "symmetric", 2 * len(order), 2 * len(order), "A plane truss on an elastic ground.", entries)


def general():
    """Rows of 0 to 30 entries."""
    dice = random.Random(2)
    entries = {}
    for i in range(203):
        for j in dice.sample(range(157), dice.choice((0, 1, 3, 8, 30))):
            entries[i, j] = dice.uniform(-1, 1)
    write("general.mtx", "general", 203, 157, "Random, with empty rows.", entries)


truss()
general()
