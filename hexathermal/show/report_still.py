"""The still picture of a report's figure: by a figure of the house where the chart names one, else panel by panel."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from hexathermal.show.diagnosis_pictures import LOOK, WIDE_IN
from hexathermal.show.figures import BLACK, GREY
from hexathermal.show.report_chart import Bars, Cells, Chart, Curve, Panel, labelled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PANEL_IN, BAR_IN, MATRIX_IN = 2.2, 0.24, 4.6
"""Heights [in]: of a panel of curves, of a bar that lies, of a matrix or a drawing to scale."""

STYLES: dict[str, dict[str, Any]] = {
    "line": {"ls": "-"},
    "dashed": {"ls": "--"},
    "dashdot": {"ls": "-."},
    "dotted": {"ls": ":"},
    "steps": {"ls": "-", "drawstyle": "steps-post"},
    "dots": {"ls": "", "marker": ".", "ms": 3.0},
    "rings": {"ls": "", "marker": "o", "ms": 4.5, "mfc": "none"},
    "squares": {"ls": "", "marker": "s", "ms": 7.0, "mfc": "none"},
}
"""How matplotlib draws each look of a curve."""

OFFSETS = {"left": -4, "right": 4, "top": 3, "middle": 0, "bottom": -3, "center": 0}
ALIGNED = {"left": "right", "right": "left", "top": "bottom", "middle": "center", "bottom": "top", "center": "center"}
"""Where a name stands from its point [points], and how it is aligned there, by the words of its side."""


def still_figure(chart: Chart) -> Figure:
    """Return the still picture of a chart.

    Parameters
    ----------
    chart : Chart

    Examples
    --------
    >>> panel = Panel("Rise", (Curve("leg 1", [0.0, 1.0], [0.0, 2.0]),), "time", "rise", "h", "K")
    >>> len(still_figure(Chart("rise", "Rise", "Leg 1 rises by 2 K.", "", (panel,))).axes)
    1
    """
    if chart.still is not None:
        return chart.still()
    import matplotlib as mpl
    from matplotlib.figure import Figure

    heights = [_height(panel) for panel in chart.panels]
    with mpl.rc_context(LOOK):
        figure = Figure(figsize=(WIDE_IN, sum(heights) + 0.5), layout="constrained")
        grid = figure.subplots(len(heights), 1, squeeze=False, sharex=chart.shared, height_ratios=heights)
        for axes, panel in zip(grid[:, 0], chart.panels, strict=True):
            _draw(figure, axes, panel)
            if not chart.shared or panel is chart.panels[-1]:
                axes.set_xlabel(labelled(panel.x, panel.x_unit))
        figure.align_ylabels()
    return figure


def _height(panel: Panel) -> float:
    """Return the height of a panel [in]."""
    if panel.across:
        names = max((len(mark.names) for mark in panel.marks if isinstance(mark, Bars)), default=1)
        return 0.7 + BAR_IN * names
    if panel.equal or any(isinstance(mark, Cells) for mark in panel.marks):
        return MATRIX_IN * panel.height
    return PANEL_IN * panel.height


def _draw(figure: Figure, axes: Axes, panel: Panel) -> None:
    """Draw a panel."""
    axes.set_title(panel.title)
    axes.set_ylabel(labelled(panel.y, panel.y_unit))
    for first, last in panel.shaded:
        axes.axvspan(first, last, color="#F3F1EA", lw=0.0, zorder=0)
    other = None
    if panel.right:
        other = axes.twinx()
        other.grid(False)
        other.spines["right"].set_visible(True)
        other.set_ylabel(labelled(panel.right, panel.right_unit))
    bars = [mark for mark in panel.marks if isinstance(mark, Bars)]
    if bars:
        _bars(axes, panel, bars)
    for mark in panel.marks:
        if isinstance(mark, Cells):
            _cells(figure, axes, panel, mark)
        elif isinstance(mark, Curve):
            _curve(other if other is not None and mark.right else axes, mark)
    if panel.line is not None:
        (axes.axvline if panel.across else axes.axhline)(panel.line, color=GREY, lw=1.0, ls=":")
    if panel.log:
        (axes.set_xscale if panel.across else axes.set_yscale)("log")
    if panel.equal:
        axes.set_aspect("equal")
        axes.margins(0.1)  # room for names at the edges
    for limits, set_limits in ((panel.x_range, axes.set_xlim), (panel.y_range, axes.set_ylim)):
        if limits is not None:
            set_limits(*limits)
    _legend(axes, other, panel)


def _legend(axes: Axes, other: Axes | None, panel: Panel) -> None:
    """Name the marks beside the panel, where there is more than one."""
    handles, labels = axes.get_legend_handles_labels()
    if other is not None:
        more = other.get_legend_handles_labels()
        handles, labels = handles + more[0], labels + more[1]
    if len(handles) > 1:
        place = (1.12 if panel.right else 1.01, 0.5)
        axes.legend(handles, labels, loc="center left", bbox_to_anchor=place, fontsize=7.0, markerscale=1.6,
                    ncols=2 if len(handles) > 16 else 1)  # fmt: skip


def _curve(axes: Axes, mark: Curve) -> None:
    """Draw a curve with its interval."""
    style = STYLES[mark.look]
    if mark.low is not None and mark.high is not None:
        if style.get("marker"):
            reach = np.abs(np.stack([mark.y - mark.low, mark.high - mark.y]))
            axes.errorbar(mark.x, mark.y, yerr=reach, fmt="none", ecolor=mark.colour, capsize=3.0)
        else:
            axes.fill_between(mark.x, mark.low, mark.high, color=mark.colour, alpha=0.15, lw=0.0)
    axes.plot(mark.x, mark.y, color=mark.colour, label=mark.name, **style)
    sides = mark.places or ("top right",) * len(mark.labels)
    for name, side, x, y in zip(mark.labels, sides, mark.x, mark.y, strict=False):
        up, right = side.split()
        axes.annotate(name, (x, y), (OFFSETS[right], OFFSETS[up]), textcoords="offset points", fontsize=7.5,
                      color=mark.colour, ha=ALIGNED[right], va=ALIGNED[up])  # fmt: skip


def _bars(axes: Axes, panel: Panel, bars: list[Bars]) -> None:
    """Draw bars beside or upon each other; marks of the same names as diamonds."""
    names = bars[0].names
    place, solid = np.arange(len(names)), [one for one in bars if not one.mark]
    width = 0.62 if panel.stacked or len(solid) < 2 else 0.8 / len(solid)
    base = np.zeros(len(names))
    draw = axes.barh if panel.across else axes.bar
    for k, one in enumerate(solid):
        at = place if panel.stacked else place + width * (k - 0.5 * (len(solid) - 1))
        start = base if panel.stacked else np.zeros(len(names))
        draw(at, one.values, width, start, color=one.colour, label=one.name, edgecolor="#FFFFFF", lw=0.4)
        base = base + (one.values if panel.stacked else 0.0)
    for one in bars:
        if one.mark:
            where = (one.values, place) if panel.across else (place, one.values)
            axes.plot(*where, "D", color=one.colour, ms=4.5, label=one.name)
    if panel.across:
        axes.set_yticks(place, names)
        axes.invert_yaxis()
        axes.grid(axis="y", visible=False)
        return
    axes.set_xticks(place, names, rotation=90 if len(names) > 10 else 0)
    axes.grid(axis="x", visible=False)


def _cells(figure: Figure, axes: Axes, panel: Panel, mark: Cells) -> None:
    """Draw a matrix with its scale of colours."""
    axes.grid(False)
    cmap = "cividis_r" if mark.reversed else "cividis"
    edges = [np.arange(len(names)) if isinstance(names, tuple) else names for names in (mark.columns, mark.rows)]
    shown = axes.pcolormesh(*edges, np.ma.masked_invalid(mark.values), shading="nearest", cmap=cmap, vmin=mark.low,
                            vmax=mark.high, rasterized=mark.values.size > 10_000)  # fmt: skip
    if isinstance(mark.columns, tuple):
        axes.set_xticks(edges[0], mark.columns, rotation=90, fontsize=7.5)
    if isinstance(mark.rows, tuple):
        axes.set_yticks(edges[1], mark.rows, fontsize=7.5)
    bar = figure.colorbar(shown, ax=axes, shrink=0.9)
    bar.set_label(labelled(mark.name, mark.unit), color=BLACK)
