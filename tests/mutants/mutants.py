"""Plants known mistakes in openmp/, one at a time, and expects the verifier or the thread sanitizer to catch each.

`make mutants` calls it. A mistake is a [[mutant]] of a .toml file beside this one:
    kernel, name   what is broken, and how, for a reader
    file           in openmp/, or a header of common/ that openmp/ includes; serial/ keeps the correct header
    find, replace  the edit: a text that occurs exactly once in the file, and its replacement; for edits at several
                   places, two lists of the same length
    verify         more arguments for `lockstep verify --kernel KERNEL`; or, for races that the verifier might not see,
    tsan           the same in the thread sanitizer's build
    isa            optional: avx512 or avx2, if the changed code runs with these lanes alone. A build with others leaves
                   the mutant out
The sources stay unchanged. The changed file goes to a folder of its own, build/mutants/BUILD/ID/, which the compiler
searches first. Files that depend on it are compiled again (-O1 gives the same bits and is faster), linked with the
other objects of the normal build, and run.

A mutant is caught if a verify row fails, if the program crashes or hangs, or if the sanitizer sees a race in one of
TSAN_RUNS runs. It is an error if a mutant's text is not found or does not compile, or if the unchanged program, built
in the same way, does not pass the mutant's selection. No mutant can therefore count as caught by accident. Exit code 0
if all are caught, 1 if one survived, 2 on an error.
"""

import argparse
import collections
import concurrent.futures
import dataclasses
import datetime
import functools
import json
import os
import pathlib
import re
import resource
import shlex
import shutil
import signal
import subprocess
import sys
import time
import tomllib

# Archer tells the sanitizer what OpenMP orders. verify/tsan.sh explains why Archer's own lock table must be suppressed.
SUPPRESSIONS = "called_from_lib:libarcher.so\n"
ARCHER = os.environ.get("OMP_TOOL_LIBRARIES", "/usr/lib/llvm-14/lib/libarcher.so")
# The sanitizer remembers only the last few accesses to a word, and locks that threads happen to pass on hide a missing
# barrier. So it sees a race only with some probability, and gets several runs. The unchanged program shows no race in
# any run of `make tsan`.
TSAN_RUNS = 5


class Error(Exception):
    """An error in the mutants' files or in the arguments: no verdict on a mutant."""


@dataclasses.dataclass(frozen=True)
class Mutant:
    id: str
    kernel: str
    name: str
    file: str
    edits: tuple  # of (find, replace)
    selection: tuple  # words for lockstep
    tsan: bool
    isa: str  # "": any

    @functools.cached_property
    def text(self):
        """The changed content of the file."""
        text = original = pathlib.Path(self.file).read_text()
        # From the end to the beginning, so that no edit changes the position of another.
        for find, replace in sorted(self.edits, key=lambda edit: original.find(edit[0]), reverse=True):
            if original.count(find) != 1:
                raise Error(f"{self.id}: stands {original.count(find)} times in {self.file}, must once: {find}")
            begin = original.index(find)
            text = text[:begin] + replace + text[begin + len(find) :]
        return text

    @property
    def where(self):
        """The first line that differs."""
        original = pathlib.Path(self.file).read_text()
        same = os.path.commonprefix([original, self.text])
        return f"{self.file}:{same.count(chr(10)) + 1}"


def read_mutants(folder):
    mutants = []
    numbers = collections.Counter()  # over all files: a mutant's folder is its own
    for path in sorted(folder.glob("*.toml")):
        for entry in tomllib.loads(path.read_text())["mutant"]:
            kernel, tsan = entry["kernel"], "tsan" in entry
            if entry.keys() - {"isa"} != {"kernel", "name", "file", "find", "replace", "tsan" if tsan else "verify"}:
                raise Error(f"{path.name}, {entry.get('name')}: has {', '.join(entry)}")
            as_list = lambda value: value if isinstance(value, list) else [value]
            edits = tuple(zip(as_list(entry["find"]), as_list(entry["replace"]), strict=True))
            numbers[kernel] += 1
            selection = ("verify", "--kernel", kernel, *shlex.split(entry["tsan" if tsan else "verify"]))
            id = f"{kernel.replace('/', '-')}-{numbers[kernel]}"
            isa = entry.get("isa", "")
            if isa not in ("", "avx512", "avx2"):
                raise Error(f"{path.name}, {entry['name']}: isa is {isa}, expected avx512 or avx2")
            mutants.append(Mutant(id, kernel, entry["name"], entry["file"], edits, selection, tsan, isa))
            mutants[-1].text  # a stale mutant is an error even if it is not selected
    return mutants


LEAST = 5  # mutants of a kernel


def check_numbers(mutants, report):
    """Checks that each kernel of a program has enough mutants, and that each mutant's kernel exists. report: of its
    `list`."""
    listed = {row["kernel"] for row in report["rows"]}
    numbers = collections.Counter(mutant.kernel for mutant in mutants)
    few = [f"{kernel} has {numbers[kernel]}" for kernel in sorted(listed) if numbers[kernel] < LEAST]
    if few:
        raise Error(f"fewer than {LEAST} mutants: {', '.join(few)}")
    if unknown := set(numbers) - listed:
        raise Error(f"mutants of no kernel: {', '.join(sorted(unknown))}")


def some_of(mutants, n):
    """The n mutants of today. All mutants form a ring: the first of each kernel, the second of each, and so on. Each
    day continues where the day before stopped."""
    by_kernel = collections.defaultdict(list)
    for mutant in mutants:
        by_kernel[mutant.kernel].append(mutant)
    rounds = max(map(len, by_kernel.values()))
    ring = [of_kernel[r] for r in range(rounds) for of_kernel in by_kernel.values() if r < len(of_kernel)]
    day = datetime.date.today().toordinal()
    first = day * n % len(ring)
    days = -(-len(ring) // n)
    print(
        f"day {day}: {min(n, len(ring))} of {len(ring)} mutants, from number {first + 1} on; all have their turn in"
        f" {days} days"
    )
    return [ring[(first + k) % len(ring)] for k in range(min(n, len(ring)))]


def share_of(mutants, shard):
    """Those of shard "2/3", the second of three; the rule is that of verify/shard.h."""
    numbers = re.fullmatch(r"([1-9][0-9]{0,5})/([1-9][0-9]{0,5})", shard)
    if not numbers or int(numbers[1]) > int(numbers[2]):
        raise Error(f"--shard {shard}: expected I/N with 1 <= I <= N, such as 2/3")
    return mutants[int(numbers[1]) - 1 :: int(numbers[2])]


class Build:
    """A built program: its folder, its objects, its commands to compile and link. Makes changed programs from it."""

    def __init__(self, folder, objects, compile, link, libs):
        self.folder, self.compile, self.link, self.libs = (
            pathlib.Path(folder),
            shlex.split(compile),
            shlex.split(link),
            shlex.split(libs),
        )
        self.work = pathlib.Path("build/mutants") / self.folder.name
        self.sources = {}  # of each object: its source, then the files included
        for object in (self.folder / name for name in objects.split()):
            if not object.exists():
                raise Error(f"{object} is not built")
            rule = object.with_suffix(".d").read_text().replace("\\\n", " ").split("\n\n")[0].splitlines()[0]
            self.sources[str(object)] = rule.split(":", 1)[1].split()

    def make(self, id, files, map=map):
        """Builds the program with these files, {name: text}, in place of its own. Returns its path."""
        overlay = self.work / id
        shutil.rmtree(overlay, ignore_errors=True)
        for name, text in files.items():
            (overlay / name).parent.mkdir(parents=True, exist_ok=True)
            (overlay / name).write_text(text)
        # A header of common/ changes for openmp/ alone, because serial/ is the reference.
        takes = lambda name, source: name.startswith("openmp/") or source.startswith("openmp/")
        changed = {o: of for o, of in sorted(self.sources.items()) if any(f in of and takes(f, of[0]) for f in files)}
        # serial/ and common/ do not include openmp/.
        if not changed or any(of[0].startswith(("serial/", "common/")) for of in changed.values()):
            raise Error(f"{id}: {', '.join(files)} goes into {', '.join(changed) or 'nothing'}")
        objects = [object for object in self.sources if object not in changed]

        def compile_one(of):
            source, object = of[0], overlay / (of[0].replace("/", "_") + ".o")
            path = overlay / source if source in files else source
            # Without weak symbols an object keeps its own instances of a template. Otherwise the linker would use
            # serial/'s for all.
            weak = ["-fno-weak"] if source.startswith("openmp/") and any(f.startswith("common/") for f in files) else []
            self.run_tool(
                id,
                [
                    *self.compile,
                    "-O1",
                    "-w",
                    *weak,
                    f"-I{overlay}",
                    "-I.",
                    f"-I{self.folder}",
                    "-c",
                    path,
                    "-o",
                    object,
                ],
            )
            return object

        objects += map(compile_one, changed.values())
        self.run_tool(id, [*self.link, *objects, *self.libs, "-o", overlay / "lockstep"])
        return overlay / "lockstep"

    def run_tool(self, id, command):
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
        if done.returncode != 0:
            raise Error(f"{id} does not compile: {shlex.join(map(str, command))}\n{done.stderr[-3000:]}")

    def clear(self, id):
        """Removes the program and the objects, which are large. The changed source, report and log stay."""
        for path in (self.work / id).glob("*.o"):
            path.unlink()
        (self.work / id / "lockstep").unlink(missing_ok=True)


def run(program, selection, tsan, seconds, name="verify"):
    """Runs a program. Returns what is wrong, "" if nothing. Its report and log stay beside it, under `name`."""
    report, log = program.parent / f"{name}.json", program.parent / f"{name}.log"
    environment = dict(os.environ)
    if tsan:
        (program.parent / "suppressions").write_text(SUPPRESSIONS)
        suppressions = f"suppressions={(program.parent / 'suppressions').resolve()}"
        options = f"ignore_noninstrumented_modules=1 halt_on_error=1 exitcode=66 {suppressions}"
        environment |= {"TSAN_OPTIONS": options, "OMP_TOOL_LIBRARIES": ARCHER, "ARCHER_OPTIONS": "verbose=1"}
    report.unlink(missing_ok=True)
    try:
        with log.open("w") as out:
            command = [program, *selection, "--json", report]
            code = subprocess.run(
                command, stdout=out, stderr=out, stdin=subprocess.DEVNULL, env=environment, timeout=seconds
            ).returncode
    except subprocess.TimeoutExpired:
        return f"hangs: killed after {seconds:.0f} s"
    said = log.read_text(errors="replace")
    if tsan and "Archer detected OpenMP application with TSan" not in said:
        raise Error(f"no Archer in {log}")
    if found := re.search(
        r"(?:WARNING|ERROR): ThreadSanitizer: ([\w -]+)", said
    ):  # a race, or memory freed under another thread
        frame = re.search(r"openmp/[\w/.]+:\d+", said[found.end() :])
        return f"tsan: {found[1].strip()}" + (f" at {frame[0]}" if frame else "")
    if code == 0:
        return ""
    if code < 0:
        return f"crash: {signal.Signals(-code).name}"
    if code != 1 or not report.exists():
        raise Error(f"{shlex.join(selection)} ends with exit code {code}: {said[-1000:]}")
    row = next(row for row in json.loads(report.read_text())["rows"] if not row["passed"])
    where = " ".join(filter(None, [row["form"], row["scene"], f"at {row['threads']}"]))
    return f"{'tsan build, ' if tsan else ''}{row['verdict']}, {where}: {row['worst_at']}"


def columns(mutants):
    """A function that prints a row, with column widths for these mutants."""
    kernel, name, where = (max(map(len, column)) for column in zip(*((m.kernel, m.name, m.where) for m in mutants)))
    return lambda *row: print(
        f"{row[0]:<{kernel}}  {row[1]:<{name}}  {row[2]:<{where}}  {row[3]:<100.100}  {row[4]:>7}", flush=True
    )


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument(
        "--kernel", help="only the mutants of this kernel, or of all of a domain: fluid/densities, fluid"
    )
    options.add_argument("--some", type=int, metavar="N", help="only N, others every day, so that all have their turn")
    options.add_argument("--shard", metavar="I/N", help="only the I-th of N shares of what is selected")
    options.add_argument("--build", default="build/avx512", help="the folder of the normal build, made before")
    options.add_argument("--tsan-build", default="build/tsan", help="the folder of the thread sanitizer's build")
    for words in ("objects", "compile", "link", "libs", "tsan-compile", "tsan-link", "tsan-make"):
        options.add_argument(f"--{words}", default="", help="the Makefile's objects, command or flags")
    options = options.parse_args()
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    jobs = len(os.sched_getaffinity(0))

    mutants = read_mutants(pathlib.Path(__file__).parent)
    report = json.loads(subprocess.check_output([pathlib.Path(options.build) / "lockstep", "list", "--json"]))
    mutants = [m for m in mutants if m.isa in ("", report["machine"]["isa"])]
    check_numbers(mutants, report)
    if options.kernel:
        mutants = [m for m in mutants if m.kernel == options.kernel or m.kernel.startswith(options.kernel + "/")]
    if not mutants:
        raise Error(f"no mutants of {options.kernel}")
    if options.some:
        mutants = some_of(mutants, options.some)
    if options.shard and not (mutants := share_of(mutants, options.shard)):
        print("0 caught, 0 survived")
        return 0
    # Shards that share a folder each have an unchanged program of their own.
    unchanged = "unchanged" + ("-" + options.shard.replace("/", "of") if options.shard else "")

    builds = {}
    if any(not m.tsan for m in mutants):
        builds[False] = Build(options.build, options.objects, options.compile, options.link, options.libs)
    if any(m.tsan for m in mutants):
        if subprocess.run(shlex.split(options.tsan_make)).returncode != 0:
            raise Error(f"{options.tsan_make} failed")
        builds[True] = Build(
            options.tsan_build, options.objects, options.tsan_compile, options.tsan_link, options.libs
        )

    # The unchanged program, with the same files compiled in the same way, must pass every selection.
    usual = {}  # seconds of each selection
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for tsan, build in builds.items():
            files = {m.file: pathlib.Path(m.file).read_text() for m in mutants if m.tsan == tsan}
            program = build.make(unchanged, files, pool.map)

            def check(numbered):
                (number, selection), start = numbered, time.monotonic()
                if wrong := run(program, selection, tsan, 1800, str(number)):
                    raise Error(f"the unchanged program does not pass {shlex.join(selection)}: {wrong}")
                usual[tsan, selection] = time.monotonic() - start

            list(pool.map(check, enumerate(dict.fromkeys(m.selection for m in mutants if m.tsan == tsan))))
            build.clear(unchanged)
    print(f"the unchanged program passes all {len(usual)} selections")

    def try_mutant(mutant):
        start, build, error = time.monotonic(), builds[mutant.tsan], None
        try:
            program = build.make(mutant.id, {mutant.file: mutant.text})
            for attempt in range(1, (TSAN_RUNS if mutant.tsan else 1) + 1):
                caught = run(program, mutant.selection, mutant.tsan, 30 + 10 * usual[mutant.tsan, mutant.selection])
                if caught:
                    caught += f" (run {attempt})" if attempt > 1 else ""
                    break
        except Error as e:
            caught, error = "ERROR", e
        build.clear(mutant.id)
        return mutant, caught, error, time.monotonic() - start

    row = columns(mutants)
    row("kernel", "mutant", "where", "caught by", "seconds")
    survived, errors = 0, []
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for mutant, caught, error, seconds in pool.map(try_mutant, mutants):
            row(mutant.kernel, mutant.name, mutant.where, caught or "SURVIVED", f"{seconds:.1f}")
            survived += not caught
            errors += [error] if error else []
    for error in errors:
        print(f"mutants: {error}", file=sys.stderr)
    print(
        f"{len(mutants) - survived - len(errors)} caught, {survived} survived"
        + (f", {len(errors)} errors" if errors else "")
    )
    return 2 if errors else 1 if survived else 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Error as error:
        print(f"mutants: {error}", file=sys.stderr)
        sys.exit(2)
