"""The contact solver with contacts in their order, in batches and in blocks, and how large the batches are."""

import judge
import page
import source
import style

TITLE = "Contact solver: contacts reordered into batches"
PAPER_FIGURE = "[ITJ07] Figure 5"
PAPER = (
    "With contacts in their original order the solver is at most 4 times faster on 64 cores than serial; reordered into"
    " batches without conflicts, 35 times, with the time to reorder. Simulated; the paper does not mention lanes."
)
NOTES = ["batches", "contact_solver"]
REPORTS = {"contact_batches": None}
PAPER_AT_64 = {"original": 4, "batches": 35, "blocks": 35}
SERIES = {"original": 1, "batches": 0, "blocks": 2}


def table(data):
    rows = []
    for scene in dict.fromkeys(r["scene"] for r in data["contact_batches"]["rows"]):
        serial = source.row_of(data, "contact_batches", scene=scene, form="original", variant="serial")
        for form in (*SERIES, "reorder"):
            found = source.rows_of(data, "contact_batches", scene=scene, form=form, variant="openmp")
            for kind, ms in (("measured", "measured_ms"), ("modelled", "modelled_ms")):
                timed = [r for r in found if ms in r]
                for r in timed:
                    speed_ups = {"over_serial": serial["measured_ms"] / r[ms], "over_one_core": timed[0][ms] / r[ms]}
                    rows.append(
                        {"scene": scene, "form": form, "kind": kind, "cores": r["cores"], "ms": r[ms]}
                        | (speed_ups if form != "reorder" else {})
                        | (source.whole_cores(timed[0], r) if kind == "measured" else {})
                        | (source.where_time_goes(r) if kind == "modelled" else {})
                        | {"from": source.references(serial, timed[0], r)}
                    )
        for r in source.rows_of(data, "contact_batches", scene=scene, variant="batch_size"):
            rows.append(
                {"scene": scene, "kind": "batch", "batch": r["batch"], "contacts": r["contacts"], "from": r["from"]}
            )
    return rows


def scenes_of(rows):
    return list(dict.fromkeys(r["scene"] for r in rows))


def of_all_scenes(rows, kind, cores, column):
    """In words: each order, from the scene where its gain is lowest to where it is highest."""
    words = []
    for form in ("blocks", "batches", "original"):
        values = [r[column] for r in rows if r.get("form") == form and r["kind"] == kind and r["cores"] == cores]
        words.append(f"{form} {min(values):.1f}x" + (f" to {max(values):.1f}x" if len(values) > 1 else ""))
    return ", ".join(words)


def in_short(rows):
    most, measured = source.most_cores(rows), source.most_measured(rows)
    return {
        "paper": "35x reordered, 4x in the original order, 64 cores over serial",
        "measured": f"{page.threads(measured)} over serial: {of_all_scenes(rows, 'measured', measured, 'over_serial')}",
        "modelled": (
            f"{most} cores over serial: {of_all_scenes(rows, 'modelled', most, 'over_serial')}; "
            f"over one core: {of_all_scenes(rows, 'modelled', most, 'over_one_core')}"
        ),
        "scene": ", ".join(scenes_of(rows)),
    }


def here(rows):
    most = source.most_cores(rows)
    paragraphs = [
        "Settled scenes, one step. Above: speed-up over the scalar serial solver in the original order, by lanes"
        " and threads together; this is the paper's measure. Middle: speed-up over the same code on one core, by"
        " threads alone. The original order runs in parallel as far as its dependences allow, and keeps its bits."
        " Batches, and blocks of space, include the time to make them. Below: contacts in each batch; a vector holds"
        " sixteen. Times are the least disturbed of the repeats."
    ]
    for scene in scenes_of(rows):
        batches = source.at(rows, scene=scene, form="batches", kind="modelled", cores=most)
        reorder = source.at(rows, scene=scene, form="reorder", kind="modelled", cores=most)
        original = source.at(rows, scene=scene, form="original", kind="modelled", cores=most)
        blocks = source.at(rows, scene=scene, form="blocks", kind="modelled", cores=most)
        reached = "reached" if batches["over_serial"] >= PAPER_AT_64["batches"] else "not reached"
        alone = "reached" if batches["over_one_core"] >= PAPER_AT_64["batches"] else "not reached"
        paragraphs.append(
            f"{scene}: at {most} cores batches are {batches['over_serial']:.1f} times faster than serial (35 {reached})"
            f" and {batches['over_one_core']:.1f} times faster than on one core (35 {alone}), the original order"
            f" {original['over_serial']:.1f} and {original['over_one_core']:.1f} times (paper: 4);"
            f" {100 * reorder['ms'] / batches['ms']:.0f} % of the time makes the batches. What the cores lose:"
            f" {source.losses(batches)}. Blocks are {blocks['over_serial']:.1f} and {blocks['over_one_core']:.1f} times"
            f" faster, and the cores lose: {source.losses(blocks)}."
        )
    return paragraphs


def claims(rows):
    claimed = {
        "original": "In their original order, contacts let 64 cores be 4 times as fast as serial",
        "batches": "Reordered into batches without conflicts, 35 times, with the time to reorder",
        "blocks": "The same, with contacts in blocks of space instead of batches",
    }
    measures = {"over_serial": "over serial", "over_one_core": "over one core, so by threads alone"}
    found = []
    for form, words in claimed.items():
        asked, parts = PAPER_AT_64[form], []
        for scene in scenes_of(rows):
            r = source.at_most_cores(rows, scene=scene, form=form)
            parts += [(f"{scene}, {of}", source.told(r), r[column], r) for column, of in measures.items()]
        found += judge.claim("[ITJ07] Figure 5", words, f"{asked}x", judge.at_least(asked), parts, "x")
    return found


def draw(rows):
    scenes = scenes_of(rows)
    figure, axes = style.panels(3, len(scenes), max(2.7, 7 / len(scenes)), 2.4)
    cores = sorted({r["cores"] for r in rows if r["kind"] == "modelled"})
    for column, scene in enumerate(scenes):
        own = [r for r in rows if r["scene"] == scene]
        over_serial, over_one, sizes = axes[:, column]
        for axis, measure in ((over_serial, "over_serial"), (over_one, "over_one_core")):
            for form, series in SERIES.items():
                for kind in ("modelled", "measured"):
                    style.line(axis, [r for r in own if r.get("form") == form], kind, measure, series)
            style.cores_axis(axis, cores)
            style.log_y(axis, "")
        for value in PAPER_AT_64.values():
            over_serial.plot(64, value, **style.PAPER)
        style.ideal(over_one, cores)
        batches = sorted((r["batch"], r["contacts"]) for r in own if r["kind"] == "batch")
        sizes.bar(*zip(*batches), width=1, color=style.COLOURS[0], edgecolor="white", linewidth=0.4)
        sizes.axhline(16, linestyle="--", **style.BOUND)
        style.log_y(sizes, "")
        sizes.xaxis.set_major_locator(style.MaxNLocator(integer=True))
        sizes.set_xlabel("batch")
        over_serial.set_title(scene)
    for axis, label in zip(axes[:, 0], ("speed-up over serial", "speed-up over one core", "contacts in the batch")):
        axis.set_ylabel(label)
    names = {"original": "original order", "batches": "batches", "blocks": "blocks of space"}
    keys = [style.series_key(SERIES[form], words) for form, words in names.items()]
    keys += [*style.kinds_key(), *style.disturbed_key(rows), style.paper_key(), style.ideal_key()]
    style.key_below(figure, keys, 4)
    return figure
