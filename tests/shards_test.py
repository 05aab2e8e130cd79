"""Tests that the scripts' shards are disjoint and together the whole: /usr/bin/python3 tests/shards_test.py"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE / "mutants"))
import mutants  # noqa: E402, from the folder above

NO_SHARES = ["0/2", "3/2", "a/b", "1", "1/", "/2", "-1/2", "1/2/3", "1/0", " 1/2", "1 /2", "01/2"]


class Mutants(unittest.TestCase):
    def test_shards_are_disjoint_and_together_all(self):
        planted = [mutant.id for mutant in mutants.read_mutants(HERE / "mutants")]
        for count in (1, 2, 3, len(planted) + 1):
            shares = [mutants.share_of(planted, f"{number}/{count}") for number in range(1, count + 1)]
            self.assertEqual(sorted(sum(shares, [])), sorted(planted))
            self.assertLessEqual(max(map(len, shares)) - min(map(len, shares)), 1)

    def test_what_is_no_share_is_refused_in_words(self):
        for shard in NO_SHARES:
            with self.assertRaisesRegex(mutants.Error, "expected I/N with 1 <= I <= N"):
                mutants.share_of(["a", "b"], shard)


class Fuzz(unittest.TestCase):
    """fuzz.sh in a folder of its own, with a fuzzer that does nothing."""

    LOADERS = ["fluid", "cloth", "obj", "off", "stl"]

    def setUp(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        root = pathlib.Path(kept.name)
        for loader in self.LOADERS:
            (root / "tests/fuzz/corpus" / loader).mkdir(parents=True)
        (root / "common/fluid").mkdir(parents=True)
        for scene in ("common/scene.cpp", "common/fluid/scene.cpp"):
            (root / scene).write_text('"kind"')
        self.script = shutil.copy(HERE / "fuzz/fuzz.sh", root / "tests/fuzz")
        fuzzer = root / "build/fuzz/loaders_fuzz"
        fuzzer.parent.mkdir(parents=True)
        fuzzer.write_text(f"#!/bin/sh\necho 'LOCKSTEP_LOADER: expected one of: {' '.join(self.LOADERS)}'\n")
        fuzzer.chmod(0o755)

    def fuzz(self, shard, *loaders):
        command = ["bash", self.script, "1", *loaders]
        return subprocess.run(command, env=os.environ | {"SHARD": shard}, capture_output=True, text=True)

    def run_by(self, shard, *loaders):
        done = self.fuzz(shard, *loaders)
        self.assertEqual(done.returncode, 0, done.stderr)
        return [line.split()[0] for line in done.stdout.splitlines()[1:]]

    def test_shards_are_disjoint_and_together_all(self):
        for count in (1, 2, 3, 6):
            ran = sum((self.run_by(f"{number}/{count}") for number in range(1, count + 1)), [])
            self.assertEqual(sorted(ran), sorted(self.LOADERS))
        self.assertEqual(sorted(self.run_by("")), sorted(self.LOADERS))
        self.assertEqual(self.run_by("2/2", "obj", "stl"), ["stl"])

    def test_what_is_no_share_is_refused_in_words(self):
        for shard in NO_SHARES:
            done = self.fuzz(shard)
            self.assertEqual(done.returncode, 2, shard)
            self.assertIn(f"SHARD={shard}: expected I/N with 1 <= I <= N", done.stderr)


if __name__ == "__main__":
    unittest.main()
