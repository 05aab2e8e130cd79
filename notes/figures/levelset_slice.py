"""A slice of a level set: distances, and their first-order error."""

import numpy
import style

TITLE = "Level set: a slice of spheres and box at 128^3"
PAPER_FIGURE = "[ITJ07] Figures 6 to 8"
PAPER = "The methods, as drawings; there is no field to compare with."
NOTES = ["levelset"]
REPORTS = {"levelset_slice": None}
SCENE = "spheres_and_box_128_full"


def table(data):
    return [
        {k: r[k] for k in ("x", "y", "distance", "error_in_spacings", "from")} for r in data["levelset_slice"]["rows"]
    ]


def in_short(rows):
    errors = [abs(r["error_in_spacings"]) for r in rows]
    return {
        "paper": "drawings",
        "measured": f"error against the exact distance: mean {numpy.mean(errors):.2f} h, at most {max(errors):.2f} h",
        "modelled": "–",
        "scene": SCENE,
    }


def here(rows):
    return [
        "Left: the signed distance in the plane z = 1/2, contours every 0.05, the interface in black. Right: its error"
        " in spacings h. First-order upwind has an error where fronts curve. It is largest beside the box's edges and"
        " where two fronts meet."
    ]


def draw(rows):
    n = max(r["x"] for r in rows) + 1
    distance, error = (
        numpy.array([r[name] for r in rows]).reshape(-1, n) for name in ("distance", "error_in_spacings")
    )
    figure, [[left, right]] = style.panels(1, 2, 4.2, 3.6)
    image = left.imshow(distance, origin="lower", cmap="RdBu", vmin=-abs(distance).max(), vmax=abs(distance).max())
    left.contour(distance, levels=numpy.arange(-1, 1, 0.05), colors="grey", linewidths=0.5)
    left.contour(distance, levels=[0], colors="black")
    figure.colorbar(image, ax=left, label="distance, m", shrink=0.85)
    image = right.imshow(error, origin="lower", cmap="viridis")
    right.contour(distance, levels=[0], colors="white")
    figure.colorbar(image, ax=right, label="error, h", shrink=0.85)
    for axis in (left, right):
        axis.set_xlabel("x, h")
        axis.set_ylabel("y, h")
        axis.grid(False)
    return figure
