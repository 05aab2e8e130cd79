"""What the modelled speed-ups owe to this machine: dearer and cheaper barriers, another memory."""

import page
import source
import style

TITLE = "How far the model depends on its machine"
PAPER_FIGURE = "none"
PAPER = "The papers simulate one machine; how its barriers and memory matter, they do not show."
NOTES = ["scaling"]
REPORTS = {"sensitivity": None}


def table(data):
    """A row for each kernel and machine: the same records, replayed at other costs."""
    rows = []
    many = max(r["cores"] for r in source.rows_of(data, "sensitivity"))
    for at_many in source.rows_of(data, "sensitivity", cores=many):
        named = {column: at_many[column] for column in ("kernel", "form", "scene")}
        one = source.row_of(data, "sensitivity", **named, cores=1)
        here = at_many["replays"][0]["memory_gb_per_s"]
        for alone, replay in zip(one["replays"], at_many["replays"], strict=True):
            memory = "here" if replay["memory_gb_per_s"] == here else "server"
            shares = {column: replay[column] for column in ("together", "waiting", "serial")}
            rows.append(
                named
                | {"kind": "modelled", "cores": many, "barriers": replay["barriers"], "memory": memory}
                | {"memory_gb_per_s": replay["memory_gb_per_s"], "ms": replay["modelled_ms"]}
                | {"speed_up": alone["modelled_ms"] / replay["modelled_ms"]}
                | {"bound_by_memory": replay["memory_ms"] >= replay["compute_ms"]}
                | shares
                | {"from": source.references(one, at_many)}
            )
    return rows


def kernels(rows):
    return list(dict.fromkeys(r["kernel"] for r in rows))


def of(rows, kernel, barriers, memory):
    return source.at(rows, kernel=kernel, barriers=barriers, memory=memory)


def in_short(rows):
    as_here = [r for r in rows if r["barriers"] == 1 and r["memory"] == "here"]
    return {
        "paper": "–",
        "measured": "–",
        "modelled": f"{rows[0]['cores']} cores, barriers half as dear to twice: "
        + ", ".join(
            f"{r['kernel']} {of(rows, r['kernel'], 0.5, 'here')['speed_up']:.1f}x to"
            f" {of(rows, r['kernel'], 2, 'here')['speed_up']:.1f}x"
            for r in as_here
        ),
        "scene": ", ".join(r["scene"] for r in as_here),
    }


def here(rows):
    cores = rows[0]["cores"]
    server = next(r for r in rows if r["memory"] == "server")
    own = next(r for r in rows if r["memory"] == "here")
    paragraphs = [
        f"Speed-up at {cores} modelled cores over one. Forks, joins and barriers cost half as much as here, as much,"
        f" and twice as much; memory carries {page.number(own['memory_gb_per_s'])} GB/s as here, or"
        f" {page.number(server['memory_gb_per_s'])} GB/s, what eight channels of DDR5-4800 carry at most. One core's"
        " barriers cost the same in all. All machines replay the same records, so nothing else differs. `lockstep scale"
        " --barrier-us ... --memory-gb-per-s ...` models yet others (notes/scaling.md)."
    ]
    for kernel in kernels(rows):
        cheap, usual, dear = (of(rows, kernel, barriers, "here") for barriers in (0.5, 1, 2))
        wide = of(rows, kernel, 1, "server")
        text = (
            f"{kernel} ({usual['form']}, {usual['scene']}): {cheap['speed_up']:.1f}x, {usual['speed_up']:.1f}x,"
            f" {dear['speed_up']:.1f}x; forks and barriers take {100 * usual['together']:.0f} % of the cores' time as"
            " they are."
        )
        if usual["bound_by_memory"]:
            text += f" Memory holds it: {wide['speed_up']:.1f}x with the server's."
        paragraphs.append(text)
    return paragraphs


def draw(rows):
    names = kernels(rows)
    figure, [[axis]] = style.panels(1, 1, 8.5, 1.4 + 0.62 * len(names))
    machines = [(barriers, memory) for memory in ("here", "server") for barriers in (0.5, 1, 2)]
    words = {0.5: "barriers half as dear", 1: "as dear as here", 2: "twice as dear"}
    height = 0.8 / len(machines)
    for series, (barriers, memory) in enumerate(machines):
        places = [k - 0.4 + (series + 0.5) * height for k in range(len(names))]
        values = [of(rows, kernel, barriers, memory)["speed_up"] for kernel in names]
        colour = style.COLOURS[series % 3]
        look = {"color": colour} if memory == "here" else {"facecolor": "white", "edgecolor": colour}
        label = words[barriers] + ("" if memory == "here" else ", memory of a server")
        axis.barh(places, values, height=0.9 * height, label=label, **look)
        for place, value in zip(places, values):
            style.beside(axis, f"{value:.1f}", value, place)
    axis.set_yticks(range(len(names)), names)
    axis.set_ylim(len(names) - 0.45, -0.55)
    axis.set_xlabel(f"speed-up at {rows[0]['cores']} modelled cores over one")
    axis.grid(False)
    style.key_below(figure, axis.get_legend_handles_labels()[0], 3)
    return figure
