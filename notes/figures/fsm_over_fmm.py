"""Marching and sweeping in padded blocks: which is faster on how many cores, and the work that padding makes."""

import judge
import page
import source
import style

TITLE = "Level set: fast sweeping relative to fast marching, in blocks"
PAPER_FIGURE = "[ITJ07] Figure 9"
PAPER = (
    "Serial sweeping takes 30 % longer than serial marching. In blocks padded by the band, marching is ahead up to 16"
    " cores and sweeping beyond, by 2 at 64; marching reaches a speed-up of 21 there, sweeping 55. Simulated."
)
NOTES = ["levelset"]
REPORTS = {"levelset_blocks": None}
NAMES = {"fast_marching": "marching", "fast_sweeping": "sweeping"}
SERIES = {"fast_marching": 0, "fast_sweeping": 1}
PAPER_AT_64 = {"fast_marching": 21, "fast_sweeping": 55}
PAPER_RATIO = {1: 1 / 1.3, 16: 1, 64: 2}  # marching time over sweeping time, as its text says


def table(data):
    rows = []
    serial = {a: source.row_of(data, "levelset_blocks", algorithm=a, variant="serial") for a in NAMES}
    for algorithm in NAMES:
        own = serial[algorithm]
        rows.append(
            {
                "kind": "serial",
                "algorithm": algorithm,
                "scene": own["scene"],
                "ms": own["measured_ms"],
                "from": own["from"],
            }
        )
        found = source.rows_of(data, "levelset_blocks", algorithm=algorithm, variant="openmp")
        for kind, ms in (("measured", "measured_ms"), ("modelled", "modelled_ms")):
            for cores in sorted({r["cores"] for r in found if ms in r}):
                best = min((r for r in found if r["cores"] == cores), key=lambda r: r[ms])
                rows.append(
                    {
                        "kind": kind,
                        "algorithm": algorithm,
                        "scene": best["scene"],
                        "cores": cores,
                        "blocks": best["blocks"],
                        "ms": best[ms],
                    }
                    | {"over_serial_marching": serial["fast_marching"]["measured_ms"] / best[ms]}
                    | {"over_own_serial": own["measured_ms"] / best[ms]}
                    | (source.where_time_goes(best) if kind == "modelled" else source.whole_cores(best))
                    | {"from": source.references(serial["fast_marching"], own, best)}
                )
    for sweeping in [r for r in rows if r["kind"] != "serial" and r["algorithm"] == "fast_sweeping"]:
        marching = source.at(rows, kind=sweeping["kind"], algorithm="fast_marching", cores=sweeping["cores"])
        sweeping["marching_over_sweeping"] = marching["ms"] / sweeping["ms"]
        sweeping["from"] = source.references(sweeping, marching)
        sweeping |= source.whole_cores(sweeping, marching)
    overlap = {
        r["blocks"]: r for r in source.rows_of(data, "levelset_blocks", algorithm="fast_marching", variant="openmp")
    }
    for blocks, r in sorted(overlap.items()):
        rows.append(
            {"kind": "overlap", "scene": r["scene"], "blocks": blocks}
            | {"computed_over_wanted": r["work_points"] / r["band_points"], "from": r["from"]}
        )
    return rows


def crossing(rows):
    """In words: at which numbers of modelled cores sweeping in blocks is the faster one."""
    ahead = {
        r["cores"]: r["marching_over_sweeping"] > 1
        for r in rows
        if r["kind"] == "modelled" and "marching_over_sweeping" in r
    }
    if len(set(ahead.values())) == 1:
        return (
            f"{'sweeping' if ahead[1] else 'marching'} is ahead at every number of cores modelled: there is no crossing"
        )
    return (
        f"sweeping is ahead at {', '.join(str(cores) for cores, sweeping in ahead.items() if sweeping)} cores, marching"
        " at the others"
    )


def in_short(rows):
    def words(kind, cores):
        of = {a: source.at(rows, kind=kind, algorithm=a, cores=cores) for a in NAMES}
        speed_ups = ", ".join(
            f"{name} {of[a]['over_own_serial']:.1f}x over its serial form" for a, name in NAMES.items()
        )
        return f"{speed_ups}; marching time over sweeping time {of['fast_sweeping']['marching_over_sweeping']:.1f}"

    most, measured = source.most_cores(rows), source.most_measured(rows)
    return {
        "paper": "64 cores: marching 21x, sweeping 55x over one; sweeping ahead by 2, from 16 cores on",
        "measured": f"{page.threads(measured)}: {words('measured', measured)}",
        "modelled": f"{most} cores: {words('modelled', most)}",
        "scene": rows[0]["scene"],
    }


def here(rows):
    most = source.most_cores(rows)
    serial = {a: source.at(rows, kind="serial", algorithm=a)["ms"] for a in NAMES}
    overlap = [r for r in rows if r["kind"] == "overlap"]
    paragraphs = [
        f"{rows[0]['scene']}. At each number of cores each algorithm uses its best number of blocks, which stands"
        f" beside the point. Serial sweeping takes {serial['fast_sweeping'] / serial['fast_marching']:.2f} of the time"
        " of serial marching (paper: 1.3). Sweeping uses sixteen lanes; marching uses a heap and no lanes; the times"
        f" include this; {crossing(rows)}. Padding: {overlap[-1]['blocks']} blocks compute"
        f" {overlap[-1]['computed_over_wanted']:.1f} distances for each that is needed, in both algorithms."
    ]
    for algorithm, name in NAMES.items():
        r = source.at(rows, kind="modelled", algorithm=algorithm, cores=most)
        reached = "reached" if r["over_own_serial"] >= PAPER_AT_64[algorithm] else "not reached"
        paragraphs.append(
            f"The paper's {PAPER_AT_64[algorithm]} for {name} is {reached} at {most} cores"
            f" ({r['over_own_serial']:.1f} over its own serial form, {r['blocks']} blocks); the cores lose:"
            f" {source.losses(r)}."
        )
    return paragraphs


def claims(rows):
    serial = {a: source.at(rows, kind="serial", algorithm=a) for a in NAMES}
    slower = serial["fast_sweeping"]["ms"] / serial["fast_marching"]["ms"]
    both = {"from": source.references(*serial.values())}
    found = judge.claim(
        "[ITJ07] on Figure 9",
        "Serially, sweeping takes 1.3 times as long as marching",
        "1.3",
        judge.at_most(1.3),
        [("sweeping", "measured, serial", slower, both)],
    )
    for algorithm, name in NAMES.items():
        asked = PAPER_AT_64[algorithm]
        many = source.at_most_cores(rows, algorithm=algorithm)
        one = source.at(rows, kind=many["kind"], algorithm=algorithm, cores=1)
        alone = {"from": source.references(one, many)}
        parts = [
            ("over its serial form", source.told(many), many["over_own_serial"], many),
            ("over one core, so by threads alone", source.told(many), one["ms"] / many["ms"], alone),
        ]
        words = f"In padded blocks, 64 cores make {name} {asked} times as fast"
        found += judge.claim("[ITJ07] on Figure 9", words, f"{asked}x", judge.at_least(asked), parts, "x")
    few = source.at(rows, kind="modelled", algorithm="fast_sweeping", cores=16)
    if few:
        parts = [("marching time over sweeping time", source.told(few), few["marching_over_sweeping"], few)]
        words = "Up to 16 cores marching is the faster one"
        found += judge.claim("[ITJ07] Figure 9", words, "at most 1", judge.within(1), parts)
    many = source.at_most_cores(rows, algorithm="fast_sweeping")
    parts = [("marching time over sweeping time", source.told(many), many["marching_over_sweeping"], many)]
    words = "On 64 cores sweeping is twice as fast as marching"
    return found + judge.claim("[ITJ07] Figure 9", words, "2", judge.at_least(2), parts)


def draw(rows):
    figure, [[ratio, over_marching, over_own, overlap]] = style.panels(1, 4, 2.85, 3)
    cores = sorted({r["cores"] for r in rows if r["kind"] == "modelled"})
    for axis, measure in ((over_marching, "over_serial_marching"), (over_own, "over_own_serial")):
        for algorithm, series in SERIES.items():
            own = [r for r in rows if r.get("algorithm") == algorithm]
            for kind in ("modelled", "measured"):
                style.line(axis, own, kind, measure, series)
            if axis is over_marching:
                for r in own:
                    if r["kind"] == "modelled":
                        place = dict(
                            xytext=(0, 6 if series else -12), textcoords="offset points", ha="center", fontsize=6.5
                        )
                        axis.annotate(f"{r['blocks']}", (r["cores"], r[measure]), color=style.COLOURS[series], **place)
        style.cores_axis(axis, cores)
        style.log_y(axis, "speed-up")
    for kind in ("modelled", "measured"):
        style.line(ratio, rows, kind, "marching_over_sweeping", SERIES["fast_sweeping"])
    ratio.plot(*zip(*PAPER_RATIO.items()), **style.PAPER)
    ratio.axhline(1, **style.BOUND)
    style.cores_axis(ratio, cores)
    style.log_y(ratio, "marching time / sweeping time")
    ratio.set_title("sweeping relative to marching")
    over_marching.margins(y=0.12)
    over_marching.set_title("over serial marching (number: blocks)")
    over_own.set_title("each over its own serial form")
    for value in PAPER_AT_64.values():
        over_own.plot(64, value, **style.PAPER)
    style.ideal(over_own, cores)
    padding = [r for r in rows if r["kind"] == "overlap"]
    blocks = [r["blocks"] for r in padding]
    overlap.plot(blocks, [r["computed_over_wanted"] for r in padding], color=style.COLOURS[3], marker=style.MARKERS[3])
    style.power_axis(overlap, blocks, "blocks")
    overlap.tick_params(axis="x", labelsize=6.5)
    overlap.set_ylabel("distances computed / wanted")
    overlap.set_ylim(bottom=0)
    overlap.set_title("what padding costs (counted)")
    keys = [style.series_key(SERIES[a], f"fast {name}") for a, name in NAMES.items()]
    keys += [*style.kinds_key(), *style.disturbed_key(rows), style.paper_key(), style.ideal_key()]
    style.key_below(figure, keys)
    return figure
