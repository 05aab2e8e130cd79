"""Times other libraries on our scenes, in turn with ours:

    compare.py REPORT --programs FOLDER --make COMMAND [--only PEER[/SCENE[/THREADS]],...] [--add ROWS]

`make peers` calls it; notes/peers.md says what is compared and what a row is. Packages that are missing are installed
if that is possible; a peer that cannot be built or run is skipped, and a line says why. Rows of the same comparison
that REPORT has already are replaced, others stay. --add merges rows of a file that somebody else measured, and
measures nothing.
"""

import argparse
import dataclasses
import json
import os
import pathlib
import shlex
import shutil
import statistics
import subprocess
import sys
import time

SCHEMA = 1
MINUTES = 20  # no comparison begins later
PATIENCE = 400  # s, of one comparison


@dataclasses.dataclass
class Peer:
    name: str
    packages: list  # of Debian: the first is the one whose version is told
    scenes: list
    threads: str = "1"
    environment: dict = dataclasses.field(default_factory=dict)


PEERS = {
    "bullet": Peer("Bullet", ["libbullet-dev"], ["pyramid_24", "castle", "box_pit_4000"]),
    "ode": Peer("ODE", ["libode-dev"], ["pyramid_24", "castle", "box_pit_4000"], "1,2"),
    "openvdb": Peer(
        "OpenVDB",
        ["libopenvdb-dev", "libtbb-dev"],
        ["spheres_and_box_128", "corrupted_256", "spheres_and_box_128_full"],
        "1,2",
    ),
    "openvdb_tracking": Peer("OpenVDB tracking", ["libopenvdb-dev", "libtbb-dev"], ["enright_32", "enright_64"], "1,2"),
    "hypre": Peer("hypre PFMG-PCG", ["libhypre-dev", "libopenmpi-dev"], ["drop_64", "drop_128"]),
    "eigen_pressure": Peer("Eigen ICCG", ["libeigen3-dev"], ["drop_64", "drop_128"], "1,2"),
    # Its few OpenMP regions would take four threads.
    "cholmod": Peer("CHOLMOD", ["libsuitesparse-dev"], ["drop_64"], environment={"OMP_THREAD_LIMIT": "1"}),
    "libccd": Peer("libccd", ["libccd-dev"], ["hull_soup"]),
    "eigen_product": Peer("Eigen", ["libeigen3-dev"], ["poisson_128", "elasticity_48"], "1,2"),
}

# What a row must have, and its types. notes/peers.md says what each means.
FIELDS = {
    "peer": str,
    "version": str,
    "work": str,
    "scene": str,
    "items": dict,
    "ours": str,
    "threads": int,
    "ms": (int, float),
    "spread": (int, float, type(None)),
    "ours_ms": (int, float),
    "ours_spread": (int, float, type(None)),
    "ratio": (int, float),
    "whole_cores": bool,
    "quality": dict,
    "ours_quality": dict,
    "not_the_same": str,
    "cpu": str,
    "isa": str,
    "commit": str,
    "date": str,
}
SAME = ("peer", "work", "scene", "threads", "ours", "cpu", "isa")  # a comparison


class Refused(Exception):
    """A report or rows that cannot be used, or an unknown name."""


# --- Rows


def spread(samples):
    """The interquartile range over the median, as `lockstep bench` has it."""
    if len(samples) < 2:
        return None
    in_order = sorted(samples)
    at = lambda q: in_order[int(q * (len(in_order) - 1))]  # noqa: E731
    return (at(0.75) - at(0.25)) / at(0.5)


def finished(measured, peer, version, machine):
    """A row of a program with what the program does not know."""
    ms, ours_ms = statistics.median(measured["samples"]), statistics.median(measured["ours_samples"])
    row = {"peer": peer, "version": version} | {k: v for k, v in measured.items() if not k.endswith("samples")}
    row |= {"ms": ms, "spread": spread(measured["samples"]), "ours_ms": ours_ms}
    row |= {"ours_spread": spread(measured["ours_samples"]), "ratio": ms / ours_ms, "rounds": len(measured["samples"])}
    row |= {field: machine[field] for field in ("cpu", "isa", "commit", "date")}
    check([row], peer)
    return row


def check(rows, where):
    """Refuses what is not a list of rows."""
    if not isinstance(rows, list):
        raise Refused(f"{where}: expected a list of rows")
    for number, row in enumerate(rows):
        place = f"{where}: row {number}"
        if not isinstance(row, dict):
            raise Refused(f"{place}: expected an object")
        for field, kind in FIELDS.items():
            if field not in row:
                raise Refused(f"{place}: no {field} (notes/peers.md)")
            if not isinstance(row[field], kind) or (isinstance(row[field], bool) and kind is not bool):
                raise Refused(f"{place}: {field} is {row[field]!r}")
        if not (row["ms"] > 0 and row["ours_ms"] > 0):
            raise Refused(f"{place}: ms and ours_ms must be positive")
        if abs(row["ratio"] * row["ours_ms"] / row["ms"] - 1) > 1e-3:
            raise Refused(f"{place}: ratio is not ms / ours_ms")


def merged(old, new):
    """Old rows in their order, those of a comparison that is new replaced; then the others."""
    key = lambda row: tuple(row[field] for field in SAME)  # noqa: E731
    newest = {key(row): row for row in new}
    kept = [newest.pop(key(row), row) for row in old]
    return kept + list(newest.values())


def read(path):
    """A report, or None where there is none."""
    try:
        report = json.loads(path.read_text())
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as error:
        raise Refused(f"{path}: {error}") from error
    if not isinstance(report, dict) or "rows" not in report or report.get("schema", SCHEMA) != SCHEMA:
        raise Refused(f'{path}: expected {{"schema": {SCHEMA}, "rows": [...]}}')
    check(report["rows"], path)
    return report


def write(path, report):
    """Whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_suffix(".new")
    beside.write_text(json.dumps(report, indent=2) + "\n")
    beside.replace(path)


def keep(path, rows, machine=None):
    """Merges rows into the report; its machine is that of the last rows that were measured here."""
    report = read(path) or {"schema": SCHEMA, "quick": False, "machine": machine, "rows": []}
    report |= {"machine": machine or report["machine"], "rows": merged(report["rows"], rows)}
    write(path, report)


# --- Packages and programs


def installed_version(package):
    """Of Debian's package, or None."""
    try:
        found = subprocess.run(
            ["dpkg-query", "-W", "-f", "${db:Status-Abbrev}${Version}", package], capture_output=True, text=True
        )
    except FileNotFoundError:
        return None
    return found.stdout[3:].strip() if found.returncode == 0 and found.stdout.startswith("ii") else None


def install(packages):
    """Installs Debian packages as root or by sudo. Returns why not, in words, or None."""
    missing = [package for package in packages if not installed_version(package)]
    if not missing:
        return None
    asked = f"needs {' and '.join(missing)}"
    if not shutil.which("apt-get"):
        return f"{asked}; this system has no apt-get"
    prefix = [] if os.geteuid() == 0 else ["sudo"]
    if prefix and not shutil.which("sudo"):
        return f"{asked}; as root, type: apt-get install {' '.join(missing)}"
    print(" ".join([*prefix, "apt-get install", *missing]), flush=True)
    command = [*prefix, "env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "install", "-y", "-qq", *missing]
    if subprocess.run(command, stdout=subprocess.DEVNULL).returncode:
        return f"{asked}, and apt-get cannot install that (apt-get update?)"
    return None


def last_line(text):
    lines = [line for line in text.splitlines() if line.strip()]
    return lines[-1] if lines else "no word why"


def measure(program, peer, scene, threads):
    """What the program prints. Raises Refused with its reason."""
    try:
        ran = subprocess.run(
            [program, scene, threads],
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            env=os.environ | peer.environment,
        )
    except subprocess.TimeoutExpired:
        raise Refused(f"took more than {PATIENCE} s") from None
    if ran.returncode:
        raise Refused(last_line(ran.stderr))
    return json.loads(ran.stdout.splitlines()[-1])


def chosen(only):
    """[(peer's key, [(scene, threads)])] of PEER[/SCENE[/THREADS]],...; all without it."""
    wanted = {}
    for part in only.split(",") if only else PEERS:
        key, scene, threads, *_ = [*part.split("/"), "", ""]
        if key not in PEERS:
            raise Refused(f"no peer {key}, expected one of: {', '.join(PEERS)}")
        for each in [scene] if scene else PEERS[key].scenes:
            wanted.setdefault(key, []).append((each, threads or PEERS[key].threads))
    return list(wanted.items())


def told(row):
    """A line of the table that a run prints."""
    both = f"{row['ms']:10.3f} {row['ours_ms']:10.3f} {row['ratio']:8.2f}"
    cores = "" if row["whole_cores"] else "  without whole cores"
    return f"{row['peer']:15} {row['scene']:25} {row['threads']:7} {both}{cores}"


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("report", type=pathlib.Path)
    arguments.add_argument("--programs", type=pathlib.Path, required=True)
    arguments.add_argument("--make", required=True)
    arguments.add_argument("--only")
    arguments.add_argument("--add", type=pathlib.Path)
    options = arguments.parse_args()
    if options.add:
        added = read(options.add)
        if not added:
            raise Refused(f"{options.add}: cannot be read")
        if not options.report.exists():
            raise Refused(f"{options.report}: is not there: make peers comes first")
        keep(options.report, added["rows"])
        print(f"{options.report}: {len(added['rows'])} rows from {options.add}")
        return 0
    wanted = chosen(options.only)
    read(options.report)  # refused before anything is measured
    begun, measured_any = time.monotonic(), False
    print(f"{'peer':15} {'scene':25} threads {'its ms':>10} {'ours':>10} {'ratio':>8}", flush=True)
    for key, scenes in wanted:
        peer, program = PEERS[key], options.programs / key
        skip = lambda why: print(f"{peer.name}: skipped: {why}", flush=True)  # noqa: E731
        if why := install(peer.packages):
            skip(why)
            continue
        made = subprocess.run([*shlex.split(options.make), str(program)], capture_output=True, text=True)
        if made.returncode:
            skip(f"it does not build: {last_line(made.stderr)}")
            continue
        for scene, threads in scenes:
            if time.monotonic() - begun > 60 * MINUTES:
                skip(f"{scene}: {MINUTES} minutes are over (ONLY={key}/{scene} measures it alone)")
                continue
            try:
                found = measure(program, peer, scene, threads)
                version = installed_version(peer.packages[0]) or "unknown"
                rows = [finished(row, peer.name, version, found["machine"]) for row in found["rows"]]
                keep(options.report, rows, found["machine"])
            except Refused as refused:
                skip(f"{scene}: {refused}")
                continue
            measured_any = True
            for row in rows:
                print(told(row), flush=True)
    print(options.report if measured_any else "nothing was measured")
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Refused as refused:
        print(f"compare.py: {refused}", file=sys.stderr)
        sys.exit(2)
