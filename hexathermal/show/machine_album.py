"""The pictures of a machine's diagnosis, each with the words for people who do not see it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from hexathermal.learn.campaign import Campaign
from hexathermal.learn.hexapod_data import AXES
from hexathermal.learn.machine_diagnosis.gain import MachineResidual
from hexathermal.learn.machine_diagnosis.planning import MachineExperiment
from hexathermal.learn.machine_diagnosis.result import MachineDiagnosis
from hexathermal.poses import FloatArray
from hexathermal.show import machine_figures as figures
from hexathermal.show import machine_run_figures as along
from hexathermal.show.diagnosis_album import file_names
from hexathermal.show.diagnosis_figures import ranking_figure
from hexathermal.show.diagnosis_pictures import Picture
from hexathermal.show.machine_limits import limits_by_cause
from hexathermal.show.machine_signals import UM, Pooled, Signal, followed_leg, pooled, shares
from hexathermal.show.machine_words import changed, framed_out

MOST_RUNS = 6
"""Runs that have a picture of their own."""

LEG_SIGNALS = {
    "length": "its displacement",
    "direction": "the direction of its last move",
    "leg-temperature": "its temperature since the zero",
}
"""What each leg's residual is held against, in words."""

PART_SIGNALS = ("platform-temperature", "base-temperature", "air-temperature")


def pictures_of(
    found: MachineDiagnosis, campaign: Campaign, plan: MachineExperiment | None
) -> dict[str, list[Picture]]:
    """Return the pictures by section: runs, all, follows, pose, legs, parts, ranking, gain, limits, plan."""
    every = pooled(campaign, found)
    held = [run for run in every.runs if run.role == "validation"]
    signals = {one.name: one for one in every.signals}
    poses = [signals[axis] for axis in AXES if axis in signals]
    shown = (held or list(every.runs))[:MOST_RUNS]
    return {
        "runs": [_run(found, run, name) for run, name in zip(shown, file_names(run.run for run in shown), strict=True)],
        "all": [_joined(found, every, legs) for legs in (False, True)],
        "follows": [_follows(found, every)] if every.signals else [],
        "pose": [_pose(found, every, poses)] if poses else [],
        "legs": [_signal(found, every, signals[name], True) for name in LEG_SIGNALS if name in signals],
        "parts": [_signal(found, every, signals[name], False) for name in PART_SIGNALS if name in signals],
        "ranking": [_ranking(found)] if found.candidates else [],
        "gain": [_gain(found)] if found.gain is not None and changed(found) else [],
        "limits": [_limits(found)] if limits_by_cause(found.limits) else [],
        "plan": [] if plan is None else [_promise(plan), _plan(plan)],
    }


def _sizes(values: FloatArray) -> tuple[float, float]:
    """Return RMS distance and angle of residuals (n, 6) [um, urad]."""
    square = np.mean(np.square(values * UM), axis=0)
    return float(np.sqrt(square[:3].sum())), float(np.sqrt(square[3:].sum()))


def _left(found: MachineDiagnosis, before: FloatArray, after: FloatArray) -> str:
    """Return what is left, in words."""
    far, turned = _sizes(before)
    words = f"RMS distance and angle: machine as filed {far:.2f} µm, {turned:.2f} µrad"
    if changed(found):
        near, straight = _sizes(after)
        words += f"; extended machine {near:.2f} µm, {straight:.2f} µrad"
    return words + "."


def _frames(found: MachineDiagnosis) -> str:
    """Return what was taken out of the runs that are shown, in words."""
    return " Each run without the motion of the measuring frame that suits it best." if framed_out(found) else ""


def _run(found: MachineDiagnosis, run: MachineResidual, name: str) -> Picture:
    """Return the picture of one run."""
    fitted = "never fitted" if run.role == "validation" else "fitted"
    left = _left(found, run.before, run.after)
    alt = (
        f"Run {run.run}, {fitted}, {len(run.time)} poses in {np.ptp(run.time) / 3600.0:.1f} hours: what is left of "
        f"x, y, z, rx, ry, rz against time. {left}"
    )
    return Picture(name, alt, f"{run.run} ({fitted}), measured less predicted pose. {left}{_frames(found)}",
                   partial(along.run_figure, run, changed(found)))  # fmt: skip


def _joined(found: MachineDiagnosis, every: Pooled, legs: bool) -> Picture:
    """Return the picture of all runs, of coordinates or legs."""
    what = "six legs, by the Jacobian" if legs else "six coordinates"
    held = " Grey: for validation." if any(run.role == "validation" for run in found.residuals) else ""
    caption = f"All runs, {what}. {along.scale_words(every.runs)}.{held}{_frames(found)}"
    sizes = [np.sqrt(np.mean(np.square(one * UM))) for one in _both(every.runs, legs)]
    said = f"RMS of all: {sizes[0]:.2f}" + (f" to {sizes[1]:.2f}" if changed(found) else "")
    alt = f"What is left of {what}, in {len(found.residuals)} runs one behind the other. {said} (µm, µrad)."
    return Picture("all-legs" if legs else "all-coordinates", alt, caption,
                   partial(along.joined_figure, every.runs, legs, changed(found)))  # fmt: skip


def _both(runs: Sequence[MachineResidual], legs: bool) -> tuple[FloatArray, FloatArray]:
    """Return residuals of all runs before and after, shape (n, 6)."""
    before = np.concatenate([run.legs_before if legs else run.before for run in runs])
    return before, np.concatenate([run.legs_after if legs else run.after for run in runs])


def _follows(found: MachineDiagnosis, every: Pooled) -> Picture:
    """Return the picture of what the residual follows."""
    before = shares(every, every.before)
    after = shares(every, every.after) if changed(found) else None
    said = _most(every, before, after)
    caption = (
        "Which part of the variance of each residual (column) follows each signal (row), where chance could hardly "
        f"make it: area, and percent from 10 on. {said}.{_frames(found)}"
    )
    alt = f"Share of 12 residuals that follows {len(every.signals)} signals. {said}."
    return Picture("follows", alt, caption, partial(figures.follows_figure, every, before, after))


def _most(every: Pooled, before: FloatArray, after: FloatArray | None) -> str:
    """Return what is followed most, in words."""
    k, j = np.unravel_index(int(np.argmax(before)), before.shape)
    if not before[k, j] > 0.0:
        return "No residual follows a signal more than chance could make it"
    signal = every.signals[k]
    words = f"commanded {signal.name}" if signal.label == f"commanded {signal.name}" else f"the {signal.short}"
    if signal.each_leg:
        words = words.replace("the leg", f"leg {followed_leg(signal, every.before, int(j)) + 1}")
    said = f"Most: {along.NAMES[j]} follows {words}, {100.0 * before[k, j]:.0f} % of its variance"
    return said if after is None else f"{said}, {100.0 * after[k, j]:.0f} % with the extended machine"


def _pose(found: MachineDiagnosis, every: Pooled, poses: list[Signal]) -> Picture:
    """Return the picture of residuals against the pose."""
    caption = (
        "Each coordinate's residual (row) against each commanded coordinate (column): means of parts of equal count, "
        "bars of twice their standard error."
    )
    alt = f"36 small panels, residual of 6 coordinates against {len(poses)} commanded ones. {caption}"
    return Picture("residual-pose", alt, caption, partial(along.pose_figure, every, poses, changed(found)))


def _signal(found: MachineDiagnosis, every: Pooled, signal: Signal, legs: bool) -> Picture:
    """Return the picture of residuals against one signal."""
    what = "leg" if legs else "coordinate"
    own = LEG_SIGNALS[signal.name] if legs else f"the {signal.label}"
    caption = (
        f"Each {what}'s residual against {own}: means of parts of equal count, bars of twice their standard error."
    )
    first, last = float(np.nanmin(signal.values)), float(np.nanmax(signal.values))
    alt = f"{caption} The signal goes from {first:.2f} to {last:.2f} {signal.unit}."
    return Picture(f"residual-{signal.name}", alt, caption,
                   partial(along.signal_figure, every, signal, legs, changed(found)))  # fmt: skip


def _ranking(found: MachineDiagnosis) -> Picture:
    """Return the picture of the ranking."""
    best = "; ".join(f"{one.cause} {one.target or ''} {one.evidence:.1f}" for one in found.candidates[:4])
    alt = f"Evidence of {len(found.candidates)} candidates; a name needs {found.threshold:.1f}. First: {best}."
    caption = "Evidence of each candidate. What ends left of the dotted line is too weak for a name in this campaign."
    return Picture("ranking", alt, caption, partial(ranking_figure, found))


def _gain(found: MachineDiagnosis) -> Picture:
    """Return the picture of the gain."""
    assert found.gain is not None  # the caller asks
    total = found.gain.unframed if framed_out(found) else found.gain.total
    far, turned = total["translation"], total["rotation"]
    sizes = [f"{one.before.value * UM:.3f} to {one.after.value * UM:.3f}" for one in (far, turned)]
    alt = f"RMSE of each axis: all runs together {sizes[0]} µm and {sizes[1]} µrad."
    each = (
        "on all runs for validation, each without the motion of the measuring frame that suits it best"
        if framed_out(found) else "on each run for validation"
    )  # fmt: skip
    caption = f"RMSE of each axis {each}: open diamond before, dot after with its 95 % interval."
    return Picture("gain", alt, caption, partial(figures.gain_figure, found))


def _limits(found: MachineDiagnosis) -> Picture:
    """Return the picture of the limits of detection."""
    sizes = [one.translation * UM for _cause, places in limits_by_cause(found.limits) for one in places]
    alt = f"Smallest effects that would be named, from {min(sizes):.2g} to {max(sizes):.2g} µm; the table has them."
    caption = (
        "How much a cause must move the platform in these poses to be named (RMS). Each dot is one leg, pair or joint."
    )
    return Picture("limits", alt, caption, partial(figures.limits_figure, found))


def _plan(plan: MachineExperiment) -> Picture:
    """Return the picture of planned poses."""
    different = len(np.unique(np.round(plan.coordinates, 4), axis=0))
    alt = (
        f"{len(plan.coordinates)} commanded poses, {different} different ones, and how much each part is to be warmer. "
        f"{plan.scenarios[0].words}."
    )
    caption = "Poses in the order in which they are measured, from home, and by how much each part is warmer then."
    return Picture("plan", alt, caption, partial(figures.plan_figure, plan))


def _promise(plan: MachineExperiment) -> Picture:
    """Return the picture of what a plan promises."""
    least = plan.promises[0]
    alt = (
        f"Log evidence between names; the least, {least.true} from {least.rival}: {least.before:.1f} to "
        f"{least.after:.1f}."
    )
    caption = (
        "By how much log evidence the true name beats the other on average: with these data alone, and with the plan."
    )
    return Picture("plan-promise", alt, caption, partial(figures.promise_figure, plan))
