"""A step of the fluid, by the way in which forms avoid conflicts between threads."""

import judge
import page
import source
import style

TITLE = "Game fluid: what locks cost"
PAPER_FIGURE = "[LRB08], on Figure 9"
PAPER = (
    "A lock for each grid cell would cost much; sub-grids owned by threads, with locks for cells on their borders"
    " alone, almost entirely amortise it. The paper gives no numbers."
)
NOTES = ["fluid", "scaling"]
REPORTS = {"bench": ["fluid/step"], "curves": None}
FORMS = {
    "owner_gather": "no lock: each particle gathers its own sums",
    "pair_lists": "no lock: pairs listed once",
    "sub_grid": "locks on the borders of sub-grids",
    "cell_locks": "a lock a cell",
}


def table(data):
    scenes = ["dam_break_500k", "dam_break_5k"]
    scene = source.first_scene(data, "fluid/step", "cell_locks", scenes, "curves")
    return [r for form in FORMS for r in source.over_cores(data, "fluid/step", form, scene)]


def of_each(rows, kind, cores):
    return [r for r in rows if r["kind"] == kind and r["cores"] == cores]


def in_short(rows):
    most, measured = source.most_cores(rows), source.most_measured(rows)
    return {
        "paper": "a lock a cell costs much, locks on borders almost nothing",
        "measured": f"{page.threads(measured)}: " + ", ".join(
            f"{r['form']} {r['ms']:.3g} ms" for r in of_each(rows, "measured", measured)
        ),
        "modelled": f"{most} cores: " + ", ".join(
            f"{r['form']} {r['ms']:.3g} ms ({100 * r['locks']:.0f} % in locks)" for r in of_each(rows, "modelled", most)
        ),
        "scene": rows[0]["scene"],
    }


def here(rows):
    most = source.most_cores(rows)
    paragraphs = [
        f"{rows[0]['scene']}, fluid/step. Locks: the share of the cores' time in taking locks and waiting for them;"
        " modelled, also at 1 and 2 cores."
    ]
    for r in of_each(rows, "modelled", most):
        one = source.at(rows, kind="modelled", form=r["form"], cores=1)
        paragraphs.append(
            f"{r['form']}: {100 * one['locks']:.0f} % in locks on one core, {100 * r['locks']:.0f} % on {most},"
            f" {r['speed_up']:.1f}x; the cores lose: {source.losses(r)}."
        )
    sub_grid = source.at(rows, kind="modelled", form="sub_grid", cores=most)
    if sub_grid["locks"] < 0.05:
        return [
            *paragraphs,
            "The paper's claim that locks on borders are almost entirely amortised holds: less than 5 % of the time.",
        ]
    why = "with more cores the sub-grids are smaller, and a larger part of each is border"
    return [
        *paragraphs,
        f"The paper's claim that locks on borders are almost entirely amortised is not reached: {why}.",
    ]


def claims(rows):
    borders, cells = (source.at_most_cores(rows, form=form) for form in ("sub_grid", "cell_locks"))
    most = source.most_cores(rows)
    locks = source.at(rows, kind="modelled", form="sub_grid", cores=most)
    both = {"from": source.references(borders, cells)}
    return [
        *judge.claim(
            "[LRB08] on Figure 9",
            "A lock for every cell costs much more than locks on the borders of sub-grids",
            "above 1x",
            judge.more_than(1),
            [("time with a lock a cell over time without", source.told(cells), cells["ms"] / borders["ms"], both)],
            "x",
        ),
        *judge.claim(
            "[LRB08] on Figure 9",
            "Locks on borders cost almost nothing (taken here as a twentieth of the time)",
            "at most 5 %",
            judge.within(5),
            [("share of the cores' time in locks", source.told(locks), 100 * locks["locks"], locks)],
            "%",
        ),
    ]


def draw(rows):
    figure, [[time, speed, locks]] = style.panels(1, 3, 3.5, 3.2)
    cores = sorted({r["cores"] for r in rows})
    style.ideal(speed, cores)
    for series, form in enumerate(FORMS):
        own = [r for r in rows if r["form"] == form]
        for kind in ("modelled", "measured"):
            style.line(time, own, kind, "ms", series)
            style.line(speed, own, kind, "speed_up", series)
        modelled = [r for r in own if r["kind"] == "modelled"]
        style.modelled(locks, [r["cores"] for r in modelled], [100 * r["locks"] for r in modelled], series)
    for axis in (time, speed, locks):
        style.cores_axis(axis, cores)
    style.log_y(time, "ms a step")
    style.limit_to(time, [r["ms"] for r in rows])
    style.log_y(speed, "speed-up over one core", 2)
    style.limit_to(speed, [r["speed_up"] for r in rows] + [cores[-1]], 1.3)
    locks.set_ylabel("time in locks, % of the cores' time")
    keys = [style.series_key(series, f"{form} ({words})") for series, (form, words) in enumerate(FORMS.items())]
    style.key_below(figure, [*keys, *style.kinds_key(), *style.disturbed_key(rows), style.ideal_key()], 3)
    return figure
