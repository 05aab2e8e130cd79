"""Every kernel on 64 cores: what threads give, and what lanes and threads give together."""

import page
import source
import style

TITLE = "Every kernel: threads alone, and lanes times threads"
PAPER_FIGURE = "[ITJ07] Figures 7 to 10"
PAPER = (
    "Speed-ups on 64 cores over one, simulated: contact solver 35x, fast marching 21x, fast sweeping 55x, game physics"
    " 36x to 61x; of whole productions, fluid 45x, face 50x and cloth 30x ([ISCA07]). None over a serial program."
)
NOTES = ["scaling", "simd"]
REPORTS = {"bench": None, "scale": None}
# On 64 cores over one, by kernel and, where the paper is about one, by form.
PAPER_AT_64 = {
    ("rigid/contact_solver", "batches"): (35, 35),
    ("rigid/contact_solver", "blocks"): (35, 35),
    ("levelset/fast_marching", None): (21, 21),
    ("levelset/fast_sweeping", "blocks"): (55, 55),
    ("rigid/step", None): (36, 61),
    ("fluid/step", None): (36, 61),
    ("cloth/step", None): (36, 61),
    ("production_fluid/step", None): (45, 45),
    ("production_face/step", None): (50, 50),
    ("production_cloth/step", None): (30, 30),
}


def table(data):
    """A row for each kernel and form, on that of its scenes which moves the most bytes."""
    timed, modelled = {}, {}
    for r in source.rows_of(data, "bench"):
        timed.setdefault((r["kernel"], r["form"], r["scene"]), {})[r["variant"], r["threads"]] = r
    for r in source.rows_of(data, "scale"):
        modelled.setdefault((r["kernel"], r["form"], r["scene"]), {})[r["cores"]] = r
    largest = {}
    for case, runs in timed.items():
        if case in modelled and {("serial", 1), ("openmp", 1)} <= set(runs):
            bytes_of = runs["openmp", 1]["bytes"]
            if case[:2] not in largest or bytes_of > largest[case[:2]][0]:
                largest[case[:2]] = bytes_of, case
    rows = []
    for _, case in largest.values():
        serial, one = timed[case]["serial", 1], timed[case]["openmp", 1]
        over = modelled[case]
        most = max(cores for cores in over if cores <= 64)
        lanes = serial["ms"] / one["ms"]
        threads, of_cores = (over[1][ms] / over[most][ms] for ms in ("modelled_ms", "compute_ms"))
        rows.append(
            dict(zip(("kernel", "form", "scene"), case))
            | {"cores": most, "serial_ms": serial["ms"], "one_thread_ms": one["ms"], "lanes": lanes}
            | {"threads": threads, "threads_unbound": of_cores, "both": lanes * threads}
            | source.where_time_goes(over[most])
            | source.whole_cores(serial, one)
            | {"from": source.references(serial, one, over[1], over[most])}
        )
    if not rows:
        raise source.Missing("bench.json and scale.json: no kernel that was both timed and modelled")
    return rows


def name_of(r):
    return f"{r['kernel']} {r['form']}".strip()


def paper(r):
    """The paper's least and most for a row, or None."""
    return PAPER_AT_64.get((r["kernel"], r["form"])) or PAPER_AT_64.get((r["kernel"], None))


def fastest(rows):
    """Of each kernel the form that takes least on all cores."""
    best = {}
    for r in rows:
        ms = r["one_thread_ms"] / r["threads"]
        if r["kernel"] not in best or ms < best[r["kernel"]][0]:
            best[r["kernel"]] = ms, r
    return [r for _, r in best.values()]


def in_short(rows):
    own = fastest(rows)
    half = sum(r["threads"] > r["cores"] / 2 for r in own)
    return {
        "paper": "21x to 61x by threads",
        "measured": "–",
        "modelled": (
            f"{own[0]['cores']} cores: {half} of {len(own)} kernels use half of them; over serial"
            f" {min(r['both'] for r in own):.0f}x to {max(r['both'] for r in own):,.0f}x"
        ),
        "scene": "of each kernel the one that moves the most bytes",
    }


def here(rows):
    own = fastest(rows)
    cores = own[0]["cores"]
    half = [r for r in own if r["threads"] > cores / 2]
    unbound = [r for r in own if r["threads_unbound"] > cores / 2]
    return [
        f"Each kernel in the form that takes least on {cores} cores; the table has all forms. Left: one core over"
        f" {cores}, both modelled. Right: lanes times threads, which is serial over one thread, measured, times the"
        " gain on the left. Lanes shorten what a core does between two barriers, so threads alone gain less than on the"
        " papers' cores, and both together more.",
        f"{len(half)} of {len(own)} kernels use half of {cores} cores; {len(unbound)} would if all cores did not share"
        " this machine's memory (hollow: without that bound).",
    ]


def details(rows):
    cores = rows[0]["cores"]
    header = ["kernel", "form", "scene", "serial, ms", "1 thread, ms", "lanes", f"{cores} cores", "without memory"]
    header += ["both", "paper", "the cores lose"]
    cells = []
    for r in rows:
        asked = paper(r)
        cells.append(
            [r["kernel"], r["form"], r["scene"], page.number(r["serial_ms"]), page.number(r["one_thread_ms"])]
            + [page.number(r[column], "x") for column in ("lanes", "threads", "threads_unbound", "both")]
            + ["–" if asked is None else "x to ".join(str(n) for n in dict.fromkeys(asked)) + "x", source.losses(r)]
        )
    return page.table(header, cells)


def draw(rows):
    own = fastest(rows)
    places = range(len(own))
    figure, [[threads, both]] = style.panels(1, 2, 4.6, 0.8 + 0.15 * len(own), sharey=True)
    look = {"linestyle": "none", "marker": style.MARKERS[0], "markersize": 4.5, "color": style.COLOURS[0]}
    threads.axvline(own[0]["cores"] / 2, **style.BOUND)
    threads.plot([r["threads_unbound"] for r in own], places, **look | {"markerfacecolor": "white"})
    threads.plot([r["threads"] for r in own], places, **look)
    for place, r in zip(places, own):
        if asked := paper(r):
            threads.plot(sorted(set(asked)), [place] * len(set(asked)), **style.PAPER | {"markersize": 7})
    style.log_x(threads, f"{own[0]['cores']} cores over one, modelled", (1, 2, 5))
    for place, r in zip(places, own):
        both.plot([r["lanes"], r["both"]], [place, place], color=style.GREY, linewidth=0.8, zorder=1)
    both.plot([r["lanes"] for r in own], places, **look | {"color": style.COLOURS[1], "marker": style.MARKERS[1]})
    both.plot([r["both"] for r in own], places, **look)
    style.log_x(both, "over serial: lanes on one thread, and with threads", (1,))
    threads.set_yticks(places, [name_of(r) for r in own], fontsize=6.5)
    threads.set_ylim(len(own) - 0.4, -0.6)
    keys = [style.series_key(0, "threads; both"), style.series_key(1, "lanes alone, measured"), style.paper_key()]
    style.key_below(figure, keys)
    return figure
