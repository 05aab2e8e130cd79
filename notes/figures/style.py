"""The style of all figures. Measured: filled markers, solid lines, bars for the spread. Modelled: hollow markers,
dashed lines.

Colours are Okabe and Ito's, which colour-blind readers can tell apart, and a brown; markers and hatches tell series
apart without colour.
"""

import io

import matplotlib

matplotlib.use("svg")

import matplotlib.pyplot as plt  # noqa: E402, after the backend is chosen
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, MaxNLocator, NullLocator

import page

COLOURS = ["#0072B2", "#D55E00", "#009E73", "#000000", "#CC79A7", "#E69F00", "#56B4E9", "#7A5230"]
MARKERS = ["o", "s", "^", "D", "v", "P", "X", "<"]
HATCHES = ["", "///", "...", "xxx", "\\\\\\", "++", "oo"]
SHARE_COLOURS = ["#0072B2", "#E69F00", "#D55E00", "#000000", "#CC79A7", "#999999", "#009E73"]
PAPER = {"color": "#555555", "marker": "*", "markersize": 11, "linestyle": "none"}
GREY = "#999999"
MARKER_SIZE = 5
CLEAR = {"facecolor": "white", "alpha": 0.8, "linewidth": 0, "pad": 0.6}  # behind text among marks
BOUND = {"color": "#555555", "linewidth": 0.9}
DISTURBED = {"markerfacecolor": "white", "markeredgecolor": GREY}  # a point that never had whole cores
DISTURBED_BAR = {"facecolor": "white", "edgecolor": GREY, "hatch": ""}

matplotlib.rcParams.update(
    {
        "svg.hashsalt": "lockstep",  # the same file from the same numbers
        "svg.fonttype": "none",  # text that can be selected and searched
        "font.size": 9,
        "axes.titlesize": 9,
        "axes.labelsize": 9,
        "xtick.labelsize": 8,
        "ytick.labelsize": 8,
        "legend.fontsize": 8,
        "legend.framealpha": 0.9,
        "axes.grid": True,
        "axes.axisbelow": True,
        "grid.color": "#dddddd",
        "grid.linewidth": 0.6,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "lines.linewidth": 1.3,
        "lines.markersize": MARKER_SIZE,
        "errorbar.capsize": 2.5,
        "hatch.linewidth": 0.6,
    }
)


def panels(rows, columns, width, height, **more):
    """A figure of panels, each width by height inches; all axes in rows of a list."""
    figure, axes = plt.subplots(
        rows, columns, figsize=(width * columns, height * rows), squeeze=False, layout="constrained", **more
    )
    return figure, axes


def measured(axis, x, y, series, spreads=None, whole=None, **more):
    """`spreads`: the interquartile range over the median, a point; None where not known. `whole`: whether a point was
    timed on whole cores; others become hollow and grey."""
    reach = [s * v / 2 if s is not None else 0 for s, v in zip(spreads, y)] if spreads else None
    axis.errorbar(x, y, yerr=reach, color=COLOURS[series], marker=MARKERS[series], linestyle="-", zorder=3, **more)
    disturbed = [(a, b) for a, b, w in zip(x, y, whole or []) if not w]
    if disturbed:
        axis.plot(*zip(*disturbed), marker=MARKERS[series], linestyle="none", zorder=4, **DISTURBED)


def arrows_up(axis, x, y, series):
    """From points that are lower bounds."""
    for place in zip(x, y):
        axis.annotate(
            "",
            place,
            xytext=(0, 16),
            textcoords="offset points",
            arrowprops={"arrowstyle": "<-", "color": COLOURS[series]},
        )


def modelled(axis, x, y, series, **more):
    axis.plot(
        x,
        y,
        color=COLOURS[series],
        marker=MARKERS[series],
        linestyle="--",
        markerfacecolor="white",
        markersize=6.5,
        **more
    )


def line(axis, rows, kind, column, series):
    """Rows of one kind over cores."""
    own = [r for r in rows if r["kind"] == kind and r.get(column) is not None]
    x, y = [r["cores"] for r in own], [r[column] for r in own]
    if kind == "measured":
        spreads = [r.get("spread" if column == "ms" else column + "_spread") for r in own]
        measured(axis, x, y, series, spreads, [r.get("whole_cores", True) for r in own])
    else:
        modelled(axis, x, y, series)


def limit_to(axis, values, factor=1.6):
    """A logarithmic axis around the values, so that long error bars do not stretch it."""
    axis.set_ylim(min(values) / factor, max(values) * factor)


def cores_axis(axis, cores):
    power_axis(axis, cores, "cores (threads)")


def power_axis(axis, values, label):
    axis.set_xscale("log", base=2)
    axis.xaxis.set_major_locator(FixedLocator(sorted(set(values))))
    axis.xaxis.set_major_formatter(FuncFormatter(page.plain))
    axis.xaxis.set_minor_locator(NullLocator())
    axis.set_xlabel(label)


def log_y(axis, label, base=10):
    axis.set_yscale("log", base=base)
    if base == 10:
        axis.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.yaxis.set_major_formatter(FuncFormatter(page.plain))
    axis.yaxis.set_minor_locator(NullLocator())
    axis.set_ylabel(label)


def log_x(axis, label, subs=(1,)):
    axis.set_xscale("log")
    axis.xaxis.set_major_locator(LogLocator(subs=subs))
    axis.xaxis.set_major_formatter(FuncFormatter(page.plain))
    axis.xaxis.set_minor_locator(NullLocator())
    axis.set_xlabel(label)


def few_ticks(values):
    """Where a decade has ticks: the fewer decades, the more."""
    values = [v for v in values if v > 0]
    return (1, 2, 5) if max(values) < 300 * min(values) else (1,)


def ideal(axis, cores, share=1):
    """Every core in full use, or a share of it."""
    axis.plot(cores, [share * c for c in cores], linestyle=":", **BOUND)


def beside(axis, text, x, y):
    """Text at the end of a bar."""
    axis.annotate(text, (x, y), xytext=(4, 0), textcoords="offset points", va="center", fontsize=7.5, bbox=CLEAR)


def series_key(series, label):
    return Line2D([], [], color=COLOURS[series], marker=MARKERS[series], label=label)


def kinds_key():
    """The legend's entries for measured and modelled."""
    return [
        Line2D([], [], color="#555555", marker="o", linestyle="-", label="measured"),
        Line2D([], [], color="#555555", marker="o", linestyle="--", markerfacecolor="white", label="modelled"),
    ]


def disturbed_key(rows):
    """The legend's entry for points that never had whole cores, if there are any."""
    some = any(r.get("whole_cores") is False for r in rows)
    return (
        [Line2D([], [], marker="o", linestyle="none", label="measured without whole cores", **DISTURBED)]
        if some
        else []
    )


def ideal_key(label="all cores in full use"):
    return Line2D([], [], linestyle=":", label=label, **BOUND)


def band_key(label):
    return Patch(color="#555555", alpha=0.35, label=label)


def serial_key():
    return Line2D([], [], color="#555555", marker="x", linestyle="none", label="serial")


def paper_key():
    return Line2D([], [], label="paper (simulated)", **PAPER)


def key_below(figure, handles, columns=None):
    """One legend for the whole figure, under it; svg_of() makes room for it."""
    figure.legend(
        handles=handles, loc="upper center", bbox_to_anchor=(0.5, 0), ncols=columns or len(handles), frameon=False
    )


def settle(figure):
    """Gives all axes their places, for good: what follows may ask where things are."""
    figure.draw_without_rendering()
    figure.set_layout_engine("none")


def svg_of(figure):
    svg = io.StringIO()
    figure.savefig(svg, format="svg", metadata={"Date": None}, bbox_inches="tight")
    plt.close(figure)
    return svg.getvalue()


def stacked_shares(axis, names, rows, shares):
    """One bar a row, divided into the shares of the cores' time."""
    left = [0] * len(rows)
    for number, (share, words) in enumerate(shares.items()):
        widths = [100 * r[share] for r in rows]
        look = {"color": SHARE_COLOURS[number], "hatch": HATCHES[number], "edgecolor": "white", "linewidth": 0.5}
        axis.barh(range(len(rows)), widths, left=left, height=0.65, label=words, **look)
        left = [a + b for a, b in zip(left, widths)]
    axis.set_yticks(range(len(rows)), names)
    axis.invert_yaxis()
    axis.set_xlim(0, 100)
    axis.set_xlabel("share of the cores' time, %")
    axis.grid(False)
    axis.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2, frameon=False, fontsize=7.5)
