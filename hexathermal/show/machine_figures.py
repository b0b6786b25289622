"""Figures of what a machine's diagnosis decided: what the residual follows, gain, limits, the planned experiment."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hexathermal.learn.hexapod_data import AXES
from hexathermal.learn.hexapod_scores import PoseScore
from hexathermal.learn.machine_diagnosis.observability import CLOSE
from hexathermal.learn.machine_diagnosis.planning import MachineExperiment
from hexathermal.learn.machine_diagnosis.result import MachineDiagnosis
from hexathermal.poses import FloatArray
from hexathermal.show.diagnosis_figures import lying, plain_log
from hexathermal.show.diagnosis_pictures import LOOK, NARROW_IN
from hexathermal.show.figures import BLACK, BLUE, GREEN, GREY, PURPLE, VERMILION
from hexathermal.show.machine_limits import limits_by_cause
from hexathermal.show.machine_run_figures import LEGS
from hexathermal.show.machine_signals import UM, Pooled
from hexathermal.show.machine_words import framed_out

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHIFTS, TURNS = ("x", "y", "z", "translation"), ("rx", "ry", "rz", "rotation")
LARGEST_DOT = 15.0
"""Diameter of a dot that stands for the whole variance [pt]."""

LONG_AXIS = 60.0
"""Log evidence from which on an axis is logarithmic."""

NUMBERED = 0.095
"""A share from which on its percent are written."""


def follows_figure(all_of: Pooled, before: FloatArray, after: FloatArray | None, width: float) -> Figure:
    """Return which part of each coordinate's and leg's residual follows each signal: area stands for variance.

    Parameters
    ----------
    all_of : Pooled
    before, after : array, shape (signals, 12)
        See `hexathermal.show.machine_signals.shares`.
    width : float [in]
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    wide, count = width > NARROW_IN, len(all_of.signals)
    scale = 1.0 if wide else 0.62
    with mpl.rc_context(LOOK):
        figure = Figure(figsize=(width, 0.9 + 0.31 * count), layout="constrained")
        axes = figure.subplots()
        for k in range(count):
            for j in range(12):
                _ring(axes, j, k, before[k, j], scale, BLUE if after is None else VERMILION, after is None)
                if after is not None:
                    _ring(axes, j, k, after[k, j], scale, BLUE, True)
                if before[k, j] >= NUMBERED and wide:
                    axes.annotate(f"{100.0 * before[k, j]:.0f}", (j, k), (9.0, 0.0), textcoords="offset points",
                                  fontsize=7.0, va="center")  # fmt: skip
        axes.axvline(5.5, color=GREY, lw=0.8)
        axes.set_xticks(range(12), [*AXES, *(name if wide else name.replace("leg ", "L") for name in LEGS)])
        axes.tick_params(axis="x", labelsize=9.0 if wide else 7.0)
        axes.xaxis.tick_top()
        axes.set_yticks(range(count), [one.short if wide else one.shortest for one in all_of.signals])
        axes.tick_params(length=0.0)
        axes.set_xlim(-0.7, 11.7)
        axes.set_ylim(count - 0.4, -0.6)
        for side in axes.spines.values():
            side.set_visible(False)
        _legend_of_dots(figure, after is not None)
    return figure


def _ring(axes: Axes, j: int, k: int, part: float, scale: float, colour: str, filled: bool) -> None:
    """Draw a share as a dot or a ring."""
    if part > 0.004:
        axes.plot(j, k, "o", ms=scale * LARGEST_DOT * float(np.sqrt(part)), color=colour, mew=1.3,
                  mfc=colour if filled else "none")  # fmt: skip


def _legend_of_dots(figure: Figure, changed: bool) -> None:
    """Say what rings and dots are."""
    from matplotlib.lines import Line2D

    marks = [("machine as filed", VERMILION, "none"), ("extended machine", BLUE, BLUE)]
    kept = marks if changed else [("machine as filed", BLUE, BLUE)]
    handles = [
        Line2D([], [], ls="none", marker="o", color=c, mfc=fill, mew=1.3, ms=7.0, label=name) for name, c, fill in kept
    ]
    figure.legend(handles=handles, loc="outside lower left", ncols=2)


def gain_figure(found: MachineDiagnosis, width: float) -> Figure:
    """Return the RMSE of each axis of each run for validation, before and after; of all, where frames differ."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    assert found.gain is not None  # the caller asks
    runs = [*found.gain.runs.items(), ("all", found.gain.total)]
    if framed_out(found):  # frames of runs would be all that is seen
        runs = [("all, no frame", found.gain.unframed)]
    wide = width > NARROW_IN
    with mpl.rc_context(LOOK):
        rows = 5 * len(runs) - 1
        figure = Figure(figsize=(width, 0.9 + 0.155 * rows if wide else 1.7 + 0.31 * rows), layout="constrained")
        panels = figure.subplots(1, 2, sharey=True) if wide else figure.subplots(2, 1)
        for axes, names, unit in zip(panels, (SHIFTS, TURNS), ("µm", "µrad"), strict=True):
            axes.grid(False, axis="y")
            labels: list[tuple[float, str]] = []
            for j, (run, scores) in enumerate(runs):
                for k, name in enumerate(names):
                    _scored(axes, 5 * j + k, scores[name], j == 0 and k == 0)
                    both = "together" if wide else name
                    word = both if k == 3 else f"{SHIFTS[k]}, {TURNS[k]}" if wide else name
                    labels.append((5 * j + k, f"{run}: {word}" if k == 0 else word))
            axes.set_yticks([at for at, _ in labels], [word for _, word in labels], fontsize=7.5)
            axes.tick_params(axis="y", length=0.0)
            axes.set_ylim(rows - 0.3, -0.7)
            axes.set_xlim(left=0.0)
            axes.set_xlabel(f"RMSE on runs never fitted ({unit})")
        handles, words = panels[0].get_legend_handles_labels()
        figure.legend(handles, words, loc="outside upper left", ncols=3 if wide else 2)
    return figure


def _scored(axes: Axes, at: float, one: PoseScore, first: bool) -> None:
    """Draw one score: open diamond before, dot after with its interval."""
    axes.plot([one.before.value * UM, one.after.value * UM], [at, at], color=GREY, lw=0.9, zorder=1)
    axes.plot([one.after.low * UM, one.after.high * UM], [at, at], color=BLUE, lw=3.0, alpha=0.4, zorder=2,
              solid_capstyle="butt", label="95 % interval" if first else None)  # fmt: skip
    axes.plot(one.after.value * UM, at, "o", color=BLUE, ms=4.6, zorder=4, label="extended machine" if first else None)
    axes.plot(one.before.value * UM, at, "D", mfc="none", color=VERMILION, ms=4.6, mew=1.3, zorder=3,
              label="machine as filed" if first else None)  # fmt: skip


def limits_figure(found: MachineDiagnosis, width: float) -> Figure:
    """Return from which size on each cause would be named, on the platform; the span is that of its places."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    shown = limits_by_cause(found.limits)
    wide = width > NARROW_IN
    with mpl.rc_context(LOOK):
        figure = Figure(figsize=(width, 1.0 + 0.24 * len(shown) * (1 if wide else 2)), layout="constrained")
        panels = figure.subplots(1, 2, sharey=True) if wide else figure.subplots(2, 1)
        for axes, what, unit in zip(panels, ("translation", "rotation"), ("µm", "µrad"), strict=True):
            axes.set_xscale("log")
            axes.grid(False, axis="y")
            for k, (_cause, places) in enumerate(shown):
                sizes = np.array([getattr(one, what) for one in places]) * UM
                axes.plot([sizes.min(), sizes.max()], [k, k], color=GREY, lw=3.0, alpha=0.5, solid_capstyle="round")
                axes.plot(sizes, np.full(len(sizes), k), "o", color=BLUE, ms=3.4)
            axes.set_yticks(range(len(shown)), [cause for cause, _places in shown])
            axes.set_ylim(len(shown) - 0.4, -0.6)
            axes.set_xlabel(f"smallest RMS that is named ({unit})")
            plain_log(axes)
            axes.tick_params(axis="x", labelsize=8.0)
    return figure


def plan_figure(plan: MachineExperiment, width: float) -> Figure:
    """Return a planned experiment: commanded coordinates pose by pose, and how much each part is to be warmer."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    number = np.arange(1, len(plan.coordinates) + 1)
    looks = ((VERMILION, "D"), (BLUE, "o"), (BLACK, "^"))
    with mpl.rc_context(LOOK):
        figure = Figure(figsize=(width, 5.0), layout="constrained")
        shift, turn, heat = figure.subplots(3, 1, sharex=True)
        for k, axis in enumerate(AXES):
            colour, mark = looks[k % 3]
            axes = shift if k < 3 else turn
            axes.plot(number, plan.coordinates[:, k], color=colour, lw=0.5, marker=mark, ms=3.4, label=axis,
                      mfc="none" if mark == "D" else colour)  # fmt: skip
        shift.set_ylabel("shift (mm)")
        turn.set_ylabel("turn (°)")
        _rises(heat, plan)
        heat.set_xlabel("pose, in order")
        heat.xaxis.get_major_locator().set_params(integer=True)
        for axes in (shift, turn, heat):
            axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        figure.align_ylabels()
    return figure


def _rises(axes: Axes, plan: MachineExperiment) -> None:
    """Draw how much warmer each part is to be; legs that are alike are one curve."""
    view = plan.view
    number, legs = np.arange(1, len(view) + 1), view.dT.mean(axis=2)
    alike: dict[bytes, list[int]] = {}
    for leg in range(6):
        alike.setdefault(np.round(legs[:, leg], 6).tobytes(), []).append(leg)
    for k, group in enumerate(alike.values()):
        name = "six legs" if len(group) == 6 else f"leg {', '.join(str(leg + 1) for leg in group)}"
        axes.plot(number, legs[:, group[0]], color=VERMILION, lw=2.0 if k == 0 else 1.0, label=name)
    parts = (("platform", view.plates[:, 0], GREEN, "--"), ("base", view.plates[:, 1], PURPLE, "-."),
             ("air", view.air, BLACK, ":"))  # fmt: skip
    for name, values, colour, style in parts:
        if np.isfinite(values).any():
            axes.plot(number, values, color=colour, ls=style, lw=1.4, label=name)
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, -0.5), max(high, 1.0))
    axes.set_ylabel("warmer by (K)")


def promise_figure(plan: MachineExperiment, width: float) -> Figure:
    """Return by how much log evidence the plan tells names apart: without it, with it, and what is asked for."""
    import matplotlib as mpl

    wide = width > NARROW_IN
    with mpl.rc_context(LOOK):
        figure, axes = lying(width, len(plan.promises), 0.34 if wide else 0.5)
        for k, one in enumerate(plan.promises):
            axes.plot([max(one.before, 0.0), max(one.after, 0.0)], [k, k], color=GREY, lw=1.0, zorder=1)
            axes.plot(max(one.before, 0.0), k, "D", mfc="none", color=VERMILION, ms=6.0, mew=1.5, zorder=3,
                      label="these data alone" if k == 0 else None)  # fmt: skip
            axes.plot(max(one.after, 0.0), k, "o", color=BLUE, ms=6.0, zorder=2,
                      label="with the experiment" if k == 0 else None)  # fmt: skip
        axes.axvline(CLOSE, color=BLACK, ls=":", lw=1.2, label=f"told apart from {CLOSE:g}")
        axes.set_yticks(range(len(plan.promises)), [f"{one.true},\nnot {one.rival}" for one in plan.promises],
                        fontsize=7.5 if wide else 6.5)  # fmt: skip
        most = max(CLOSE, *(one.after for one in plan.promises))
        if most > LONG_AXIS:
            axes.set_xscale("symlog", linthresh=1.0)
            axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
        axes.set_xlim(0.0, (1.1 if most <= LONG_AXIS else 2.0) * most)
        axes.set_xlabel("separation (mean log evidence)")
        figure.legend(loc="outside upper left", ncols=3 if wide else 1)
    return figure
