"""The scaling model against the machine, at the thread counts that the machine has."""

import statistics

import page
import source
import style

TITLE = "The scaling model against measurements"
PAPER_FIGURE = "none"
PAPER = "The papers show no such comparison of their simulator."
NOTES = ["scaling"]
REPORTS = {"scale": None}
BAND = 0.1


def table(data):
    columns = ("kernel", "form", "scene", "cores", "measured_ms", "modelled_ms", "off_by", "whole_cores", "from")
    rows = [{c: r[c] for c in columns} for r in source.rows_of(data, "scale") if "off_by" in r]
    if not rows:
        raise source.Missing("scale.json: no row that was measured, too")
    return rows


def most(rows):
    """The most cores on which all runs could be measured, too."""
    return max(r["cores"] for r in rows)


def summary(rows, cores):
    own = [r for r in rows if r["cores"] == cores]
    within = sum(abs(r["off_by"]) <= BAND for r in own)
    median = page.signed_percent(statistics.median(r["off_by"] for r in own))
    worst = max(own, key=lambda r: abs(r["off_by"]))
    name = " ".join(filter(None, (worst["kernel"], worst["form"], worst["scene"])))
    return (
        f"{within} of {len(own)} within {100 * BAND:.0f} %, median {median}, worst"
        f" {page.signed_percent(worst['off_by'])} ({name})"
    )


def in_short(rows):
    return {
        "paper": "–",
        "measured": (
            f"{len({(r['kernel'], r['form'], r['scene']) for r in rows})} runs at 1 to {page.threads(most(rows))}"
        ),
        "modelled": f"{page.threads(most(rows))}: {summary(rows, most(rows))}",
        "scene": "all that bench times",
    }


def here(rows):
    of_each = "; ".join(
        f"{page.threads(cores)}: {summary(rows, cores)}" for cores in sorted({r["cores"] for r in rows})
    )
    return [
        f"Modelled time over measured time: {of_each}. The shaded band is {100 * BAND:.0f} % to either side. In a"
        " record only one core works at a time, so the model does not see two cores that access memory at once; it"
        f" only bounds their total bandwidth (notes/scaling.md). Beyond {page.threads(most(rows))} no measurement here"
        " can check the model."
    ]


def details(rows):
    runs = {}
    for r in rows:
        runs.setdefault((r["kernel"], r["form"], r["scene"]), {})[r["cores"]] = r
    n, threads = most(rows), page.threads(most(rows))
    at_most = {name: by_cores for name, by_cores in runs.items() if n in by_cores}
    header = [
        "kernel",
        "form",
        "scene",
        f"measured, ms, {threads}",
        f"modelled, ms, {threads}",
        "off by",
        "off by, 1 thread",
        "JSON row",
    ]
    cells = [
        [
            *name,
            page.number(by[n]["measured_ms"]),
            page.number(by[n]["modelled_ms"]),
            page.signed_percent(by[n]["off_by"]),
        ]
        + [page.signed_percent(by[1]["off_by"]) if 1 in by else "–", by[n]["from"]]
        for name, by in at_most.items()
    ]
    marked = [i for i, by in enumerate(at_most.values()) if abs(by[n]["off_by"]) > BAND]
    return f"<p>{threads}: {summary(rows, n)}. Rows further off are marked.</p>\n" + page.table(
        header, cells, marked=marked
    )


def draw(rows):
    widest = max(max(1 + r["off_by"], 1 / (1 + r["off_by"])) for r in rows)
    kernels = list(dict.fromkeys(r["kernel"] for r in rows))
    figure, [[axis]] = style.panels(1, 1, 11, 1.2 + 0.2 * len(kernels))
    axis.axvspan(1 - BAND, 1 + BAND, color="#dddddd", zorder=0)
    axis.axvline(1, **style.BOUND)
    for series, cores in enumerate(sorted({1, most(rows)})):
        own = [r for r in rows if r["cores"] == cores]
        look = {"color": style.COLOURS[series], "marker": style.MARKERS[series], "linestyle": "none", "markersize": 4.5}
        white = {"markerfacecolor": "white", "label": page.threads(cores)}
        for whole_cores, more in ((True, white), (False, style.DISTURBED)):
            among = [r for r in own if r["whole_cores"] == whole_cores]
            places = [kernels.index(r["kernel"]) - 0.15 + 0.3 * series for r in among]
            axis.plot([1 + r["off_by"] for r in among], places, **look, **more)
    style.log_x(
        axis, "modelled time / measured time", (1, 2, 5) if widest > 2 else (0.8, 0.9, 1, 1.1, 1.2, 1.4, 1.6, 1.8)
    )
    axis.set_yticks(range(len(kernels)), kernels)
    axis.set_ylim(len(kernels) - 0.4, -0.6)
    style.key_below(figure, axis.get_legend_handles_labels()[0] + style.disturbed_key(rows))
    return figure
