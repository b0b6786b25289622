"""Static figures for reports and the command line, written as PNG, SVG or PDF.

Figures are made with matplotlib's objects alone: no window, no global state, safe in any thread.  Colours are Okabe and
Ito's (the purple darker), which colour-blind readers can tell apart; curves also differ in style and are labelled.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError
from hexathermal.poses import FloatArray
from hexathermal.predict.table_writing import MARK, written_whole
from hexathermal.simulate.day import HOUR_S
from hexathermal.simulate.demonstration import Demonstration, largest

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

VERMILION, BLUE, GREEN, PURPLE, BLACK, GREY = "#D55E00", "#0072B2", "#009E73", "#A6427E", "#1A1A1A", "#6E6E6E"
FORMATS = (".png", ".svg", ".pdf")

GAP_STEPS = 5.0
"""A curve is broken where the step in time is more than so many usual ones."""

STYLE: Any = {
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,
    "grid.color": "#E4E4E4",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.6,
    "legend.frameon": False,
    "svg.fonttype": "none",
}
"""The look of every figure."""


def day_figure(result: Demonstration) -> Figure:
    """Return the figure of a simulated day: temperatures, and the platform's error with and without correction.

    Parameters
    ----------
    result : Demonstration

    Returns
    -------
    Figure
        Three panels over time [h]: temperatures [degC], largest shift [um] and largest turn [urad] of any work pose.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.2, 7.4), layout="constrained")
        heat, shift, turn = figure.subplots(3, 1, sharex=True, height_ratios=[1.25, 1.0, 1.0])
        hours = result.truth.time / HOUR_S
        _temperatures(heat, hours, result)
        without, with_ = largest(result.errors_without), largest(result.errors_with)
        for axes, k, unit, what in ((shift, 0, "µm", "shift"), (turn, 1, "µrad", "turn")):
            _working(axes, result)
            axes.plot(hours, without[k], color=VERMILION, ls="--")
            axes.plot(hours, with_[k], color=BLUE)
            axes.set_ylabel(f"platform {what} ({unit})")
            axes.set_ylim(0.0, 1.08 * float(max(without[k].max(), with_[k].max())))
            _label_curves(axes, hours, (without[k], with_[k]), unit)
        shift.set_title(f"Largest shift of the platform's origin, {len(result.poses)} work poses")
        turn.set_title(f"Largest turn of the platform, {len(result.poses)} work poses")
        turn.set_xlabel("time since the first movement (h)")
        turn.set_xlim(0.0, float(hours[-1]))
        turn.set_xticks(np.arange(0.0, hours[-1] + 0.01, 1.0 if hours[-1] <= 14.0 else 2.0))
        figure.align_ylabels()
    return figure


def working_hours(result: Demonstration) -> tuple[tuple[float, float], ...]:
    """Return from when to when the machine works [h]."""
    hours = result.truth.time / HOUR_S
    edges = np.flatnonzero(np.diff(np.concatenate([[0], result.truth.working.astype(int), [0]])))
    return tuple((float(hours[first]), float(hours[min(last, len(hours) - 1)]))
                 for first, last in zip(edges[::2], edges[1::2], strict=True))  # fmt: skip


def _working(axes: Axes, result: Demonstration) -> None:
    """Shade the times when the machine works."""
    for first, last in working_hours(result):
        axes.axvspan(first, last, color="#F3F1EA", lw=0.0, zorder=0)


def _temperatures(axes: Axes, hours: Any, result: Demonstration) -> None:
    """Draw the temperatures of the parts."""
    truth = result.truth
    _working(axes, result)
    axes.plot(hours, truth.legs, color=BLACK, lw=0.9)
    curves = (
        (truth.legs.mean(axis=1), BLACK, "-", "six legs"),
        (truth.platform, GREEN, "-", "platform plate"),
        (truth.base, PURPLE, "-.", "base plate"),
        (truth.room, GREY, ":", "room"),
    )
    for values, colour, style, _label in curves[1:]:
        axes.plot(hours, values, color=colour, ls=style)
    ends = spaced([float(values[-1]) for values, *_rest in curves], 0.062 * float(np.ptp(truth.legs)))
    for (_values, colour, _style, label), end in zip(curves, ends, strict=True):
        axes.annotate(
            label, (1.0, end), (5, 0), xycoords=("axes fraction", "data"), textcoords="offset points",
            color=colour, va="center", annotation_clip=False,
        )  # fmt: skip
    axes.set_ylabel("temperature (°C)")
    axes.set_title(f"Machine {result.hexapod.name or 'without a name'}: true temperatures (shaded: the machine works)")


def gaps_in(time: FloatArray) -> npt.NDArray[np.intp]:
    """Return the rows before which time passed without one: more than `GAP_STEPS` usual steps.

    Parameters
    ----------
    time : array, shape (n,)

    Examples
    --------
    >>> gaps_in(np.array([0.0, 1.0, 2.0, 9.0, 10.0])).tolist()
    [3]
    """
    step = np.diff(time)
    return np.flatnonzero(step > GAP_STEPS * np.median(step)) + 1 if len(step) else np.array([], dtype=np.intp)


def spaced(values: list[float], gap: float) -> list[float]:
    """Return values moved apart, in their order, until neighbours are `gap` apart."""
    order = np.argsort(values)
    moved = np.array(values)[order]
    for _round in range(200):
        close = np.flatnonzero(np.diff(moved) < gap)
        if not close.size:
            break
        for k in close:
            middle = 0.5 * (moved[k] + moved[k + 1])
            moved[k], moved[k + 1] = middle - 0.5001 * gap, middle + 0.5001 * gap
    out = np.empty(len(values))
    out[order] = moved
    return [float(value) for value in out]


def _label_curves(axes: Axes, hours: Any, curves: tuple[Any, Any], unit: str) -> None:
    """Name both curves in the margin, with their largest values, and mark where these stand."""
    labels = ((0.72, VERMILION, "without\ncorrection"), (0.28, BLUE, "with\ncorrection"))
    for values, (height, colour, label) in zip(curves, labels, strict=True):
        top = int(np.argmax(values))
        axes.plot(hours[top], values[top], "o", color=colour, ms=4.0)
        axes.annotate(
            f"{label}\n\u2264 {values[top]:.2f} {unit}", (1.0, height), (5, 0), xycoords="axes fraction",
            textcoords="offset points", color=colour, va="center", annotation_clip=False,
        )  # fmt: skip


def save_figure(figure: Figure, path: str | Path) -> Path:
    """Write a figure; the name's ending says how: .png (200 dots an inch), .svg or .pdf. Returns the path.

    Raises
    ------
    ArgumentError
        Another ending.
    """
    file = Path(path)
    if file.suffix.lower() not in FORMATS:
        raise ArgumentError(
            f"cannot write a figure as {file.suffix or 'a file without an ending'}; use {', '.join(FORMATS)}"
        )
    with written_whole(file) as part:
        draw(figure, part, file.suffix[1:].lower())
    return file


def laid_out(figure: Figure) -> Figure:
    """Return a figure laid out once: each file of a figure that lays itself out is drawn twice."""
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
        figure.set_layout_engine(None)
    return figure


def draw(figure: Figure, path: Path, kind: str) -> None:
    """Write a figure to a file in a format given by name: png, svg or pdf."""
    figure.savefig(path, format=kind, dpi=200, metadata={"Software" if kind == "png" else "Creator": MARK})
