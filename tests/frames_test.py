"""Reads frames with Debian's VTK, and types README's Python: /usr/bin/python3 tests/frames_test.py

The environment variable LOCKSTEP names the program (default build/lockstep).
"""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "notes" / "pictures"))
from render import read  # noqa: E402, from the folder above

PROGRAM = (ROOT / os.environ.get("LOCKSTEP", "build/lockstep")).resolve()

# A box falls beside two balls at rest on a static box; a body of two parts turns.
RIGID = """
kind = "rigid"
frames = 1
time_step = 0.01
[[body]]
plane = [0, 1, 0]
[[body]]
box = [2, 0.5, 2]
position = [0, 0.5, 0]
[[body]]
box = [0.1, 0.2, 0.3]
position = [5, 8, 0]
orientation = [0, 0.6, 0, 0.8]
velocity = [0, -1, 0]
mass = 4
[[body]]
sphere = 0.5
position = [1, 1.5, 0]
mass = 2
[[body]]
capsule = { half = 0.4, radius = 0.2 }
position = [9, 5, 0]
mass = 1
[[body]]
position = [-5, 5, 0]
angular_velocity = [0, 3, 0]
mass = 1
[[body.part]]
box = [0.5, 0.5, 0.5]
[[body.part]]
sphere = 0.5
position = [0, 1, 0]
"""

CLOTH = """
kind = "cloth"
frames = 1
thickness = 0.01
[sheet]
rows = 9
columns = 9
origin = [-0.5, 1, -0.5]
width = [1, 0, 0]
height = [0, 0, 1]
mass = 0.1
[[sphere]]
centre = [0, 0.6, 0]
radius = 0.2
[[box]]
centre = [3, 0, 0]
half = [0.1, 0.2, 0.3]
[[capsule]]
from = [5, 0, 0]
to = [6, 0, 0]
radius = 0.1
[[plane]]
normal = [0, 2, 0]
point = [0, -1, 0]
"""

FLUID = """
kind = "fluid"
frames = 1
particles_per_metre = 204
[[block]]
min = [-0.02, -0.08, -0.02]
max = [0.02, -0.06, 0.02]
"""


def points(data):
    return vtk_to_numpy(data.GetPoints().GetData())


def volume(data):
    triangles = vtk.vtkTriangleFilter()
    triangles.SetInputData(data)
    mass = vtk.vtkMassProperties()
    mass.SetInputConnection(triangles.GetOutputPort())
    return mass.GetVolume()


class Frames(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def lockstep(self, *arguments):
        return subprocess.run([PROGRAM, *arguments], cwd=self.folder, check=True, capture_output=True, text=True).stdout

    def frames(self, scene, count):
        (self.folder / "scene.toml").write_text(scene)
        self.lockstep("run", "--scene", "scene.toml", "--frames", str(count), "--out", "frames")
        return self.folder / "frames"

    def test_bodies(self):
        frames = self.frames(RIGID, 30)
        start, end = (read(frames / f"bodies_{k:05d}.vtk") for k in (0, 30))
        array = lambda name, data=start: vtk_to_numpy(data.GetPointData().GetArray(name))  # noqa: E731
        self.assertEqual(list(array("body")), [0, 1, 2, 3, 4, 5])
        self.assertEqual(list(array("kind")), [5, 2, 2, 0, 1, 6])
        np.testing.assert_allclose(array("mass"), [0, 0, 4, 2, 1, 1], rtol=1e-6)
        np.testing.assert_allclose(array("velocity")[2], [0, -1, 0])
        np.testing.assert_allclose(array("angular_velocity")[5], [0, 3, 0], atol=1e-6)
        np.testing.assert_allclose(points(start)[2], [5, 8, 0])
        # It falls freely, within what the first order of a step of 10 ms is off.
        time = 0.3
        np.testing.assert_allclose(points(end)[2], [5, 8 - time - 9.81 * time**2 / 2, 0], atol=9.81 * time * 0.01 / 2)
        # Each box's corners are at its pose. vtkQuaternion begins with w, as the array does.
        pose = vtk.vtkQuaterniond(*map(float, array("orientation_wxyz")[2]))
        turn = np.empty((3, 3))
        pose.ToMatrix3x3(turn)
        corners = points(read(frames / "frame_00000.vtk"))[:8]
        half = np.abs((corners - points(start)[2]) @ turn)
        order = half.max(axis=0)
        np.testing.assert_allclose(np.sort(order), [0.1, 0.2, 0.3], atol=1e-5)
        np.testing.assert_allclose(half, np.tile(order, (8, 1)), atol=1e-5)

    def test_what_stands_still_is_a_file(self):
        frames = self.frames(RIGID, 2)
        ground, fixed, moving = (read(frames / f"{name}.vtk") for name in ("ground", "static", "frame_00002"))
        self.assertEqual(ground.GetNumberOfCells(), 1)
        self.assertTrue((points(ground)[:, 1] == 0).all())
        self.assertLess(points(ground)[:, 0].min(), -5)
        self.assertGreater(points(ground)[:, 0].max(), 9)
        self.assertAlmostEqual(volume(fixed), 4 * 1 * 4, places=5)
        body = lambda data: set(vtk_to_numpy(data.GetCellData().GetArray("body")))  # noqa: E731
        self.assertEqual((body(ground), body(fixed), body(moving)), ({0}, {1}, {2, 3, 4, 5}))

    def test_obstacles_of_a_cloth(self):
        frames = self.frames(CLOTH, 2)
        parts = vtk.vtkPolyDataConnectivityFilter()
        parts.SetInputData(read(frames / "obstacles.vtk"))
        parts.SetExtractionModeToSpecifiedRegions()
        parts.Update()
        volumes, bounds = [], []
        for region in range(parts.GetNumberOfExtractedRegions()):
            parts.InitializeSpecifiedRegionList()
            parts.AddSpecifiedRegion(region)
            clean = vtk.vtkCleanPolyData()
            clean.SetInputConnection(parts.GetOutputPort())
            clean.Update()
            bounds.append(clean.GetOutput().GetBounds())
            volumes.append(volume(clean.GetOutput()) if clean.GetOutput().GetNumberOfCells() > 1 else 0)
        # With the thickness. Polygons within a ball of 32 sides have 2 % less.
        sphere = 4 / 3 * np.pi * 0.21**3
        capsule = np.pi * 0.11**2 * (1 + 4 / 3 * 0.11)
        box = 8 * 0.11 * 0.21 * 0.31
        for found, exact in zip(sorted(volumes), sorted((0, sphere, capsule, box))):
            self.assertLessEqual(found, exact + 1e-6)
            self.assertGreaterEqual(found, 0.97 * exact)
        plane = next(b for b in bounds if b[2] == b[3])
        self.assertAlmostEqual(plane[2], -0.99, places=6)
        self.assertTrue(plane[0] < -0.5 and plane[1] > 0.5 and plane[4] < -0.5 and plane[5] > 0.5, plane)
        capsules = [b for b in bounds if b[0] > 4]
        np.testing.assert_allclose(capsules, [[4.89, 6.11, -0.11, 0.11, -0.11, 0.11]], atol=1e-5)

    def test_box_of_a_fluid(self):
        frames = self.frames(FLUID, 2)
        box = read(frames / "box.vtk")
        np.testing.assert_allclose(box.GetBounds(), [-0.065, 0.065, -0.08, 0.1, -0.065, 0.065], atol=1e-7)
        self.assertEqual(box.GetNumberOfLines(), 12)
        lengths = np.linalg.norm(
            np.diff(points(box)[vtk_to_numpy(box.GetLines().GetConnectivityArray())].reshape(12, 2, 3), axis=1), axis=2
        )
        np.testing.assert_allclose(np.sort(lengths.ravel()), [0.13] * 8 + [0.18] * 4, rtol=1e-5)
        water = read(frames / "frame_00002.vtk")
        self.assertTrue((vtk_to_numpy(water.GetPointData().GetArray("density")) > 500).all())

    def test_nothing_that_moves(self):
        frames = self.frames('kind = "rigid"\nframes = 1\n[[body]]\nplane = [0, 1, 0]\n', 1)
        self.assertEqual(read(frames / "frame_00001.vtk").GetNumberOfCells(), 0)
        self.assertEqual(read(frames / "bodies_00001.vtk").GetNumberOfPoints(), 1)

    def test_readme(self):
        """README's Python runs as written, on what README's commands write."""
        blocks = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
        self.assertEqual(len(blocks), 1)
        self.lockstep("run", "--scene", "dam_break_5k", "--frames", "4", "--out", "build/frames/dam_break_5k")
        self.lockstep(
            "verify",
            "--kernel",
            "fluid/advance",
            "--scene",
            "dam_break_5k",
            "--threads",
            "1",
            "--json",
            "build/verify.json",
        )
        ran = subprocess.run([sys.executable, "-c", blocks[0]], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual((ran.returncode, ran.stderr), (0, ""))
        lines = ran.stdout.splitlines()
        self.assertTrue(lines[0].startswith("fluid/advance "), lines)
        times, heights = zip(*(map(float, line.split()) for line in lines[1:]))
        self.assertEqual(times, (0, 0.001, 0.002, 0.003, 0.004))
        particles = points(read(self.folder / "build/frames/dam_break_5k/frame_00004.vtk"))
        self.assertAlmostEqual(heights[4], particles[:, 1].mean(), places=6)


if __name__ == "__main__":
    unittest.main()
