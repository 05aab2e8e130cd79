"""Tests the figures and their index with small reports: /usr/bin/python3 tests/figures_test.py

The environment variable LOCKSTEP names the program (default build/lockstep), whose kernels the figures name.
"""

import argparse
import contextlib
import copy
import csv
import html
import importlib
import io
import itertools
import json
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent
FOLDER = ROOT / "notes" / "figures"
sys.path.insert(0, str(FOLDER))
import cloth_modules  # noqa: E402, from the folder above
import draw  # noqa: E402
import every_kernel  # noqa: E402
import judge  # noqa: E402
import measure  # noqa: E402
import module_times  # noqa: E402
import modules  # noqa: E402
import face_modules  # noqa: E402
import problem_sizes  # noqa: E402
import production_modules  # noqa: E402
import roofline  # noqa: E402
import scalability  # noqa: E402
import source  # noqa: E402

MACHINE = {
    "date": "2026-01-31",
    "cpu": "a cpu",
    "cores": 2,
    "isa": "avx2",
    "lanes": 8,
    "compiler": "g++",
    "flags": "-O3",
}
MACHINE |= {"commit": "abc1234", "omp": {"version": 201511}}
SHARES = {
    "work": 0.5,
    "serial": 0.1,
    "together": 0.1,
    "locks": 0.1,
    "dispatch": 0.1,
    "waiting": 0.05,
}  # the remaining 0.05 is memory

# kernel, form, scene: the rows that the figures need.
KERNELS = [
    ("rigid/step", "batches", "castle_hit"),
    ("rigid/sweep_and_prune", "batch", "boxes_100k"),
    ("rigid/box_box", "", "box_pit_4000"),
    ("rigid/gjk", "cold", "hull_pit_2000"),
    ("rigid/contact_solver", "batches", "castle_hit"),
    ("fluid/rebuild_grid", "counting_sort", "dam_break_500k"),
    ("fluid/densities", "pair_lists", "dam_break_500k"),
    ("fluid/forces", "pair_lists", "dam_break_500k"),
    ("fluid/collisions", "", "dam_break_500k"),
    ("fluid/advance", "", "dam_break_500k"),
    *(("fluid/step", form, "dam_break_500k") for form in ("owner_gather", "pair_lists", "sub_grid", "cell_locks")),
    ("cloth/relax", "colours", "flag_256"),
    ("cloth/step", "colours", "flag_128"),
    ("rigid/match_contacts", "", "castle_hit"),
]

# That have kernels of their own, of both production applications.
FIGURES_OF_MODULES = (production_modules, face_modules, cloth_modules)
MODULES = [m for figure in FIGURES_OF_MODULES for m, form in figure.MODULES.items() if form is not None]


def reports(threads=(1, 2)):
    """Every report, small, with different numbers in each row, of a machine with as many cores as the most threads."""

    def modelled(cores, ms, measured_ms):
        """The model's fields of a row, as in scale.json and in the reports of figures."""
        row = {"cores": cores, "modelled_ms": ms, "compute_ms": ms, "memory_ms": 0.0} | SHARES
        if cores <= threads[-1]:
            row |= {"measured_ms": measured_ms, "off_by": ms / measured_ms - 1, "whole_cores": True}
        return row

    counts = sorted({*threads, 64})
    bench, scale = [], []
    times = [
        ("serial", 1, 80.0),
        ("serial_twin", 1, 90.0),
        ("openmp", 1, 10.0),
        *(("openmp", t, 11.0 / t) for t in threads[1:]),
    ]
    for k, (kernel, form, scene) in enumerate(KERNELS):
        named = {"kernel": kernel, "form": form, "scene": scene}
        for variant, count, base in times:
            ms = base + k
            row = named | {"variant": variant, "threads": count, "lanes": 8 if variant == "openmp" else 1, "ms": ms}
            row |= {"spread": 0.1, "whole_cores": True}
            flops = 0.0 if kernel == "rigid/match_contacts" else 1e6 * (k + 1)
            bench.append(
                row | {"items": 1000.0, "unit": "bodies", "items_per_s": 1e6 / ms, "bytes": 1e6, "flops": flops}
            )
        scale += [named | modelled(cores, (10.0 + k) / cores, 11.0 / cores) for cores in counts]

    cloth = [
        {"scene": scene, "form": form, "iterations": n, "residual": slowness / n}
        for scene in ("flag_33", "sheet_on_sphere", "rope", "pulled_edge")
        for form, slowness in (("original", 1.0), ("chains", 0.8), ("colours", 2.5), ("batches", 1.5))
        for n in (5, 20, 80)
    ]

    both = {"fast_marching": 300.0, "fast_sweeping": 100.0}
    levelset = [
        {"scene": "s", "algorithm": a, "blocks": 1, "variant": "serial", "measured_ms": ms} for a, ms in both.items()
    ]
    for blocks in (1, 8):
        for cores in counts:
            for algorithm, ms in both.items():
                row = {"scene": "s", "algorithm": algorithm, "blocks": blocks, "variant": "openmp"}
                row |= {"work_points": 50.0 * blocks, "band_points": 50.0}
                levelset.append(row | modelled(cores, ms / min(blocks, cores), ms / min(blocks, cores) + 1))

    serial = {"original": 120.0, "batches": 130.0, "blocks": 140.0}
    contacts = [
        {"scene": "pyramid_24", "form": form, "variant": "serial", "measured_ms": ms} for form, ms in serial.items()
    ]
    for cores in counts:
        for form, ms in (("original", 30.0), ("batches", 20.0), ("blocks", 25.0), ("reorder", 2.0)):
            contacts.append(
                {"scene": "pyramid_24", "form": form, "variant": "openmp"}
                | modelled(cores, ms / cores, ms / cores + 0.5)
            )
    contacts += [
        {"scene": "pyramid_24", "variant": "batch_size", "batch": k, "contacts": 100 - 40 * k} for k in range(3)
    ]

    slice_ = [
        {"x": x, "y": y, "distance": 0.1 * (x - 1.5), "error_in_spacings": 0.01 * y} for y in range(4) for x in range(4)
    ]
    with_costs = {"scale": scale, "cloth_convergence": cloth, "levelset_blocks": levelset, "levelset_slice": slice_}
    curves = {kernel for _, kernel, *_ in scalability.WORKLOADS}
    with_costs["curves"] = [dict(row) for row in scale if row["kernel"] in curves]
    with_costs["contact_batches"] = contacts
    scale += [
        {"kernel": f"production_fluid/{module}", "form": form, "scene": "drop_128"}
        | modelled(cores, 8.0 / cores, 9.0 / cores)
        | {"compute_ms": 6.0 / cores, "memory_ms": 8.0 / cores}
        for module, form in production_modules.MODULES.items()
        for cores in counts
    ]
    face_kernels = {module: form for module, form in face_modules.MODULES.items() if form is not None}
    scale += [
        {"kernel": f"production_face/{module}", "form": form, "scene": face_modules.SCALED_ON[0]}
        | modelled(cores, 8.0 / cores, 9.0 / cores)
        for module, form in face_kernels.items()
        for cores in counts
    ]
    cloth_kernels = module_times.kernels_of("production_cloth", cloth_modules.MODULES, cloth_modules.KERNELS)
    scale += [
        {"kernel": kernel, "form": cloth_modules.MODULES[module], "scene": cloth_modules.SCALED_ON[0]}
        | modelled(cores, 8.0 / cores, 9.0 / cores)
        for module, kernel in cloth_kernels.items()
        for cores in counts
    ]
    with_costs["cloth_modules"] = [
        {"scene": "curtain", "variant": variant, "form": cloth_modules.FORM, "threads": count, "triangles": 1000}
        | {"steps": 2, "iterations": 40, "near": 3, "impacts": 1}
        | {"modules": [{"module": module, "ms": ms + k} for k, module in enumerate(cloth_modules.MODULES)]}
        for variant, count, ms in (("serial", 1, 40.0), *(("openmp", t, 20.0 / t) for t in threads))
    ]
    with_costs["face_modules"] = [
        {"scene": "face_381k", "variant": variant, "form": face_modules.FORM, "threads": count, "tetrahedra": 1000}
        | {"steps": 2, "iterations": 40}
        | {"modules": [{"module": module, "ms": ms + k} for k, module in enumerate(face_modules.MODULES)]}
        for variant, count, ms in (("serial", 1, 40.0), *(("openmp", t, 20.0 / t) for t in threads))
    ]
    with_costs["production_modules"] = [
        {"scene": "drop_128", "variant": variant, "form": production_modules.FORM, "threads": count, "cells": 1000}
        | {"particles": 50, "substeps": 3, "iterations": 40}
        | {"modules": [{"module": module, "ms": ms + k} for k, module in enumerate(production_modules.MODULES)]}
        for variant, count, ms in (("serial", 1, 40.0), *(("openmp", t, 20.0 / t) for t in threads))
    ]
    with_costs["sensitivity"] = [
        {"kernel": kernel, "form": "f", "scene": "s", "cores": cores}
        | {
            "replays": [
                modelled(64, 64.0 / cores + (barriers * slow if cores > 1 else 0), 1.0)
                | {"barriers": barriers, "memory_gb_per_s": memory}
                for memory in (40.0, 307.2)
                for barriers in (0.5, 1, 2)
            ]
        }
        for kernel, slow in (("fluid/step", 1.0), ("cloth/step", 3.0))
        for cores in (1, 64)
    ]
    with_costs["problem_sizes"] = [
        {"kernel": kernel, "form": "f", "scene": f"s{size:.0f}", "items": size, "unit": "things", "cores": cores}
        | modelled(cores, 10.0 if cores == 1 else 10.0 / (64 * in_use), 1.0)
        for kernel, uses in (("fluid/step", (0.1, 0.25, 1.0)), ("cloth/relax", (0.1, 0.2, 0.4)))
        for size, in_use in zip((100.0, 1000.0, 16000.0), uses)
        for cores in (1, 64)
    ]
    costs = {"costs": {"lock_moved_ns": 6.2, "memory_gb_per_s": 40.0}}
    peaks = {"peaks": [{"threads": t, "triad_gb_per_s": 20.0 * t, "fma_gflop_per_s": 100.0 * t} for t in threads]}
    found = {"bench": {"quick": False, "machine": MACHINE | peaks, "rows": bench}}
    return found | {
        name: {"quick": False, "machine": MACHINE | costs, "rows": rows} for name, rows in with_costs.items()
    }


def write(reports_, folder):
    for name, report in reports_.items():
        (folder / f"{name}.json").write_text(json.dumps(report))


def run_draw(folder, *figure):
    return subprocess.run([sys.executable, FOLDER / "draw.py", folder, *figure], capture_output=True, text=True)


def rows_in(folder, name):
    with open(folder / f"{name}.csv", newline="") as lines:
        return list(csv.DictReader(lines))


@contextlib.contextmanager
def drawn(reports_, *figure):
    """A folder with the figures of these reports."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        write(reports_, folder)
        with contextlib.redirect_stdout(io.StringIO()):
            draw.main(folder, *figure)
        yield folder


class Figures(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        kept = tempfile.TemporaryDirectory()
        cls.addClassCleanup(kept.cleanup)
        cls.folder = pathlib.Path(kept.name)
        cls.reports = reports()
        write(cls.reports, cls.folder)
        data = source.load(cls.folder, cls.reports)
        cls.tables = {name: figure.table(data) for name, figure in draw.chosen().items()}
        with contextlib.redirect_stdout(io.StringIO()):
            draw.main(cls.folder)
        cls.index = (cls.folder / "index.html").read_text()

    def rows(self, name):
        return rows_in(self.folder, name)

    def row(self, name, **wanted):
        found = [r for r in self.rows(name) if all(r[column] == str(value) for column, value in wanted.items())]
        self.assertEqual(len(found), 1, wanted)
        return found[0]

    def referred(self, reference):
        """The target of a reference: a row of a report, or a place in it."""
        name, place = reference.split(".json#")
        if place.isdigit():
            return self.reports[name]["rows"][int(place)]
        found = self.reports[name]
        for step in place.split("/"):
            found = found[int(step)] if step.isdigit() else found[step]
        return found

    def test_every_figure_stands_in_the_index_and_beside_it(self):
        modules = {path.stem for path in FOLDER.glob("*.py") if "\nPAPER_FIGURE = " in path.read_text()}
        self.assertEqual(modules, {*draw.FIGURES, *draw.OPTIONAL})
        modules = set(draw.FIGURES)  # the others have no report here: tests/peers_test.py
        for name in modules:
            self.assertIn(f"<section id='{name}'>", self.index)
            self.assertIn(f"<a href='#{name}'>", self.index)
            self.assertTrue((self.folder / f"{name}.svg").read_text().rstrip().endswith("</svg>"))
        self.assertEqual(self.index.count("<svg "), len(modules))

    def test_words_in_pictures_are_text(self):
        words_of = {"scalability": "sweep and prune", "cloth_convergence": "rms strain", "modules": "Box-box"}
        for name, words in words_of.items():
            self.assertIn(f">{words}</text>", self.section(self.index, name))

    def section(self, index, name):
        return index[index.index(f"<section id='{name}'>") :].split("</section>")[0]

    def test_no_two_things_have_one_id(self):
        ids = re.findall(r"""\bid=["']([^"']+)""", self.index)
        self.assertGreater(len(ids), 100)
        self.assertEqual(len(ids), len(set(ids)))
        for used in re.findall(r"""href=["']#([^"']+)|url\(#([^)]+)""", self.index):
            self.assertTrue(set(used) & set(ids), used)

    def test_the_index_needs_no_other_file_or_network(self):
        own = re.sub(r"xmlns(:xlink)?=.http[^ >]*", "", self.index)
        for word in ("<script", "<link", "http", "@import", "<img"):
            self.assertFalse(word in own, word)
        self.assertEqual(set(re.findall(r"url\((.)", own)), {"#"})

    def test_links_lead_somewhere(self):
        for target in set(re.findall("href='([^'#]+)'", self.index)):
            self.assertTrue((self.folder.resolve() / target).exists(), target)
        notes = [note for name in draw.FIGURES for note in draw.chosen(name)[name].NOTES]
        for note in notes:
            self.assertIn(f"/{note}.md'>", self.index)

    def test_machine_and_commit_are_said_once_and_in_the_table_of_the_machine(self):
        for fact in (MACHINE["cpu"], MACHINE["commit"], MACHINE["date"]):
            self.assertEqual(self.index.count(fact), 2, fact)
        other = copy.deepcopy(self.reports)
        other["levelset_slice"]["machine"] = MACHINE | {"commit": "def5678"}
        self.assertIn("commit abc1234, def5678", draw.stamp(other, other))
        for name, commit in {"levelset_slice": "def5678", "sph_locks": "abc1234"}.items():
            section = draw.section(other, name, draw.chosen(name)[name], self.tables[name], "<svg></svg>", "notes")
            self.assertIn(f"commit {commit}.", section)

    def test_claims_come_first_and_name_their_rows(self):
        self.assertLess(self.index.index("<section id='claims'>"), self.index.index("<section id='short'>"))
        rows = self.rows("claims")
        for row in rows:
            self.assertIn(row["verdict"], (judge.EXCEEDED, judge.REPRODUCED, judge.NOT))
            for reference in row["from"].split(","):
                self.assertIsInstance(self.referred(reference), dict, row)
        section = self.section(self.index, "claims")
        for claim in {row["claim"] for row in rows}:
            self.assertEqual(section.count(f"<td>{html.escape(claim)}</td>"), 1)
        for name in {row["figure"] for row in rows}:
            self.assertIn(f"<a href='#{name}'>figure</a>, <a href='{name}.csv'>{name}.csv</a>", section)
            self.assertIn(f"<code>make figures FIGURE={name}</code>", section)

    def claimed(self, figure, words, of=""):
        found = [r for r in self.rows("claims") if r["figure"] == figure and words in r["claim"] and of in r["of"]]
        self.assertEqual(len(found), 1, (figure, words, of))
        return float(found[0]["found"]), found[0]["verdict"]

    def test_claims_are_judged_by_the_numbers_of_the_reports(self):
        self.assertEqual(self.claimed("contact_batches", "Reordered", "over serial"), (120 / (20 / 64), "exceeded"))
        sweeping = self.claimed("fsm_over_fmm", "sweeping 55 times", "serial form")
        self.assertEqual(sweeping, (100 / (100 / 8), "not reproduced"))
        self.assertEqual(self.claimed("fsm_over_fmm", "Serially"), (100 / 300, "exceeded"))
        self.assertEqual(self.claimed("cloth_convergence", "twice the iterations", "rope"), (2.5, "not reproduced"))
        locks = [r["locks"] for r in self.reports["curves"]["rows"] if r["form"] == "sub_grid" and r["cores"] == 64]
        self.assertEqual(self.claimed("sph_locks", "almost nothing"), (100 * locks[0], "not reproduced"))
        serial = [r for r in self.reports["face_modules"]["rows"] if r["variant"] == "serial"]
        time = self.row("frame_times", application="production face", variant="serial")["ms"]
        self.assertEqual(time, str(sum(m["ms"] for m in serial[0]["modules"])))

    def test_verdicts(self):
        for judged, low, met, beyond in (
            (judge.at_least(35), 34.9, 35, 39),
            (judge.at_most(1.3), 1.31, 1.3, 1.1),
            (judge.between(36, 61), 35, 50, 68),
        ):
            self.assertEqual([judged(x) for x in (low, met, beyond)], [judge.NOT, judge.REPRODUCED, judge.EXCEEDED])
        self.assertEqual([judge.within(2)(x) for x in (1, 2, 2.1)], [judge.REPRODUCED, judge.REPRODUCED, judge.NOT])
        self.assertEqual([judge.more_than(1)(x) for x in (1, 9)], [judge.NOT, judge.REPRODUCED])
        of = lambda *verdicts: judge.verdict_of([{"verdict": v} for v in verdicts])
        self.assertEqual(of(judge.NOT, judge.NOT), judge.NOT)
        self.assertEqual(of(judge.NOT, judge.EXCEEDED), "in part: 1 of 2")
        self.assertEqual(of(judge.REPRODUCED, judge.EXCEEDED), "reproduced or exceeded")

    def test_numbers_of_the_roofline_stand_apart(self):
        # A hundred kernels, most of them within a third of a decade of each other, and one that hardly computes.
        crowded = reports()
        bench = crowded["bench"]
        bench["rows"] = [
            {"kernel": f"fluid/k{k}", "form": "", "scene": "s", "variant": variant, "threads": threads}
            | {"ms": ms * (1 + 0.9 * math.sin(k)), "spread": 0.1, "bytes": 1e6, "whole_cores": True}
            | {"flops": 1e6 * (1 + 0.5 * math.cos(7 * k)) * (50 if k % 10 == 0 else 1) * (1e-6 if k == 100 else 1)}
            | {"from": f"bench.json#{k}"}
            for k in range(101)
            for variant, threads, ms in (("serial", 1, 80.0), ("openmp", 1, 10.0), ("openmp", 2, 5.0))
        ]
        for k, peak in enumerate(bench["machine"]["peaks"]):
            peak["from"] = f"bench.json#machine/peaks/{k}"
        rows = roofline.table(crowded)
        figure = roofline.draw(rows)
        self.assertEqual(roofline.below(rows), [101])
        for axis, threads in zip(figure.axes, (1, 2)):
            texts = [text for text in axis.texts if text.get_text().isdigit()]
            self.assertEqual(len(texts), 100)
            boxes = [text.get_window_extent() for text in texts]
            for a, b in itertools.combinations(boxes, 2):
                self.assertFalse(a.x0 < b.x1 and b.x0 < a.x1 and a.y0 < b.y1 and b.y0 < a.y1, (a, b))
            own = roofline.points(rows, "openmp", threads)
            for x, y in axis.transData.transform([(r["flops_per_byte"], r["gflop_per_s"]) for r in own]):
                self.assertFalse(any(box.contains(x, y) for box in boxes))
        roofline.style.svg_of(figure)

    def test_every_row_of_every_csv_names_rows_of_reports(self):
        for name in draw.FIGURES:
            rows = self.rows(name)
            self.assertTrue(rows, name)
            for row in rows:
                for reference in row["from"].split(","):
                    self.assertIsInstance(self.referred(reference), dict, f"{name}: {row}")

    def test_validation_repeats_what_its_rows_say(self):
        rows = self.rows("model_validation")
        self.assertEqual(len(rows), 2 * (len(KERNELS) + len(MODULES)))
        for row in rows:
            source = self.referred(row["from"])
            for column in ("kernel", "form", "scene", "cores", "measured_ms", "modelled_ms", "off_by"):
                self.assertEqual(row[column], str(source[column]))
            if row["cores"] == "2":
                self.assertIn(f"<td>{row['from']}</td>", self.index)

    def test_validation_counts_what_is_within_the_band(self):
        # Of kernel k, at 2 threads, modelled is (10 + k) / 2 and measured 5.5: off by (k - 1) / 11. Kernels 0, 1 and 2
        # are within 10 %. Modules of production applications, 4 and 4.5, are off by 11 %.
        self.assertIn(f"3 of {len(KERNELS) + len(MODULES)} within 10\N{NO-BREAK SPACE}%", self.index)

    def test_batches_over_serial(self):
        row = self.row("contact_batches", form="batches", kind="modelled", cores=64)
        self.assertAlmostEqual(float(row["over_serial"]), 120 / (20 / 64))
        self.assertAlmostEqual(float(row["over_one_core"]), 64)
        row = self.row("contact_batches", form="original", kind="measured", cores=2)
        self.assertAlmostEqual(float(row["over_serial"]), 120 / 15.5)
        self.assertAlmostEqual(float(row["over_one_core"]), 30.5 / 15.5)

    def test_gains_of_a_module(self):
        k = KERNELS.index(("rigid/gjk", "cold", "hull_pit_2000"))
        row = self.row("modules", kernel="rigid/gjk")
        self.assertAlmostEqual(float(row["simd_gain"]), (80 + k) / (10 + k))
        self.assertAlmostEqual(float(row["simd_gain_over_twin"]), (90 + k) / (10 + k))
        self.assertAlmostEqual(float(row["threads_measured"]), (10 + k) / (5.5 + k))
        self.assertAlmostEqual(float(row["threads_modelled"]), 64)

    def test_gains_of_a_module_without_memory(self):
        row = self.row("production_modules", module="pressure_solve")
        self.assertAlmostEqual(float(row["modelled_speed_up"]), 64)
        self.assertAlmostEqual(float(row["cores_speed_up"]), 64 * 8 / 6)
        self.assertIn("1/85.3", self.index)  # of the whole frame

    def test_blocks_are_the_best_at_each_number_of_cores(self):
        row = self.row("fsm_over_fmm", algorithm="fast_sweeping", kind="modelled", cores=64)
        self.assertEqual(row["blocks"], "8")
        self.assertAlmostEqual(float(row["over_serial_marching"]), 300 / (100 / 8))
        self.assertAlmostEqual(float(row["over_own_serial"]), 8)
        self.assertAlmostEqual(float(row["marching_over_sweeping"]), 3)

    def test_iterations_to_the_same_residual(self):
        # Residuals fall as 1 / n: colours at 20 leave 2.5 / 20, which the original order reaches after 8.
        row = self.row("cloth_convergence", scene="rope", form="colours", iterations=20)
        self.assertAlmostEqual(float(row["original_needs"]), 8)
        self.assertAlmostEqual(float(row["times_the_original"]), 2.5)
        self.assertEqual(row["at_least"], "False")
        # At 5 they leave more than the original order at its first point, 5: it may need fewer.
        row = self.row("cloth_convergence", scene="rope", form="colours", iterations=5)
        self.assertEqual((float(row["times_the_original"]), row["at_least"]), (1, "True"))
        # Chains at 80 are below the whole curve of the original order.
        self.assertEqual(
            self.row("cloth_convergence", scene="rope", form="chains", iterations=80)["times_the_original"], ""
        )

    def test_problem_sizes_say_from_where_on_half_of_the_cores_are_in_use(self):
        row = self.row("problem_sizes", kernel="fluid/step", scene="s1000")
        self.assertAlmostEqual(float(row["in_use"]), 0.25)
        self.assertAlmostEqual(float(row["speed_up"]), 16)
        sizes = {name: problem_sizes.half_used_from(rows) for name, rows in self.sizes().items()}
        self.assertAlmostEqual(sizes["fluid/step f"], 4000)  # halfway between .25 and 1, and between 1,000 and 16,000
        self.assertIsNone(sizes["cloth/relax f"])
        self.assertIn("fluid/step f: from 4,000 things", self.section(self.index, "problem_sizes"))
        self.assertIn("cloth/relax f: not by 16,000 things (40", self.section(self.index, "problem_sizes"))

    def test_every_kernel_gains_by_lanes_times_threads(self):
        # Row 0 of KERNELS: 80 ms serial, 10 ms on one thread, 10 / 64 ms on 64 modelled cores.
        row = self.row("every_kernel", kernel="rigid/step", form="batches")
        self.assertAlmostEqual(float(row["lanes"]), 8)
        self.assertAlmostEqual(float(row["threads"]), 64)
        self.assertAlmostEqual(float(row["both"]), 512)
        drawn_ = every_kernel.fastest(self.tables["every_kernel"])
        self.assertEqual(len(drawn_), len({kernel for kernel, *_ in KERNELS}))
        self.assertEqual(len(self.rows("every_kernel")), len(KERNELS))
        self.assertIn("36x to 61x", self.section(self.index, "every_kernel"))

    def sizes(self):
        return problem_sizes.kernels(self.tables["problem_sizes"])

    def test_sensitivity_compares_the_same_records(self):
        # 64 ms on one core; on 64 cores 1 ms and barriers, of 1 ms as they are.
        for barriers, speed_up in ((0.5, 64 / 1.5), (1, 64 / 2), (2, 64 / 3)):
            for memory in ("here", "server"):
                row = self.row("sensitivity", kernel="fluid/step", barriers=barriers, memory=memory)
                self.assertAlmostEqual(float(row["speed_up"]), speed_up)
        self.assertIn("cloth/step (f, s): 25.6x, 16.0x, 9.1x;", self.index)

    def test_kernels_without_flops_are_named(self):
        self.assertIn("left out: rigid/match_contacts.", self.index)

    def test_measured_points_reach_as_far_as_the_machine(self):
        for threads in ((1, 2, 4, 8, 16, 32, 64), (1,)):
            most = threads[-1]
            words = f"{most} thread" + ("s" if most > 1 else "")
            with drawn(reports(threads)) as folder:
                index = (folder / "index.html").read_text()
                self.assertIn(f"<b>The model at {words}:</b>", index)
                for name in ("scalability", "sph_locks"):
                    measured = {r["cores"] for r in rows_in(folder, name) if r["kind"] == "measured"}
                    self.assertEqual(measured, {str(t) for t in threads}, name)
                self.assertEqual({r["threads"] for r in rows_in(folder, "modules")}, {str(most)})
                self.assertEqual({r["threads"] for r in rows_in(folder, "frame_times")}, {"1", str(most)})
                self.assertEqual({r["cores"] for r in rows_in(folder, "model_validation")}, {str(t) for t in threads})
                for beginning in (
                    f"{words}: rigid body step ",
                    f"{words}: owner_gather ",
                    f"{words} over serial: ",
                    f"{words}: marching ",
                ):
                    self.assertIn(f"<td>{beginning}", index)
                self.assertRegex(index, f"{words} [0-9.]+ GFLOP/s")  # of the roofline
                self.assertNotIn("<td>2 threads", index)

    def test_rough_runs_say_so_everywhere(self):
        self.assertNotIn("QUICK", self.index)
        rough = {name: report | {"quick": True} for name, report in self.reports.items()}
        with drawn(rough) as folder:
            index = (folder / "index.html").read_text()
            for part in index.split("<section ")[:-1]:  # the page's head, and each figure; the machine comes last
                self.assertTrue("QUICK run, rough numbers" in part, part[:100])
        one = self.reports | {"scale": rough["scale"]}
        self.assertIn(": scale.json.", draw.rough(one, ["bench", "scale"]))
        self.assertEqual(draw.rough(one, ["bench"]), "")

    def test_what_never_had_whole_cores_is_hollow_and_grey(self):
        disturbed = copy.deepcopy(reports())
        for r in disturbed["bench"]["rows"]:
            if r["kernel"] in ("fluid/step", "rigid/box_box") and r["variant"] == "openmp" and r["threads"] == 2:
                r |= {"whole_cores": False, "spread": None}
        scaled = {"scale": "fluid/step", "curves": "fluid/step"}
        for name, kernel in (scaled | {"contact_batches": None, "levelset_blocks": None}).items():
            for r in disturbed[name]["rows"]:
                if r.get("cores") == 2 and r.get("kernel") == kernel:
                    r["whole_cores"] = False
        with drawn(disturbed) as folder:
            index = (folder / "index.html").read_text()
            for name, count in {
                "scalability": 1,
                "sph_locks": 4,
                "frame_times": 1,
                "modules": 1,
                "roofline": 5,
                "contact_batches": 4,  # forms
                "fsm_over_fmm": 2,  # algorithms
                "model_validation": 4,  # forms of fluid/step
            }.items():
                section = self.section(index, name)
                self.assertIn(f"Hollow grey: {count} of the measured values", section)
                flagged = [r for r in rows_in(folder, name) if r["whole_cores"] == "False"]
                self.assertEqual(len(flagged), count, name)

                def greys(of):
                    return len(re.findall("stroke: #999999", (of / f"{name}.svg").read_text()))

                self.assertGreater(greys(folder), greys(self.folder), name)
        self.assertNotIn("Hollow grey", self.index)

    def test_one_figure_needs_its_own_reports_alone(self):
        only = {name: copy.deepcopy(self.reports[name]) for name in ("bench", "curves")}
        for report in only.values():
            report["rows"] = [r for r in report["rows"] if r["kernel"] == "fluid/step"]
        with drawn(only, "sph_locks") as folder:
            self.assertEqual({path.suffix for path in folder.iterdir()}, {".json", ".csv", ".svg", ".html"})
            index = (folder / "index.html").read_text()
            self.assertEqual(index.count("<section "), 4)  # claims, the table, the figure and the machine
        self.assertEqual(run_draw(self.folder, "sph_lock").returncode, 2)

    def test_each_figure_asks_for_what_it_draws(self):
        for name, module in draw.chosen().items():
            needs = measure.needed({name: module})
            behind = {reference.split(".json#")[0] for row in self.rows(name) for reference in row["from"].split(",")}
            self.assertLessEqual(behind, set(needs), name)
            kernels = {row["kernel"] for row in self.rows(name) if row.get("kernel")}
            for report in ("bench", "scale"):
                if report in behind and needs[report] is not None:
                    self.assertEqual(kernels, set(needs[report]), name)
        together = measure.needed(draw.chosen())
        self.assertEqual(set(together), set(self.reports))
        self.assertIsNone(together["bench"])  # the roofline shows every kernel
        quick = measure.needed(draw.chosen(), quick=True)
        self.assertEqual(set(quick), set(together))
        self.assertLess({"fluid/step", "rigid/gjk"}, set(quick["bench"]))
        self.assertIsNone(measure.needed(draw.chosen("roofline"), quick=True)["bench"])

        options = argparse.Namespace(threads="1,2", shard="2/3", quick=False, full=False, resume=True)

        def command(*chosen):
            figures = {name: draw.chosen(name)[name] for name in chosen}
            return [
                str(word)
                for word in measure.command("lockstep", pathlib.Path("f"), measure.needed(figures), options)
            ]

        figures = ["lockstep", "figures", "--report"]
        options_ = ["--threads", "1,2", "--brief", "--resume", "--shard", "2/3", "--out", "f"]
        fluid = ["--kernel", "fluid/step"]
        self.assertEqual(command("sph_locks"), [*figures, "bench,curves", *fluid, *options_])
        # The validation shows every kernel, so `bench` has them too.
        self.assertEqual(command("sph_locks", "model_validation"), [*figures, "bench,curves,scale", *options_])
        options.full = True
        self.assertIn("--full", command("production_modules"))

    def test_kernels_and_forms_are_those_of_the_program(self):
        program = ROOT / os.environ.get("LOCKSTEP", "build/lockstep")
        listed = subprocess.run([program, "list", "--json"], capture_output=True, check=True, cwd=ROOT).stdout
        known = {(row["kernel"], row["form"]) for row in json.loads(listed)["rows"]}
        drawn_ = {(kernel, form) for _, kernel, form, *_ in scalability.WORKLOADS}
        self.assertLessEqual({kernel for kernel, _ in every_kernel.PAPER_AT_64}, {kernel for kernel, _ in known})
        drawn_ |= {(kernel, form) for *_, kernel, form, _ in modules.MODULES}
        for domain in ("fluid", "face", "cloth"):
            figure = importlib.import_module("production_modules" if domain == "fluid" else f"{domain}_modules")
            kernels = module_times.kernels_of(f"production_{domain}", figure.MODULES, getattr(figure, "KERNELS", {}))
            drawn_ |= {(kernel, figure.MODULES[module]) for module, kernel in kernels.items()}
        self.assertEqual(drawn_ - known, set())

    def test_what_is_missing_is_told_in_a_line(self):
        def refused(wrong, expected):
            with tempfile.TemporaryDirectory() as name:
                folder = pathlib.Path(name)
                write(wrong, folder)
                result = run_draw(folder)
                self.assertEqual(result.returncode, 2, result.stderr)
                self.assertRegex(result.stderr, expected)
                self.assertEqual(len(result.stderr.splitlines()), 1)
                self.assertFalse((folder / "index.html").exists())

        refused(
            {name: report for name, report in self.reports.items() if name != "scale"}, "scale.json: cannot be read"
        )
        bench = self.reports["bench"]
        fewer = bench | {"rows": [r for r in bench["rows"] if r["kernel"] != "rigid/box_box"]}
        refused(self.reports | {"bench": fewer}, "bench.json: no row with kernel 'rigid/box_box'")


if __name__ == "__main__":
    unittest.main()
