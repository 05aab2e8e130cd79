"""How large a problem must be for half of 64 cores to be in use."""

import math

import page
import source
import style

TITLE = "How large a problem must be"
PAPER_FIGURE = "none; beside [ITJ07] Figure 10"
PAPER = (
    "The papers give one speed-up a kernel, at one size that they often do not name. How it depends on the size, they"
    " do not show."
)
NOTES = ["scaling", "big_machine"]
REPORTS = {"problem_sizes": None}
HALF = 0.5


def table(data):
    """A row for each kernel and scene: the share of 64 cores in use, which is the speed-up over one core by 64."""
    many = max(r["cores"] for r in source.rows_of(data, "problem_sizes"))
    rows = []
    for at_many in source.rows_of(data, "problem_sizes", cores=many):
        named = {column: at_many[column] for column in ("kernel", "form", "scene")}
        one = source.row_of(data, "problem_sizes", **named, cores=1)
        speed_up = one["modelled_ms"] / at_many["modelled_ms"]
        rows.append(
            named
            | {"kind": "modelled", "cores": many, "items": at_many["items"], "unit": at_many["unit"]}
            | {"ms": at_many["modelled_ms"], "speed_up": speed_up, "in_use": speed_up / many}
            | {"compute_speed_up": one["compute_ms"] / at_many["compute_ms"]}
            | source.where_time_goes(at_many)
            | {"from": source.references(one, at_many)}
        )
    return rows


def kernels(rows):
    """{name: its rows by size}."""
    names = dict.fromkeys(f"{r['kernel']} {r['form']}".strip() for r in rows)
    return {
        name: sorted((r for r in rows if f"{r['kernel']} {r['form']}".strip() == name), key=lambda r: r["items"])
        for name in names
    }


def half_used_from(rows):
    """The size from which on half of the cores are in use: between two scenes on a line of logarithms. None if even the
    largest scene does not reach it."""
    if rows[-1]["in_use"] < HALF:
        return None
    above = rows[-1]
    for row in reversed(rows[:-1]):
        if row["in_use"] < HALF:
            part = math.log(HALF / row["in_use"]) / math.log(above["in_use"] / row["in_use"])
            return row["items"] * (above["items"] / row["items"]) ** part
        above = row
    return above["items"]


def size(items, unit):
    return f"{float(f'{items:.2g}'):,.0f} {unit}"


def said(name, rows):
    found, most = half_used_from(rows), rows[-1]
    if found is None:
        return f"{name}: not by {size(most['items'], most['unit'])} ({100 * most['in_use']:.0f} %)"
    least = "at most " if found == rows[0]["items"] else ""
    return f"{name}: from {least}{size(found, most['unit'])}"


def in_short(rows):
    return {
        "paper": "–",
        "measured": "–",
        "modelled": f"half of {rows[0]['cores']} cores in use: "
        + "; ".join(said(name, own) for name, own in kernels(rows).items()),
        "scene": ", ".join(dict.fromkeys(r["scene"] for r in rows)),
    }


def here(rows):
    cores = rows[0]["cores"]
    paragraphs = [
        f"The share of {cores} modelled cores in use, which is the speed-up over one core by {cores}, on scenes of"
        " growing size. Where it passes a half is read off between two scenes, both axes logarithmic."
    ]
    for name, own in kernels(rows).items():
        largest = own[-1]
        bound = largest["compute_speed_up"] > 1.1 * largest["speed_up"]
        unbound = f" Without the bound by memory: {largest['compute_speed_up']:.1f}x." if bound else ""
        paragraphs.append(
            f"{said(name, own)}. On {largest['scene']}, {size(largest['items'], largest['unit'])}:"
            f" {largest['speed_up']:.1f}x; the cores lose: {source.losses(largest)}.{unbound}"
        )
    return paragraphs


def draw(rows):
    figure, [[axis]] = style.panels(1, 1, 7.5, 4.4)
    found = kernels(rows)
    for series, own in enumerate(found.values()):
        style.modelled(axis, [r["items"] for r in own], [100 * r["in_use"] for r in own], series)
    axis.axhline(100 * HALF, linestyle=":", **style.BOUND)
    style.log_x(axis, "size: what each kernel counts (rows, bodies, pairs, particles, points)")
    axis.set_ylim(0, 100)
    axis.set_ylabel(f"{rows[0]['cores']} cores in use, %")
    keys = [style.series_key(series, f"{name}, {own[0]['unit']}") for series, (name, own) in enumerate(found.items())]
    axis.legend(handles=keys, loc="upper center", bbox_to_anchor=(0.5, -0.15), ncols=2, frameon=False, fontsize=7.5)
    return figure
