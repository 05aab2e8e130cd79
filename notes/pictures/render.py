"""Renders README's pictures from frames that `lockstep run` wrote: render.py FRAMES PICTURES

FRAMES holds a folder a scene, as `make pictures` makes them; PICTURES gets NAME.png of each picture in `pictures`.
VTK of Debian renders into an X server: without one, xvfb-run gives it one.
"""

import pathlib
import sys

import numpy as np
import vtk
from PIL import Image
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

WIDTH, HEIGHT = 1200, 800
FINER = 2  # rendered larger, then averaged: smooth edges


def read(path):
    reader = vtk.vtkGenericDataObjectReader()
    reader.SetFileName(str(path))
    reader.ReadAllScalarsOn()
    reader.ReadAllVectorsOn()
    reader.Update()
    if reader.GetErrorCode() or not reader.GetOutput():
        raise OSError(f"{path}: VTK does not read it")
    return reader.GetOutput()


def last(folder, part="frame"):
    """The last frame of a part: how many there are is the moment to show."""
    return read(max(folder.glob(f"{part}_*.vtk")))


def field(path):
    """An image of a field: its values [z, y, x], at the centres of cells, and the side of a cell."""
    reader = vtk.vtkXMLImageDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    image = reader.GetOutput()
    if not image.GetNumberOfPoints():
        raise OSError(f"{path}: VTK does not read it")
    values = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(image.GetDimensions()[::-1])
    return values.astype(np.float64), image.GetSpacing()[0]


def colours(low, high, stops):
    """A table of colours between stops, #rrggbb."""
    function = vtk.vtkColorTransferFunction()
    function.SetColorSpaceToLab()
    for x, stop in zip(np.linspace(low, high, len(stops)), stops):
        function.AddRGBPoint(x, *rgb(stop))
    return function


def rgb(text):
    return tuple(int(text[k : k + 2], 16) / 255 for k in (1, 3, 5))


def actor(source, colour=None, table=None, array=None, cells=False):
    """An actor of a data set or of a filter, in one colour or coloured by an array."""
    mapper = vtk.vtkPolyDataMapper()
    if isinstance(source, vtk.vtkDataObject):
        mapper.SetInputData(source)
    else:
        mapper.SetInputConnection(source.GetOutputPort())
    if array:
        mapper.SetScalarModeToUseCellFieldData() if cells else mapper.SetScalarModeToUsePointFieldData()
        mapper.SelectColorArray(array)
        mapper.SetLookupTable(table)
        mapper.UseLookupTableScalarRangeOn()
    else:
        mapper.ScalarVisibilityOff()
    shown = vtk.vtkActor()
    shown.SetMapper(mapper)
    if colour:
        shown.GetProperty().SetColor(*rgb(colour))
    shown.GetProperty().SetAmbient(0.18)
    shown.GetProperty().SetDiffuse(0.85)
    return shown


def bar(table, title, ticks):
    """A legend of colours at the upper left."""
    legend = vtk.vtkScalarBarActor()
    legend.SetLookupTable(table)
    legend.SetTitle(title)
    legend.SetNumberOfLabels(ticks)
    legend.SetLabelFormat("%.3g")
    legend.SetPosition(0.03, 0.72)
    legend.SetPosition2(0.075, 0.25)
    legend.SetBarRatio(0.25)
    legend.UnconstrainedFontSizeOn()
    for text in (legend.GetTitleTextProperty(), legend.GetLabelTextProperty()):
        text.SetColor(0.15, 0.15, 0.15)
        text.SetFontFamilyToArial()
        text.SetFontSize(15 * FINER)
        text.BoldOff()
        text.ItalicOff()
        text.ShadowOff()
    return legend


def render(path, actors, eye, focus, shade, angle=30, bars=()):
    """Writes a picture. `shade` is the radius, m, within which things darken each other."""
    renderer = vtk.vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    for shown in actors:
        renderer.AddActor(shown)
    for legend in bars:
        renderer.AddActor2D(legend)
    renderer.AutomaticLightCreationOff()
    eye, focus = np.array(eye, float), np.array(focus, float)
    ahead = focus - eye
    right = np.cross(ahead, (0, 1, 0))
    right *= np.linalg.norm(ahead) / np.linalg.norm(right)
    up = np.array((0, np.linalg.norm(ahead), 0))
    for side, height, strength in ((-0.8, 1.2, 0.85), (1.2, 0.5, 0.3), (0.0, 0.1, 0.2)):
        light = vtk.vtkLight()
        light.SetLightTypeToSceneLight()
        light.PositionalOff()
        light.SetPosition(*(eye + side * right + height * up))
        light.SetFocalPoint(*focus)
        light.SetIntensity(strength)
        renderer.AddLight(light)
    camera = renderer.GetActiveCamera()
    camera.SetPosition(*eye)
    camera.SetFocalPoint(*focus)
    camera.SetViewAngle(angle)
    renderer.ResetCameraClippingRange()
    renderer.UseSSAOOn()
    renderer.SetSSAORadius(shade)
    renderer.SetSSAOBias(0.01 * shade)
    renderer.SetSSAOKernelSize(128)
    renderer.SSAOBlurOn()
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetSize(FINER * WIDTH, FINER * HEIGHT)
    window.AddRenderer(renderer)
    window.Render()
    image = vtk.vtkWindowToImageFilter()
    image.SetInput(window)
    image.ReadFrontBufferOff()
    image.Update()
    pixels = vtk_to_numpy(image.GetOutput().GetPointData().GetScalars()).reshape(FINER * HEIGHT, FINER * WIDTH, 3)
    picture = Image.fromarray(np.ascontiguousarray(pixels[::-1])).reduce(FINER)
    # A palette takes a third of the bytes.
    picture.quantize(256, method=Image.Quantize.MAXCOVERAGE, kmeans=3).save(path, optimize=True)
    print(path)


def round_surface(points, radius):
    """A sphere about each point, with the points' arrays."""
    sphere = vtk.vtkSphereSource()
    sphere.SetRadius(radius)
    sphere.SetThetaResolution(10)
    sphere.SetPhiResolution(8)
    spheres = vtk.vtkGlyph3DMapper()
    spheres.SetInputData(points)
    spheres.SetSourceConnection(sphere.GetOutputPort())
    spheres.ScalingOff()
    return spheres


def castle(folder, path):
    """The castle after the shot, bricks by their speed."""
    bricks, bodies = last(folder), last(folder, "bodies")
    table = colours(0, 20, ("#d9cfbd", "#e0a84e", "#d0603c", "#a8333f", "#6a1a3a"))
    shown = [actor(bricks, table=table, array="speed", cells=True), actor(read(folder / "ground.vtk"), "#f1efeb")]
    # The ball is a body of kind 0.
    kinds = vtk_to_numpy(bodies.GetPointData().GetArray("kind"))
    for body in np.flatnonzero(kinds == 0):
        sphere = vtk.vtkSphereSource()
        sphere.SetCenter(bodies.GetPoint(body))
        sphere.SetRadius(1.5)
        sphere.SetThetaResolution(64)
        sphere.SetPhiResolution(32)
        shown.append(actor(sphere, "#2b2f38"))
    render(path, shown, eye=(-46, 34, -66), focus=(1, 4, -8), shade=1.2, bars=[bar(table, "speed, m/s", 5)])


def dam_break(folder, path, spacing=0.00234):
    """The dam break as the wave breaks at the far wall, particles by their speed."""
    water = last(folder)
    velocity = vtk_to_numpy(water.GetPointData().GetArray("velocity"))
    speed = numpy_to_vtk(np.linalg.norm(velocity, axis=1))
    speed.SetName("speed")
    water.GetPointData().AddArray(speed)
    table = colours(0, 1.6, ("#0b2f6b", "#1f6fb5", "#5fb3dd", "#b5e2ef", "#e8f7fa"))
    mapper = round_surface(water, 0.6 * spacing)
    mapper.SetScalarModeToUsePointFieldData()
    mapper.SelectColorArray("speed")
    mapper.SetLookupTable(table)
    mapper.UseLookupTableScalarRangeOn()
    particles = vtk.vtkActor()
    particles.SetMapper(mapper)
    particles.GetProperty().SetAmbient(0.2)
    edges = actor(read(folder / "box.vtk"), "#9a9a9a")
    edges.GetProperty().SetLineWidth(1.5 * FINER)
    edges.GetProperty().LightingOff()
    render(
        path,
        [particles, edges],
        eye=(-0.21, 0.15, 0.42),
        focus=(0.004, 0.004, 0),
        shade=0.01,
        bars=[bar(table, "speed, m/s", 5)],
    )


def smooth(data):
    normals = vtk.vtkPolyDataNormals()
    normals.SetInputData(data)
    normals.SplittingOff()
    normals.ConsistencyOn()
    return normals


def under(path):
    """Bodies that a game's cloth lies on. They are written as the cloth meets them; without the scene's thickness of
    10 mm they lie below it."""
    outside = smooth(read(path))
    outside.Update()
    body = outside.GetOutput()
    points = vtk_to_numpy(body.GetPoints().GetData())
    points -= 0.015 * vtk_to_numpy(body.GetPointData().GetNormals())
    return actor(body, "#d8d4cd")


def garment(folder, path):
    """The poncho, draped."""
    cloth = actor(smooth(last(folder)), "#b23a48")
    render(path, [cloth, under(folder / "obstacles.vtk")], eye=(1.15, 1.8, 2.65), focus=(0, 1.25, 0), shade=0.12)


def level_set(folder, path):
    """The surface of the knot, and a slice of the distances about it."""
    phi = last(folder)
    surface = vtk.vtkContourFilter()
    surface.SetInputData(phi)
    surface.SetValue(0, 0)
    surface.ComputeNormalsOff()
    band = phi.GetScalarRange()[1]
    plane = vtk.vtkPlane()
    plane.SetOrigin(0.5, 0.5, 0.5)
    plane.SetNormal(0, 0, 1)
    cut = vtk.vtkCutter()
    cut.SetInputData(phi)
    cut.SetCutFunction(plane)
    table = colours(0, band, ("#ffffff", "#c6dbef", "#6baed6", "#2171b5", "#08306b"))
    near = vtk.vtkClipPolyData()  # distances are computed in a band about the surface
    near.SetInputConnection(cut.GetOutputPort())
    near.SetValue(0.9 * band)
    near.InsideOutOn()
    distances = actor(near, table=table, array="phi")
    distances.GetProperty().LightingOff()
    lines = vtk.vtkContourFilter()
    lines.SetInputConnection(cut.GetOutputPort())
    lines.GenerateValues(4, 0.2 * band, 0.8 * band)
    levels = actor(lines, "#303030")
    levels.GetProperty().LightingOff()
    levels.GetProperty().SetLineWidth(FINER)
    smoothed = vtk.vtkPolyDataNormals()
    smoothed.SetInputConnection(surface.GetOutputPort())
    smoothed.SplittingOff()
    frame = vtk.vtkOutlineFilter()
    frame.SetInputData(phi)
    edges = actor(frame, "#9a9a9a")
    edges.GetProperty().SetLineWidth(1.5 * FINER)
    edges.GetProperty().LightingOff()
    shown = [actor(smoothed, "#d9d2c5"), distances, levels, edges]
    render(path, shown, eye=(1.0, 1.35, 3.15), focus=(0.5, 0.47, 0.5), shade=0.05, bars=[bar(table, "distance, m", 5)])


def zero_of(values, spacing):
    """The surface on which a field vanishes, with normals, closed where the box ends."""
    # A cell more on each side, of the other sign where the field is negative: it vanishes on the sides of the box.
    padded = np.abs(np.pad(values, 1, mode="edge"))
    padded[1:-1, 1:-1, 1:-1] = values
    image = vtk.vtkImageData()
    image.SetDimensions(*padded.shape[::-1])
    image.SetSpacing(spacing, spacing, spacing)
    image.SetOrigin(*3 * (-0.5 * spacing,))
    image.GetPointData().SetScalars(numpy_to_vtk(padded.ravel(), deep=True))
    surface = vtk.vtkContourFilter()
    surface.SetInputData(image)
    surface.SetValue(0, 0)
    surface.ComputeScalarsOff()
    surface.ComputeNormalsOn()
    surface.Update()
    return surface.GetOutput()


def shiny(shown, opacity=1.0):
    shown.GetProperty().SetSpecular(0.5)
    shown.GetProperty().SetSpecularPower(40)
    shown.GetProperty().SetOpacity(opacity)
    return shown


def spray(folder, radius, colour):
    """Drops that left the surface, as balls of one radius, which is more than theirs, so that they are seen."""
    drops = vtk.vtkActor()
    drops.SetMapper(round_surface(last(folder, "spray"), radius))
    drops.GetMapper().ScalarVisibilityOff()
    drops.GetProperty().SetColor(*rgb(colour))
    return drops


def box_of(x, y, z):
    """The edges of a box with a corner at the origin."""
    cube = vtk.vtkCubeSource()
    cube.SetBounds(0, x, 0, y, 0, z)
    outline = vtk.vtkOutlineFilter()
    outline.SetInputConnection(cube.GetOutputPort())
    edges = actor(outline, "#9a9a9a")
    edges.GetProperty().SetLineWidth(1.5 * FINER)
    edges.GetProperty().LightingOff()
    return edges


def falling_drop(folder, path):
    """A pool into which a drop has fallen."""
    phi, spacing = field(max(folder.glob("frame_*.vti")))
    water = shiny(actor(zero_of(phi, spacing), "#3d86c6"))
    drops = spray(folder, 0.3 * spacing, "#3d86c6")
    render(path, [water, drops, box_of(1, 1.5, 1)], eye=(1.62, 1.4, 3.25), focus=(0.5, 0.53, 0.5), shade=0.12)


def glass(folder, path):
    """Water that is poured into a glass."""
    phi, spacing = field(max(folder.glob("frame_*.vti")))
    solid, _ = field(folder / "obstacles.vti")
    # Within walls the level set goes on; water does not. A gap keeps its surface apart from that of the glass.
    water = shiny(actor(zero_of(np.maximum(phi, 0.4 * spacing - solid), spacing), "#3d86c6"))
    wall = shiny(actor(zero_of(solid, spacing), "#b9cdd3"), opacity=0.25)
    drops = spray(folder, 0.3 * spacing, "#3d86c6")
    render(path, [water, drops, wall], eye=(0.23, 0.29, 0.53), focus=(0.05, 0.112, 0.05), shade=0.01)


def face(data, shift):
    """The skin of a face, and eyes for it, moved by `shift`."""
    skin = vtk.vtkDataSetSurfaceFilter()
    skin.SetInputData(data)
    skin.Update()
    shown = [actor(smooth(skin.GetOutput()), "#d9a58a")]
    shown[0].GetProperty().SetSpecular(0.12)
    shown[0].GetProperty().SetSpecularPower(12)
    for side in (-1, 1):
        for z, radius, colour in ((0.0795, 0.0125, "#f6f4f0"), (0.0872, 0.0062, "#4a3a2c")):
            ball = vtk.vtkSphereSource()
            ball.SetCenter(side * 0.029, 0.026, z)
            ball.SetRadius(radius)
            ball.SetThetaResolution(48)
            ball.SetPhiResolution(48)
            shown.append(actor(ball, colour))
    inside = vtk.vtkSphereSource()  # of the mouth
    inside.SetRadius(1)
    inside.SetThetaResolution(64)
    inside.SetPhiResolution(64)
    shown.append(actor(inside, "#3a1a18"))
    shown[-1].SetScale(0.05, 0.085, 0.07)
    for part in shown:
        part.SetPosition(*shift)
    return shown


def faces(frames, path):
    """A face at rest, and with five expressions."""
    shown = face(read(min((frames / "face_smile").glob("frame_*.vtk"))), (-0.2, 0.12, 0))
    expressions = ("smile", "frown", "open_mouth", "pucker", "surprise")
    for k, name in enumerate(expressions, start=1):
        shown += face(last(frames / f"face_{name}"), (0.2 * (k % 3 - 1), 0.12 - 0.25 * (k // 3), 0))
    render(path, shown, eye=(0, -0.01, 1.25), focus=(0, -0.01, 0), shade=0.01, angle=25)


def draped(folder, colour):
    """A cloth, and the bodies that it lies on."""
    return [actor(smooth(last(folder)), colour), actor(smooth(last(folder, "obstacles")), "#d8d4cd")]


def curtain(folder, path):
    """A curtain that a ball pushes through, held at two corners."""
    shown = draped(folder, "#b23a48")
    render(path, shown, eye=(2.3, 1.4, 3.7), focus=(0, 0.78, 0.2), shade=0.12)


def cloth_on_ball(folder, path):
    """A cloth that has fallen over a ball."""
    shown = draped(folder, "#3d6fa8")
    render(path, shown, eye=(0.8, 0.65, 1.3), focus=(0, -0.08, 0), shade=0.1)


def twisted_tube(folder, path):
    """A tube whose ends turn opposite ways."""
    tube = actor(smooth(last(folder)), "#c98a3a")
    render(path, [tube], eye=(0.35, 0.45, 1.75), focus=(0, 0, 0), shade=0.08)


def funnel(folder, path):
    """Three sheets in a funnel of boards, pressed by a ball."""
    sheets = actor(smooth(last(folder)), "#6a8f4e")
    bodies = actor(last(folder, "obstacles"), "#cfc8ba")
    bodies.GetProperty().SetOpacity(0.35)
    render(path, [sheets, bodies], eye=(0.7, 1.1, 1.3), focus=(0, 0.15, 0), shade=0.08)


# The scene whose frames each picture is of; faces are of several.
pictures = {
    castle: "castle_hit",
    dam_break: "dam_break_100k",
    garment: "garment",
    level_set: "mesh_96",
    falling_drop: "falling_drop",
    glass: "glass_48",
    faces: "",
    curtain: "curtain_and_ball_5k",
    cloth_on_ball: "ball_5k",
    twisted_tube: "tube_5k",
    funnel: "funnel",
}

if __name__ == "__main__":
    frames, folder = map(pathlib.Path, sys.argv[1:3])
    for picture, scene in pictures.items():
        if picture.__name__ in (sys.argv[3:] or [picture.__name__]):
            picture(frames / scene, folder / f"{picture.__name__}.png")
