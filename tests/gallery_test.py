"""Makes the gallery of a few frames of two scenes: xvfb-run /usr/bin/python3 tests/gallery_test.py

The environment variable LOCKSTEP names the program (default build/lockstep).
"""

import contextlib
import io
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
VIEWS = ROOT / "notes" / "views"
sys.path.insert(0, str(VIEWS))
import gallery  # noqa: E402, from the folder above
from PIL import Image  # noqa: E402

PROGRAM = (ROOT / os.environ.get("LOCKSTEP", "build/lockstep")).resolve()
THREE = pathlib.Path("/usr/share/javascript/three")
FEW = {"sheet_over_box_and_capsule": 2, "mesh_96": 1}


class Scenes(unittest.TestCase):
    def test_a_dozen_of_every_domain_that_has_frames(self):
        listed = json.loads(subprocess.run([PROGRAM, "list", "--json"], capture_output=True, check=True).stdout)
        domains = {domain["name"] for domain in listed["domains"] if domain["runs"]}
        self.assertGreaterEqual(len(gallery.SCENES), 12)
        self.assertEqual({gallery.file_of(scene).parent.name for scene in gallery.SCENES}, domains)

    def test_each_says_in_a_line_what_it_shows(self):
        for scene in gallery.SCENES:
            words = gallery.first_sentence(gallery.file_of(scene))
            self.assertTrue(words.endswith(".") and 20 < len(words) < 200, words)


@unittest.skipUnless(THREE.exists(), "libjs-three is not installed: no view can be made")
class Gallery(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        kept = tempfile.TemporaryDirectory()
        cls.addClassCleanup(kept.cleanup)
        cls.folder = pathlib.Path(kept.name)
        all_scenes = gallery.SCENES
        gallery.SCENES = {scene: (frames, all_scenes[scene][1]) for scene, frames in FEW.items()}
        with contextlib.redirect_stdout(io.StringIO()):
            gallery.main(PROGRAM, cls.folder)
        gallery.SCENES = all_scenes
        cls.index = (cls.folder / "index.html").read_text("utf-8")

    def test_links_lead_to_files_beside_it(self):
        targets = set(re.findall("(?:href|src)='([^']+)'", self.index))
        self.assertEqual(targets, {f"{scene}.{kind}" for scene in FEW for kind in ("html", "png")})
        self.assertEqual({path.name for path in self.folder.iterdir()}, targets | {"index.html"})

    def test_it_needs_no_network(self):
        for word in ("http", "<script", "<link", "@import", "url("):
            self.assertNotIn(word, self.index)

    def test_each_scene_has_its_words_command_and_verdict(self):
        for scene, frames in FEW.items():
            card = self.index[self.index.index(f"<article id='{scene}'>") :].split("</article>")[0]
            self.assertIn(f"<code>make view SCENE={scene} FRAMES={frames}</code>", card)
            self.assertIn(gallery.first_sentence(gallery.file_of(scene)), card)
            self.assertIn("bitwise", card)

    def test_stills_show_something(self):
        for scene in FEW:
            pixels = np.asarray(Image.open(self.folder / f"{scene}.png").convert("RGB")).astype(int)
            self.assertEqual(pixels.shape, (400, 600, 3))
            self.assertGreater((abs(pixels - pixels[0, 0]).sum(axis=2) > 30).mean(), 0.05, scene)


if __name__ == "__main__":
    unittest.main()
