"""Every kernel against the machine's peaks of computation and memory."""

import math

import numpy
import page
import source
import style

TITLE = "Roofline of every kernel"
PAPER_FIGURE = "none"
PAPER = "The papers have no such figure; it says what bounds a kernel on this machine."
NOTES = ["simd", "linear"]
REPORTS = {"bench": None}
SPAN = 5000


def table(data):
    rows = []
    for r in source.rows_of(data, "bench"):
        if r["variant"] == "serial_twin":
            continue
        named = {c: r[c] for c in ("kernel", "form", "scene", "variant", "threads", "ms", "bytes", "flops")} | {
            "from": r["from"]
        }
        if r["flops"] > 0 and r["bytes"] > 0:
            named |= {
                "flops_per_byte": r["flops"] / r["bytes"],
                "gflop_per_s": 1e-6 * r["flops"] / r["ms"],
                "spread": r["spread"],
            }
            named |= source.whole_cores(r)
        rows.append(named)
    # Each kernel and form has one scene here, the one that moves the most bytes. Points are numbered.
    largest = {}
    for r in rows:
        key = r["kernel"], r["form"]
        if key not in largest or r["bytes"] > largest[key]["bytes"]:
            largest[key] = r
    rows = [r for r in rows if r["scene"] == largest[r["kernel"], r["form"]]["scene"]]
    numbers = {}
    for r in rows:
        if "gflop_per_s" in r:
            r["number"] = numbers.setdefault((r["kernel"], r["form"]), len(numbers) + 1)
    for peak in data["bench"]["machine"].get("peaks", []):
        rows.append({"variant": "peak"} | peak)
    if not any(r["variant"] == "peak" for r in rows):
        raise source.Missing("bench.json: machine has no peaks")
    return rows


def domain(r):
    return r["kernel"].split("/")[0]


def points(rows, variant, threads):
    return [r for r in rows if r["variant"] == variant and r["threads"] == threads and "gflop_per_s" in r]


def floor(rows):
    """Where the picture ends, GFLOP/s. A few kernels compute next to nothing, and would leave half of it empty."""
    return min(r["fma_gflop_per_s"] for r in rows if r["variant"] == "peak") / SPAN


def below(rows):
    """The numbers that the picture leaves out, as openmp is slower there."""
    openmp = [r for r in rows if r["variant"] == "openmp" and "gflop_per_s" in r]
    return sorted({r["number"] for r in openmp if r["gflop_per_s"] < floor(rows)})


def without_flops(rows):
    return list(
        dict.fromkeys(
            f"{r['kernel']} {r['form']}".strip() for r in rows if r["variant"] != "peak" and "gflop_per_s" not in r
        )
    )


def share_of_roof(rows, r):
    peak = source.at(rows, variant="peak", threads=r["threads"])
    return r["gflop_per_s"] / min(peak["fma_gflop_per_s"], peak["triad_gb_per_s"] * r["flops_per_byte"])


def roof_words(peak):
    return f"{page.threads(peak['threads'])}: {peak['triad_gb_per_s']:.3g} GB/s, {peak['fma_gflop_per_s']:.3g} GFLOP/s"


def thread_counts(rows):
    """One thread and the most that were timed; one of them where they are the same."""
    return sorted({1, max(r["threads"] for r in rows if r["variant"] == "openmp")})


def in_short(rows):
    def best(variant, threads):
        r = max(points(rows, variant, threads), key=lambda r: r["gflop_per_s"])
        return f"{r['gflop_per_s']:.3g} GFLOP/s ({r['kernel']} {r['form']})".replace(" )", ")")

    of_openmp = ", ".join(f"{page.threads(threads)} {best('openmp', threads)}" for threads in thread_counts(rows))
    return {
        "paper": "–",
        "measured": f"highest: serial {best('serial', 1)}, {of_openmp}",
        "modelled": "–",
        "scene": "of each kernel the one that moves the most bytes",
    }


def here(rows):
    peaks = [r for r in rows if r["variant"] == "peak"]
    roofs = "; ".join(roof_words(p) for p in peaks)
    above = [f"{r['number']}" for r in points(rows, "openmp", 1) if share_of_roof(rows, r) > 1]
    return [
        f"The roofs are measured: triad beyond the caches, and independent multiply-adds in lanes ({roofs}). Flops and"
        " bytes are declared beside each kernel in the verifier. Flops are those of the serial form, so additional"
        " work of openmp does not count. Bytes count each read and write of memory once, so a kernel that reads its"
        " data repeatedly appears too far to the right. Left: from the serial time (cross) to openmp on one thread"
        f" (its number). Right: openmp on the most threads, {thread_counts(rows)[-1]}. A kernel above the slanted roof"
        " has its data in the caches"
        + (f" ({', '.join(above)} on one thread). " if above else ". ")
        + (f"Slower than the picture goes: {', '.join(map(str, below(rows)))}. " if below(rows) else "")
        + (f"Kernels without flops are left out: {', '.join(without_flops(rows))}." if without_flops(rows) else "")
    ]


def details(rows):
    numbered = {}
    for r in rows:
        if "gflop_per_s" in r:
            numbered.setdefault(r["number"], {})[r["variant"], r["threads"]] = r
    header = ["number", "kernel", "form", "scene", "flops/byte", "GFLOP/s: serial"]
    for threads in thread_counts(rows):
        header += [page.threads(threads), "of its roof"]
    cells = []
    for number, runs in numbered.items():
        r = runs["openmp", 1]
        cells.append([number, r["kernel"], r["form"], r["scene"], page.number(r["flops_per_byte"])])
        cells[-1].append(page.number(runs["serial", 1]["gflop_per_s"]))
        for threads in thread_counts(rows):
            run = runs["openmp", threads]
            cells[-1] += [page.number(run["gflop_per_s"]), f"{100 * share_of_roof(rows, run):.0f} %"]
    return page.table(header, cells)


def label(axis, rows, others, series_of):
    """Numbers the points, each at the nearest place that is free of points, of those of `others` and of other numbers.

    Call it when the axes have their limits and places: what is free is asked in pixels.
    """
    point = axis.figure.dpi / 72
    half = 0.5 * point * style.MARKER_SIZE
    middles = axis.transData.transform([(r["flops_per_byte"], r["gflop_per_s"]) for r in [*rows, *others]])
    taken = numpy.hstack([middles - half, middles + half])
    for r, (x, y) in zip(rows, middles):
        place = (r["flops_per_byte"], r["gflop_per_s"])
        look = {"textcoords": "offset points", "color": style.COLOURS[series_of[domain(r)]], "zorder": 5}
        text = axis.annotate(
            f"{r['number']}", place, xytext=(0, 0), ha="center", va="center", fontsize=6.5, bbox=style.CLEAR, **look
        )
        size = text.get_window_extent()
        for dx, dy in places():
            left, low = x + point * dx - size.width / 2, y + point * dy - size.height / 2
            box = numpy.array([left, low, left + size.width, low + size.height])
            if not ((box[:2] < taken[:, 2:]) & (taken[:, :2] < box[2:])).all(axis=1).any():
                break
        taken = numpy.vstack([taken, box])
        text.set_position((dx, dy))
        line = {"arrowstyle": "-", "linewidth": 0.4, "color": look["color"], "shrinkA": 3, "shrinkB": 0}
        axis.annotate("", place, xytext=(dx, dy), arrowprops=line, **look)


def places():
    """Where a number may stand, relative to its point, in points: the nearest first."""
    for distance in range(7, 120, 2):
        for turn in range(max(8, distance)):
            angle = 2 * math.pi * turn / max(8, distance)
            yield distance * math.cos(angle), distance * math.sin(angle)


def draw(rows):
    figure, axes = style.panels(1, len(thread_counts(rows)), 6.5, 6.5, sharex=True, sharey=True)
    drawn = [r for r in rows if "gflop_per_s" in r]
    series_of = {name: series for series, name in enumerate(dict.fromkeys(map(domain, drawn)))}
    low, high = (f(r["flops_per_byte"] for r in drawn) for f in (min, max))
    reach = [low / 1.6, high * 1.6]
    for axis, threads in zip(axes[0], thread_counts(rows)):
        peak = source.at(rows, variant="peak", threads=threads)
        ridge = peak["fma_gflop_per_s"] / peak["triad_gb_per_s"]
        corners = sorted([*reach, ridge])
        axis.plot(corners, [min(peak["fma_gflop_per_s"], peak["triad_gb_per_s"] * x) for x in corners], **style.BOUND)
        own = points(rows, "openmp", threads)
        serial = {r["number"]: r for r in points(rows, "serial", 1)} if threads == 1 else {}
        for r in own:
            series = series_of[domain(r)]
            colour = style.COLOURS[series]
            if serial:
                s = serial[r["number"]]
                axis.plot([r["flops_per_byte"]] * 2, [s["gflop_per_s"], r["gflop_per_s"]], color=colour, linewidth=0.5)
                axis.plot(s["flops_per_byte"], s["gflop_per_s"], color=colour, marker="x", markersize=4)
            spread = None if r["spread"] is None else min(r["spread"], 1.5)
            style.measured(axis, [r["flops_per_byte"]], [r["gflop_per_s"]], series, [spread], [r["whole_cores"]])
        style.log_x(axis, "flops / byte")
        axis.set_xlim(reach)
        style.log_y(axis, "GFLOP/s" if threads == 1 else "")
        axis.set_title(roof_words(peak))
    peaks = [r["fma_gflop_per_s"] for r in rows if r["variant"] == "peak"]
    shown = [r["gflop_per_s"] for r in drawn if r["gflop_per_s"] >= floor(rows)]
    style.limit_to(axes[0][0], shown + peaks, 1.5)
    keys = [style.series_key(series, domain) for domain, series in series_of.items()]
    style.key_below(figure, [*keys, style.serial_key(), *style.disturbed_key(rows)], 5)
    style.settle(figure)
    for axis, threads in zip(axes[0], thread_counts(rows)):
        shown = [r for r in points(rows, "openmp", threads) if r["gflop_per_s"] >= floor(rows)]
        label(axis, shown, points(rows, "serial", 1) if threads == 1 else [], series_of)
    return figure
