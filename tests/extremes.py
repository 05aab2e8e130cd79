"""Runs Lockstep at its limits: the smallest inputs, the largest that make sense, and more than any machine holds.

Each input is a scene that this script writes. It runs and writes its frames, or it is refused in one line before
anything large is allocated: a refused process must stay below REFUSED_MB. `make extremes` prints the table. The exit
code is 1 if any case fails.
"""

import os
import pathlib
import re
import resource
import shutil
import subprocess
import sys
import time

FOLDER = pathlib.Path("build/extremes")
REFUSED_MB = 200  # for the program, its libraries and a short scene file
RIGID = 'kind = "rigid"\nframes = 1\n'
GROUND = "[[body]]\nplane = [0, 1, 0]\n"


def fluid(particles_per_metre, low, high):
    return (
        f'kind = "fluid"\nparticles_per_metre = {particles_per_metre}\n[[block]]\nmin = {low}\nmax = {high}\njitter ='
        " 0.05\n"
    )


def sheet(rows, columns, iterations):
    size = f"width = [{.01 * columns}, 0, 0]\nheight = [0, {-.01 * rows}, 0]"
    return (
        f'kind = "cloth"\niterations = {iterations}\n[sheet]\nrows = {rows}\ncolumns = {columns}\norigin = [0, 0,'
        f' 0]\n{size}\nmass = 1\nbending = true\npins = ["top_left"]\n'
    )


def points(n):
    return f'kind = "levelset"\npoints = [{n}, {n}, {n}]\n[[sphere]]\ncentre = [0, 0, 0]\nradius = 0.6\n'


def pit(count, across):
    return RIGID + f'[[pit]]\nof = "boxes"\ncount = {count}\nacross = {across}\n'


BLOCK = ([-0.064, -0.079, -0.064], [0.064, 0.09, 0.064])
RUNS = "runs"  # expected to run; otherwise, what the refusal must contain:
MEMORY, LIMIT = "needs", "expected"
# Name, scene, frames, limit of address space in bytes (0: no limit), expected result.
CASES = [
    ("1 particle", fluid(204, [-0.002] * 3, [0.002] * 3), 20, 0, RUNS),
    ("5 million particles", fluid(1215, *BLOCK), 2, 0, RUNS),
    ("5 million particles in 1 GB", fluid(1215, *BLOCK), 2, 2**30, MEMORY),
    ("a billion particles", fluid(7100, *BLOCK), 2, 0, MEMORY),
    ("a sheet of 2 particles", sheet(1, 2, 5), 20, 0, RUNS),
    ("a sheet of 4 million", sheet(2000, 2000, 3), 2, 0, RUNS),
    ("a sheet of 4 million in 1 GB", sheet(2000, 2000, 3), 2, 2**30, MEMORY),
    ("a sheet of 10^12", sheet(1000000, 1000000, 3), 2, 0, LIMIT),
    ("8 grid points", points(2), 1, 0, RUNS),
    ("512^3 grid points", points(512), 1, 0, RUNS),
    ("512^3 grid points, band of 5", "band = 5\n" + points(512), 1, 0, RUNS),
    ("512^3 grid points in 1 GB", points(512), 1, 2**30, MEMORY),
    ("4096^3 grid points", points(4096), 1, 0, LIMIT),
    ("0 bodies", RIGID, 5, 0, "no body"),
    ("only the ground", RIGID + GROUND, 5, 0, RUNS),
    ("1 body in nothing", RIGID + "[[body]]\nsphere = 0.5\nmass = 1\n", 20, 0, RUNS),
    ("1 million bodies falling", pit(1000000, 150), 2, 0, RUNS),
    ("1 million bodies in 1 GB", pit(1000000, 150), 2, 2**30, MEMORY),
    ("a billion bodies", pit(1000000000, 1000), 2, 0, LIMIT),
]


def run(name, text, frames, limit):
    """Exit code, seconds, peak memory in MB, the lines of output, and the frames written."""
    folder = FOLDER / re.sub(r"\W+", "_", name)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "scene.toml").write_text(text)
    command = [
        "build/lockstep",
        "run",
        "--scene",
        folder / "scene.toml",
        "--frames",
        str(frames),
        "--out",
        folder / "frames",
    ]
    limits = (lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit))) if limit else None
    start = time.monotonic()
    with open(folder / "said", "w") as said:
        child = subprocess.Popen(
            [str(word) for word in command], stdout=said, stderr=subprocess.STDOUT, preexec_fn=limits
        )
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = 0  # already waited for, by wait4
    seconds = time.monotonic() - start
    lines = (folder / "said").read_text().splitlines()
    wrote = sorted(path.name for path in folder.glob("frames/frame_*.vtk"))
    shutil.rmtree(folder / "frames", ignore_errors=True)  # large
    code = status >> 8 if status & 127 == 0 else -(status & 127)
    return code, seconds, usage.ru_maxrss / 1024, lines, wrote


def fault(expected, frames, code, peak, lines, wrote):
    if expected == RUNS:
        whole = [f"frame_{k:05d}.vtk" for k in range(frames + 1)]
        return "" if code == 0 and wrote == whole else f"exit code {code}, {len(wrote)} frames"
    if code != 2 or len(lines) != 1 or wrote:
        return f"exit code {code}, {len(lines)} lines, {len(wrote)} frames"
    if peak > REFUSED_MB:
        return f"took {peak:.0f} MB before it was refused"
    if expected not in lines[0]:
        return f"does not say '{expected}'"
    need = re.search(r"needs ([\d.e+]+) MB of memory, and ([\d.e+]+) MB is available", lines[0])
    return "refused although it fits" if need and float(need[1]) <= float(need[2]) else ""


def main():
    print(f"{'extreme':<30} {'expected':<8} {'seconds':>8} {'peak MB':>8}  what it said")
    failed = 0
    for name, text, frames, limit, expected in CASES:
        code, seconds, peak, lines, wrote = run(name, text, frames, limit)
        wrong = fault(expected, frames, code, peak, lines, wrote)
        failed += bool(wrong)
        said = lines[0].replace(str(FOLDER), "") if lines else ""
        print(
            (
                f"{name:<30} {expected:<8} {seconds:8.1f} {peak:8.0f} "
                f" {'FAILED ' + wrong + ': ' if wrong else ''}{said[:150]}"
            ),
            flush=True,
        )
    print(f"{len(CASES) - failed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
