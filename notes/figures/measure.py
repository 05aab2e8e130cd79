"""Measures what figures need: measure.py PROGRAM FOLDER [--figure NAME] [--threads 1,2,4] [--shard 1/2] [--quick]
[--resume].

Runs `lockstep bench`, `scale` and `figures` for the reports and kernels that the figures name (REPORTS, see draw.py).
Options go to the program as they are.
"""

import argparse
import pathlib
import subprocess
import sys

import draw
import source


def needed(figures):
    """{report: its kernels, or None for all} of the figures together."""
    needs = {}
    for figure in figures.values():
        for report, kernels in figure.REPORTS.items():
            if report in draw.OPTIONAL:
                continue
            both = needs.get(report, []), kernels
            needs[report] = None if None in both else list(dict.fromkeys([*both[0], *both[1]]))
    return needs


def commands(program, folder, needs, options):
    """The program's command for each report."""
    more = [f"--{name}" for name in ("quick", "resume") if getattr(options, name)]
    more += ["--shard", options.shard] if options.shard else []
    found = []
    for report, kernels in needs.items():
        if report in ("bench", "scale"):
            selected = ["--kernel", ",".join(kernels)] if kernels else []
            threads = ["--threads", options.threads] if report == "bench" and options.threads else []
            found.append([program, report, *selected, *threads, *more, "--json", folder / f"{report}.json"])
        else:
            found.append([program, "figures", "--report", report, *more, "--out", folder])
    return found


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("program", type=pathlib.Path)
    arguments.add_argument("folder", type=pathlib.Path)
    arguments.add_argument("--figure")
    arguments.add_argument("--threads")
    arguments.add_argument("--shard")
    arguments.add_argument("--quick", action="store_true")
    arguments.add_argument("--resume", action="store_true")
    options = arguments.parse_args()
    needs = needed(draw.chosen(options.figure))
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
