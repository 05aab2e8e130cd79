"""Draws figures, and an index page: draw.py FOLDER [FIGURE], where measure.py left the JSON. Without a name, all.

A figure is a module beside this one, named in FIGURES, with
    TITLE, PAPER_FIGURE, PAPER   the paper's figure and its content
    NOTES                        the notes to read, notes/NAME.md
    REPORTS                      the reports that it needs, and of which kernels: {"bench": ["fluid/step"]}; None: all
    table(data)                  the rows of the figure, computed from the JSON; "from" names the JSON rows behind each
    draw(rows)                   a matplotlib figure of the rows
    here(rows)                   paragraphs: what our figure shows, and why where a claim of the paper is not reached
    in_short(rows)               the figure's row of the index: paper, measured, modelled, scene
    claims(rows)                 optional: rows of judge.claim(), of what the papers claim
    details(rows)                optional: HTML below the figure
FOLDER gets NAME.csv and NAME.svg of each figure, claims.csv, and index.html, which contains them.
"""

import csv
import html
import importlib
import io
import os
import pathlib
import sys

import judge
import page
import source
import style

FIGURES = [
    "contact_batches",
    "fsm_over_fmm",
    "scalability",
    "problem_sizes",
    "every_kernel",
    "modules",
    "cloth_convergence",
    "frame_times",
    "production_modules",
    "face_modules",
    "cloth_modules",
    "sph_locks",
    "roofline",
    "levelset_slice",
    "sensitivity",
    "model_validation",
]
OPTIONAL = ["peers"]  # drawn where FOLDER has their report, of the same name, which measure.py does not make

NOTES = pathlib.Path(__file__).resolve().parent.parent

STYLE = """
body { font: 15px/1.45 sans-serif; max-width: 1180px; margin: 1.5em auto; padding: 0 1em; color: #111; }
h1 { font-size: 1.5em; } h2 { font-size: 1.2em; margin: 2em 0 .4em; }
.scroll { overflow-x: auto; margin: .8em 0; }
.scroll svg { display: block; min-width: 640px; max-width: 100%; height: auto; }
nav ul { columns: 20em; padding-left: 1.2em; }
p, ul { max-width: 75em; margin: .5em 0; } td ul { margin: 0; padding-left: 1.2em; }
table { border-collapse: collapse; font-size: 12px; line-height: 1.3; }
#claims table, #short table { min-width: 60em; }
th, td { border: 1px solid #bbb; padding: 2px 6px; text-align: left; vertical-align: top; }
th { background: #eee; } tr.off td { font-weight: bold; background: #f6e3d8; }
tr { break-inside: avoid; } thead { display: table-header-group; }
.rough, .not { font-weight: bold; color: #8a3d00; } .met { font-weight: bold; color: #00573f; }
figure { margin: 0; break-inside: avoid; }
.source { font-size: 12px; color: #444; max-width: none; }
@page { size: A4 landscape; margin: 10mm; }
@media print {
  body { max-width: none; margin: 0; padding: 0; font-size: 9pt; line-height: 1.3; }
  p, ul { max-width: none; } table { font-size: 7pt; }
  section { break-before: page; } h2 { margin-top: 0; break-after: avoid; }
  .scroll { overflow: visible; } .scroll svg { min-width: 0; max-height: 105mm; } .source { break-before: avoid; }
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


def stamp(data, names):
    """Machine, date and commit of reports."""
    return "; ".join(
        [
            told(data, names, lambda d: f"{d['machine']['cpu']}, {d['machine']['cores']} cores, {d['machine']['isa']}"),
            told(data, names, lambda d: d["machine"]["date"]),
            "commit " + told(data, names, lambda d: d["machine"]["commit"]),
        ]
    )


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


def index_table(tables, figures, said):
    header = ["figure", "paper's figure", "paper's numbers", "measured here", "modelled here", "scene"]
    rows = []
    for name, figure in figures.items():
        short = figure.in_short(tables[name])
        numbers = [short[what] for what in ("paper", "measured", "modelled", "scene")]
        rows.append([page.link(f"#{name}", figure.TITLE), figure.PAPER_FIGURE, *numbers])
    return f"<section id='short'>\n<h2>The figures in short</h2>\n{said}{page.table(header, rows)}</section>\n"


def contents(figures, notes, with_claims):
    entries = [("#claims", "The papers' claims")] if with_claims else []
    entries += [("#short", "The figures in short"), *((f"#{name}", figure.TITLE) for name, figure in figures.items())]
    entries += [("#machine", "The machine, and what things cost on it"), (f"{notes}/README.md", "The notes")]
    return "<nav><ul>" + "".join(f"<li>{page.link(*entry)[0]}</li>\n" for entry in entries) + "</ul></nav>\n"


def claims_of(figures, tables):
    """The rows of claims.csv."""
    having = {name: figure for name, figure in figures.items() if hasattr(figure, "claims")}
    return [{"figure": name} | row for name, figure in having.items() for row in figure.claims(tables[name])]


def claims_section(found, said):
    """A row for each claim, with a line for each scene, workload or algorithm that it is asked of."""
    by_claim = {}
    for row in found:
        by_claim.setdefault((row["figure"], row["paper"], row["claim"], row["asked"]), []).append(row)
    verdicts = {name: judge.verdict_of(parts) for name, parts in by_claim.items()}
    cells = []
    for (figure, paper, claim, asked), parts in by_claim.items():
        verdict = verdicts[figure, paper, claim, asked]
        # What all lines agree on is said once.
        hows, several = {p["how"] for p in parts}, len({p["verdict"] for p in parts}) > 1
        text = "".join(
            f"<li><b>{html.escape(page.number(p['found'], p['unit']))}</b> {html.escape(p['of'])}"
            + (f" ({html.escape(p['how'])})" if len(hows) > 1 else "")
            + (f", {marked(p['verdict'])}" if several else "")
            + "</li>"
            for p in parts
        )
        said_once = f"{html.escape(hows.pop())}:" if len(hows) == 1 else ""
        data = f"{page.link('#' + figure, 'figure')[0]}, {page.link(figure + '.csv', figure + '.csv')[0]}"
        command = f"<code>make figures FIGURE={figure}</code>"
        shown = [f"{said_once}<ul>{text}</ul>", marked(verdict), f"{data}, {command}"]
        cells.append([claim, paper, asked, *((one,) for one in shown)])
    counts = [(words, list(verdicts.values()).count(words)) for words in (judge.EXCEEDED, judge.REPRODUCED, judge.NOT)]
    rest = len(verdicts) - sum(count for _, count in counts)
    total = ", ".join(f"{count} {words}" for words, count in [*counts, ("in part", rest)] if count)
    header = ["claim", "paper", "asked", "found here", "verdict", "figure, data, command"]
    return (
        "<section id='claims'>\n<h2>The papers' claims</h2>\n"
        f"<p><b>{len(verdicts)} claims: {total}.</b> Reproduced: what the paper says is reached; exceeded: by more than"
        " a tenth. A number is measured where this machine has the cores, and modelled (notes/scaling.md) where it has"
        f" not. Numbers and verdicts are computed from the JSON: {page.link('claims.csv', 'claims.csv')[0]} names the"
        " rows. Claims about Larrabee's own parts (gathers, masks and threads that hide latency, in hardware) cannot be"
        " asked here.</p>\n"
        f"{said}{page.table(header, cells)}</section>\n"
    )


def marked(verdict):
    return f"<span class='{'not' if verdict == judge.NOT else 'met'}'>{html.escape(verdict)}</span>"


def section(data, name, figure, rows, svg, notes):
    title, paper_figure, paper = (html.escape(text) for text in (figure.TITLE, figure.PAPER_FIGURE, figure.PAPER))
    first, *others = (html.escape(text) for text in figure.here(rows))
    points = "<ul>" + "".join(f"<li>{text}</li>\n" for text in others) + "</ul>\n" if others else ""
    details = figure.details(rows) if hasattr(figure, "details") else ""
    behind = files_behind(rows)
    warning = " ".join(filter(None, (rough(data, behind), disturbed(rows))))
    caption = f"<figcaption class='rough'>{html.escape(warning)}</figcaption>" if warning else ""
    read = ", ".join(page.link(f"{notes}/{note}.md", f"notes/{note}.md")[0] for note in figure.NOTES)
    script = page.link(f"{notes}/figures/{name}.py", f"notes/figures/{name}.py")[0]
    source_line = (
        f"Read {read}. Numbers: {page.link(name + '.csv', name + '.csv')[0]}, computed from"
        f" {', '.join(f'{file}.json' for file in behind)} by {script}; picture:"
        f" {page.link(name + '.svg', name + '.svg')[0]}."
    )
    if stamp(data, behind) != stamp(data, data):
        source_line += f" {html.escape(stamp(data, behind))}."
    return (
        f"<section id='{name}'>\n<h2>{title}</h2>\n<figure aria-label='{title}'><div class='scroll'>\n"
        f"{page.inline(svg, name)}</div>{caption}</figure>\n<p><b>The paper</b> ({paper_figure}): {paper}</p>\n"
        f"<p><b>Here:</b> {first}</p>\n{points}{details}<p class='source'>{source_line}</p>\n</section>\n"
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
    claims = claims_of(figures, tables)
    if claims:
        (folder / "claims.csv").write_text(csv_of(claims))
    notes = os.path.relpath(NOTES, folder.resolve())
    sections = []
    for name, figure in figures.items():
        (folder / f"{name}.csv").write_text(csv_of(tables[name]))
        drawing = figure.draw(tables[name])
        if rough(data, files_behind(tables[name])):
            drawing.suptitle("QUICK run: rough numbers", y=1, va="bottom", color="#8a3d00")
        svg = style.svg_of(drawing)
        (folder / f"{name}.svg").write_text(svg, "utf-8")
        sections.append(section(data, name, figure, tables[name], svg, notes))
    warning = rough(data, data)
    said = f"<p class='rough'>{html.escape(warning)}</p>\n" if warning else ""
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
        "<meta name='viewport' content='width=device-width, initial-scale=1'>\n"
        f"<style>{STYLE}</style></head><body>\n<h1>Lockstep: the papers' figures</h1>\n"
        f"{said}<p>[ITJ07]: <i>High-Performance Physical Simulations on Next-Generation Architecture with Many"
        " Cores</i>, Intel Technology Journal 11(3), 2007. [LRB08]: <i>Game Physics Performance on the Larrabee"
        " Architecture</i>, 2008. [ISCA07]: Hughes et al., <i>Physical Simulation for Animation and Visual Effects:"
        " Parallelization and Characterization for Chip Multiprocessors</i>, 2007, by authors of [ITJ07]. Their"
        " speed-ups come from a simulator. Here <b>measured</b> values are times on this machine: filled markers, solid"
        " lines and, where the repeats are in the report, bars of their interquartile range. <b>Modelled</b> values"
        " come from the scaling model (notes/scaling.md): hollow markers and dashed lines. Measured values that never"
        " had whole cores are hollow and grey. Each row of a figure's CSV names the rows of the JSON that it was"
        " computed from.</p>\n"
        f"<p><b>Made on:</b> {html.escape(stamp(data, data))}.</p>\n"
        f"{summary}{contents(figures, notes, bool(claims))}{claims_section(claims, said) if claims else ''}"
        f"{index_table(tables, figures, said)}{''.join(sections)}{machine_section(data)}</body></html>\n"
    )
    index.write_text(text.replace(" %", "\N{NO-BREAK SPACE}%"))
    print(index)


if __name__ == "__main__":
    try:
        main(pathlib.Path(sys.argv[1]), *sys.argv[2:])
    except source.Missing as missing:
        print(f"draw.py: {missing}", file=sys.stderr)
        sys.exit(2)
