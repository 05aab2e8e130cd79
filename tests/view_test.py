"""Makes views of small scenes and opens them in headless Chromium: /usr/bin/python3 tests/view_test.py

The environment variable LOCKSTEP names the program (default build/lockstep). Without Chromium, which `make deps` does
not install, the pages are made and what is in them is tested, and nothing is opened.
"""

import base64
import html
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import zlib

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
VIEWS = ROOT / "notes" / "views"
sys.path.insert(0, str(VIEWS))
import pack  # noqa: E402, from the folder above
import view  # noqa: E402
from PIL import Image  # noqa: E402

PROGRAM = (ROOT / os.environ.get("LOCKSTEP", "build/lockstep")).resolve()
CHROMIUM = shutil.which("chromium")
OPEN = [CHROMIUM, "--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader"]
OPEN += ["--enable-unsafe-swiftshader", "--hide-scrollbars", "--window-size=900,800"]

in_a_browser = unittest.skipUnless(CHROMIUM, "chromium is not installed: no view is opened")

# Scene, frames and more for view.py: one of each kind of picture, and one run alone.
PAGES = {
    "points": ("lattice_5k", 40, "--form", "pair_lists"),
    "bodies": ("assorted", 40),
    "mesh": ("flag_33", 12),
    "flesh": ("bar_pulls", 3),
    "surface": ("spheres_and_box_64", 1),
    "liquid": ("jet_24", 2),
    "alone": ("dam_break_5k", 4, "--variant", "openmp"),
}


def unpacked(page, name):
    """The bytes of a block of a page."""
    return zlib.decompress(base64.b64decode(re.search(f'id="{name}">([^<]*)<', page)[1]))


class Packing(unittest.TestCase):
    def steps_of(self, text, shape, before=None):
        """What data.js does, in numpy."""
        data = zlib.decompress(base64.b64decode(text))
        low, high = np.frombuffer(data, np.uint8).reshape(2, -1).astype(np.int32)
        folded = low | high << 8
        change = ((folded >> 1) ^ -(folded & 1)).reshape(shape)
        found = change + before if before is not None else change.cumsum(axis=0)
        return found & pack.STEPS

    def test_numbers_come_back_to_half_a_step(self):
        values = np.random.default_rng(1).uniform(-3, 5, (70, 11, 3)).astype(np.float32)
        other = values + np.float32(1e-4)
        low, high = np.full(3, -3.0), np.full(3, 5.01)
        for k, (own, apart) in enumerate(
            zip(pack.blocks(values, low, high), pack.blocks(other, low, high, values))
        ):
            part = values[32 * k : 32 * k + 32].transpose(0, 2, 1)
            steps = self.steps_of(own, part.shape)
            half = 0.5 * 8.01 / pack.STEPS + 1e-6
            self.assertLessEqual(abs(-3 + steps * 8.01 / pack.STEPS - part).max(), half)
            moved = self.steps_of(apart, part.shape, steps)
            self.assertLessEqual(abs(-3 + moved * 8.01 / pack.STEPS - part - 1e-4).max(), half)

    def test_a_quaternion_and_its_opposite_are_one_orientation(self):
        poses = np.zeros((3, 2, 7), np.float32)
        poses[:, :, 3] = [[1, 1], [-1, 1], [-1, -1]]
        self.assertTrue((pack.in_order(poses)[:, :, 3] == 1).all())

    def test_distances_have_codes_by_their_logarithm(self):
        codes = pack.code_of(np.array([0, 1e-12, 1e-4, 1, 9.0]), 1)
        self.assertEqual(codes.tolist(), [0, 1, 128, 255, 255])


@unittest.skipUnless(view.THREE.exists(), "libjs-three is not installed: no view can be made")
class Views(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        kept = tempfile.TemporaryDirectory()
        cls.addClassCleanup(kept.cleanup)
        cls.folder = pathlib.Path(kept.name)
        cls.pages, cls.data = {}, {}
        for kind, (scene, frames, *more) in PAGES.items():
            path = cls.folder / f"{kind}.html"
            command = [sys.executable, "-B", VIEWS / "view.py", PROGRAM, scene, path, "--frames", str(frames), *more]
            done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
            assert done.returncode == 0, done.stderr
            cls.pages[kind] = path.read_text("utf-8")
            cls.data[kind] = json.loads(re.search('id="data">(.*?)</script>', cls.pages[kind])[1])

    def test_pages_need_no_other_file_or_network(self):
        for kind, page in self.pages.items():
            for word in ("<link", " src=", "@import", "import("):
                own = page.replace((view.THREE / "three.min.js").read_text("utf-8"), "")
                self.assertNotIn(word, own, kind)

    def test_nothing_is_left_beside_the_pages(self):
        self.assertEqual({path.name for path in self.folder.iterdir()}, {f"{kind}.html" for kind in PAGES})

    def test_runs_with_the_same_bits_are_stored_once(self):
        for kind, data in self.data.items():
            self.assertEqual(data["same"], kind not in ("points", "alone"), kind)
            self.assertEqual('id="run1-0"' in self.pages[kind], kind == "points")
            self.assertEqual(data["frames"], PAGES[kind][1] + 1)
            if data["same"]:
                self.assertEqual({row["most"] for row in data["rows"]}, {0.0})
                self.assertIn("bitwise", data["verdict"])

    def test_one_run_alone_has_nothing_to_compare(self):
        data = self.data["alone"]
        self.assertEqual((len(data["runs"]), data["rows"], data["verdict"]), (1, [], ""))

    def test_lockstep_run_writes_the_same_page(self):
        path = self.folder.parent / f"{self.folder.name}.html"
        self.addCleanup(path.unlink)
        scene, frames, *more = PAGES["alone"]
        command = [PROGRAM, "run", "--scene", scene, "--frames", str(frames), *more, "--out", path]
        done = subprocess.run(command, check=True, capture_output=True, text=True, cwd=self.folder)  # any folder does
        self.assertIn(f"{frames + 1} frames of {scene}", done.stdout)
        self.assertTrue(path.read_text("utf-8") == self.pages["alone"])

    def test_distances_are_those_of_verify(self):
        # A lattice is compared from its first frame, so verify's runs are the page's.
        report = self.folder.parent / f"{self.folder.name}.json"
        self.addCleanup(report.unlink)
        command = [PROGRAM, "verify", "--kernel", "fluid/step", "--form", "pair_lists", "--scene", "lattice_5k"]
        subprocess.run([*command, "--threads", "2", "--json", report], check=True, capture_output=True)
        course = json.loads(report.read_text())["rows"][0]["courses"][0]
        self.assertEqual((course["what"], course["from"]), ("rms distance of positions", 0))
        rows, lines = self.data["points"]["rows"], self.data["points"]["curves"][0]["lines"]
        self.assertEqual(rows[0]["most"], 0)
        self.assertGreater(len(course["found"]), 10)
        np.testing.assert_allclose([row["rms"] for row in rows[1:]], course["found"][: len(rows) - 1], rtol=1e-9)
        self.assertEqual([line["values"] for line in lines[2:]], [course["found"], course["bound"]])

    def opened(self, kind, words, *more):
        """What the page says of itself, after eight seconds of its own time."""
        address = (self.folder / f"{kind}.html").as_uri() + "#" + words
        command = [*OPEN, *more, "--virtual-time-budget=8000", "--dump-dom", address]
        done = subprocess.run(command, capture_output=True, text=True, timeout=120)
        body = re.search(r"<body([^>]*)>", done.stdout)[1]
        return {name: html.unescape(value) for name, value in re.findall(r'data-([a-z-]+)="([^"]*)"', body)}

    def picture(self, kind, words):
        path = self.folder.parent / f"{self.folder.name}.png"
        address = (self.folder / f"{kind}.html").as_uri() + "#" + words
        command = [*OPEN, "--virtual-time-budget=8000", f"--screenshot={path}", address]
        subprocess.run(command, check=True, capture_output=True, timeout=120)
        pixels = np.asarray(Image.open(path).convert("RGB")).astype(int)
        path.unlink()
        return pixels[120:460, 20:860]  # of the stage

    @in_a_browser
    def test_every_kind_loads_and_shows_the_frame_of_its_address(self):
        for kind, (_, frames, *_) in PAGES.items():
            said = self.opened(kind, f"frame={frames}&mode=over&slice&mark")
            self.assertNotIn("error", said, kind)
            self.assertEqual((said.get("state"), said["frame"]), ("ready", str(frames)), kind)

    @in_a_browser
    def test_it_plays_to_the_end(self):
        said = self.opened("bodies", "play")
        self.assertNotIn("error", said)
        self.assertEqual(said["frame"], "40")
        self.assertGreater(int(said["drawn"]), 5)

    @in_a_browser
    def test_the_distance_shown_is_that_of_the_frames(self):
        for frame in (1, 40):
            said, row = self.opened("points", f"frame={frame}"), self.data["points"]["rows"][frame]
            self.assertEqual((float(said["most"]), float(said["rms"])), (row["most"], row["rms"]))

    @in_a_browser
    def test_pictures_are_not_empty_and_change(self):
        for kind in ("points", "bodies", "mesh"):
            first, last = self.picture(kind, "frame=0"), self.picture(kind, f"frame={PAGES[kind][1]}")
            background = first[2, 420]
            self.assertGreater((abs(first - background).sum(axis=2) > 30).mean(), 0.01, kind)
            self.assertGreater((abs(first - last).sum(axis=2) > 30).mean(), 0.001, kind)

    @in_a_browser
    def test_it_says_that_there_is_no_webgl(self):
        said = self.opened("bodies", "", "--disable-3d-apis")
        self.assertIn("no WebGL", said["error"])


if __name__ == "__main__":
    unittest.main()
