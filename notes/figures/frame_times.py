"""How long a frame takes, beside the papers' serial times."""

import cloth_modules
import face_modules
import judge
import page
import production_modules
import source
import style

TITLE = "Time a frame, by application"
PAPER_FIGURE = "[ITJ07] Parallelization Methodology"
PAPER = (
    "Serial seconds a frame on a 4-way 3.0 GHz Xeon: production fluid 188, face 14, production cloth 5; game rigid body"
    " 1, game fluid 0.4, game cloth 0.1, on scenes of high complexity; their sizes are not given. The target is 30"
    " frames a second."
)
GAMES = [
    ("game rigid body", 1000, "rigid/step", "batches", ["castle_hit", "castle", "pyramid_24"]),
    ("game fluid", 400, "fluid/step", "pair_lists", ["dam_break_500k", "dam_break_100k", "dam_break_5k"]),
    ("game cloth", 100, "cloth/step", "colours", ["flag_256", "flag_128"]),
]
# Application, the paper's time, the figure whose report has frames of it, and what says how large its scene is.
PRODUCTION = [
    ("production fluid", 188e3, "production_modules", production_modules.FORM, "cells"),
    ("production face", 14e3, "face_modules", face_modules.FORM, "tetrahedra"),
    ("production cloth", 5e3, "cloth_modules", cloth_modules.FORM, "triangles"),
]
NOTES = ["fluid", "cloth", "production_fluid", "production_face", "production_cloth"]
REPORTS = {"bench": [kernel for _, _, kernel, *_ in GAMES], "scale": [kernel for _, _, kernel, *_ in GAMES]}
REPORTS |= {report: None for _, _, report, *_ in PRODUCTION}
REAL_TIME_MS = 1000 / 30


def table(data):
    rows = []
    variants = dict.fromkeys([("serial", 1), ("openmp", 1), ("openmp", source.most_threads(data))])
    for application, paper_ms, kernel, form, scenes in GAMES:
        scene = source.first_scene(data, kernel, form, scenes)
        for variant, threads in variants:
            r = source.row_of(data, "bench", kernel=kernel, form=form, scene=scene, variant=variant, threads=threads)
            rows.append(
                {"application": application, "paper_serial_ms": paper_ms, "kernel": kernel, "form": form}
                | {"scene": scene, "items": r["items"], "unit": r["unit"], "variant": variant, "threads": threads}
                | {"ms": r["ms"], "spread": r["spread"]}
                | source.whole_cores(r)
                | {"from": r["from"]}
            )
    for application, paper_ms, report, form, unit in PRODUCTION:
        frames = source.rows_of(data, report, form=form)
        most = max(r["threads"] for r in frames)
        for variant, threads in dict.fromkeys([("serial", 1), ("openmp", 1), ("openmp", most)]):
            r = source.at(frames, variant=variant, threads=threads)
            rows.append(
                {"application": application, "paper_serial_ms": paper_ms, "form": form, "scene": r["scene"]}
                | {"items": r[unit], "unit": unit, "variant": variant, "threads": threads}
                | {"ms": sum(module["ms"] for module in r["modules"]), "spread": None, "from": r["from"]}
            )
    return rows


def is_game(r):
    return r["application"].startswith("game")


def in_short(rows):
    def words(variant, threads):
        own = [r for r in rows if is_game(r) and (r["variant"], r["threads"]) == (variant, threads)]
        return ", ".join(f"{r['application'].removeprefix('game ')} {r['ms']:.3g} ms" for r in own)

    most = max(r["threads"] for r in rows if is_game(r))
    production = [r for r in rows if not is_game(r)]
    many = max(r["threads"] for r in production)
    frames = ", ".join(f"{r['application']} {r['ms'] / 1e3:.3g} s" for r in production if r["threads"] == many > 1)
    return {
        "paper": "serial: game rigid body 1 s, fluid 0.4 s, cloth 0.1 s; production fluid 188 s, face 14 s, cloth 5 s",
        "measured": f"serial: {words('serial', 1)}; {page.threads(most)}: {words('openmp', most)}"
        + (f"; {frames}" if frames else ""),
        "modelled": "–",
        "scene": ", ".join(dict.fromkeys(r["scene"] for r in rows)),
    }


def here(rows):
    of_each = "; ".join(
        dict.fromkeys(f"{r['application']}: {r['scene']} ({r['items']:,.0f} {r['unit']})" for r in rows)
    )
    return [
        f"{of_each}. A frame of a game is one step, one of a production application as many as 1/24 s (cloth: 1/60 s)"
        " takes. Games: medians of the repeats, bars are interquartile ranges; production: one frame, the sum of its"
        " modules. The papers' scenes are not published and their machine is some twenty years older. A ratio between"
        " their times and ours has therefore no meaning."
    ]


def claims(rows):
    most = max(r["threads"] for r in rows if is_game(r))
    own = [r for r in rows if is_game(r) and (r["variant"], r["threads"]) == ("openmp", most)]
    parts = [(f"{r['application']}, {r['scene']}", f"measured, {page.threads(most)}", r["ms"], r) for r in own]
    words = "Games need 30 frames a second (the aim of the paper; its scenes' sizes are not known)"
    judged = judge.within(REAL_TIME_MS)
    return judge.claim("[ITJ07] Methodology", words, f"at most {REAL_TIME_MS:.1f} ms", judged, parts, "ms")


def draw(rows):
    figure, [[axis]] = style.panels(1, 1, 11, 5.6)
    looks = {
        "serial": {"color": style.COLOURS[3]},
        "openmp": {"color": style.COLOURS[6], "hatch": "///", "edgecolor": "white"},
        "most": {"color": style.COLOURS[0], "hatch": "...", "edgecolor": "white"},
    }
    paper = {"facecolor": "white", "edgecolor": "#555555"}
    labels = {"paper": "[ITJ07], serial", "serial": "here, serial", "openmp": "here, openmp, 1 thread"}
    labels["most"] = f"here, openmp, {page.threads(max(r['threads'] for r in rows))}"
    names, place = [], 0
    for application in dict.fromkeys(r["application"] for r in rows):
        own = [r for r in rows if r["application"] == application]
        bars = [("paper", own[0]["paper_serial_ms"], 0, True, paper)]
        for r in own:
            kind = "most" if r["threads"] > 1 else r["variant"]
            bars.append((kind, r["ms"], r["spread"] or 0, r.get("whole_cores", True), looks[kind]))
        names.append((place + (len(bars) - 1) / 2, f"{application}\n{own[0]['scene']}"))
        for kind, ms, spread, whole, look in bars:
            [bar] = axis.barh(place, ms, height=0.9, xerr=spread * ms / 2 or None, label=labels.pop(kind, None), **look)
            if not whole:
                bar.set(**style.DISTURBED_BAR)
            words = page.number(ms, "ms") if ms < 1000 else page.number(ms / 1000, "s")
            style.beside(axis, words, ms * (1 + spread / 2), place)
            place += 1
        place += 0.8
    axis.axvline(REAL_TIME_MS, linestyle="--", label="30 frames a second", **style.BOUND)
    style.log_x(axis, "time a frame, ms")
    axis.set_xlim(min(r["ms"] for r in rows) / 3, 8e5)
    axis.set_yticks(*zip(*names))
    axis.set_ylim(place - 0.5, -0.9)
    axis.grid(axis="y", visible=False)
    style.key_below(figure, axis.get_legend_handles_labels()[0])
    return figure
