"""The nine modules of game physics: what lanes and threads give to each, in numbers."""

import judge
import page
import source
import style

TITLE = "The modules of game physics: lanes and threads"
PAPER_FIGURE = "[LRB08] Figure 7"
PAPER = (
    "How each of nine modules takes to SIMD and to threads, in words (columns 'paper' of the table below). It gives no"
    " numbers."
)
# Domain, module, the paper's words on SIMD and on threads, and our counterpart: kernel, form, scenes (the first with
# results). The paper's one module of forces is two kernels here.
PLAIN_LANES, PLAIN_THREADS, FINE = (
    "straightforward, vector instructions",
    "straightforward",
    "fine-grain synchronization",
)
RESTRUCTURED = "algorithm restructured"
FORCES = ("SIMD-friendly implementation, vector instructions", "coarse-grain synchronization")
CONTACTS = ["castle_hit", "castle", "pyramid_24"]
DAMS = ["dam_break_500k", "dam_break_100k"]
MODULES = [
    (
        "rigid",
        "Broad phase (SAP)",
        "SIMD-friendly implementation",
        PLAIN_THREADS,
        "rigid/sweep_and_prune",
        "batch",
        ["boxes_100k", "castle"],
    ),
    ("rigid", "Box-box", PLAIN_LANES, PLAIN_THREADS, "rigid/box_box", "", ["box_pit_4000", "pyramid_24"]),
    ("rigid", "GJK", PLAIN_LANES, PLAIN_THREADS, "rigid/gjk", "cold", ["hull_pit_2000", "hull_soup"]),
    (
        "rigid",
        "Constraint solver",
        "algorithm and data restructured",
        FINE,
        "rigid/contact_solver",
        "batches",
        CONTACTS,
    ),
    ("fluid", "Rebuild grid", PLAIN_LANES, FINE, "fluid/rebuild_grid", "counting_sort", DAMS),
    ("fluid", "Compute forces: densities", *FORCES, "fluid/densities", "pair_lists", DAMS),
    ("fluid", "Compute forces: forces", *FORCES, "fluid/forces", "pair_lists", DAMS),
    ("fluid", "Process collisions", "straightforward, autovectorizer", PLAIN_THREADS, "fluid/collisions", "", DAMS),
    ("fluid", "Advance particles", "straightforward, autovectorizer", PLAIN_THREADS, "fluid/advance", "", DAMS),
    ("cloth", "Constraint relaxation", RESTRUCTURED, RESTRUCTURED, "cloth/relax", "colours", ["flag_256", "flag_128"]),
]


NOTES = ["fluid", "cloth", "broad_phase", "narrow_phase", "contact_solver"]
REPORTS = {"bench": [kernel for *_, kernel, _, _ in MODULES], "scale": [kernel for *_, kernel, _, _ in MODULES]}


def table(data):
    rows = []
    threads = source.most_threads(data)
    for domain, module, paper_simd, paper_threads, kernel, form, scenes in MODULES:
        scene = source.first_scene(data, kernel, form, scenes)
        timed = {
            (r["variant"], r["threads"]): r
            for r in source.rows_of(data, "bench", kernel=kernel, form=form, scene=scene)
        }
        serial, twin, one, many = (
            timed.get(v) for v in (("serial", 1), ("serial_twin", 1), ("openmp", 1), ("openmp", threads))
        )
        if not (serial and one and many):
            raise source.Missing(
                f"bench.json: {kernel} '{form}' on {scene}: needs serial, and openmp on 1 and {threads} threads"
            )
        modelled = {r["cores"]: r for r in source.rows_of(data, "scale", kernel=kernel, form=form, scene=scene)}
        most = max(c for c in modelled if c <= 64)
        rows.append(
            {"domain": domain, "module": module, "kernel": kernel, "form": form, "scene": scene, "lanes": one["lanes"]}
            | {
                "paper_simd": paper_simd,
                "simd_gain": serial["ms"] / one["ms"],
                "simd_gain_spread": source.spread_of_ratio(serial, one),
            }
            | {"simd_gain_over_twin": twin["ms"] / one["ms"] if twin else None, "lane_use": one.get("lane_use")}
            | {"paper_threads": paper_threads, "threads": threads, "threads_measured": one["ms"] / many["ms"]}
            | {"threads_spread": source.spread_of_ratio(one, many), "modelled_cores": most}
            | {"threads_modelled": modelled[1]["modelled_ms"] / modelled[most]["modelled_ms"]}
            | source.whole_cores(serial, one, many)
            | {"from": source.references(serial, *([twin] if twin else []), one, many, modelled[1], modelled[most])}
        )
    return rows


def in_short(rows):
    def span(column):
        return f"{min(r[column] for r in rows):.1f}x to {max(r[column] for r in rows):.1f}x"

    return {
        "paper": "words only",
        "measured": (
            f"lanes and layout {span('simd_gain')}; {page.threads(rows[0]['threads'])} {span('threads_measured')}"
        ),
        "modelled": f"{rows[0]['modelled_cores']} cores: {span('threads_modelled')}",
        "scene": ", ".join(dict.fromkeys(r["scene"] for r in rows)),
    }


def here(rows):
    known = [r for r in rows if r["lane_use"] is not None]
    return [
        f"SIMD: serial time over openmp time on one thread, {rows[0]['lanes']} lanes; 'twin' is the serial form of the"
        " algorithm that openmp runs, if the best serial algorithm is another. The versions also differ in data"
        f" layout, so a gain may exceed that of lanes alone. Threads: one thread over {rows[0]['threads']}, measured,"
        " and one core over many, modelled. Lane use: the share of lanes that hold an element: a particle, a"
        " constraint, a pair still iterated on, a candidate to test, whether near or not"
        + (f", counted for {len(known)} of the {len(rows)} rows." if known else "; these reports do not hold it.")
    ]


def claims(rows):
    threads = f"measured, {page.threads(rows[0]['threads'])}"
    gains = {
        "simd_gain": ("lanes", "measured, 1 thread over serial"),
        "threads_measured": ("threads", threads + " over 1"),
    }
    found = []
    for column, (what, how) in gains.items():
        parts = [(r["module"], how, r[column], r) for r in rows]
        words = f"Each of the nine modules of games takes to {what}"
        found += judge.claim("[LRB08] Figure 7", words, "above 1x", judge.more_than(1), parts, "x")
    parts = [
        (r["module"], "counted", 100 * r["lane_use"], r)
        for r in rows
        if r["module"] in ("Box-box", "GJK") and r["lane_use"] is not None
    ]
    words = "Masks leave most lanes in use in the narrow phase, as the broad phase has sorted out what is apart"
    return found + judge.claim("[LRB08] on Figure 10", words, "above 50 %", judge.more_than(50), parts, "%")


def details(rows):
    header = ["", "module", "kernel", "scene", "SIMD: paper", "SIMD gain", "over twin", "lane use", "threads: paper"]
    header.append(f"{page.threads(rows[0]['threads'])}, measured")
    header.append(f"{rows[0]['modelled_cores']} cores, modelled")
    cells = [
        [
            r["domain"],
            r["module"],
            f"{r['kernel']} {r['form']}",
            r["scene"],
            r["paper_simd"],
            page.number(r["simd_gain"], "x"),
        ]
        + [page.number(r["simd_gain_over_twin"], "x")]
        + ["–" if r["lane_use"] is None else f"{100 * r['lane_use']:.0f} %"]
        + [r["paper_threads"], page.number(r["threads_measured"], "x"), page.number(r["threads_modelled"], "x")]
        for r in rows
    ]
    return page.table(header, cells)


def draw(rows):
    figure, axes = style.panels(1, 3, 3.4, 3.6, sharey=True)
    columns = [
        ("SIMD gain over serial, measured", "simd_gain", "simd_gain_spread", style.COLOURS[0], True),
        (
            f"gain of {page.threads(rows[0]['threads'])}, measured",
            "threads_measured",
            "threads_spread",
            style.COLOURS[1],
            True,
        ),
        (f"gain of {rows[0]['modelled_cores']} cores, modelled", "threads_modelled", None, style.COLOURS[2], False),
    ]
    places = range(len(rows))
    for axis, (label, column, spread, colour, filled) in zip(axes[0], columns):
        values = [r[column] for r in rows]
        look = (
            {"color": colour}
            if filled
            else {"facecolor": "white", "edgecolor": colour, "hatch": "///", "linestyle": "--"}
        )
        bars = [(r[spread] or 0) * v / 2 for r, v in zip(rows, values)] if spread else None
        for bar, r in zip(axis.barh(places, values, xerr=bars, height=0.65, **look), rows):
            if filled and not r["whole_cores"]:
                bar.set(**style.DISTURBED_BAR)
        for place, value, bar in zip(places, values, bars or [0] * len(rows)):
            style.beside(axis, page.number(value), value + bar, place)
        axis.set_xlim(0, 1.25 * max(values))
        axis.set_xlabel(label)
        axis.grid(axis="y", visible=False)
    axes[0][0].set_yticks(places, [r["module"] for r in rows])
    axes[0][0].invert_yaxis()
    return figure
