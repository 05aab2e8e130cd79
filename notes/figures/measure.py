"""Measures what figures need: measure.py PROGRAM FOLDER [--figure NAME] [--threads 1,2,4] [--shard 1/2] [--quick]
[--full] [--resume].

Runs `lockstep figures` for the reports and kernels that the figures name (REPORTS, see draw.py). Options go to it as
they are.
"""

import argparse
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


def command(program, folder, needs, options):
    """One command for all reports. The kernels are those of `bench` and `scale` together."""
    lists = [needs[report] for report in ("bench", "scale") if report in needs]
    kernels = list(dict.fromkeys(kernel for kernels in lists for kernel in kernels or []))
    selected = ["--kernel", ",".join(kernels)] if kernels and None not in lists else []
    threads = ["--threads", options.threads] if options.threads else []
    effort = "--quick" if options.quick else "--brief"
    more = [f"--{name}" for name in ("full", "resume") if getattr(options, name)]
    more += ["--shard", options.shard] if options.shard else []
    reports = ["--report", ",".join(needs)]
    return [program, "figures", *reports, *selected, *threads, effort, *more, "--out", folder]


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
    return subprocess.run(command(options.program, options.folder, needs, options)).returncode


if __name__ == "__main__":
    try:
        sys.exit(main())
    except source.Missing as missing:
        print(f"measure.py: {missing}", file=sys.stderr)
        sys.exit(2)
