"""Figures of error budgets: stacked contributions, maps over poses, curves over a day."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.predict.budget import AXES, Budget
from hexathermal.predict.budget_map import BudgetMap
from hexathermal.show.figures import BLACK, BLUE, GREEN, GREY, PURPLE, STYLE, VERMILION

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SKY, YELLOW, ORANGE = "#56B4E9", "#F0E442", "#E69F00"
COLOURS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, YELLOW)
HATCHES = ("", "//", "", "\\\\", "", "..", "")
OTHERS = "#C9C9C9"
SHOWN = len(COLOURS)
MAPPED = (("remaining", "Bias that remains"), ("uncertainty", "Standard uncertainty"), ("worst_case", "Worst case"))
MARKED = 40
"""Curves of so few points show each: one between two poses out of reach would not be seen."""
PANELS = (("shift", "µm", slice(0, 3)), ("turn", "µrad", slice(3, 6)))


def contributions_figure(budget: Budget, probability: float = 0.95) -> Figure:
    """Return stacked contributions of each axis: bars as high as the standard uncertainty, split as the variance is.

    The bias that remains stands beside as a mark.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8.4, 4.4), layout="constrained")
        panels = figure.subplots(1, 2)
        names = [item.label for item in budget.contributions[:SHOWN]]
        shares = budget.shares
        for axes, (what, unit, part) in zip(panels, PANELS, strict=True):
            bottom = np.zeros(3)
            place = np.arange(3)
            heights = shares[:, part] * budget.uncertainty[part] * 1e6
            for k, name in enumerate(names):
                axes.bar(place, heights[k], 0.62, bottom, color=COLOURS[k], hatch=HATCHES[k], edgecolor="white",
                         lw=0.4, label=name)  # fmt: skip
                bottom += heights[k]
            if len(heights) > SHOWN:
                rest = heights[SHOWN:].sum(axis=0)
                axes.bar(place, rest, 0.62, bottom, color=OTHERS, label=f"{len(heights) - SHOWN} others")
            bias = np.abs(budget.remaining[part]) * 1e6
            axes.plot(place, bias, "D", color=BLACK, ms=5, label="|bias| that remains")
            axes.set_xticks(place, AXES[part])
            axes.set_ylabel(f"standard uncertainty, bias ({unit})")
            axes.grid(axis="x", visible=False)
            axes.set_title(f"{what.capitalize()} of the point" if what == "shift" else "Turn of the platform")
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside right center")
        figure.suptitle(
            f"Machine {budget.machine or 'without a name'}, {budget.frame} frame: uncertainty split as its variance is",
            fontsize=9.5,
        )
    return figure


def map_figure(found: BudgetMap, values: list[tuple[str, FloatArray]]) -> Figure:
    """Return a map over one or two coordinates: curves, or pictures of bias, uncertainty and worst case.

    Parameters
    ----------
    values : list of (name, values)
        The one or two coordinates of the grid, the first one across; the last changes fastest.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        if len(values) == 1:
            figure = Figure(figsize=(7.2, 5.4), layout="constrained")
            name, along = values[0]
            _curves(figure, found, along, _axis(name))
            return figure
        figure = Figure(figsize=(11.0, 6.4), layout="constrained")
        for row, (what, unit, _part) in zip(figure.subplots(2, 3), PANELS, strict=True):
            for axes, (name, title) in zip(row, MAPPED, strict=True):
                _picture(figure, axes, found, values, (name, what, unit))
                axes.set_title(f"{title}: {what}")
        note = "; grey: out of reach" if found.refused else ""
        figure.suptitle(
            f"Ring: worst pose{note}. Worst case: |bias| + expanded uncertainty ({100 * found.probability:g} %)",
            fontsize=9.0, color=GREY,
        )  # fmt: skip
    return figure


def _picture(
    figure: Figure, axes: Axes, found: BudgetMap, values: list[tuple[str, FloatArray]], shown: tuple[str, str, str]
) -> None:
    """Draw one quantity over two coordinates; `shown`: its name, shift or turn, and the unit."""
    (column_name, columns), (row_name, rows) = values
    name, what, unit = shown
    sizes = found.size(name, what).reshape(len(columns), len(rows)).T * 1e6
    axes.grid(visible=False)
    axes.set_facecolor("#EFEFEF")
    # a coordinate with one value, or with equal ends, is drawn one unit wide
    edges = [along if np.ptp(along) > 0.0 else along[0] + np.arange(len(along)) for along in (columns, rows)]
    low, high = _colours(sizes, found.size("worst_case", what) * 1e6)
    picture = axes.pcolormesh(*edges, sizes, shading="nearest", cmap="cividis", vmin=low, vmax=high)
    figure.colorbar(picture, ax=axes).set_label(unit)
    if np.isfinite(sizes).any():
        worst = found.worst(what).index
        axes.plot(edges[0][worst // len(rows)], edges[1][worst % len(rows)], "o", mfc="none",
                  mec=VERMILION, ms=11, mew=2.0, clip_on=False)  # fmt: skip
    axes.set_xlabel(_axis(column_name))
    axes.set_ylabel(_axis(row_name))


def _colours(sizes: FloatArray, worst: FloatArray) -> tuple[float, float]:
    """Return the range of colours: never less than 2 % of the worst case, so that rounding does not look like a map."""
    if not np.isfinite(sizes).any():
        return 0.0, 1.0
    low, high, least = float(np.nanmin(sizes)), float(np.nanmax(sizes)), 0.02 * float(np.nanmax(worst))
    if high - low >= least and least > 0.0:
        return low, high
    low = max(0.0, 0.5 * (low + high - least))
    return low, low + (least or 1.0)


def _axis(name: str) -> str:
    """Return a coordinate's name with its unit in brackets."""
    return name.replace("_mm", " (mm)").replace("_deg", " (deg)")


def day_figure(found: BudgetMap, time_s: FloatArray) -> Figure:
    """Return temperatures, drift, what remains and the worst case over a day."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.2, 7.0), layout="constrained")
        _curves(figure, found, np.asarray(time_s) / 3600.0, "time (h)", temps=True)
    return figure


def _curves(figure: Figure, found: BudgetMap, along: FloatArray, label: str, temps: bool = False) -> None:
    """Draw drift, bias, uncertainty and worst case along a coordinate; the temperatures above them where asked for."""
    panels: Any = figure.subplots(3 if temps else 2, 1, sharex=True)
    if temps:
        panels[0].plot(along, found.temps, lw=1.0, color=GREY)
        panels[0].plot(along, found.temps.mean(axis=1), color=BLACK)
        panels[0].set_ylabel("temperature (°C)")
        panels[0].set_title("Thermometers (grey) and their mean")
    for axes, (what, unit, _part) in zip(panels[-2:], PANELS, strict=True):
        _four(axes, found, along, what)
        axes.set_ylabel(f"{what} ({unit})")
        axes.set_ylim(bottom=0.0)
        axes.set_title("Shift of the point" if what == "shift" else "Turn of the platform")
    panels[-2].legend(loc="upper center", bbox_to_anchor=(0.5, -0.04), ncols=2)
    panels[-1].set_xlabel(label)
    if np.ptp(along) > 0.0:
        panels[-1].set_xlim(float(along.min()), float(along.max()))
    figure.align_ylabels()


def _four(axes: Axes, found: BudgetMap, along: FloatArray, what: str) -> None:
    """Draw the four curves of one panel."""
    curves = (
        ("uncorrected", VERMILION, "--", "drift without correction"),
        ("worst_case", BLUE, "-", f"worst case ({100 * found.probability:g} %)"),
        ("remaining", GREEN, "-.", "bias that remains"),
        ("uncertainty", PURPLE, ":", "standard uncertainty"),
    )
    for name, colour, style, label in curves:
        marker = "." if len(along) <= MARKED else ""
        axes.plot(along, found.size(name, what) * 1e6, color=colour, ls=style, marker=marker, label=label,
                  clip_on=not marker)  # fmt: skip
