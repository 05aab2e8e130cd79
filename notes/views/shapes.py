"""What a page draws of a recording: triangles, bodies, surfaces of level sets and slices, and what does not move."""

import base64

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

import pack
from recording import positions, triangles_of
from render import zero_of


def base64_of(array, kind):
    return base64.b64encode(np.ascontiguousarray(array, kind).tobytes()).decode()


def mesh(points, triangles, lines=()):
    return {
        "points": base64_of(points, "<f4"),
        "triangles": base64_of(triangles, "<u4"),
        "lines": base64_of(lines, "<u4"),
    }


def fixed(run):
    """The parts that do not move: {name: mesh}."""
    shown = {}
    for name, data in run.fixed.items():
        if isinstance(data, tuple):
            data = zero_of(*data)
        lines = vtk_to_numpy(data.GetLines().GetData()).reshape(-1, 3)[:, 1:] if data.GetNumberOfLines() else []
        triangles = triangles_of(data) if data.GetNumberOfPolys() else []
        shown[name] = mesh(positions(data), triangles, lines)
    return shown


def fixed_shape(run, size):
    """What stays as it is while elements move within a box of a size, m: triangles of a mesh, surfaces of bodies, the
    radius of particles."""
    if run.kind == "mesh":
        return {"triangles": base64_of(run.triangles, "<u4"), "colour": "#d9a58a" if run.is_flesh else "#b23a48"}
    if run.kind == "points":
        return {"radius": 0.5 * nearest(run.values[0]), "fast": fast(run, size)}
    return {"bodies": bodies(run), "fast": fast(run, size)}


def fast(run, size):
    """How far a fast element moves in a frame, m: all but one in two hundred are slower, in the fastest of some frames.
    At least a hundred steps of the page's numbers, so that colours show no rounding."""
    steps = range(0, run.count - 1, max(1, run.count // 200))
    ways = [np.linalg.norm(run.values[f + 1, :, :3] - run.values[f, :, :3], axis=1) for f in steps]
    return max([100 * size / pack.STEPS, *(float(np.percentile(way, 99.5)) for way in ways if len(way))])


def nearest(points):
    """The median distance to the nearest point, of some points; a hundredth of their box if there is one only."""
    apart = []
    for k in range(0, len(points), max(1, len(points) // 200)):
        to_all = ((points - points[k]) ** 2).sum(axis=1)
        to_all[k] = np.inf
        apart.append(np.sqrt(to_all.min()))
    found = float(np.median(apart)) if len(points) > 1 else 0.0
    return found or 0.01 * float(np.linalg.norm(np.ptp(points, axis=0))) or 0.01


def bodies(run):
    """Corners in the frame of the body that each belongs to, and triangles of all bodies that move."""
    surface = run.surfaces
    split = vtk.vtkTriangleFilter()  # keeps points and the cells' data
    split.SetInputData(surface)
    split.Update()
    triangles = vtk_to_numpy(split.GetOutput().GetPolys().GetData()).reshape(-1, 4)[:, 1:]
    of_cell = vtk_to_numpy(split.GetOutput().GetCellData().GetArray("body"))
    of_point = np.zeros(surface.GetNumberOfPoints(), np.int32)
    of_point[triangles.ravel()] = np.repeat(of_cell, 3)
    pose = run.values[0][of_point].astype(np.float64)
    local = turned(positions(surface) - pose[:, :3], pose[:, 3:] * [1, -1, -1, -1])
    return mesh(local, triangles) | {"body": base64_of(of_point, "<u4")}


def turned(v, q):
    """Vectors turned by unit quaternions, w first."""
    across = 2 * np.cross(q[:, 1:], v)
    return v + q[:, :1] * across + np.cross(q[:, 1:], across)


def phi_of(run, frame):
    return np.array(run.values[frame, :, 0]).reshape(run.grid["points"][::-1])


def surface_of(run, frame):
    phi, spacing = phi_of(run, frame), run.grid["spacing"]
    if run.kind == "liquid":
        if "obstacles" in run.fixed:
            # Within walls the level set goes on; the liquid does not. A gap keeps its surface apart from theirs.
            phi = np.maximum(phi, 0.4 * spacing - run.fixed["obstacles"][0])
        return zero_of(phi.astype(np.float64), spacing)
    image = vtk.vtkImageData()
    image.SetDimensions(*run.grid["points"])
    image.SetSpacing(3 * (spacing,))
    image.SetOrigin(*run.grid["first"])
    image.GetPointData().SetScalars(numpy_to_vtk(phi.ravel(), deep=True))
    surface = vtk.vtkContourFilter()
    surface.SetInputData(image)
    surface.SetValue(0, 0)
    surface.ComputeNormalsOff()
    surface.ComputeScalarsOff()
    surface.Update()
    return surface.GetOutput()


def surface_block(run, frame, low, high, compared=None):
    """A frame's surface, with drops of spray: four numbers (points, triangles, drops, whether points have codes), the
    codes of the points' distance from another run, places, drops, corners."""
    surface = surface_of(run, frame)
    points, drops = positions(surface), run.spray[frame] if run.spray else np.zeros((0, 3))
    triangles = triangles_of(surface) if surface.GetNumberOfPolys() else np.zeros((0, 3), np.int64)
    codes = b""
    if compared:
        other, size = compared
        apart = np.abs(phi_of(run, frame).astype(np.float64) - phi_of(other, frame))
        at = np.rint((points - run.grid["first"]) / run.grid["spacing"]).astype(int)
        at = np.clip(at, 0, np.array(run.grid["points"]) - 1)
        codes = pack.code_of(apart[at[:, 2], at[:, 1], at[:, 0]], size).tobytes()
    head = np.array([len(points), len(triangles), len(drops), len(codes) > 0], "<u4").tobytes()
    # Closed surfaces of liquids reach half a cell beyond the outermost centres.
    margin = run.grid["spacing"]
    places = [pack.along(pack.quantised(np.asarray(p, float), low - margin, high + margin).T) for p in (points, drops)]
    corners = pack.along(triangles.astype(np.int32).reshape(1, -1))
    return pack.deflated(head, codes, *places, corners)


def slice_of(run):
    """The slice through the middle, across z: where it is, and the range of its values."""
    nx, ny, nz = run.grid["points"]
    first, spacing = run.grid["first"], run.grid["spacing"]
    most = 16 * spacing if run.kind == "surface" else 4 * spacing
    corner = [first[0], first[1], first[2] + spacing * (nz // 2)]
    return {"columns": nx, "rows": ny, "corner": [float(x) for x in corner], "spacing": float(spacing), "most": most}


def slices(run):
    """Yields for each frame the slice's distances as bytes: 0 of -most, 255 of +most."""
    most = slice_of(run)["most"]
    for frame in range(run.count):
        middle = phi_of(run, frame)[run.grid["points"][2] // 2]
        yield pack.deflated(np.rint(255 * np.clip(0.5 + 0.5 * middle / most, 0, 1)).astype(np.uint8).tobytes())
