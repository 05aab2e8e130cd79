"""Draws every figure from its CSV, and an index page: draw.py FOLDER, where `build/lockstep figures` left the CSVs.

A figure is a module beside this one that is named as its CSV, with TITLE, PAPER (what the paper shows), HERE (what we see) and
draw(rows), which gives a matplotlib figure; rows are dictionaries, one a line of the CSV.
"""

import csv
import html
import importlib
import pathlib
import sys

import matplotlib

matplotlib.use("svg")
matplotlib.rcParams["svg.hashsalt"] = "lockstep"  # the same file from the same numbers


def main(folder):
    entries = []
    for path in sorted(folder.glob("*.csv")):
        figure = importlib.import_module(path.stem)
        with open(path, newline="") as lines:
            rows = list(csv.DictReader(lines))
        figure.draw(rows).savefig(path.with_suffix(".svg"), metadata={"Date": None}, bbox_inches="tight")
        entries.append(
            f"<h2>{html.escape(figure.TITLE)}</h2>\n<img src='{path.stem}.svg' alt=''>\n"
            f"<p><b>The paper:</b> {html.escape(figure.PAPER)}</p>\n<p><b>Here:</b> {html.escape(figure.HERE)}</p>\n"
            f"<p><a href='{path.name}'>{path.name}</a>, notes/figures/{path.stem}.py</p>\n"
        )
    index = folder / "index.html"
    index.write_text("<!doctype html><meta charset='utf-8'><title>Lockstep: figures</title>\n<h1>Figures</h1>\n" + "".join(entries))
    print(index)


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
