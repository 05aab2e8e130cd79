"""Five workloads over cores, and where the cores' time goes."""

import judge
import page
import source
import style

TITLE = "Scalability of game physics"
PAPER_FIGURE = "[ITJ07] Figure 10, [LRB08] Figure 14"
PAPER = (
    "[ITJ07]: 36x to 61x on 64 cores over one. [LRB08]: more than half of the cores' resources in use at up to 64"
    " cores, in some cases nearly linear. Both simulated."
)
PAPER_AT_64 = [36, 61]  # [ITJ07]
# The first scene with results is used: the one of `lockstep figures`, or its quick one.
WORKLOADS = [
    ("rigid body step", "rigid/step", "batches", ["castle_hit", "pyramid_24"]),
    ("sweep and prune", "rigid/sweep_and_prune", "batch", ["boxes_100k", "castle"]),
    ("GJK", "rigid/gjk", "cold", ["hull_pit_2000", "hull_soup"]),
    ("fluid step", "fluid/step", "pair_lists", ["dam_break_500k", "dam_break_5k"]),
    ("cloth step", "cloth/step", "colours", ["flag_128"]),
]
NOTES = ["scaling", "big_machine"]
REPORTS = {"bench": [kernel for _, kernel, *_ in WORKLOADS], "curves": None}


def table(data):
    rows = []
    for name, kernel, form, scenes in WORKLOADS:
        scene = source.first_scene(data, kernel, form, scenes, "curves")
        rows += [{"workload": name} | r for r in source.over_cores(data, kernel, form, scene)]
    return rows


def of_each(rows, kind, cores):
    return [r for r in rows if r["kind"] == kind and r["cores"] == cores]


def speed_ups(rows):
    return ", ".join(f"{r['workload']} {r['speed_up']:.1f}x" for r in rows)


def in_short(rows):
    most, measured = source.most_cores(rows), source.most_measured(rows)
    return {
        "paper": "36x to 61x at 64 cores; over 50 % utilisation",
        "measured": f"{page.threads(measured)}: " + speed_ups(of_each(rows, "measured", measured)),
        "modelled": f"{most} cores: " + speed_ups(of_each(rows, "modelled", most)),
        "scene": ", ".join(dict.fromkeys(r["scene"] for r in rows)),
    }


def here(rows):
    most = source.most_cores(rows)
    paragraphs = [
        "Speed-up of the openmp version over itself on one core, so by threads alone. All points use sixteen lanes,"
        " which leaves each core less work between barriers than the papers' cores had. Right: how the cores' time is"
        " spent."
    ]
    for r in of_each(rows, "modelled", most):
        use = r["speed_up"] / most
        least = "reached" if r["speed_up"] >= PAPER_AT_64[0] else "not reached"
        half = "reached" if use > 0.5 else "not reached"
        measured = [m for m in rows if m["kind"] == "measured" and m["workload"] == r["workload"]][-1]
        bound = r["compute_speed_up"] > 1.1 * r["speed_up"]
        unbound = f" Without the bound by memory: {r['compute_speed_up']:.1f}x." if bound else ""
        paragraphs.append(
            f"{r['workload']} ({r['kernel']} {r['form']}, {r['scene']}), modelled, {most} cores: {r['speed_up']:.1f}x,"
            f" {100 * use:.0f} % of full use ([ITJ07]'s 36x {least}, [LRB08]'s half {half}); the cores lose:"
            f" {source.losses(r)}.{unbound} Measured on {page.threads(measured['cores'])}: {measured['speed_up']:.1f}x."
        )
    return paragraphs


def claims(rows):
    at_most_cores = [source.at_most_cores(rows, workload=name) for name, *_ in WORKLOADS]
    low, high = PAPER_AT_64
    speed = [(r["workload"], source.told(r), r["speed_up"], r) for r in at_most_cores]
    use = [(of, how, 100 * speed_up / r["cores"], r) for of, how, speed_up, r in speed]
    best = max(use, key=lambda part: part[2])
    return [
        *judge.claim(
            "[ITJ07] Figure 10",
            f"Game physics is {low} to {high} times as fast on 64 cores as on one",
            f"{low}x to {high}x",
            judge.between(low, high),
            speed,
            "x",
        ),
        *judge.claim(
            "[LRB08] Figure 14",
            "More than half of the resources of up to 64 cores are in use",
            "above 50 %",
            judge.more_than(50),
            use,
            "%",
        ),
        *judge.claim(
            "[LRB08] Figure 14",
            "Some of them gain nearly in proportion to the cores (taken here as nine tenths)",
            "above 90 %",
            judge.more_than(90),
            [best],
            "%",
        ),
    ]


def draw(rows):
    figure, [[speed, where]] = style.panels(1, 2, 5.2, 4)
    cores = sorted({r["cores"] for r in rows})
    most = source.most_cores(rows)
    style.ideal(speed, cores)
    style.ideal(speed, cores, 0.5)
    for series, (name, *_) in enumerate(WORKLOADS):
        own = [r for r in rows if r["workload"] == name]
        for kind in ("modelled", "measured"):
            style.line(speed, own, kind, "speed_up", series)
    speed.plot([64, 64], PAPER_AT_64, color="#555555", linewidth=6, alpha=0.35, solid_capstyle="butt")
    style.cores_axis(speed, cores)
    style.log_y(speed, "speed-up over one core", 2)
    style.limit_to(speed, [r["speed_up"] for r in rows] + [cores[-1]], 1.3)
    keys = (
        [style.series_key(series, name) for series, (name, *_) in enumerate(WORKLOADS)]
        + style.kinds_key()
        + style.disturbed_key(rows)
    )
    keys += [style.ideal_key("all, and half of the cores in use"), style.band_key("[ITJ07] (simulated)")]
    speed.legend(handles=keys, loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2, frameon=False, fontsize=7.5)
    bars = of_each(rows, "modelled", most)
    style.stacked_shares(where, [r["workload"] for r in bars], bars, source.SHARES)
    where.set_title(f"modelled, {most} cores")
    return figure
