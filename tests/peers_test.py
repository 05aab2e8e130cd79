"""Tests how make peers merges rows, and what it says when it skips: /usr/bin/python3 tests/peers_test.py

No library is needed: programs and package tools are small scripts.
"""

import contextlib
import copy
import io
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCRIPT = ROOT / "notes" / "peers" / "compare.py"
sys.path[:0] = [str(SCRIPT.parent), str(ROOT / "notes" / "figures")]
import compare  # noqa: E402, from the folder above
import draw  # noqa: E402
import measure  # noqa: E402

MACHINE = {"cpu": "a cpu", "cores": 2, "isa": "avx2", "commit": "abc1234", "date": "2026-01-31", "omp": {"version": 1}}


def measured(scene="pyramid_24", threads=1, samples=(6.0, 4.0, 5.0), ours=(2.0, 2.5, 3.0)):
    """A row as a program prints it."""
    return {
        "work": "a step of rigid bodies",
        "scene": scene,
        "ours": "rigid/step batches",
        "items": {"bodies": 10},
        "threads": threads,
        "cores": 0.99 * threads,
        "whole_cores": True,
        "samples": list(samples),
        "ours_samples": list(ours),
        "quality": {"deepest_mm": 3.5},
        "ours_quality": {"deepest_mm": 0.5},
        "not_the_same": "substeps",
    }


def row(**changed):
    return compare.finished(measured(), "Bullet", "3.24", MACHINE) | changed


class Rows(unittest.TestCase):
    def test_a_row_has_medians_spreads_and_their_ratio(self):
        found = row()
        self.assertEqual((found["ms"], found["ours_ms"], found["ratio"], found["rounds"]), (5, 2.5, 2, 3))
        self.assertAlmostEqual(found["spread"], (5 - 4) / 5)  # quartiles as the benchmark's: at 0 and 1 of 0 .. 2
        self.assertIsNone(compare.spread([1.0]))
        self.assertNotIn("samples", found)
        self.assertEqual((found["cpu"], found["commit"]), ("a cpu", "abc1234"))

    def test_a_new_row_replaces_the_same_comparison_alone(self):
        old = [row(), row(threads=2), row(peer="ODE"), row(cpu="another cpu")]
        new = [row(commit="def5678", version="4"), row(scene="castle")]
        found = compare.merged(old, new)
        self.assertEqual(found, [new[0], *old[1:], new[1]])
        self.assertEqual(compare.merged([], new), new)
        self.assertEqual(compare.merged(old, []), old)

    def test_rows_that_are_not_rows_are_refused(self):
        compare.check([row(), row(spread=None)], "f")

        def refused(rows, words):
            with self.assertRaisesRegex(compare.Refused, words):
                compare.check(rows, "f")

        for field in compare.FIELDS:
            refused([row(), {k: v for k, v in row().items() if k != field}], f"f: row 1: no {field}")
        refused([row(threads="2")], "threads is '2'")
        refused([row(threads=True)], "threads is True")
        refused([row(ms=0.0)], "must be positive")
        refused([row(ratio=0.5)], "ratio is not ms / ours_ms")
        refused({"rows": []}, "expected a list")
        refused(["row"], "expected an object")

    def test_the_note_has_the_fields(self):
        note = (ROOT / "notes" / "peers.md").read_text()
        for field in [*compare.FIELDS, "cores", "rounds"]:
            self.assertIn(f"| `{field}` |", note)

    def test_every_peer_has_its_program_and_its_scenes(self):
        for key, peer in compare.PEERS.items():
            self.assertTrue((SCRIPT.parent / f"{key}.cpp").exists(), key)
            for scene in peer.scenes:
                self.assertEqual(len(list(ROOT.glob(f"scenes/*/{scene}.toml"))), 1, scene)
        deps = next(line for line in (ROOT / "Makefile").read_text().splitlines() if line.startswith("DEBS "))
        for package in ("libbullet-dev", "libode-dev", "libopenvdb-dev", "libhypre-dev"):
            self.assertNotIn(package, deps)  # make peers alone installs them


class Runs(unittest.TestCase):
    """compare.py in a folder whose PATH has the tools that a test puts there."""

    def setUp(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        self.folder = pathlib.Path(kept.name)
        (self.folder / "programs").mkdir()
        (self.folder / "tools").mkdir()
        self.tool("dpkg-query", 'printf "ii 3.24"')
        self.tool("make", "exit 0")

    def script(self, path, text):
        path.write_text(f"#!/bin/sh\n{text}\n")
        path.chmod(0o755)

    def tool(self, name, text):
        self.script(self.folder / "tools" / name, text)

    def program(self, name, text):
        self.script(self.folder / "programs" / name, text)

    def prints(self, name, *rows):
        said = json.dumps({"machine": MACHINE, "rows": rows})
        self.program(name, f"echo a library says hello; echo '{said}'")

    def run_it(self, *words, **environment):
        command = [sys.executable, "-B", SCRIPT, self.folder / "peers.json", "--programs", self.folder / "programs"]
        path = {"PATH": str(self.folder / "tools")} | environment
        return subprocess.run([*command, "--make", "make", *words], capture_output=True, text=True, env=path)

    def rows(self):
        return json.loads((self.folder / "peers.json").read_text())["rows"]

    def test_measures_and_merges(self):
        self.prints("bullet", measured(), measured(threads=2, samples=(1.0, 1.0)))
        ran = self.run_it("--only", "bullet/pyramid_24")
        self.assertEqual(ran.returncode, 0, ran.stderr)
        found = [(r["threads"], r["version"], r["ratio"]) for r in self.rows()]
        self.assertEqual(found, [(1, "3.24", 2), (2, "3.24", 0.4)])
        self.prints("bullet", measured(samples=(10.0, 10.0)))
        self.assertEqual(self.run_it("--only", "bullet/pyramid_24").returncode, 0)
        self.assertEqual([r["ratio"] for r in self.rows()], [4, 0.4])

    def test_runs_what_is_asked_for(self):
        found = compare.chosen("ode/castle,libccd")
        self.assertEqual(found, [("ode", [("castle", "1,2")]), ("libccd", [("hull_soup", "1")])])
        self.assertEqual(compare.chosen("ode/castle/2"), [("ode", [("castle", "2")])])
        self.assertEqual([key for key, _ in compare.chosen(None)], list(compare.PEERS))
        self.program("bullet", 'echo "$@" >&2; exit 2')
        self.assertIn("castle: castle 2\n", self.run_it("--only", "bullet/castle/2").stdout)

    def test_says_why_a_peer_is_skipped(self):
        def skipped(words):
            ran = self.run_it("--only", "bullet/castle")
            self.assertEqual(ran.returncode, 0, ran.stderr)
            self.assertIn(f"Bullet: skipped: {words}\n", ran.stdout)
            self.assertIn("nothing was measured\n", ran.stdout)
            self.assertFalse((self.folder / "peers.json").exists())

        self.program("bullet", "echo first >&2; echo bodies have several surfaces >&2; exit 2")
        skipped("castle: bodies have several surfaces")
        self.program("bullet", "exit 1")
        skipped("castle: no word why")
        self.tool("make", "echo bullet.cpp: no such header >&2; exit 2")
        skipped("it does not build: bullet.cpp: no such header")
        self.tool("dpkg-query", "exit 1")
        skipped("needs libbullet-dev; this system has no apt-get")

    def test_installs_by_root_or_sudo_or_says_what_to_type(self):
        said = io.StringIO()
        with contextlib.ExitStack() as stack:
            stack.enter_context(contextlib.redirect_stdout(said))
            stack.enter_context(mock.patch.object(compare, "installed_version", lambda package: None))
            which = stack.enter_context(mock.patch.object(compare.shutil, "which", lambda name: name == "apt-get"))
            uid = stack.enter_context(mock.patch.object(compare.os, "geteuid", return_value=1000))
            run = stack.enter_context(mock.patch.object(compare.subprocess, "run"))
            self.assertEqual(compare.install(["a", "b"]), "needs a and b; as root, type: apt-get install a b")
            run.assert_not_called()
            uid.return_value = 0
            run.return_value.returncode = 0
            self.assertIsNone(compare.install(["a"]))
            self.assertEqual(run.call_args[0][0][2:], ["apt-get", "install", "-y", "-qq", "a"])
            run.return_value.returncode = 100
            self.assertEqual(compare.install(["a"]), "needs a, and apt-get cannot install that (apt-get update?)")
            stack.enter_context(mock.patch.object(compare.shutil, "which", lambda name: name))
            uid.return_value = 1000
            run.return_value.returncode = 0
            self.assertIsNone(compare.install(["a"]))
            self.assertEqual(run.call_args[0][0][:2], ["sudo", "env"])
        self.assertIn("sudo apt-get install a\n", said.getvalue())

    def test_no_comparison_begins_after_the_time_is_over(self):
        self.prints("bullet", measured())
        clock = iter([0.0, 60.0 * compare.MINUTES + 1])
        words = ["compare.py", str(self.folder / "peers.json"), "--programs", str(self.folder / "programs")]
        said = io.StringIO()
        with mock.patch.object(sys, "argv", [*words, "--make", "true", "--only", "bullet/castle"]):
            with mock.patch.object(compare.time, "monotonic", lambda: next(clock)):
                with mock.patch.object(compare, "install", lambda packages: None), contextlib.redirect_stdout(said):
                    self.assertEqual(compare.main(), 0)
        words = "Bullet: skipped: castle: 20 minutes are over (ONLY=bullet/castle measures it alone)"
        self.assertIn(words, said.getvalue())

    def test_unknown_names_and_broken_reports_are_refused(self):
        def refused(words, *arguments):
            ran = self.run_it(*arguments)
            self.assertEqual(ran.returncode, 2)
            self.assertRegex(ran.stderr, words)
            self.assertEqual(len(ran.stderr.splitlines()), 1)

        refused("no peer jolt, expected one of: bullet, ode", "--only", "jolt")
        (self.folder / "peers.json").write_text("{")
        refused("peers.json: ", "--only", "bullet")
        (self.folder / "peers.json").write_text('{"rows": [{"peer": "Jolt"}]}')
        refused("peers.json: row 0: no version", "--only", "bullet")
        (self.folder / "peers.json").write_text('{"schema": 99, "rows": []}')
        refused("expected {\"schema\": 1", "--only", "bullet")

    def test_adds_rows_that_others_measured(self):
        theirs = self.folder / "jolt.json"
        theirs.write_text(json.dumps({"rows": [row(peer="Jolt")]}))
        ran = self.run_it("--add", theirs)
        self.assertEqual((ran.returncode, "make peers comes first" in ran.stderr), (2, True))
        self.prints("bullet", measured())
        self.run_it("--only", "bullet/pyramid_24")
        for _ in range(2):
            self.assertEqual(self.run_it("--add", theirs).returncode, 0)
            self.assertEqual([r["peer"] for r in self.rows()], ["Bullet", "Jolt"])
        self.assertEqual(json.loads((self.folder / "peers.json").read_text())["machine"], MACHINE)
        theirs.write_text(json.dumps({"rows": [row(peer="Jolt", ratio=3.0)]}))
        self.assertEqual(self.run_it("--add", theirs).returncode, 2)


class Figure(unittest.TestCase):
    def test_shows_both_directions_and_what_differs(self):
        rows = [row(), row(threads=2, ratio=0.25, ms=1.0, ours_ms=4.0), row(peer="ODE", whole_cores=False, spread=None)]
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            report = {"schema": 1, "quick": False, "machine": MACHINE, "rows": copy.deepcopy(rows)}
            (folder / "peers.json").write_text(json.dumps(report))
            with contextlib.redirect_stdout(io.StringIO()):
                draw.main(folder, "peers")
            index = (folder / "index.html").read_text()
            csv = (folder / "peers.csv").read_text()
        self.assertIn("ours is ahead in 2 of 3 rows", index)
        self.assertIn("Ours is slower in: Bullet: pyramid_24, 2 threads (0.25).", index)
        for words in ("deepest mm 3.5", "deepest mm 0.5", "substeps", "Bullet 3.24", "a cpu, avx2, abc1234"):
            self.assertIn(words, index)
        self.assertIn("Hollow grey: 1 of the measured values", index)
        self.assertEqual(len(csv.splitlines()), 4)

    def test_is_drawn_where_its_report_is_and_never_measured(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            self.assertNotIn("peers", draw.chosen(folder=folder))
            (folder / "peers.json").write_text("{}")
            self.assertEqual(list(draw.chosen(folder=folder)), [*draw.FIGURES, "peers"])
        self.assertEqual(measure.needed(draw.chosen("peers")), {})


if __name__ == "__main__":
    unittest.main()
