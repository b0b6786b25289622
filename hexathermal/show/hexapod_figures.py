"""Figures of hexapod campaigns: virtual runs, identified laws, what looks alike, errors."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from hexathermal.learn.coverage import TWO_SIDED
from hexathermal.learn.hexapod_identification import HexapodIdentification
from hexathermal.learn.hexapod_observability import Observability
from hexathermal.learn.hexapod_validation import HexapodValidation
from hexathermal.poses import FloatArray, pose_from_coordinates
from hexathermal.predict.pose_errors import pose_errors
from hexathermal.show.figures import BLACK, BLUE, GREEN, GREY, PURPLE, STYLE, VERMILION

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from hexathermal.simulate.machine.machine import VirtualMachine
    from hexathermal.simulate.machine.runs import MachineRun

AXES = ("x", "y", "z", "rx", "ry", "rz")
PANELS = (("shift", "µm", slice(0, 3)), ("turn", "µrad", slice(3, 6)))
COLOURS = (VERMILION, BLUE, BLACK)
MARKS = ("o", "s", "^")


def simulated_run_figure(machine: VirtualMachine, run: MachineRun) -> Figure:
    """Return one run of a virtual machine, drawn from what is written of it: displacements, rises, errors of the pose.

    Parameters
    ----------
    machine : VirtualMachine
    run : MachineRun
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.4, 8.4), layout="constrained")
        motion, heat, shift, turn = figure.subplots(4, 1, sharex=True, height_ratios=[0.7, 1.2, 1.0, 1.0])
        hours = run.time / 3600.0
        motion.plot(hours, run.q * 1e3, ".", color=GREY, ms=2.0)
        motion.set_ylabel("six legs: q (mm)")
        motion.set_title(f"{run.name} ({run.role}): {len(hours)} measured poses")
        rise = run.temperatures - run.temperatures[0]
        legs = rise.shape[1] - 2
        for k in range(legs):
            heat.plot(hours, rise[:, k], color=VERMILION, lw=0.8, label="legs" if k == 0 else None)
        heat.plot(hours, rise[:, -2], color=GREEN, label="platform")
        heat.plot(hours, rise[:, -1], color=PURPLE, ls="-.", label="base")
        heat.plot(hours, run.air - run.air[0], color=GREY, ls=":", label="air")
        heat.set_ylabel("rise (K)")
        heat.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
        poses = (pose_from_coordinates(six, hexapod=machine.hexapod) for six in (run.commanded, run.measured))
        errors = pose_errors(*poses)
        for axes, (what, unit, part) in zip((shift, turn), PANELS, strict=True):
            _components(axes, hours, errors[:, part], tuple(AXES[part]))
            axes.set_ylabel(f"{what} ({unit})")
            axes.set_title(f"Measured less commanded pose: {what}")
        turn.set_xlabel("time (h)")
        figure.align_ylabels()
    return figure


def _components(axes: Axes, hours: Any, values: FloatArray, names: tuple[str, ...]) -> None:
    """Draw three components."""
    for k, name in enumerate(names):
        axes.plot(hours, values[:, k] * 1e6, MARKS[k], color=COLOURS[k], ms=2.2, label=name)
    axes.axhline(0.0, color=GREY, lw=0.6)
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), markerscale=2.0)


def laws_figure(found: HexapodIdentification) -> Figure:
    """Return the coefficients of the laws with 95 % intervals: each leg's own, the common law, laws from elsewhere."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    s, at = len(found.rows.sensors), [found.rows.sensors.index(name) for name in found.sensors]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8.6, 0.7 + 3.1 * len(at)), layout="constrained")
        panels = figure.subplots(len(at), 2, squeeze=False)
        for row, sensor in zip(panels, at, strict=True):
            for symbol, axes in enumerate(row):
                spread = float(found.spread[len(at) * symbol + at.index(sensor)])
                _coefficient(axes, found, s * symbol + sensor, 2 * s, spread)
                axes.set_title(f"{'AB'[symbol]} of {found.rows.sensors[sensor]}: chosen {found.chosen}")
                axes.set_ylabel("µm/m/K")
                axes.set_xticks(range(1, 7), [f"leg {leg}" for leg in range(1, 7)])
        panels[0, 1].legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def _coefficient(axes: Axes, found: HexapodIdentification, first: int, step: int, spread: float) -> None:
    """Draw one coefficient of all legs under every kind of laws; `spread` is that between legs [1/K]."""
    legs = np.arange(1, 7)
    which = first + step * np.arange(6)
    looks = {"leg-specific": (BLUE, "o"), "common": (VERMILION, "-"), "bench": (GREEN, "s")}
    for name, fit in found.fits.items():
        colour, mark = looks.get(name, (PURPLE, "D"))
        value = fit.b[which] * 1e6
        half = TWO_SIDED * np.sqrt(np.diagonal(fit.full_covariance)[which]) * 1e6
        if mark == "-":
            axes.plot(legs, value, color=colour, label=name)
            axes.fill_between(legs, value - half, value + half, color=colour, alpha=0.15, lw=0.0)
            for sign in (-1.0, 1.0) if np.isfinite(spread) else ():
                axes.plot(legs, value + sign * np.hypot(half, 1e6 * TWO_SIDED * spread), color=colour, ls=":", lw=1.0,
                          label="common, legs' spread in it" if sign > 0.0 else None)  # fmt: skip
        else:
            axes.errorbar(
                legs, value, yerr=half if half.any() else None, fmt=mark, color=colour, ms=4.5, capsize=3.0, label=name
            )


def observability_figure(found: Observability) -> Figure:
    """Return what the data tell apart: singular values, and how uncertainty grows since coefficients look alike."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.2, max(4.6, 0.8 + 0.24 * len(found.coefficients))), layout="constrained")
        values, inflation = figure.subplots(1, 2, width_ratios=[1.0, 1.5])
        values.semilogy(np.arange(1, len(found.singular_values) + 1), np.maximum(found.singular_values, 1e-16), "o-",
                        color=BLUE)  # fmt: skip
        values.set_xlabel("direction, best first")
        values.xaxis.get_major_locator().set_params(integer=True)
        values.set_ylabel("singular value of the scaled columns")
        values.set_title(f"Directions: condition number {found.condition:.3g}")
        finite = [one for one in found.coefficients if np.isfinite(one.uncertainty)]
        names = [one.name + ("" if np.isfinite(one.uncertainty) else " (never seen)") for one in found.coefficients]
        shown = [found.coefficients.index(one) for one in finite]
        inflation.barh(shown, [one.uncertainty * 1e6 for one in finite], 0.7, color=BLUE,
                       label="all unknown together")  # fmt: skip
        inflation.barh(shown, [one.alone * 1e6 for one in finite], 0.35, color=VERMILION,
                       label="if all others were known")  # fmt: skip
        inflation.set_yticks(np.arange(len(names)), names)
        inflation.invert_yaxis()
        inflation.grid(axis="y", visible=False)
        inflation.set_xlabel("standard uncertainty (µm/m/K)")
        inflation.set_title("Coefficients: what the measurement's noise leaves")
        inflation.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=2)
    return figure


def validation_figure(found: HexapodValidation, run: str) -> Figure:
    """Return one run of a validation: errors of the platform before and after correction, per axis.

    Parameters
    ----------
    found : HexapodValidation
    run : str
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    here = found.rows.run == found.rows.runs.index(run)
    hours = found.rows.time[here] / 3600.0
    told = "was fitted" if run in found.fitted else "never fitted" if found.fits_known else "for validation"
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.4, 7.2), layout="constrained")
        panels = figure.subplots(3, 2, sharex=True)
        for k, name in enumerate(AXES):
            axes = panels[k % 3, k // 3]
            before, after = found.before[here, k] * 1e6, found.after[here, k] * 1e6
            axes.plot(hours, before, "o", mfc="none", color=VERMILION, ms=3.0, mew=0.8)
            axes.plot(hours, after, ".", color=BLUE, ms=4.0)
            axes.axhline(0.0, color=GREY, lw=0.6)
            axes.set_ylabel(f"{name} ({'µm' if k < 3 else 'µrad'})")
            score = found.runs[run][name]
            axes.set_title(f"{name}: RMS {score.before.value * 1e6:.2f} → {score.after.value * 1e6:.2f}")
        for axes in panels[2]:
            axes.set_xlabel("time (h)")
        panels[0, 1].plot([], [], "o", mfc="none", color=VERMILION, ms=3.0, label="without correction")
        panels[0, 1].plot([], [], ".", color=BLUE, label="with correction")
        handles, labels = panels[0, 1].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=2)
        figure.suptitle(f"{run}: error of the platform, base axes; {told}", fontsize=9.5)
        figure.align_ylabels()
    return figure
