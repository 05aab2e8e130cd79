"""Tests what `make nightly` selects: /usr/bin/python3 tests/nightly_test.py; the program stands in LOCKSTEP."""

import json
import os
import pathlib
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "verify"))
import nightly  # noqa: E402, from the folder above

PROGRAM = os.environ.get("LOCKSTEP", "build/lockstep")


class Nightly(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.listed = json.loads(subprocess.check_output([PROGRAM, "list", "--json"]))["rows"]

    def test_every_form_has_a_large_scene(self):
        for row in self.listed:
            own = set(row["scenes"] + row["more_scenes"]) & set(nightly.SCENES)
            self.assertTrue(own or row["covered_by"], f"{row['kernel']} {row['form']}")

    def test_every_scene_is_of_some_kernel(self):
        for scene in nightly.SCENES:
            self.assertTrue(nightly.kernels_of(self.listed, scene, None), scene)

    def test_kernels_are_named_as_on_the_command_line(self):
        of = lambda named: nightly.kernels_of(self.listed, "castle_hit", named)
        self.assertEqual(of("rigid/gjk"), ["rigid/gjk"])
        self.assertEqual(of("gjk"), ["rigid/gjk"])
        self.assertIn("rigid/step", of("*/step"))
        self.assertEqual(of("fluid,box_box"), ["rigid/box_box"])
        self.assertGreater(len(of("rigid")), 10)


if __name__ == "__main__":
    unittest.main()
