"""Do reports of `lockstep verify` agree, bit for bit? Arguments: two or more of its JSON files, from other runs, builds
or machines.

A row of verify holds a hash of the openmp form's result. Rows of the same kernel, form and scene must hold the same
hash in all reports and at all thread counts. Reports made with other lanes or another compiler (--bitwise) must agree
in the rows with a bitwise verdict. Forms that depend on the order in which threads take a lock have no hash. Prints a
line a form. The exit code is 1 if any rows differ, or if there is nothing to compare.
"""

import argparse
import collections
import json
import sys


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("reports", nargs="+")
    arguments.add_argument("--bitwise", action="store_true", help="only rows whose verdict is bitwise")
    options = arguments.parse_args()

    hashes = collections.defaultdict(lambda: collections.defaultdict(set))  # by kernel and form, then by scene
    rows = collections.Counter()
    failed = 0
    for path in options.reports:
        with open(path) as file:
            report = json.load(file)
        failed += sum(not row["passed"] for row in report["rows"])
        for row in report["rows"]:
            if row["hash"] and (row["verdict"] == "bitwise" or not options.bitwise):
                hashes[row["kernel"], row["form"]][row["scene"]].add(row["hash"])
                rows[row["kernel"], row["form"]] += 1
    print(f"{'kernel':<19} {'form':<25} {'scenes':>6} {'rows':>5}  {len(options.reports)} reports")
    differ = 0
    for (kernel, form), of_scene in hashes.items():
        wrong = [scene for scene, found in of_scene.items() if len(found) > 1]
        differ += len(wrong)
        print(
            f"{kernel:<19} {form:<25} {len(of_scene):6} {rows[kernel, form]:5} "
            f" {'DIFFER on ' + ', '.join(wrong) if wrong else 'same bits'}"
        )
    scenes = sum(map(len, hashes.values()))
    print(
        f"{scenes - differ} passed, {differ} failed" + (f"; {failed} rows of the reports had failed" if failed else "")
    )
    return 1 if differ or failed or not scenes or len(options.reports) < 2 else 0


if __name__ == "__main__":
    sys.exit(main())
