"""What `make nightly` runs: verify, determinism and the thread sanitizer on many threads and large scenes.

Arguments: the program, --kernel (as `lockstep verify` takes it), --threads (64), --no-tsan. On fewer cores than threads
the threads take turns, which costs time and shows the same mistakes. `verify` runs on 1 and on that many threads, under
three values of OMP_SCHEDULE; all must leave the same bits. Then the sanitizer runs each form on that many threads, on
one of the scenes that is its own. Everything is run before the exit code says whether anything failed.
"""

import argparse
import fnmatch
import json
import os
import pathlib
import subprocess
import sys
import time

# Large enough that 64 threads have a unit of work each in most loops. Every form has one, but those whose code another
# form covers: tests/nightly_test.py.
SCENES = [
    "dam_break_100k",
    "flag_256",
    "flags_64",
    "garment",
    "spheres_and_box_256",
    "spheres_and_box_256_full",
    "poisson_128",
    "poisson_64",
    "elasticity_48",
    "castle_hit",
    "hull_soup",
    "rounds_20000",
    "drop_128",
    "falling_drop",
    "obstacle_48",
    "block_370k",
    "face_smile",
    "ball_92k",
]
SCHEDULES = ["static,1", "dynamic,1", "guided"]


def names_kernel(named, kernel):
    """As verify/names.h has it: the whole name, a domain, a last part, or a pattern; several, separated by commas."""
    return any(name in kernel.split("/") or fnmatch.fnmatchcase(kernel, name) for name in named.split(","))


def kernels_of(listed, scene, named):
    """The kernels that register the scene, of those that are named."""
    return list(
        dict.fromkeys(
            row["kernel"]
            for row in listed
            if scene in row["scenes"] + row["more_scenes"] and (not named or names_kernel(named, row["kernel"]))
        )
    )


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("program")
    arguments.add_argument("--kernel")
    arguments.add_argument("--threads", default="64")
    arguments.add_argument("--no-tsan", action="store_true")
    options = arguments.parse_args()
    listed = json.loads(subprocess.check_output([options.program, "list", "--json"]))["rows"]
    kernels = list(dict.fromkeys(row["kernel"] for row in listed))
    chosen = [kernel for kernel in kernels if not options.kernel or names_kernel(options.kernel, kernel)]
    if not chosen:
        print(f"nightly.py: no kernel {options.kernel}", file=sys.stderr)
        return 2
    failed, reports = [], []

    def run(name, command, **environment):
        start = time.monotonic()
        code = subprocess.run(command, env=os.environ | environment).returncode
        print(f"{name}: {'passed' if code == 0 else 'FAILED'}, {time.monotonic() - start:.0f} s", flush=True)
        if code:
            failed.append(name)

    for scene in SCENES:
        if not (of_scene := kernels_of(listed, scene, options.kernel)):
            continue
        for schedule in SCHEDULES:
            report = pathlib.Path(f"build/nightly_{scene}.{schedule}.json")
            report.unlink(missing_ok=True)
            command = [options.program, "verify", "--kernel", ",".join(of_scene), "--scene", scene]
            command += ["--threads", f"1,{options.threads}", "--failed", "--json", report]
            run(f"verify {scene} {schedule}", command, OMP_SCHEDULE=schedule)
            reports.append(report)
    run("determinism", [sys.executable, "verify/same_bits.py", *reports])
    if not options.no_tsan:
        environment = {"THREADS": options.threads, "SCENES": " ".join(SCENES), "QUICK": "1"}
        run("tsan", ["verify/tsan.sh", *chosen], **environment)
    print("nightly: " + (f"FAILED {', '.join(failed)}" if failed else "all passed"))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
