"""Ours and other libraries on the same work: the ratio of their times, row by row, with what each of them reaches."""

import page
import source
import style

TITLE = "Other libraries on the same work"
PAPER_FIGURE = "none"
PAPER = "The papers compare their programs with themselves on fewer cores. This figure is not one of theirs."
NOTES = ["peers"]
REPORTS = {"peers": None}


def in_words(quality):
    """The measures of a row's quality, such as "deepest 1.2 mm"."""
    return ", ".join(
        f"{what.replace('_', ' ')} {value if isinstance(value, str) else page.number(value)}"
        for what, value in quality.items()
    )


def table(data):
    same = ("peer", "version", "work", "scene", "threads", "ms", "spread", "ours", "ours_ms", "ours_spread", "ratio")
    return [
        {what: r[what] for what in same}
        | {"ratio_spread": source.spread_of_ratio(r, {"spread": r["ours_spread"]}), "whole_cores": r["whole_cores"]}
        | {"quality": in_words(r["quality"]), "ours_quality": in_words(r["ours_quality"])}
        | {"not_the_same": r["not_the_same"], "machine": f"{r['cpu']}, {r['isa']}, {r['commit']}, {r['date']}"}
        | {"from": r["from"]}
        for r in source.rows_of(data, "peers")
    ]


def name_of(row):
    _, *settings = row["ours"].split(", ")
    return ", ".join([f"{row['peer']}: {row['scene']}", *settings])


def in_short(rows):
    ahead = sum(r["ratio"] > 1 for r in rows)
    low, high = min(r["ratio"] for r in rows), max(r["ratio"] for r in rows)
    return {
        "paper": "–",
        "measured": f"their time over ours: {page.number(low)} to {page.number(high)}; ours is ahead in {ahead} of"
        f" {len(rows)} rows",
        "modelled": "–",
        "scene": ", ".join(dict.fromkeys(r["scene"] for r in rows)),
    }


def here(rows):
    behind = [f"{name_of(r)}, {page.threads(r['threads'])} ({page.number(r['ratio'])})" for r in rows if r["ratio"] < 1]
    return [
        "Their median time over ours, on as many threads of the same machine; both took turns. Right of 1 ours is"
        " faster, left of 1 theirs. The work is alike, not the same: the table says what differs, and what quality each"
        " of them reached.",
        f"Ours is slower in: {'; '.join(behind)}." if behind else "Ours is slower in none of these rows.",
    ]


def details(rows):
    header = ["peer", "work", "scene", "threads", "its ms (spread)", "ours, ms (spread)", "their time / ours"]
    header += ["its quality", "our quality", "what is not the same", "machine"]

    def with_spread(ms, spread):
        return page.number(ms) + ("" if spread is None else f" ({100 * spread:.0f} %)")

    lines = [
        [f"{r['peer']} {r['version']}", r["work"], r["scene"], r["threads"], with_spread(r["ms"], r["spread"])]
        + [f"{r['ours']}: {with_spread(r['ours_ms'], r['ours_spread'])}", page.number(r["ratio"])]
        + [r["quality"], r["ours_quality"], r["not_the_same"], r["machine"]]
        for r in rows
    ]
    return page.table(header, lines, {i for i, r in enumerate(rows) if r["ratio"] < 1})


def draw(rows):
    names = list(dict.fromkeys(name_of(r) for r in rows))
    figure, [[axis]] = style.panels(1, 1, 8.5, 0.9 + 0.27 * len(names))
    counts = sorted({r["threads"] for r in rows})
    for series, threads in enumerate(counts):
        own = [r for r in rows if r["threads"] == threads]
        places = [names.index(name_of(r)) + 0.12 * (series - 0.5 * (len(counts) - 1)) for r in own]
        ratios = [r["ratio"] for r in own]
        reach = [r["ratio"] * (r["ratio_spread"] or 0) / 2 for r in own]
        look = dict(color=style.COLOURS[series], marker=style.MARKERS[series], linestyle="none", zorder=3)
        axis.errorbar(ratios, places, xerr=reach, **look)
        disturbed = [(x, y) for x, y, r in zip(ratios, places, own) if not r["whole_cores"]]
        if disturbed:
            axis.plot(*zip(*disturbed), marker=style.MARKERS[series], linestyle="none", zorder=4, **style.DISTURBED)
    axis.axvline(1, **style.BOUND)
    style.log_x(axis, "their time / ours (left of 1: they are faster; right of 1: ours is)", (1, 2, 5))
    axis.set_yticks(range(len(names)), names)
    axis.set_ylim(len(names) - 0.4, -0.6)
    keys = [style.series_key(series, page.threads(threads)) for series, threads in enumerate(counts)]
    style.key_below(figure, [*keys, *style.disturbed_key(rows)])
    return figure
