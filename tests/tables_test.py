"""Tests what make tables writes and refuses: /usr/bin/python3 tests/tables_test.py"""

import copy
import json
import pathlib
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "notes"))
import tables  # noqa: E402, from the folder above


def row(variant, threads, ms, **changed):
    where = {"kernel": "cloth/relax", "form": "colours", "scene": "flag_128", "variant": variant, "threads": threads}
    return where | {"ms": ms, "spread": 0.02, "whole_cores": True, "items": 16384.0, "unit": "particles"} | changed


REPORT = {
    "command": "bench",
    "complete": True,
    "quick": False,
    "machine": {
        "cpu": "a cpu",
        "cores": 2,
        "isa": "avx2",
        "compiler": "g++ 12",
        "date": "2026-01-31",
        "commit": "abc1234",
        "busy_cores": 0.0,
        "peaks": [{"threads": 1, "triad_gb_per_s": 17.5, "fma_gflop_per_s": 71.5}],
    },
    "rows": [
        row("serial", 1, 12.0),
        row("openmp", 1, 4.0, spread=0.3),
        row("openmp", 2, 2.5, whole_cores=False),
        row("openmp", 1, 0.5, kernel="rigid/spheres", form="", scene="rounds", unit="pairs", items=1234567.0),
    ],
}


class Tables(unittest.TestCase):
    def setUp(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        self.folder = pathlib.Path(kept.name)
        self.report, self.page = self.folder / "bench.json", self.folder / "times.md"
        self.page.write_text(f"# Times\n\n{tables.MARK}\n\nof before\n")

    def written(self, report=REPORT):
        self.report.write_text(json.dumps(report))
        tables.main(self.report, self.folder)
        return self.page.read_text()

    def test_a_line_has_the_times_of_a_scene_and_their_ratios(self):
        text = self.written()
        relax = "| relax colours | flag_128 | 16,384 particles | 12 |  | 4 (x 3.00) ±15 % | 2.5 (x 1.60) * |"
        self.assertIn(relax, text)
        self.assertIn("| spheres | rounds | 1,234,567 pairs |  |  | 0.5 |  |", text)

    def test_a_page_keeps_its_beginning_and_loses_old_tables(self):
        text = self.written()
        self.assertTrue(text.startswith("# Times\n"))
        self.assertNotIn("of before", text)
        self.assertLess(text.index("## cloth"), text.index("## rigid"))
        self.assertEqual(self.written(), text)

    def test_other_pages_get_the_rows_that_they_name(self):
        page = self.folder / "cloth.md"
        page.write_text("Before.\n<!-- make tables: */spheres -->\nold\n<!-- end of make tables -->\nAfter.\n")
        self.written()
        text = page.read_text()
        self.assertTrue(text.startswith("Before.\n<!-- make tables: */spheres -->\na cpu, 2 cores"))
        self.assertTrue(text.endswith(" |\n\n<!-- end of make tables -->\nAfter.\n"))
        self.assertIn("| spheres | rounds |", text)
        self.assertNotIn("relax", text)
        self.assertNotIn("old", text)

    def test_a_scene_can_be_named_and_must_be_there(self):
        page = self.folder / "rigid.md"
        block = "<!-- make tables: {} -->\n<!-- end of make tables -->\n"
        page.write_text(block.format("rigid/spheres:rounds cloth/relax:none"))
        self.written()
        self.assertNotIn("relax col", page.read_text())
        page.write_text(block.format("rigid/spheres:nowhere"))
        with self.assertRaisesRegex(tables.Refused, "rigid.md: the report has no rows of rigid/spheres:nowhere"):
            self.written()

    def test_it_names_the_machine_and_the_sitting(self):
        self.assertIn("a cpu, 2 cores, avx2, g++ 12; 2026-01-31, commit abc1234, `bench`.", self.written())

    def test_reports_that_are_not_whole_are_refused_in_words(self):
        for name, value, word in (
            ("quick", True, "is quick"),
            ("complete", False, "is cut off"),
            ("command", "verify", "no report of make bench"),
            ("command", "bench --kernel linear/multiply", "has a part of the kernels"),
            ("shards", [], "in one sitting"),
        ):
            with self.assertRaisesRegex(tables.Refused, word):
                self.written(copy.deepcopy(REPORT) | {name: value})
        self.report.unlink()
        with self.assertRaisesRegex(tables.Refused, "make bench comes first"):
            tables.main(self.report, self.folder)

    def test_the_page_has_tables(self):
        text = (ROOT / "notes" / "times.md").read_text("utf-8")
        head, mark, rest = text.partition(tables.MARK)
        self.assertTrue(mark)
        domains = [folder.name for folder in (ROOT / "scenes").iterdir() if folder.is_dir()]
        self.assertGreater(len(domains), 7)
        for domain in domains:
            self.assertIn(f"\n## {domain}\n", rest)


if __name__ == "__main__":
    unittest.main()
