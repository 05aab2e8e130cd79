"""Draws figures, and an index page: draw.py FOLDER [FIGURE], where measure.py left the JSON. Without a name, all.

A figure is a module beside this one, named in FIGURES, with
    TITLE, PAPER_FIGURE, PAPER   the paper's figure and its content
    REPORTS                      the reports that it needs, and of which kernels: {"bench": ["fluid/step"]}; None: all
    table(data)                  the rows of the figure, computed from the JSON; "from" names the JSON rows behind each
    draw(rows)                   a matplotlib figure of the rows
    here(rows)                   paragraphs: what our figure shows, and why where a claim of the paper is not reached
    in_short(rows)               the figure's row of the index: paper, measured, modelled, scene
    details(rows)                optional: HTML below the figure
FOLDER gets NAME.csv and NAME.svg of each figure, and index.html, which contains them.
"""

import base64
import csv
import html
import importlib
import io
import pathlib
import sys

import page
import source
import style

FIGURES = [
    "contact_batches",
    "fsm_over_fmm",
    "scalability",
    "modules",
    "cloth_convergence",
    "frame_times",
    "production_modules",
    "face_modules",
    "cloth_modules",
    "sph_locks",
    "roofline",
    "levelset_slice",
    "model_validation",
]
OPTIONAL = ["peers"]  # drawn where FOLDER has their report, of the same name, which measure.py does not make

STYLE = """
body { font: 15px/1.45 sans-serif; max-width: 1180px; margin: 1.5em auto; padding: 0 1em; color: #111; }
h1 { font-size: 1.5em; } h2 { font-size: 1.2em; margin: 2em 0 .4em; }
img { display: block; max-width: 100%; height: auto; margin: .6em 0; }
p, ul { max-width: 75em; margin: .5em 0; }
table { border-collapse: collapse; font-size: 12px; line-height: 1.3; margin: .8em 0; }
th, td { border: 1px solid #bbb; padding: 2px 6px; text-align: left; vertical-align: top; }
th { background: #eee; } tr.off td { font-weight: bold; background: #f6e3d8; }
tr { break-inside: avoid; } thead { display: table-header-group; }
.rough { font-weight: bold; color: #8a3d00; } figure { margin: 0; break-inside: avoid; }
.source { font-size: 12px; color: #444; max-width: none; }
@page { size: A4 landscape; margin: 10mm; }
@media print {
  body { max-width: none; margin: 0; padding: 0; font-size: 9pt; line-height: 1.3; }
  p, ul { max-width: none; } table { font-size: 7pt; }
  section { break-before: page; } h2 { margin-top: 0; break-after: avoid; }
  img { max-height: 105mm; } .source { break-before: avoid; }
  a { color: inherit; text-decoration: none; }
  th, tr.off td { -webkit-print-color-adjust: exact; print-color-adjust: exact; }
}
"""


def csv_of(rows):
    columns = [c for c in dict.fromkeys(c for r in rows for c in r) if c != "from"] + ["from"]
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def files_behind(rows):
    return sorted({reference.split(".json#")[0] for r in rows for reference in r["from"].split(",")})


def told(data, names, what):
    """One property of the reports' machines; several values if they differ."""
    return ", ".join(dict.fromkeys(what(data[name]) for name in names))


def stamp(data, rows):
    """Machine, date and commit of the reports behind rows."""
    names = files_behind(rows)
    return [
        told(data, names, lambda d: f"{d['machine']['cpu']}, {d['machine']['cores']} cores, {d['machine']['isa']}"),
        told(data, names, lambda d: d["machine"]["date"]),
        told(data, names, lambda d: d["machine"]["commit"]),
    ]


def rough(data, names):
    """Which reports were made with QUICK=1, in words; "" if none."""
    quick = [f"{name}.json" for name in names if data[name]["quick"]]
    return f"QUICK run, rough numbers, not for citing: {', '.join(quick)}." if quick else ""


def disturbed(rows):
    """How many rows never had whole cores, in words; "" if none."""
    count = sum(r.get("whole_cores") is False for r in rows)
    return (
        f"Hollow grey: {count} of the measured values never had whole cores; other programs took a part."
        if count
        else ""
    )


def index_table(data, tables, figures):
    header = [
        "figure",
        "paper's figure",
        "paper's numbers",
        "measured here",
        "modelled here",
        "scene",
        "machine",
        "date",
        "commit",
    ]
    rows = []
    for name, figure in figures.items():
        short = figure.in_short(tables[name])
        numbers = [short[what] for what in ("paper", "measured", "modelled", "scene")]
        rows.append([page.link(f"#{name}", figure.TITLE), figure.PAPER_FIGURE, *numbers, *stamp(data, tables[name])])
    return page.table(header, rows)


def section(data, name, figure, rows, svg):
    image = base64.b64encode(svg).decode()
    title, paper_figure, paper = (html.escape(text) for text in (figure.TITLE, figure.PAPER_FIGURE, figure.PAPER))
    first, *others = (html.escape(text) for text in figure.here(rows))
    points = "<ul>" + "".join(f"<li>{text}</li>\n" for text in others) + "</ul>\n" if others else ""
    details = figure.details(rows) if hasattr(figure, "details") else ""
    behind = ", ".join(f"{file}.json" for file in files_behind(rows))
    warning = " ".join(filter(None, (rough(data, files_behind(rows)), disturbed(rows))))
    caption = f"<figcaption class='rough'>{html.escape(warning)}</figcaption>" if warning else ""
    return (
        f"<section id='{name}'>\n<h2>{title}</h2>\n<figure><img src='data:image/svg+xml;base64,{image}'"
        f" alt='{title}'>{caption}</figure>\n<p><b>The paper</b> ({paper_figure}): {paper}</p>\n<p><b>Here:</b>"
        f" {first}</p>\n{points}{details}<p class='source'>Numbers: <a href='{name}.csv'>{name}.csv</a>, computed from"
        f" {behind}; script: notes/figures/{name}.py; {html.escape('; '.join(stamp(data, rows)))}</p>\n</section>\n"
    )


def facts_of(machine):
    """The properties of a report's machine, flattened, as text."""
    facts = {what: str(value) for what, value in machine.items() if what not in ("omp", "costs", "peaks", "busy_cores")}
    if "busy_cores" in machine:
        facts["cores that others kept busy at the start"] = page.number(machine["busy_cores"])
    facts |= {f"OpenMP: {what}": str(value) for what, value in machine["omp"].items()}
    facts |= {f"cost: {what}": page.number(value) for what, value in machine.get("costs", {}).items()}
    for peak in machine.get("peaks", []):
        for what in ("triad_gb_per_s", "fma_gflop_per_s"):
            facts[f"peak on {page.threads(peak['threads'])}: {what}"] = page.number(peak[what])
    return facts


def machine_section(data):
    """First the properties that all reports share, then the others; reports with equal values share a column."""
    facts = {name: facts_of(report["machine"]) for name, report in data.items()}
    every = dict.fromkeys(what for found in facts.values() for what in found)
    agreed = [what for what in every if len({found.get(what) for found in facts.values()}) == 1]
    found_by = {}
    for name, found in facts.items():
        found_by.setdefault(tuple(found.get(what, "–") for what in every if what not in agreed), []).append(
            f"{name}.json"
        )
    rest = [[what, *values] for what, values in zip((what for what in every if what not in agreed), zip(*found_by))]
    return (
        "<section id='machine'>\n<h2>The machine, and what things cost on it</h2>\n"
        + page.table(["all reports", ""], [[what, next(iter(facts.values()))[what]] for what in agreed])
        + page.table(["", *(", ".join(names) for names in found_by.values())], rest)
        + "</section>\n"
    )


def chosen(name=None, folder=None):
    """The modules of all figures, those of OPTIONAL where the folder has their reports, or of one."""
    if name not in (None, *FIGURES, *OPTIONAL):
        raise source.Missing(f"no figure {name}, expected one of: {', '.join([*FIGURES, *OPTIONAL])}")
    there = [figure for figure in OPTIONAL if folder and (folder / f"{figure}.json").exists()]
    return {figure: importlib.import_module(figure) for figure in ([name] if name else [*FIGURES, *there])}


def main(folder, name=None):
    figures = chosen(name, folder)
    data = source.load(folder, list(dict.fromkeys(report for figure in figures.values() for report in figure.REPORTS)))
    tables = {name: figure.table(data) for name, figure in figures.items()}
    sections = []
    for name, figure in figures.items():
        (folder / f"{name}.csv").write_text(csv_of(tables[name]))
        drawing = figure.draw(tables[name])
        if rough(data, files_behind(tables[name])):
            drawing.suptitle("QUICK run: rough numbers", color="#8a3d00")
        svg = style.svg_of(drawing)
        (folder / f"{name}.svg").write_bytes(svg)
        sections.append(section(data, name, figure, tables[name], svg))
    warning = rough(data, data)
    validation = figures.get("model_validation")
    summary = (
        f"<p><b>The model at {page.threads(validation.most(tables['model_validation']))}:</b> "
        f"{html.escape(validation.summary(tables['model_validation'], validation.most(tables['model_validation'])))}; "
        "<a href='#model_validation'>every run</a>. <a href='#machine'>The machine and its costs</a>.</p>\n"
        if validation
        else ""
    )
    index = folder / "index.html"
    text = (
        "<!doctype html>\n<html lang='en'><head><meta charset='utf-8'><title>Lockstep: figures</title>\n"
        f"<style>{STYLE}</style></head><body>\n<h1>Lockstep: the papers' figures</h1>\n"
        + (f"<p class='rough'>{html.escape(warning)}</p>\n" if warning else "")
        + "<p>[ITJ07]: <i>High-Performance Physical Simulations on Next-Generation Architecture with Many Cores</i>,"
        " Intel Technology Journal 11(3), 2007. [LRB08]: <i>Game Physics Performance on the Larrabee Architecture</i>,"
        " 2008. Their speed-ups come from a simulator. Here <b>measured</b> values are times on this machine: filled"
        " markers, solid lines and, where the repeats are in the report, bars of their interquartile range."
        " <b>Modelled</b> values come from the scaling model (notes/scaling.md): hollow markers and dashed lines."
        " Measured values that never had whole cores are hollow and grey. Each row of a figure's CSV names the rows of"
        " the JSON that it was computed from.</p>\n"
        f"{summary}{index_table(data, tables, figures)}{''.join(sections)}{machine_section(data)}</body></html>\n"
    )
    index.write_text(text.replace(" %", "\N{NO-BREAK SPACE}%"))
    print(index)


if __name__ == "__main__":
    try:
        main(pathlib.Path(sys.argv[1]), *sys.argv[2:])
    except source.Missing as missing:
        print(f"draw.py: {missing}", file=sys.stderr)
        sys.exit(2)
