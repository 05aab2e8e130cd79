"""Writes the tables of the notes from a report of `make bench`: tables.py REPORT FOLDER

The report must be of all kernels, of one sitting and of full effort. FOLDER/times.md gets all rows behind its mark.
Other pages get rows between lines such as

    <!-- make tables: rigid/gjk rigid/step:pyramid_24 -->
    <!-- end of make tables -->

of the kernels that are named, or of one of their scenes, both as patterns.
"""

import fnmatch
import json
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent / "figures"))
from page import number  # noqa: E402, from that folder

MARK = "<!-- written by make tables: what follows is from one report -->"
BLOCK = re.compile(r"(<!-- make tables: ([^\n]*) -->\n).*?(<!-- end of make tables -->)", re.DOTALL)
TOLD_SPREAD = 0.1  # of the median: smaller spreads are left out


class Refused(Exception):
    """A report or a page that cannot be used."""


def cell(row, before=None):
    """A time in ms, how many times as fast as `before` it is, and what to know of the measurement."""
    if row is None:
        return ""
    text = number(row["ms"])
    if before:
        text += f" (x {before['ms'] / row['ms']:.2f})"
    if not row["whole_cores"]:
        text += " *"
    if (row["spread"] or 0) > TOLD_SPREAD:
        text += f" ±{50 * row['spread']:.0f} %"
    return text


def lines_of(rows, threads):
    """A line for each kernel, form and scene, in the report's order."""
    groups = {}
    for row in rows:
        of_scene = groups.setdefault((row["kernel"], row["form"], row["scene"]), {})
        of_scene[row["variant"], row["threads"]] = row
    for (kernel, form, scene), found in groups.items():
        serial, one = found.get(("serial", 1)), found.get(("openmp", 1))
        items = next(iter(found.values()))
        line = [f"{kernel.split('/')[1]} {form}".strip(), scene, f"{items['items']:,.0f} {items['unit']}"]
        line += [cell(serial), cell(found.get(("serial_twin", 1)))]
        line += [cell(found.get(("openmp", n)), serial if n == 1 else one) for n in threads]
        yield line


def table(rows, threads):
    header = ["kernel, form", "scene", "items", "serial", "serial twin"]
    header += ["1 thread" if n == 1 else f"{n} threads" for n in threads]
    lines = [header, ["---"] * 3 + ["--:"] * (len(header) - 3), *lines_of(rows, threads)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def thread_counts(report):
    return sorted({row["threads"] for row in report["rows"] if row["variant"] == "openmp"})


def sitting(report):
    machine = report["machine"]
    return (
        f"{machine['cpu']}, {machine['cores']} cores, {machine['isa']}, {machine['compiler']}; {machine['date']},"
        f" commit {machine['commit']}, `{report['command']}`."
    )


def tables(report):
    machine, rows = report["machine"], report["rows"]
    peaks = "; ".join(
        f"{number(p['triad_gb_per_s'])} GB/s and {number(p['fma_gflop_per_s'])} GFLOP/s on {p['threads']}"
        for p in machine["peaks"]
    )
    text = [
        sitting(report),
        f"Peaks by number of threads: {peaks}.",
        f"Other programs used {machine['busy_cores']:.2f} cores before it began.",
    ]
    parts = ["\n".join(text)]
    for domain in dict.fromkeys(row["kernel"].split("/")[0] for row in rows):
        of_domain = [row for row in rows if row["kernel"].split("/")[0] == domain]
        parts.append(f"## {domain}\n\n{table(of_domain, thread_counts(report))}")
    return "\n\n".join(parts) + "\n"


def is_named(row, names):
    for name in names:
        kernel, _, scene = name.partition(":")
        if fnmatch.fnmatch(row["kernel"], kernel) and fnmatch.fnmatch(row["scene"], scene or "*"):
            return True
    return False


def with_blocks(text, report, page):
    """The text of a page with the rows that its blocks name."""

    def block(found):
        rows = [row for row in report["rows"] if is_named(row, found[2].split())]
        if not rows:
            raise Refused(f"{page}: the report has no rows of {found[2]}")
        return f"{found[1]}{sitting(report)}\n\n{table(rows, thread_counts(report))}\n\n{found[3]}"

    return BLOCK.sub(block, text)


def read(path):
    try:
        report = json.loads(path.read_text())
    except (OSError, ValueError) as error:
        raise Refused(f"{path}: cannot be read ({error}); make bench comes first") from None
    if not report.get("command", "").startswith("bench"):
        raise Refused(f"{path}: is no report of make bench")
    selected = any(word in report["command"] for word in ("--kernel", "--form", "--scene"))
    if selected or "shard" in report or "shards" in report:
        part = f"{path}: has a part of the kernels (`{report['command']}`), or several sittings"
        raise Refused(f"{part}; make bench for all, in one sitting, comes first")
    if report["quick"] or not report["complete"]:
        raise Refused(f"{path}: is {'quick' if report['quick'] else 'cut off'}; make bench without QUICK comes first")
    return report


def main(report_path, folder):
    times = folder / "times.md"
    head, mark, _ = times.read_text("utf-8").partition(MARK)
    if not mark:
        raise Refused(f"{times}: lacks the line {MARK}")
    report = read(report_path)
    written = {times: head + MARK + "\n\n" + tables(report)}
    for page in folder.glob("*.md"):
        text = page.read_text("utf-8")
        if page != times and BLOCK.search(text):
            written[page] = with_blocks(text, report, page)
    for page, text in written.items():
        page.write_text(text, "utf-8")
    print(f"{len(report['rows'])} rows: {', '.join(str(page) for page in sorted(written))}")


if __name__ == "__main__":
    try:
        main(*map(pathlib.Path, sys.argv[1:]))
    except Refused as refused:
        print(f"tables.py: {refused}", file=sys.stderr)
        sys.exit(2)
