"""Makes a page of stills and views of a dozen scenes: gallery.py PROGRAM FOLDER [SCENE...]

FOLDER gets index.html and of each scene SCENE.html, its view (view.py), and SCENE.png, its last frame as
`make pictures` renders it. VTK of Debian renders into an X server: without one, xvfb-run gives it one.
"""

import html
import itertools
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
sys.path.insert(0, str(HERE.parent / "pictures"))
import render  # noqa: E402, from the folder above


def coarse_dam(folder, path):
    render.dam_break(folder, path, spacing=1 / 160)


def smile(folder, path):
    """One face, as large as the six of `render.faces` together."""
    shown = render.face(render.last(folder), (0, 0, 0))
    render.render(path, shown, eye=(0, -0.02, 0.62), focus=(0, -0.02, 0), shade=0.01, angle=25)


def billiard(folder, path):
    """Balls just after the break, by their speed."""
    table = render.colours(0, 2, ("#d9cfbd", "#e0a84e", "#d0603c", "#a8333f"))
    balls = render.actor(render.smooth(render.last(folder)), table=table, array="speed", cells=True)
    shown = [balls, render.actor(render.read(folder / "ground.vtk"), "#dfe8df")]
    legend = [render.bar(table, "speed, m/s", 3)]
    render.render(path, shown, eye=(-0.75, 0.5, 0.45), focus=(0.02, 0, 0), shade=0.03, bars=legend)


def draped(folder, path):
    """A game's cloth over bodies that do not move."""
    cloth = render.actor(render.smooth(render.last(folder)), "#3d6fa8")
    shown = [cloth, render.under(folder / "obstacles.vtk")]
    render.render(path, shown, eye=(1.4, 1.3, 2.2), focus=(0, 0.25, 0), shade=0.1)


def jet(folder, path):
    """Liquid that pours on a block."""
    phi, spacing = render.field(max(folder.glob("frame_*.vti")))
    solid, _ = render.field(folder / "obstacles.vti")
    water = render.shiny(render.actor(render.zero_of(np.maximum(phi, 0.4 * spacing - solid), spacing), "#3d86c6"))
    block = render.actor(render.zero_of(solid, spacing), "#b9b2a5")
    drops = render.spray(folder, 0.3 * spacing, "#3d86c6")
    box = render.box_of(*(spacing * n for n in phi.shape[::-1]))
    render.render(path, [water, block, drops, box], eye=(1.35, 1.4, 2.75), focus=(0.38, 0.6, 0.34), shade=0.1)


def stretched(folder, path):
    """A drop in a given flow."""
    phi, spacing = render.field(max(folder.glob("frame_*.vti")))
    water = render.shiny(render.actor(render.zero_of(phi, spacing), "#3d86c6"))
    shown = [water, render.box_of(*(spacing * n for n in phi.shape[::-1]))]
    render.render(path, shown, eye=(1.3, 1.2, 2.4), focus=(0.5, 0.47, 0.5), shade=0.1)


def walls(folder, path):
    """A cloth over bodies that move."""
    shown = render.draped(folder, "#b23a48")
    render.render(path, shown, eye=(0.55, 0.7, 1.05), focus=(-0.1, -0.02, 0), shade=0.05)


# Frames, few enough that views stay small and are made in minutes, and what renders the last one.
SCENES = {
    "castle_hit": (30, render.castle),
    "billiard": (60, billiard),
    "dam_break_5k": (200, coarse_dam),
    "garment": (100, render.garment),
    "sheet_over_box_and_capsule": (100, draped),
    "mesh_96": (1, render.level_set),
    "enright_32": (20, stretched),
    "jet_24": (10, jet),
    "face_smile": (12, smile),
    "ball_5k": (60, render.cloth_on_ball),
    "ball_and_walls": (24, walls),
    "tube_5k": (60, render.twisted_tube),
}

STYLE = """
body { margin: 0 auto; max-width: 1400px; padding: 0 1em; font: 15px/1.4 sans-serif; color: #222; background: #fff; }
h1 { font-size: 1.4em; }
main { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 300px), 1fr)); gap: 1.2em;
  margin: 1em 0; }
article { border: 1px solid #ccc; padding: .6em; overflow: hidden; }
article img { display: block; width: 100%; height: auto; aspect-ratio: 3 / 2; }
h2 { font-size: 1.05em; margin: .5em 0 .2em; } p { margin: .3em 0; }
code { display: block; font-size: 12px; overflow-x: auto; white-space: nowrap; padding: .2em .4em; }
code { background: #f4f4f2; }
.small { font-size: 12px; color: #555; }
"""


def file_of(scene):
    """A scene of the repository, by its name."""
    return next((ROOT / "scenes").glob(f"*/{scene}.toml"))


def first_sentence(path):
    """Of the comment at the top of a scene, which says what it shows."""
    comment = itertools.takewhile(lambda line: line.startswith("#"), path.read_text("utf-8").splitlines())
    return re.split(r"(?<=\w[.)])\s+(?=[A-Z])", " ".join(line.lstrip("# ") for line in comment))[0]


def make(program, scene, frames, picture, folder):
    """The still and the view of a scene; what view.py says of it."""
    page = folder / f"{scene}.html"
    with tempfile.TemporaryDirectory(dir=folder) as kept:
        run = [program, "run", "--scene", scene, "--frames", str(frames), "--out", kept, "--force"]
        subprocess.run(run, check=True, stdout=subprocess.DEVNULL)
        picture(pathlib.Path(kept), folder / f"{scene}.png")
    view = [sys.executable, "-B", HERE / "view.py", program, scene, page, "--frames", str(frames)]
    said = subprocess.run(view, check=True, stdout=subprocess.PIPE, text=True).stdout
    print(said, end="", flush=True)
    return said.splitlines()


def card(scene, frames, said):
    """A scene on the page; `said` are the lines that view.py printed: size, verdict, distance."""
    shown = html.escape(scene.replace("_", " "))
    domain = file_of(scene).parent.name.replace("_", " ")
    size = said[0].split(": ")[1].split(",")[0]
    return (
        f"<article id='{scene}'>\n<a href='{scene}.html'><img src='{scene}.png' alt='{shown}, frame {frames}'></a>\n"
        f"<h2><a href='{scene}.html'>{shown}</a> <span class='small'>{domain}, {size}</span></h2>\n"
        f"<p>{html.escape(first_sentence(file_of(scene)))}</p>\n"
        f"<code>make view SCENE={scene} FRAMES={frames}</code>\n"
        + "".join(f"<p class='small'>{html.escape(line)}</p>\n" for line in said[1:])
        + "</article>\n"
    )


def index(cards):
    return (
        "<!doctype html>\n<html lang='en'><head><meta charset='utf-8'><title>Lockstep: gallery</title>\n"
        "<meta name='viewport' content='width=device-width, initial-scale=1'>\n"
        f"<style>{STYLE}</style></head><body>\n<h1>Lockstep: gallery</h1>\n"
        "<p>Each still is the last frame of the openmp run. It leads to a view: the serial run on the left, openmp on"
        " the right, frame by frame, with their distance below. Under each: how to make its view again, and what"
        " <code style='display: inline'>lockstep verify</code> says of the step. The domain <i>linear</i> has no frames"
        " to show.</p>\n"
        f"<main>\n{''.join(cards)}</main>\n</body></html>\n"
    )


def main(program, folder, *names):
    folder.mkdir(parents=True, exist_ok=True)
    render.WIDTH, render.HEIGHT = 600, 400
    cards = []
    for scene, (frames, picture) in SCENES.items():
        if scene in (names or SCENES):
            cards.append(card(scene, frames, make(program, scene, frames, picture, folder)))
    path = folder / "index.html"
    path.write_text(index(cards), "utf-8")
    print(path)


if __name__ == "__main__":
    try:
        main(*map(pathlib.Path, sys.argv[1:3]), *sys.argv[3:])
    except subprocess.CalledProcessError as failed:
        sys.exit(failed.returncode)
