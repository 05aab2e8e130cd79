"""A slice of a level set: distances, and their first-order error."""

import matplotlib.pyplot as plt
import numpy

TITLE = "Level set: a slice of spheres and box at 128^3"
PAPER = "[ITJ07] shows the methods in Figures 6 to 8, as drawings; it has no field of its own to compare with."
HERE = (
    "Left: the signed distance in the plane z = 1/2, contours every .05, the interface in black. Right: its error in spacings. First-order "
    "upwind is off where fronts curve, and most beside the box's edges and where two fronts meet."
)


def draw(rows):
    n = max(int(r["x"]) for r in rows) + 1

    def field(name):
        return numpy.array([float(r[name]) for r in rows]).reshape(-1, n)

    figure, (left, right) = plt.subplots(1, 2, figsize=(8.5, 3.8))
    distance, error = field("distance"), field("error_in_spacings")
    image = left.imshow(distance, origin="lower", cmap="RdBu", vmin=-abs(distance).max(), vmax=abs(distance).max())
    left.contour(distance, levels=numpy.arange(-1, 1, 0.05), colors="grey", linewidths=0.5)
    left.contour(distance, levels=[0], colors="black")
    figure.colorbar(image, ax=left, label="distance, m")
    image = right.imshow(error, origin="lower", cmap="viridis")
    right.contour(distance, levels=[0], colors="white")
    figure.colorbar(image, ax=right, label="error, h")
    for axis in (left, right):
        axis.set_xticks([])
        axis.set_yticks([])
    figure.tight_layout()
    return figure
