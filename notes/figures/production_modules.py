"""A frame of the production fluid, module by module: its time, and what cores would give to it."""

import page
import source
import style

TITLE = "Production fluid: a frame by module"
PAPER_FIGURE = "[ITJ07] Parallelization Methodology, Figure 8"
PAPER = (
    "188 s a frame of a production fluid, serially, on a 3.0 GHz Xeon; the size of its scene is not given. On 64"
    " simulated cores the distances of the level set take 1/21 (fast marching in blocks) or 1/55 (fast sweeping) of the"
    " time of one; the modules of the fluid together 1/45 (Hughes et al., ISCA 2007)."
)
PAPER_MS, PAPER_AT_64 = 188e3, 45
FORM = "multigrid"  # of the step
# The form of each module that the step calls, in the order of a step.
MODULES = {
    "time_step": "",
    "advect_level_set": "maccormack",
    "advect_particles": "",
    "advance_spray": "",
    "advect_velocity": "semi_lagrangian",
    "apply_forces": "",
    "sort_particles": "",
    "extend_level_set": "",
    "correct_level_set": "",
    "redistance": "sweeping",
    "remove_particles": "",
    "adjust_radii": "",
    "make_system": "",
    "pressure_solve": "multigrid",
    "project": "",
    "extrapolate": "",
}
REPORTS = {"production_modules": None, "scale": [f"production_fluid/{module}" for module in MODULES]}


def table(data):
    frames = source.rows_of(data, "production_modules", form=FORM)
    serial = next(r for r in frames if r["variant"] == "serial")
    one = next(r for r in frames if r["variant"] == "openmp" and r["threads"] == 1)
    many = max((r for r in frames if r["variant"] == "openmp"), key=lambda r: r["threads"])
    scene = serial["scene"]
    ms = [{m["module"]: m["ms"] for m in r["modules"]} for r in (serial, one, many)]
    rows = []
    for module, form in MODULES.items():
        if ms[1][module] < 1e-3 * sum(ms[1].values()):
            continue
        modelled = {
            r["cores"]: r
            for r in source.rows_of(data, "scale", kernel=f"production_fluid/{module}", form=form, scene=scene)
        }
        most = max(c for c in modelled if c <= 64)
        gain = modelled[1]["modelled_ms"] / modelled[most]["modelled_ms"]
        rows.append(
            {"scene": scene, "cells": serial["cells"], "particles": serial["particles"]}
            | {"substeps": serial["substeps"], "iterations": serial["iterations"]}
            | {"kernel": f"production_fluid/{module}", "module": module, "form": form}
            | {"serial_ms": ms[0][module], "one_thread_ms": ms[1][module], "threads": many["threads"]}
            | {"many_threads_ms": ms[2][module], "cores": most, "modelled_speed_up": gain}
            | {"modelled_ms": ms[1][module] / gain}
            | {"from": source.references(serial, one, many, modelled[1], modelled[most])}
        )
    return rows


def total(rows, column):
    return sum(r[column] for r in rows)


def of_frame(rows):
    """How much faster all modules together would be on many cores."""
    return total(rows, "one_thread_ms") / total(rows, "modelled_ms")


def in_short(rows):
    first = rows[0]
    return {
        "paper": "188 s a frame; 45x at 64 cores",
        "measured": f"serial {total(rows, 'serial_ms') / 1e3:.2f} s, one thread"
        f" {total(rows, 'one_thread_ms') / 1e3:.2f} s, {page.threads(first['threads'])}"
        f" {total(rows, 'many_threads_ms') / 1e3:.2f} s a frame",
        "modelled": f"{first['cores']} cores: {of_frame(rows):.1f}x",
        "scene": f"{first['scene']} ({first['cells']:,} cells, {first['particles']:,} particles)",
    }


def here(rows):
    first = rows[0]
    longest = max(rows, key=lambda r: r["modelled_ms"])
    return [
        f"A frame of 1/24 s has {first['substeps']} substeps, and {first['iterations']} iterations of the pressure in"
        " all. Left: the time of each module, all substeps together. Right: what the model of"
        f" {first['cores']} cores gives to each on the same scene, alone. The frame would take 1/{of_frame(rows):.1f}"
        f" of the time of one core, and {longest['module']} would take"
        f" {longest['modelled_ms'] / total(rows, 'modelled_ms'):.0%} of that. The papers' times are of another machine"
        " and another scene.",
    ]


def details(rows):
    threads, cores = page.threads(rows[0]["threads"]), rows[0]["cores"]
    header = ["module", "serial, ms", "one thread, ms", f"{threads}, ms", "lanes", "threads"]
    header.append(f"{cores} cores, modelled")
    cells = [
        [r["module"]]
        + [page.number(r[column]) for column in ("serial_ms", "one_thread_ms", "many_threads_ms")]
        + [page.number(r["serial_ms"] / r["one_thread_ms"], "x")]
        + [page.number(r["one_thread_ms"] / r["many_threads_ms"], "x"), page.number(r["modelled_speed_up"], "x")]
        for r in rows
    ]
    return page.table(header, cells)


def draw(rows):
    figure, [[left, right]] = style.panels(1, 2, 5.2, 4.2, sharey=True)
    places = range(len(rows))
    columns = [
        ("serial", "serial_ms", 0.27),
        ("one thread", "one_thread_ms", 0.0),
        (page.threads(rows[0]["threads"]), "many_threads_ms", -0.27),
    ]
    for (label, column, shift), colour in zip(columns, style.COLOURS):
        left.barh([p - shift for p in places], [r[column] for r in rows], height=0.25, color=colour, label=label)
    left.set_xscale("log")
    left.set_xlabel("ms a frame, measured")
    left.legend(loc="lower right")
    look = {"facecolor": "white", "edgecolor": style.COLOURS[2], "hatch": "///", "linestyle": "--"}
    right.barh(places, [r["modelled_speed_up"] for r in rows], height=0.65, **look)
    for place, r in zip(places, rows):
        style.beside(right, page.number(r["modelled_speed_up"]), r["modelled_speed_up"], place)
    right.axvline(PAPER_AT_64, color=style.GREY, linestyle=":", label="paper: all modules together")
    right.set_xlim(0, 1.15 * max(PAPER_AT_64, *(r["modelled_speed_up"] for r in rows)))
    right.set_xlabel(f"gain of {rows[0]['cores']} cores, modelled")
    right.legend(loc="center right")
    for axis in (left, right):
        axis.grid(axis="y", visible=False)
    left.set_yticks(places, [r["module"] for r in rows])
    left.invert_yaxis()
    return figure
