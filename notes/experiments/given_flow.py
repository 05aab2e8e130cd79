"""How much volume a level set lost in a given flow that brings it back, and how much is misplaced.

/usr/bin/python3 notes/experiments/given_flow.py FOLDER: compares the last frame that `lockstep run` wrote there with
the first, by cells' shares of liquid (liquid_share in common/production_fluid/state.h)."""

import pathlib
import sys

import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy


def shares(file):
    reader = vtk.vtkXMLImageDataReader()
    reader.SetFileName(str(file))
    reader.Update()
    image = reader.GetOutput()
    phi = vtk_to_numpy(image.GetPointData().GetArray("phi")).astype(float)
    return np.clip(0.5 - phi / image.GetSpacing()[0], 0, 1)


frames = sorted(pathlib.Path(sys.argv[1]).glob("frame_*.vti"))
start, end = shares(frames[0]), shares(frames[-1])
print(f"lost {100 * (1 - end.sum() / start.sum()):.2f} %, misplaced {100 * abs(end - start).sum() / start.sum():.2f} %")
