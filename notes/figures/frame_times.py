"""How long a frame takes, beside the papers' serial times."""

import page
import source
import style

TITLE = "Time a frame, by application"
PAPER_FIGURE = "[ITJ07] Parallelization Methodology"
PAPER = (
    "Serial seconds a frame on a 4-way 3.0 GHz Xeon: production fluid 188, face 14, production cloth 5; game rigid body"
    " 1, game fluid 0.4, game cloth 0.1, on scenes of high complexity; their sizes are not given. The target is 30"
    " frames a second."
)
PRODUCTION_MS = {"production fluid": 188e3, "production face": 14e3, "production cloth": 5e3}
GAMES = [
    ("game rigid body", 1000, "rigid/step", "batches", ["castle_hit", "castle", "pyramid_24"]),
    ("game fluid", 400, "fluid/step", "pair_lists", ["dam_break_500k", "dam_break_100k"]),
    ("game cloth", 100, "cloth/step", "colours", ["flag_256", "flag_128"]),
]
REPORTS = {"bench": [kernel for _, _, kernel, *_ in GAMES], "scale": [kernel for _, _, kernel, *_ in GAMES]}
REAL_TIME_MS = 1000 / 30


def table(data):
    rows = []
    variants = dict.fromkeys([("serial", 1), ("openmp", 1), ("openmp", source.most_threads(data))])
    for application, paper_ms, kernel, form, scenes in GAMES:
        scene = source.first_scene(data, kernel, form, scenes)
        for variant, threads in variants:
            r = source.row_of(data, "bench", kernel=kernel, form=form, scene=scene, variant=variant, threads=threads)
            rows.append(
                {
                    "application": application,
                    "paper_serial_ms": paper_ms,
                    "kernel": kernel,
                    "form": form,
                    "scene": scene,
                }
                | {"items": r["items"], "unit": r["unit"], "variant": variant, "threads": threads}
                | {"ms": r["ms"], "spread": r["spread"]}
                | source.whole_cores(r)
                | {"from": r["from"]}
            )
    return rows


def scene_words(r):
    return (
        f"{r['scene']} ({r['items']:,.0f} {r['unit']} a frame)"
        if r["unit"] != "bodies"
        else f"{r['scene']} ({r['items']:,.0f} bodies)"
    )


def in_short(rows):
    def words(variant, threads):
        own = [r for r in rows if (r["variant"], r["threads"]) == (variant, threads)]
        return ", ".join(f"{r['application'].removeprefix('game ')} {r['ms']:.3g} ms" for r in own)

    most = max(r["threads"] for r in rows)
    return {
        "paper": "serial: game rigid body 1 s, fluid 0.4 s, cloth 0.1 s; production fluid 188 s, face 14 s, cloth 5 s",
        "measured": f"serial: {words('serial', 1)}; {page.threads(most)}: {words('openmp', most)}",
        "modelled": "–",
        "scene": ", ".join(dict.fromkeys(r["scene"] for r in rows)),
    }


def here(rows):
    games = "; ".join(dict.fromkeys(f"{r['application']}: {r['kernel']} {r['form']}, {scene_words(r)}" for r in rows))
    return [
        f"{games}. A frame is one step. Times are medians of the repeats; bars are interquartile ranges. The production"
        " applications (fluid, face, cloth) are not in this repository, so their times have no counterpart here. The"
        " papers' scenes are not published and their machine is some twenty years older. A ratio between their times"
        " and ours has therefore no meaning."
    ]


def draw(rows):
    figure, [[axis]] = style.panels(1, 1, 8.5, 4.4)
    most = max(r["threads"] for r in rows)
    looks = {
        ("serial", 1): {"color": style.COLOURS[3], "label": "here, serial"},
        ("openmp", most): {
            "color": style.COLOURS[0],
            "hatch": "...",
            "edgecolor": "white",
            "label": f"here, openmp, {page.threads(most)}",
        },
        ("openmp", 1): {
            "color": style.COLOURS[6],
            "hatch": "///",
            "edgecolor": "white",
            "label": "here, openmp, 1 thread",
        },
    }
    paper = {"facecolor": "white", "edgecolor": "#555555"}
    names, place = [], 0
    for application, paper_ms, *_ in GAMES:
        own = [r for r in rows if r["application"] == application]
        bars = [(paper_ms, 0, True, paper)]
        bars += [(r["ms"], r["spread"] or 0, r["whole_cores"], looks[r["variant"], r["threads"]]) for r in own]
        names.append((place + 1.5, f"{application}\n{own[0]['scene']}"))
        for ms, spread, whole, look in bars:
            first = application == GAMES[0][0] and look is not paper
            look = {k: v for k, v in look.items() if k != "label" or first}
            [bar] = axis.barh(place, ms, height=0.9, xerr=spread * ms / 2 or None, **look)
            if not whole:
                bar.set(**style.DISTURBED_BAR)
            style.beside(axis, page.number(ms, "ms"), ms * (1 + spread / 2), place)
            place += 1
        place += 0.8
    for application, ms in PRODUCTION_MS.items():
        names.append((place, f"{application}\n(not implemented here)"))
        axis.barh(
            place, ms, height=0.9, label="[ITJ07], serial" if application == "production fluid" else None, **paper
        )
        style.beside(axis, page.number(ms / 1000, "s"), ms, place)
        place += 1.8
    axis.axvline(REAL_TIME_MS, linestyle="--", **style.BOUND)
    axis.annotate(
        "30 frames a second",
        (REAL_TIME_MS, place - 0.6),
        xytext=(3, 0),
        textcoords="offset points",
        fontsize=7,
        color="#555555",
    )
    style.log_x(axis, "time a frame, ms")
    axis.set_xlim(min(r["ms"] for r in rows) / 3, 8e5)
    axis.set_yticks(*zip(*names))
    axis.invert_yaxis()
    axis.grid(axis="y", visible=False)
    style.key_below(figure, axis.get_legend_handles_labels()[0])
    return figure
