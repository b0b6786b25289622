"""Figures of a machine's diagnosis along its runs: what is left of six coordinates and six legs, before and after."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from hexathermal.learn.hexapod_data import AXES
from hexathermal.learn.machine_diagnosis.gain import MachineResidual
from hexathermal.poses import FloatArray
from hexathermal.show.diagnosis_pictures import GRID, LOOK, NARROW_IN
from hexathermal.show.diagnosis_run_figures import binned
from hexathermal.show.figures import BLUE, GREY, VERMILION
from hexathermal.show.machine_signals import UM, Pooled, Signal

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LEGS = tuple(f"leg {leg}" for leg in range(1, 7))
NAMES = (*AXES, *LEGS)
"""Of the columns of a residual."""

MOST_DOTS = 300
"""Rows that a panel of all runs shows; beyond, every second, third ... one."""

UNITS = ("µm",) * 3 + ("µrad",) * 3 + ("µm",) * 6
BEFORE: dict[str, Any] = {"marker": "D", "mfc": "none", "color": VERMILION, "ms": 3.6, "mew": 1.1}
AFTER: dict[str, Any] = {"marker": "o", "color": BLUE, "ms": 3.8}
"""Marks of the machine as its file has it, and of the extended machine."""


def run_figure(run: MachineResidual, changed: bool, width: float) -> Figure:
    """Return the residual of the six coordinates of one run against time.

    Parameters
    ----------
    run : MachineResidual
    changed : bool
        Whether there is an extended machine.
    width : float [in]
    """
    import matplotlib as mpl

    with mpl.rc_context(LOOK):
        figure, panels = _six(width, columns=2, height=4.6)
        hours = run.time / 3600.0
        for k in range(6):
            axes = panels[k % 3][k // 3]
            axes.axhline(0.0, color=GREY, lw=0.8)
            axes.plot(
                hours, run.before[:, k] * UM, ls="none", label="machine as filed", **(BEFORE | {"ms": 2.6, "mew": 0.8})
            )
            if changed:
                axes.plot(hours, run.after[:, k] * UM, ls="none", label="extended machine", **(AFTER | {"ms": 2.4}))
            axes.set_ylabel(f"{AXES[k]} ({UNITS[k]})")
        _finished(figure, panels, "time since the run began (h)")
    return figure


def joined_figure(runs: Sequence[MachineResidual], legs: bool, changed: bool, width: float) -> Figure:
    """Return the residual of six coordinates, or of six legs, of all runs, one run behind the other.

    Parameters
    ----------
    runs : sequence of MachineResidual
    legs : bool
        Of the legs, else of the coordinates.
    changed : bool
    width : float [in]
    """
    import matplotlib as mpl

    with mpl.rc_context(LOOK):
        figure, panels = _six(width, columns=2, height=4.6)
        ends = np.cumsum([0, *(len(run.time) for run in runs)])
        before = np.concatenate([run.legs_before if legs else run.before for run in runs]) * UM
        after = np.concatenate([run.legs_after if legs else run.after for run in runs]) * UM
        row = np.arange(0, ends[-1], -(-int(ends[-1]) // MOST_DOTS))
        for k in range(6):
            axes = panels[k % 3][k // 3]
            for j, run in enumerate(runs):
                if run.role == "validation":
                    axes.axvspan(float(ends[j]), float(ends[j + 1]), color=GRID, lw=0.0, zorder=0)
                axes.axvline(float(ends[j + 1]), color=GREY, lw=0.5)
            axes.axhline(0.0, color=GREY, lw=0.8)
            axes.plot(row, before[row, k], ls="none", label="machine as filed", **(BEFORE | {"ms": 1.9, "mew": 0.7}))
            if changed:
                axes.plot(row, after[row, k], ls="none", label="extended machine", **(AFTER | {"ms": 1.7}))
            axes.set_ylabel(f"{LEGS[k] if legs else AXES[k]} ({'µm' if legs else UNITS[k]})")
            axes.set_xlim(0.0, float(ends[-1]))
            axes.set_xticks([0.5 * (a + b) for a, b in pairwise(ends)],
                            [f"{j + 1}" for j in range(len(runs))])  # fmt: skip
            axes.tick_params(axis="x", length=0.0)
        _finished(figure, panels, "run (its rows in order of time)")
    return figure


def signal_figure(all_of: Pooled, signal: Signal, legs: bool, changed: bool, width: float) -> Figure:
    """Return means of a residual in parts of a signal, with twice their standard errors.

    Parameters
    ----------
    all_of : Pooled
    signal : Signal
    legs : bool
        Residuals of the legs, else of the coordinates.
    changed : bool
    width : float [in]
    """
    import matplotlib as mpl

    with mpl.rc_context(LOOK):
        wide = width > NARROW_IN
        figure, panels = _six(width, columns=3 if wide else 2, height=3.6 if wide else 5.0, sharex=not signal.each_leg)
        for k, axes in enumerate(axes for row in panels for axes in row):
            values = signal.values[:, k] if signal.each_leg else signal.values
            column = 6 + k if legs else k
            _means(axes, values, [all_of.before[:, column], *([all_of.after[:, column]] if changed else [])])
            axes.set_title(f"{NAMES[column]} ({UNITS[column]})")
            if signal.name == "direction":
                axes.set_xticks([-1.0, 1.0], ["inward", "outward"])
                axes.set_xlim(-1.7, 1.7)
        _finished(figure, panels, signal.axis)
    return figure


def pose_figure(all_of: Pooled, poses: Sequence[Signal], changed: bool, width: float) -> Figure:
    """Return each coordinate's residual against each commanded coordinate: means of parts, one small panel each.

    Parameters
    ----------
    all_of : Pooled
    poses : sequence of Signal
        Commanded coordinates that vary.
    changed : bool
    width : float [in]
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    wide = width > NARROW_IN
    with mpl.rc_context(LOOK | {"font.size": 8.0 if wide else 6.5, "axes.labelsize": 8.0 if wide else 6.5}):
        figure = Figure(figsize=(width, 5.6 if wide else 4.4))
        panels = figure.subplots(6, len(poses), sharex="col", sharey="row", squeeze=False)
        for j, signal in enumerate(poses):
            for k in range(6):
                axes = panels[k, j]
                _means(axes, signal.values, [all_of.before[:, k], *([all_of.after[:, k]] if changed else [])], 2.0)
                axes.locator_params(axis="both", nbins=3)
                axes.tick_params(length=0.0, labelsize=7.0 if wide else 5.5, pad=1.0)
                if j == 0:
                    axes.set_ylabel(f"{AXES[k]} ({UNITS[k]})", labelpad=2.0)
            panels[5, j].set_xlabel(f"{signal.name} ({signal.unit})", labelpad=2.0)
            panels[5, j].tick_params(axis="x", labelrotation=0.0 if wide else 90.0)
        figure.align_ylabels()
        left = 0.6 if wide else 0.46
        bottom = 0.42 if wide else 0.5
        figure.subplots_adjust(left / width, bottom / figure.get_figheight(), 0.99, 0.94, 0.12, 0.14)
        handles, labels = panels[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="upper left", ncols=2, borderaxespad=0.1)
    return figure


def _six(width: float, columns: int, height: float, sharex: bool = True) -> tuple[Figure, Any]:
    """Return a figure of six panels; call within the style."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, figure.subplots(6 // columns, columns, sharex=sharex, squeeze=False)


def _finished(figure: Figure, panels: Any, words: str) -> None:
    """Set the common axis and the legend."""
    figure.supxlabel(words, fontsize=9.0)
    handles, labels = panels[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper left", ncols=2, markerscale=1.6, handlelength=1.2)
    figure.align_ylabels()


def _means(axes: Axes, signal: FloatArray, residuals: Sequence[FloatArray], size: float = 3.8) -> None:
    """Draw means of parts of a signal with bars of twice their standard error."""
    axes.axhline(0.0, color=GREY, lw=0.8)
    looks = ((BEFORE, "machine as filed"), (AFTER, "extended machine"))
    for values, (look, label) in zip(residuals, looks, strict=False):
        known = np.isfinite(signal) & np.isfinite(values)
        if known.sum() < 2:
            continue
        x, y, _share = binned(signal[known], values[known])
        spread = np.sqrt(np.maximum(binned(signal[known], (values[known]) ** 2)[1] - y**2, 0.0))
        half = 2.0 * spread / np.sqrt(max(known.sum() / len(x), 1.0))
        mark = look | {"ms": size}
        axes.errorbar(x, y, yerr=half, ls="none", elinewidth=0.8, ecolor=look["color"], label=label, **mark)


def scale_words(runs: Sequence[MachineResidual]) -> str:
    """Return which number stands for which run."""
    return ", ".join(f"{k + 1}: {run.run}" for k, run in enumerate(runs))
