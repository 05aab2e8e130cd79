"""Residual over iterations, by the order in which a cloth's constraints are enforced."""

import matplotlib.pyplot as plt

TITLE = "Game cloth: what the order of the constraints costs"
PAPER = (
    "[LRB08], on Figure 11: passes that can run in parallel are never more than two times slower to converge than the original order. "
    "The paper gives no curves."
)
HERE = (
    "The root mean square of the constraints' strain. flag_33, sheet_on_sphere and rope: what n iterations a substep leave of it, on average, "
    "in a moving cloth. pulled_edge: what n iterations leave, once, of a sheet whose edge was pulled 10 %. Read along a horizontal line: how "
    "many iterations each order needs for the same residual. In motion the paper's bound holds; an edge pulled hard breaks it."
)

SCENES = ["flag_33", "sheet_on_sphere", "rope", "pulled_edge"]
STYLES = {"original": ("black", "o"), "chains": ("tab:blue", "s"), "colours": ("tab:red", "^"), "batches": ("tab:green", "v")}


def draw(rows):
    figure, axes = plt.subplots(1, len(SCENES), figsize=(3.4 * len(SCENES), 3.2))
    for axis, scene in zip(axes, SCENES):
        for form, (colour, marker) in STYLES.items():
            points = [(int(r["iterations"]), float(r["residual"])) for r in rows if r["scene"] == scene and r["form"] == form]
            axis.loglog(*zip(*points), color=colour, marker=marker, markersize=4, label=form)
        axis.set_title(scene)
        axis.set_xlabel("iterations")
        axis.grid(True, which="both", alpha=0.3)
    axes[0].set_ylabel("rms strain")
    axes[0].legend()
    figure.tight_layout()
    return figure
