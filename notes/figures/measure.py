"""Measures what figures need: measure.py PROGRAM FOLDER [--figure NAME] [--threads 1,2,4] [--shard 1/2] [--quick]
[--full] [--resume].

Runs `lockstep bench`, `scale` and `figures` for the reports and kernels that the figures name (REPORTS, see draw.py).
Kernels of the report `scale` are modelled on the machine's own numbers of cores and on 64. Options go to the program as
they are; --full, for the largest scenes, goes to `scale` and `figures`.
"""

import argparse
import os
import pathlib
import subprocess
import sys

import draw
import source


def needed(figures, quick=False):
    """{report: its kernels, or None for all} of the figures together. Quick: where figures name kernels, those that
    show all kernels show these."""
    asked = {}
    for figure in figures.values():
        for report, kernels in figure.REPORTS.items():
            if report not in draw.OPTIONAL:
                asked.setdefault(report, []).append(kernels)
    needs = {}
    for report, lists in asked.items():
        named = list(dict.fromkeys(kernel for kernels in lists for kernel in kernels or []))
        needs[report] = named if named and (quick or None not in lists) else None
    return needs


def few_cores():
    """1, 2, 4, ... as far as the machine has cores, 2 at least, and 64."""
    powers = [2**k for k in range(20) if 2**k <= max(2, os.cpu_count())]
    return ",".join(str(n) for n in sorted({*powers, 64}))


def commands(program, folder, needs, options):
    """The program's command for each report."""
    more = [f"--{name}" for name in ("quick", "resume") if getattr(options, name)]
    more += ["--shard", options.shard] if options.shard else []
    largest = ["--full"] if options.full else []
    found = []
    for report, kernels in needs.items():
        selected = ["--kernel", ",".join(kernels)] if kernels else []
        brief = [] if options.quick else ["--brief"]
        json = ["--json", folder / f"{report}.json"]
        if report == "bench":
            threads = ["--threads", options.threads] if options.threads else []
            found.append([program, "bench", *selected, *threads, *brief, *more, *json])
        elif report == "scale":
            found.append([program, "scale", *selected, "--cores", few_cores(), *brief, *largest, *more, *json])
        else:
            found.append([program, "figures", "--report", report, *brief, *largest, *more, "--out", folder])
    return found


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("program", type=pathlib.Path)
    arguments.add_argument("folder", type=pathlib.Path)
    arguments.add_argument("--figure")
    arguments.add_argument("--threads")
    arguments.add_argument("--shard")
    arguments.add_argument("--quick", action="store_true")
    arguments.add_argument("--full", action="store_true")
    arguments.add_argument("--resume", action="store_true")
    options = arguments.parse_args()
    figures = draw.chosen(options.figure)
    needs = needed(figures, options.quick)
    options.folder.mkdir(parents=True, exist_ok=True)
    for command in commands(options.program, options.folder, needs, options):
        if code := subprocess.run(command).returncode:
            return code
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except source.Missing as missing:
        print(f"measure.py: {missing}", file=sys.stderr)
        sys.exit(2)
