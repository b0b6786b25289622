"""Figures of a diagnosis along runs: what was measured and predicted, and the residual against each signal."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from hexathermal.learn.diagnosis.pieces import LONGEST_S
from hexathermal.learn.diagnosis.result import Diagnosis, Effect, RunResidual
from hexathermal.poses import FloatArray
from hexathermal.show.diagnosis_pictures import LOOK, NARROW_IN
from hexathermal.show.diagnosis_words import changed, signal_words
from hexathermal.show.figures import BLACK, BLUE, GREY, VERMILION

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BINS = 12
"""Means are shown of so many parts of a signal, each with as many windows."""

MOST_DOTS = 700
"""Windows that a panel shows; beyond, every second, third ... one."""

MOST_FAR = 20
"""Windows farthest out that are drawn in any case."""

MINUTES = (0, 1, 5, 15, 30, 60, 120, 240, 480, 960)
"""At the axis of the time since a move, whose scale is that of the square root: most windows come soon after one."""

ROUNDED_S = 0.1
"""Moments of steps are told to this."""

GAP_WINDOWS = 2.5
"""A curve is broken where a step in time is more than so many of the longest windows that are usual in its run."""

FEWEST_USUAL = 3
"""A window's length is usual that so many have."""


def steps_of(found: Diagnosis) -> list[Effect]:
    """Return the steps of the zero that were named and are no terms of the law."""
    steps = [one for one in found.effects if one.cause == "zero-jump" and "step_um" in one.parameters]
    return [one for one in steps if one.joined or one.refused]


def without_steps(found: Diagnosis) -> Diagnosis:
    """Return a diagnosis whose residuals after are free of steps of the zero, which no law can hold."""
    runs = list(found.residuals)
    for one in steps_of(found):
        moment, step = one.parameters["time_s"].value - ROUNDED_S, one.parameters["step_um"].value * 1e-6
        at = next((k for k, run in enumerate(runs) if run.run == one.target), len(runs))
        for k, run in enumerate(runs):
            if run.role != "identification" or (k != at and (k < at or found.law.zero == "run")):
                continue
            later = (run.time >= moment) if k == at else np.ones(len(run.time), dtype=bool)
            runs[k] = replace(run, after=run.after - step * later)
    return replace(found, residuals=tuple(runs))


def _hours(found: Diagnosis, run: RunResidual) -> FloatArray:
    """Return hours since the run began: the times of a campaign with one zero count from its first run."""
    begin = 0.0 if found.law.zero == "run" else float(run.time[0])
    return np.asarray((run.time - begin) / 3600.0)


def _style(found: Diagnosis) -> str:
    """Return the line of the law: dashed where there is another beside it."""
    return "--" if changed(found) else "-"


def run_figure(found: Diagnosis, run: RunResidual, width: float) -> Figure:
    """Return one run: measured and predicted drift above, what is left of it below.

    Parameters
    ----------
    found : Diagnosis
    run : RunResidual
    width : float [in]
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(LOOK):
        figure = Figure(figsize=(width, 4.3 if width > NARROW_IN else 4.6), layout="constrained")
        top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=[1.15, 1.0])
        hours = _hours(found, run)
        top.plot(hours, run.measured * 1e6, ".", color=BLACK, ms=3.0, label="measured")
        style = _style(found)
        _course(top, hours, (run.measured - run.before) * 1e6, color=VERMILION, ls=style, lw=1.3, label="law")
        bottom.axhline(0.0, color=GREY, lw=0.8)
        _course(bottom, hours, run.before * 1e6, color=VERMILION, ls=style, lw=1.1)
        if changed(found):
            _course(top, hours, (run.measured - run.after) * 1e6, color=BLUE, lw=1.3, label="extended law")
            _course(bottom, hours, run.after * 1e6, color=BLUE, lw=1.2)
        top.set_ylabel("drift (µm)")
        bottom.set_ylabel("left over (µm)")
        bottom.set_xlabel("time since the run began (h)")
        figure.legend(loc="outside upper left", ncols=3, handlelength=2.4)
        figure.align_ylabels()
    return figure


def runs_figure(found: Diagnosis, runs: Sequence[RunResidual], width: float) -> Figure:
    """Return the residual of many runs against time, one panel each, all in one scale."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    columns = 3 if width > NARROW_IN else 1
    lines = -(-len(runs) // columns)
    with mpl.rc_context(LOOK):
        figure = Figure(figsize=(width, 0.75 + 1.25 * lines), layout="constrained")
        panels = figure.subplots(lines, columns, sharex=True, sharey=True, squeeze=False)
        for axes, run in zip(panels.ravel(), runs, strict=False):
            hours = _hours(found, run)
            axes.axhline(0.0, color=GREY, lw=0.7)
            _course(axes, hours, run.before * 1e6, color=VERMILION, ls=_style(found), lw=1.0, label="law")
            if changed(found):
                _course(axes, hours, run.after * 1e6, color=BLUE, lw=1.1, label="extended law")
            axes.set_title(run.run)
        for axes in panels.ravel()[len(runs) :]:
            axes.set_visible(False)
        for axes in panels.ravel()[: len(runs)][-columns:]:
            axes.tick_params(labelbottom=True)
        figure.supxlabel("time since the run began (h)", fontsize=9.0)
        for axes in panels[:, 0]:
            axes.set_ylabel("left over (µm)")
        handles, labels = panels[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper left", ncols=2, handlelength=2.4)
    return figure


def gaps(time: FloatArray) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Return the windows before which time passed without one: more than `GAP_WINDOWS` of the longest usual windows.

    At rest a window lasts `LONGEST_S`, in long runs twice, four times ... that; where rows are farther apart, one step.

    Parameters
    ----------
    time : array, shape (w,) [s]
    """
    step = np.diff(time)
    if not len(step):
        return np.array([], dtype=np.int64)
    longest = max(LONGEST_S, float(np.median(step)))
    for length in LONGEST_S * 2.0 ** np.arange(1, 16):
        if np.count_nonzero(np.abs(step - length) < 0.02 * length) >= FEWEST_USUAL:
            longest = max(longest, float(length))
    return np.flatnonzero(step > GAP_WINDOWS * longest).astype(np.int64) + 1


def _course(axes: Axes, hours: FloatArray, values: FloatArray, **look: Any) -> None:
    """Draw a curve with a gap where windows are missing; a window alone between two gaps is a dot."""
    ends = gaps(hours * 3600.0)
    axes.plot(np.insert(hours, ends, np.nan), np.insert(values, ends, np.nan), **look)
    edges = np.concatenate([[0], ends, [len(hours)]])
    alone = edges[:-1][np.diff(edges) == 1]
    if len(alone):
        axes.plot(hours[alone], values[alone], ".", color=look["color"], ms=4.0)


def signal_names(found: Diagnosis) -> list[str]:
    """Return what the residual can be held against: what has no name, time, then what runs have and that varies."""
    names = dict.fromkeys(name for run in found.residuals for name in run.signals)
    varying = [name for name in names if np.ptp(_finite(pooled(found, name)[0])) > 0.0]
    return sorted(["time", *varying], key=lambda name: name != "followed")


def _finite(values: FloatArray) -> FloatArray:
    """Return values that are numbers; a zero where there are none."""
    kept = values[np.isfinite(values)]
    return kept if len(kept) else np.zeros(1)


def known_windows(found: Diagnosis, name: str) -> list[tuple[FloatArray, FloatArray, FloatArray]]:
    """Return a signal and the residual before and after [m] of each run that has it, in windows where all are known."""
    runs = []
    for run in found.residuals:
        if name == "time" or name in run.signals:
            signal = run.time if name == "time" else run.signals[name]
            known = np.isfinite(signal) & np.isfinite(run.before) & np.isfinite(run.after)
            runs.append((signal[known], run.before[known], run.after[known]))
    return runs


def pooled(found: Diagnosis, name: str) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return a signal and the residual before and after [m] in all windows of all runs that have it."""
    signal, before, after = (np.concatenate(columns) for columns in zip(*known_windows(found, name), strict=True))
    return (np.round(signal) if name == "direction" else signal), before, after  # a window may hold a reversal


def binned(signal: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Return means of a signal and of values in parts of equal count, and the share of the variance they hold.

    A signal with few values, as a direction, has one part for each.
    """
    levels = np.unique(signal)
    if len(levels) <= 3:
        part = np.searchsorted(levels, signal)
    else:
        edges = np.unique(np.quantile(signal, np.linspace(0.0, 1.0, BINS + 1)))
        part = np.clip(np.searchsorted(edges, signal, side="right") - 1, 0, max(len(edges) - 2, 0))
    count = np.bincount(part)
    kept = count > 0
    x = np.bincount(part, signal)[kept] / count[kept]
    y = np.bincount(part, values)[kept] / count[kept]
    spread = float(values.var())
    between = float(np.average((y - values.mean()) ** 2, weights=count[kept]))
    return x, y, between / spread if spread > 0.0 else 0.0


def signal_figure(found: Diagnosis, name: str, width: float) -> Figure:
    """Return the residual against one signal, before and, where something joined the law, after."""
    return clouds_figure(found, pooled(found, name), signal_words(name, found), name, width)


def clouds_figure(
    found: Diagnosis, pooled: tuple[FloatArray, FloatArray, FloatArray], words: tuple[str, str, float], name: str,
    width: float,
) -> Figure:  # fmt: skip
    """Return the residual before and after [m] against a signal, whose label, unit and factor are given.

    Parameters
    ----------
    found : Diagnosis
    pooled : tuple of array, shape (n,)
        The signal, and the residual before and after.
    words : tuple
        What the signal is called, the unit that is shown, and its factor.
    name : str
        Of the signal.
    width : float [in]
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    label, unit, factor = words
    signal, before, after = pooled
    both = [("law", before, VERMILION)] + ([("extended law", after, BLUE)] if changed(found) else [])
    with mpl.rc_context(LOOK):
        figure = Figure(figsize=(width, 2.5 if width > NARROW_IN else 2.7), layout="constrained")
        panels = figure.subplots(1, len(both), sharex=True, sharey=True, squeeze=False)[0]
        for axes, (what, values, colour) in zip(panels, both, strict=True):
            _cloud(axes, signal * factor, values * 1e6, colour, name)
            axes.set_title(what)
        panels[0].set_ylabel("left over (µm)")
        scale = f"{unit}, scale of square roots" if name == "since_move" else unit
        figure.supxlabel(f"{label} ({scale})" if scale else label, fontsize=9.0)
    return figure


def _drawn(y: FloatArray) -> npt.NDArray[np.int64]:
    """Return the windows that are drawn: every second, third ... of very many, and all that are far out."""
    step = -(-len(y) // MOST_DOTS)
    far = np.argsort(-np.abs(y - np.median(y)))[: MOST_FAR if step > 1 else 0]
    return np.union1d(np.arange(0, len(y), step), far)


def _root(values: FloatArray) -> FloatArray:
    """Return square roots; of what a margin puts below zero, zero."""
    return np.asarray(np.sqrt(np.maximum(values, 0.0)))


def _cloud(axes: Axes, x: FloatArray, y: FloatArray, colour: str, name: str) -> None:
    """Draw windows as dots, and means of parts over them."""
    sided = name == "direction"
    axes.axhline(0.0, color=GREY, lw=0.8)
    thin = _drawn(y)
    spread: Any = 0.0
    if sided:
        # dots of a direction would stand on one line: each is moved aside by the golden ratio's fractions
        spread = 0.5 * ((0.618034 * np.arange(len(x))) % 1.0 - 0.5)
        still = [0.0] if (x == 0.0).any() else []
        axes.set_xticks([-1.0, *still, 1.0], ["inward", *["not\nyet"] * len(still), "outward"])
        axes.set_xlim(-1.6, 1.6)
    if name == "since_move":
        axes.set_xscale("function", functions=(_root, np.square))
        axes.set_xticks([minute for minute in MINUTES if minute <= 1.05 * float(x.max())])
        axes.set_xlim(0.0, 1.05 * float(x.max()))
    axes.plot((x + spread)[thin], y[thin], "o", color=colour, ms=2.2, mec="none", alpha=0.45)
    middle, mean, _share = binned(x, y)
    axes.plot(middle, mean, ls="none" if sided else "-", color=BLACK, lw=1.2, marker="o", ms=4.5 if sided else 4.0)
