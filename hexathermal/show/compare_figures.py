"""Figures of a comparison: channels over each other, residuals by part, and the factors with their intervals."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from hexathermal.compare.bench_runs import CONTACT_ERROR
from hexathermal.poses import FloatArray
from hexathermal.show.figures import BLACK, BLUE, GREEN, GREY, PURPLE, STYLE, VERMILION, gaps_in

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from hexathermal.compare.bench_runs import RunCurves
    from hexathermal.compare.comparison import Comparison
    from hexathermal.compare.differences import ParameterFound
    from hexathermal.compare.scores import ComparedRun

COLUMNS = 3
SHOWN_ROWS = 1500
"""Rows of a run that are drawn."""

MEANS = 120
"""Residuals are drawn as so many means of rows."""

STANDING_OUT = (VERMILION, BLUE, GREEN, PURPLE, BLACK)
"""Colours of the thermocouples with the largest residuals; all others are grey."""

OTHERS = "#BDBDBD"

FACTORS, FARTHEST = (0.2, 5.0), (0.05, 20.0)
"""The axis of factors goes from here to here at least; what is not named widens it no farther than that."""


def channels_figure(found: Comparison, run: ComparedRun) -> Figure:
    """Return a figure of one run: each thermocouple and the drift, measured and simulated, before and after.

    Parameters
    ----------
    found : Comparison
    run : ComparedRun
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    count = len(found.sensors) + 1
    lines = -(-count // COLUMNS)
    hours = run.time / 3600.0
    thin = slice(None, None, max(1, len(hours) // SHOWN_ROWS))
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 1.0 + 1.45 * lines), layout="constrained")
        axes = figure.subplots(lines, COLUMNS, sharex=True, squeeze=False).ravel()
        for k in range(count):
            drift = k == count - 1
            _pair(axes[k], hours, run, k, thin, bool(found.differences))
            if drift:
                axes[k].set_title("drift (µm)")
            else:
                part, position = found.placed.places[k]
                axes[k].set_title(f"{found.sensors[k]}, {part} {position * 1e3:.0f} mm (K)")
            axes[k].set_xlim(0.0, float(hours[-1]))
        for unused in axes[count:]:
            unused.set_visible(False)
        for bottom in axes[max(0, count - COLUMNS) : count]:
            bottom.set_xlabel("time (h)")
            bottom.tick_params(labelbottom=True)
        handles, labels = axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=3, markerscale=5.0)
        what = f"{run.name} ({run.role}): measured and simulated, from the mean of the first rows on"
        figure.suptitle(what, x=0.01, ha="left", fontweight="bold")
    return figure


def _channel(curves: RunCurves, k: int) -> Any:
    """Return a channel's course in the unit that is drawn."""
    return curves.rises[:, k] if k < curves.rises.shape[1] else curves.drift * 1e6


def _pair(axes: Axes, hours: Any, run: ComparedRun, k: int, thin: slice, changed: bool) -> None:
    """Draw one channel."""
    shown = hours[thin]
    piece = np.searchsorted(piece_starts(hours), np.arange(len(hours))[thin], side="right")
    starts = [0, *(np.flatnonzero(np.diff(piece)) + 1).tolist()]
    axes.plot(shown, _channel(run.measured, k)[thin], ".", color=BLACK, ms=1.2, label="measured")
    _pieces(
        axes, shown, _channel(run.before, k)[thin], starts, color=VERMILION, lw=1.1, ls="--", label="bench as it is"
    )
    if changed:
        _pieces(axes, shown, _channel(run.after, k)[thin], starts, color=BLUE, lw=1.2, label="with what was named")


def piece_starts(hours: FloatArray) -> list[int]:
    """Return the rows with which pieces begin, between which time passes without settled rows; the first is 0.

    Parameters
    ----------
    hours : array, shape (n,) [h]
    """
    return [0, *gaps_in(hours).tolist()]


def _pieces(axes: Axes, hours: Any, values: Any, starts: list[int], **look: Any) -> None:
    """Draw a curve in pieces; one of a single point is a dot."""
    gaps = np.array(starts[1:], dtype=np.int64)
    values = np.asarray(values, dtype=np.float64)
    axes.plot(np.insert(hours, gaps, np.nan), np.insert(values, gaps, np.nan), **look)
    alone = [start for start, end in pairwise([*starts, len(hours)]) if end - start == 1]
    if alone:
        axes.plot(hours[alone], values[alone], ".", color=look["color"], ms=3.0)


def residuals_figure(found: Comparison, run: ComparedRun) -> Figure:
    """Return a figure of one run: simulated less measured, by part, before and after.

    Parameters
    ----------
    found : Comparison
    run : ComparedRun
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    parts = [part for part in ("body", "rod") if part in {part for part, _place in found.placed.places}]
    stages = [("bench as it is", run.before)] + ([("with what was named", run.after)] if found.differences else [])
    hours = run.time / 3600.0
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(4.2 * len(stages) + 1.5, 2.1 * (len(parts) + 1) + 0.5), layout="constrained")
        axes = figure.subplots(len(parts) + 1, len(stages), sharex=True, sharey="row", squeeze=False)
        for line, part in enumerate([*parts, "drift"]):
            looks = _looks(found, part)
            for column, (stage, curves) in enumerate(stages):
                one = axes[line, column]
                one.axhline(0.0, color=GREY, lw=0.6)
                _residuals(one, run, curves, looks)
                one.set_title(f"{part}: {stage}")
            if part != "drift":
                _names_beside(axes[line, -1], found, looks)
        for column in range(len(stages)):
            axes[-1, column].set_xlabel("time (h)")
            axes[-1, column].set_xlim(0.0, float(hours[-1]))
        for line in range(len(parts)):
            axes[line, 0].set_ylabel("simulated − measured (K)")
        axes[-1, 0].set_ylabel("simulated − measured (µm)")
        figure.suptitle(f"{run.name} ({run.role}): residuals by part", x=0.01, ha="left", fontweight="bold")
    return figure


def _looks(found: Comparison, part: str) -> dict[int, str]:
    """Return the colour of each channel of a part, in the order in which they are drawn: those that stand out last.

    These have the largest residuals (RMS) of the bench as it is in all runs, and then of the last stage: the same in
    the figure of each run.
    """
    if part == "drift":
        return {len(found.placed.places): VERMILION}
    own = [k for k, place in enumerate(found.placed.places) if place[0] == part]
    most = len(STANDING_OUT)
    first = _largest(own, [(run.measured, run.before) for run in found.runs])[: most // 2 + 1]
    last = [(run.measured, run.after if found.differences else run.before) for run in found.runs]
    chosen = sorted([*first, *(k for k in _largest(own, last) if k not in first)][:most])
    grey = {k: OTHERS for k in own if k not in chosen}
    return grey | dict(zip(chosen, STANDING_OUT, strict=False))


def _largest(channels: list[int], runs: list[tuple[RunCurves, RunCurves]]) -> list[int]:
    """Return channels by the RMS of their residuals, the largest first; runs are what was measured, and simulated."""

    def square(k: int) -> float:
        rest = np.concatenate([_channel(simulated, k) - _channel(measured, k) for measured, simulated in runs])
        good = rest[np.isfinite(rest)]
        return float(np.mean(good**2)) if len(good) else 0.0

    return sorted(channels, key=square, reverse=True)


def _residuals(axes: Axes, run: ComparedRun, curves: RunCurves, looks: dict[int, str]) -> None:
    """Draw the residuals of some channels as means over some minutes, none across times without settled rows."""
    hours = run.time / 3600.0
    width, rows = max(1, len(hours) // MEANS), piece_starts(hours)
    # the last mean of a piece takes a short rest along
    bins = [np.arange(start, max(start + 1, end - width // 2), width) for start, end in pairwise([*rows, len(hours)])]
    first = np.concatenate(bins)
    starts = np.cumsum([0, *(len(one) for one in bins[:-1])]).tolist()

    def smooth(values: Any) -> Any:
        good = np.isfinite(values)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.add.reduceat(np.where(good, values, 0.0), first) / np.add.reduceat(good.astype(float), first)

    middle = smooth(hours)
    for k, colour in looks.items():
        rest = smooth(_channel(curves, k) - _channel(run.measured, k))
        _pieces(axes, middle, rest, starts, color=colour, lw=0.8 if colour == OTHERS else 1.2)


def _names_beside(axes: Axes, found: Comparison, looks: dict[int, str]) -> None:
    """Name the channels that stand out beside a panel."""
    from matplotlib.lines import Line2D

    named = {found.sensors[k]: colour for k, colour in looks.items() if colour != OTHERS}
    rest = {"others": OTHERS} if len(named) < len(looks) else {}
    lines = [Line2D([], [], color=colour, lw=1.4, label=name) for name, colour in (named | rest).items()]
    axes.legend(handles=lines, loc="upper left", bbox_to_anchor=(1.01, 1.0), handlelength=1.4, borderaxespad=0.1)


def parameters_figure(found: Comparison) -> Figure:
    """Return a figure of all physical numbers, and of what was named besides, with 95 % intervals.

    Factors stand on an axis that holds every one that was named; thermocouples of which the data say something below,
    by the part by which they follow the air.

    Parameters
    ----------
    found : Comparison
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    factors = [one for one in found.parameters if not one.target][::-1]
    sensors = [one for one in found.parameters if one.target and one.speaks][::-1]
    count = [len(factors), len(sensors)] if sensors else [len(factors)]
    with mpl.rc_context(STYLE):
        height = 0.9 + 0.27 * len(factors) + (0.75 + 0.27 * len(sensors) if sensors else 0.0)
        figure = Figure(figsize=(7.4, height), layout="constrained")
        top, *below = figure.subplots(len(count), 1, height_ratios=count, squeeze=False).ravel()
        low, high = factor_axis(factors)
        top.set_xscale("log")
        _rows(top, factors, (low, high))
        top.axvline(1.0, color=GREEN, lw=0.9)
        top.set_xticks(*_factor_ticks(low, high))
        top.minorticks_off()
        top.set_xlabel(
            "factor on the bench's number, 95 % interval\n(green: the bench's own; grey: too small to be named, "
            "everywhere\nwhere no size would be, nowhere where others are named beside it;\norange: named; open: not "
            "needed beside what is named to foretell\nruns left out, or not told apart from it)"
        )
        top.set_title(f"{found.title}: the bench's numbers")
        for axes in below:
            ends = [
                CONTACT_ERROR,
                *(end for one in sensors for end in (one.low, one.high, one.limit_low, one.limit_high)),
            ]
            wide = 0.05 * (max(ends) - min(ends))
            _rows(axes, sensors, (min(ends) - wide, max(ends) + wide))
            axes.axvline(CONTACT_ERROR, color=GREEN, lw=0.9)
            axes.set_xlabel("part by which a thermocouple follows the air, 95 % interval (green: as usual)")
    return figure


def factor_axis(shown: Sequence[ParameterFound]) -> tuple[float, float]:
    """Return the ends of the axis of factors: every named one with its interval, others as far as `FARTHEST`.

    Parameters
    ----------
    shown : sequence of ParameterFound
    """
    ends = [*FACTORS]
    for one in shown:
        ends += [one.low, one.high] if one.named else np.clip([one.low, one.high], *FARTHEST).tolist()
    return min(ends) / 1.1 if min(ends) < FACTORS[0] else FACTORS[0], max(ends) * 1.1 if max(ends) > FACTORS[
        1
    ] else FACTORS[1]


def _factor_ticks(low: float, high: float) -> tuple[list[float], list[str]]:
    """Return ticks of the axis of factors, and their words."""
    decades = range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1)
    steps = (1.0, 2.0, 5.0) if high < 1e4 * low else (1.0,)
    ticks = [step * 10.0**decade for decade in decades for step in steps]
    ticks = [tick for tick in ticks if low * 0.999 <= tick <= high * 1.001]
    return ticks, [f"{tick:.4g}" for tick in ticks]


def _rows(axes: Axes, shown: Sequence[ParameterFound], ends: tuple[float, float]) -> None:
    """Draw numbers with their intervals, a row each, the first at the bottom."""
    low, high = ends
    for k, one in enumerate(shown):
        edges = np.clip([max(one.limit_low, 1e-9) if low > 0.0 else one.limit_low, one.limit_high], low, high)
        if not (one.named and one.limit_low <= one.value <= one.limit_high):  # named by a step, not by its size
            axes.barh(k, edges[1] - edges[0], left=edges[0], height=0.72, color="#ECECEC", zorder=1)
        colour = VERMILION if one.named else BLACK
        axes.plot(np.clip([one.low, one.high], low, high), [k, k], color=colour, lw=2.2 if one.named else 1.0, zorder=3)
        if low <= one.value <= high:
            face = "white" if one.needless else colour
            axes.plot(one.value, k, "o", color=colour, mfc=face, ms=3.0 + 2.0 * one.named + one.needless, zorder=4)
        for arrow, edge, beyond in (("<", low, one.low < low), (">", high, one.high > high)):
            if beyond:
                axes.plot(edge, k, arrow, color=colour, ms=4.0, zorder=3, clip_on=False)
        if one.alike:
            names = ", ".join(name for name, _value in one.alike)
            axes.annotate(f"not separated from {names}", (1.0, k), (5, 0), xycoords=("axes fraction", "data"),
                          textcoords="offset points", va="center", fontsize=7.0, color=PURPLE,
                          annotation_clip=False)  # fmt: skip
    axes.set_yticks(range(len(shown)), [f"{one.name} {one.target}".strip() for one in shown])
    for tick, one in zip(axes.get_yticklabels(), shown, strict=True):
        tick.set_color(VERMILION if one.named else BLACK)
    axes.set_xlim(low, high)
    axes.set_ylim(-0.6, len(shown) - 0.4)
