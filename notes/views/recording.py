"""Runs a scene by `lockstep run` and keeps of its frames what a view shows.

A frame is read as soon as it is whole, and its files are removed: a minute of the castle would be 26 GB. What is kept
goes to one file of floats a run, so that memory holds a frame at a time.
"""

import json
import pathlib
import re
import subprocess
import sys
import time

import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "pictures"))
from render import field, read  # noqa: E402, from the folder above


FIXED = ("ground", "static", "obstacles", "box")  # parts that do not move (verify/frames.h)


class Stopped(Exception):
    """The program refused the scene, or was stopped."""


class Recording:
    """One run: `values[frame]` are floats [element, component] of all frames, `curves` a number a frame, by name.

    Components are the position, m, and for rigid bodies the orientation (w, x, y, z) too; of level sets the distance,
    m, a point an element, x fastest.
    """

    def __init__(self, program, arguments, folder):
        folder.mkdir(parents=True)
        self.kind = None
        self.spray = []
        self.curves = {}
        self.fixed = {}
        self.count = 0
        self._file = folder / "values"
        with open(self._file, "wb") as self._out:
            for frame in self._follow([program, "run", *arguments, "--out", folder, "--force"], folder):
                self._take(folder, frame)
        self.values = np.memmap(self._file, np.float32, "r").reshape(self.count, *self._shape)
        series = [json.loads(path.read_text())["files"] for path in folder.glob("frame.*.series")]
        self.time_step = series[0][1]["time"] if series and len(series[0]) > 1 else 0

    def _follow(self, command, folder):
        """The numbers of frames, each as soon as it is whole: as the next one is there, or the run has ended."""

        def is_there(frame):
            return any((folder / f"frame_{frame:05d}{end}").exists() for end in (".vtk", ".vti"))

        run = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        try:
            while True:
                ended = run.poll() is not None
                if is_there(self.count + 1) or ended and is_there(self.count):
                    yield self.count
                    self.count += 1
                elif ended:
                    break
                else:
                    time.sleep(0.01)
        finally:
            run.terminate()
            said = run.communicate()[0]
        if run.returncode:
            raise Stopped(run.returncode)
        self.variant, self.form, threads = re.search(r", (serial|openmp) (\S+) on (\d+) threads", said).groups()
        self.name = f"{self.variant} {self.form}" + (f", {threads} threads" if self.variant == "openmp" else "")

    def _take(self, folder, frame):
        paths = {path.name.rsplit("_", 1)[0]: path for path in folder.glob(f"*_{frame:05d}.vt*")}
        if frame == 0:
            paths_of_fixed = [path for path in folder.glob("*.vt[ki]") if path.stem in FIXED]
            self.fixed = {path.stem: field(path) if path.suffix == ".vti" else read(path) for path in paths_of_fixed}
        data = None if paths["frame"].suffix == ".vti" else read(paths["bodies" if "bodies" in paths else "frame"])
        if data is None or data.IsA("vtkImageData"):
            values = self._level_set(paths, data)
        elif "bodies" in paths:
            values = self._bodies(data, paths)
        else:
            values = self._positions(data)
        self._shape = values.shape
        self._out.write(np.ascontiguousarray(values, np.float32).tobytes())
        for path in paths.values():
            path.unlink()

    def _level_set(self, paths, image):
        if image:
            self.kind = "surface"
            values = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(image.GetDimensions()[::-1])
            spacing, first = image.GetSpacing()[0], image.GetOrigin()
        else:
            self.kind = "liquid"
            values, spacing = field(paths["frame"])
            first = 3 * (0.5 * spacing,)
        self.grid = {"points": values.shape[::-1], "spacing": spacing, "first": first}
        inside = np.clip(0.5 - values / spacing, 0, 1)
        if "obstacles" in self.fixed:
            inside[self.fixed["obstacles"][0] < 0] = 0
        self._add("volume, m³", float(inside.sum(dtype=np.float64)) * spacing**3)
        drops = read(paths["spray"]).GetPoints() if "spray" in paths else None
        self.spray.append(vtk_to_numpy(drops.GetData()).copy() if drops else np.zeros((0, 3), np.float32))
        return values.reshape(-1, 1)

    def _bodies(self, data, paths):
        points = data.GetPointData()
        pose = np.hstack([positions(data), vtk_to_numpy(points.GetArray("orientation_wxyz"))])
        if self.kind is None:
            self.kind, self.surfaces = "bodies", read(paths["frame"])
        speed_2 = (vtk_to_numpy(points.GetArray("velocity")).astype(np.float64) ** 2).sum(axis=1)
        mass = vtk_to_numpy(points.GetArray("mass"))
        self._add("kinetic energy without spin, J", float((0.5 * mass * speed_2).sum()))
        return pose

    def _positions(self, data):
        points, cells = data.GetPointData(), data.GetCellData()
        place = positions(data)
        velocity, number = points.GetArray("velocity"), points.GetArray("id")
        if velocity:
            speed_2 = (vtk_to_numpy(velocity).astype(np.float64) ** 2).sum(axis=1)
            self._add("kinetic energy over mass, J/kg", float(0.5 * speed_2.mean()))
        if cells.GetArray("volume"):
            least = float(cells.GetArray("volume").GetRange()[0])
            self._add("least volume of a tetrahedron over that at rest", least)
        if self.kind is None:
            self.kind = "points" if number else "mesh"
            self.triangles, self.is_flesh = None if number else triangles_of(data), bool(cells.GetArray("volume"))
        if number:
            ordered = np.empty_like(place)
            ordered[vtk_to_numpy(number)] = place
            return ordered
        return place

    def _add(self, curve, value):
        self.curves.setdefault(curve, []).append(value)


def positions(data):
    return vtk_to_numpy(data.GetPoints().GetData()) if data.GetNumberOfPoints() else np.zeros((0, 3), np.float32)


def triangles_of(data):
    """Of a surface, or the boundary of a body of tetrahedra: numbers of points [triangle, corner]."""
    if data.IsA("vtkUnstructuredGrid"):
        number = vtk.vtkIdFilter()
        number.SetInputData(data)
        number.CellIdsOff()
        number.SetPointIdsArrayName("number")
        boundary = vtk.vtkDataSetSurfaceFilter()
        boundary.SetInputConnection(number.GetOutputPort())
        boundary.Update()
        data = boundary.GetOutput()
        numbers = vtk_to_numpy(data.GetPointData().GetArray("number"))
    else:
        numbers = np.arange(data.GetNumberOfPoints())
    triangles = vtk.vtkTriangleFilter()
    triangles.SetInputData(data)
    triangles.PassLinesOff()
    triangles.PassVertsOff()
    triangles.Update()
    return numbers[vtk_to_numpy(triangles.GetOutput().GetPolys().GetData()).reshape(-1, 4)[:, 1:]]
