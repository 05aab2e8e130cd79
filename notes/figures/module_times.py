"""A frame by module: what the figures of both production applications have in common.

A figure's module gives: MODULES, the form of each module's kernel in the order of a step, None where a module has no
kernel of its own; FORM of the step; SCALED_ON, the scenes that kernels are modelled on if not on the frame's own, of
which the first with results is taken; and KERNELS, of modules whose kernels have other names.
"""

import judge
import page
import source
import style


def kernels_of(domain, modules, names):
    """{module: its kernel}, of those that have one."""
    return {module: f"{domain}/{names.get(module, module)}" for module, form in modules.items() if form is not None}


def reports(name, domain, modules, names={}):
    """REPORTS of the figure of this name."""
    return {name: None, "scale": list(kernels_of(domain, modules, names).values())}


def table(data, name, domain, figure, counts):
    """The rows; `counts` are the fields of a frame that say how large it is."""
    frames = source.rows_of(data, name, form=figure.FORM)
    serial = next(r for r in frames if r["variant"] == "serial")
    one = next(r for r in frames if r["variant"] == "openmp" and r["threads"] == 1)
    many = max((r for r in frames if r["variant"] == "openmp"), key=lambda r: r["threads"])
    ms = [{m["module"]: m["ms"] for m in r["modules"]} for r in (serial, one, many)]
    rows = []
    kernels = kernels_of(domain, figure.MODULES, getattr(figure, "KERNELS", {}))
    for module, form in figure.MODULES.items():
        if form is None or ms[1][module] < 1e-3 * sum(ms[1].values()):
            continue
        on_all = source.rows_of(data, "scale", kernel=kernels[module], form=form)
        scenes = [serial["scene"], *figure.SCALED_ON]
        scaled_on = next((scene for scene in scenes if source.at(on_all, scene=scene)), None)
        if scaled_on is None:
            raise source.Missing(f"scale.json: '{kernels[module]}' '{form}' on none of {', '.join(scenes)}")
        modelled = {r["cores"]: r for r in on_all if r["scene"] == scaled_on}
        most = max(c for c in modelled if c <= 64)
        one_core = modelled[1]["modelled_ms"]
        gain, of_cores = (one_core / modelled[most][time] for time in ("modelled_ms", "compute_ms"))
        rows.append(
            {"scene": serial["scene"]}
            | {count: serial[count] for count in counts}
            | {"kernel": kernels[module], "module": module, "form": form, "modelled_on": scaled_on}
            | {"serial_ms": ms[0][module], "one_thread_ms": ms[1][module], "threads": many["threads"]}
            | {"many_threads_ms": ms[2][module], "cores": most, "modelled_speed_up": gain}
            | {"modelled_ms": ms[1][module] / gain}
            | {"cores_speed_up": of_cores, "cores_ms": ms[1][module] / of_cores}
            | {"from": source.references(serial, one, many, modelled[1], modelled[most])}
        )
    return rows


def total(rows, column):
    return sum(r[column] for r in rows)


def of_frame(rows, time="modelled_ms"):
    """How much faster all modules together would be on many cores."""
    return total(rows, "one_thread_ms") / total(rows, time)


def longest(rows, time):
    """What takes longest on many cores, and its share of the frame."""
    module = max(rows, key=lambda r: r[time])
    return f"{module[time] / total(rows, time):.0%} of it in {module['module']}"


def frame_in_words(rows):
    """What the frame would take on many cores, and what holds it."""
    return (
        f"The frame would take 1/{of_frame(rows):.1f} of the time of one core, {longest(rows, 'modelled_ms')}. All"
        " cores share this machine's memory there. If they did not wait for memory (dotted), it would take"
        f" 1/{of_frame(rows, 'cores_ms'):.1f}, {longest(rows, 'cores_ms')}."
    )


def in_short(rows, paper, scene):
    first = rows[0]
    return {
        "paper": paper,
        "measured": f"serial {total(rows, 'serial_ms') / 1e3:.2f} s, one thread"
        f" {total(rows, 'one_thread_ms') / 1e3:.2f} s, {page.threads(first['threads'])}"
        f" {total(rows, 'many_threads_ms') / 1e3:.2f} s a frame",
        "modelled": f"{first['cores']} cores: {of_frame(rows):.1f}x",
        "scene": f"{first['scene']} ({scene})",
    }


def claims(rows, application, paper_at_64):
    """What the paper says of all modules together, as one number."""
    every = {"from": source.references(*rows)}
    parts = [("all modules together", f"modelled, {rows[0]['cores']} cores", of_frame(rows), every)]
    words = f"On 64 cores a frame of the production {application} takes 1/{paper_at_64} of the time of one"
    return judge.claim("[ISCA07]", words, f"{paper_at_64}x", judge.at_least(paper_at_64), parts, "x")


def details(rows):
    threads, cores = page.threads(rows[0]["threads"]), rows[0]["cores"]
    header = ["module", "serial, ms", "one thread, ms", f"{threads}, ms", "lanes", "threads"]
    header += [f"{cores} cores, modelled", "without waiting for memory"]
    cells = [
        [r["module"]]
        + [page.number(r[column]) for column in ("serial_ms", "one_thread_ms", "many_threads_ms")]
        + [page.number(r["serial_ms"] / r["one_thread_ms"], "x")]
        + [page.number(r["one_thread_ms"] / r["many_threads_ms"], "x"), page.number(r["modelled_speed_up"], "x")]
        + [page.number(r["cores_speed_up"], "x")]
        for r in rows
    ]
    return page.table(header, cells)


def draw(rows, paper_at_64):
    figure, [[left, right]] = style.panels(1, 2, 5.2, 4.2, sharey=True)
    places = range(len(rows))
    columns = [
        ("serial", "serial_ms", 0.27),
        ("one thread", "one_thread_ms", 0.0),
        (page.threads(rows[0]["threads"]), "many_threads_ms", -0.27),
    ]
    for (label, column, shift), colour in zip(columns, style.COLOURS):
        left.barh([p - shift for p in places], [r[column] for r in rows], height=0.25, color=colour, label=label)
    style.log_x(left, "ms a frame, measured", style.few_ticks(r[c] for r in rows for _, c, _ in columns))
    look = {"facecolor": "white", "edgecolor": style.COLOURS[2]}
    of_cores = [r["cores_speed_up"] for r in rows]
    right.barh(places, of_cores, height=0.65, **look, linestyle=":", label="without waiting for memory")
    right.barh(places, [r["modelled_speed_up"] for r in rows], height=0.65, **look, hatch="///", linestyle="--")
    for place, r in zip(places, rows):
        waits = r["cores_speed_up"] > 1.1 * r["modelled_speed_up"]
        both = [r["modelled_speed_up"]] + [r["cores_speed_up"]] * waits
        style.beside(right, " | ".join(page.number(gain) for gain in both), r["cores_speed_up"], place)
    right.axvline(paper_at_64, color=style.GREY, linestyle=":", label="paper: all modules together")
    right.set_xlim(0, 1.15 * max(paper_at_64, *of_cores))
    right.set_xlabel(f"gain of {rows[0]['cores']} cores, modelled")
    for axis in (left, right):
        axis.grid(axis="y", visible=False)
    left.set_yticks(places, [r["module"] for r in rows])
    left.invert_yaxis()
    style.key_below(figure, [h for axis in (left, right) for h in axis.get_legend_handles_labels()[0]])
    return figure
