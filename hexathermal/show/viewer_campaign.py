"""A measured campaign of a whole hexapod for the viewer: what was measured, and what the machine's law leaves of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.thermal import frozen
from hexathermal.poses import FloatArray
from hexathermal.predict.temperatures import active_model
from hexathermal.show.viewer_course import FRAMES, Course, Progress, budget_regions, clock, evenly, tool_errors

if TYPE_CHECKING:
    from hexathermal.learn.campaign import Campaign
    from hexathermal.learn.hexapod_data import HexapodRows

OF_VERDICTS = ("intervals rest", "over-correction", "under-correction")
"""Beginnings of notes that belong to a verdict, which is not shown."""


def campaign_course(hexapod: Hexapod, campaign: Campaign, tool: FloatArray, progress: Progress) -> Course:
    """Return the runs of a campaign, one after the other.

    Without correction the platform stands where it was measured; with it, off by what the law does not explain:
    measured minus predicted pose, as `hexathermal.learn.hexapod_validation` tells them.

    Parameters
    ----------
    hexapod : Hexapod
        With a thermal law.
    campaign : Campaign
    tool : array, shape (3,) [m]
    progress : callable

    Raises
    ------
    ArgumentError
        The campaign is of another kind, or the machine has no law, or there are no usable rows.
    UnknownNameError
        The campaign lacks a thermometer of the law.
    """
    from hexathermal.kinematics.forward import forward_kinematics
    from hexathermal.learn.hexapod_validation import law_temperatures, validate_hexapod
    from hexathermal.predict.pose_errors import moved_poses

    refuse_other_kind(campaign)
    progress(0, 0, "reading the campaign (the first run compiles)")
    roles = [role for role in ("identification", "validation") if campaign.runs_of(role)]
    found = [(role, validate_hexapod(hexapod, campaign, role)) for role in roles]
    total = sum(len(one.rows) for _role, one in found)
    parts, labels, notes, first = [], [], [], 0
    for role, one in found:
        rows = one.rows
        kept = np.unique(np.concatenate([_of_run(rows, run, total) for run in np.unique(rows.run)]))
        told = forward_kinematics(hexapod, rows.retracted + rows.q[kept])
        errors = []
        for error in (one.before[kept], one.after[kept]):
            moved = [moved_poses(wanted, own, wanted[:3, 3]) for wanted, own in zip(told, error, strict=True)]
            errors.append(tool_errors(told, np.stack(moved), tool))
        temps = law_temperatures(rows, active_model(hexapod))[kept]
        parts.append((told, np.stack(errors), _legs(rows)[kept], temps, rows.run[kept] + first))
        labels += [f"{rows.runs[rows.run[k]]} ({role}), {clock(rows.time[k])}" for k in kept]
        notes += [note for note in one.notes if note not in notes and not note.startswith(OF_VERDICTS)]
        first += len(rows.runs)
    ideal, both, legs, temps, group = (
        np.concatenate([part[k] for part in parts], axis=1 if k == 1 else 0) for k in range(5)
    )
    centres, regions, more = budget_regions(hexapod, ideal, temps, tool, progress)
    if len(labels) < total:
        notes.append(f"{len(labels)} of {total} usable rows are shown, evenly")
    if campaign.zero == "run" and first > 1:
        notes.append("temperatures of the legs: rise since each run's zero, on the mean of the runs' zeros")
    notes.insert(0, "the wanted pose is that of the scales; poses are measured, with the noise of what measured them")
    return Course(
        hexapod, f"campaign {campaign.title or campaign.folder.name}", tuple(labels), group.astype(np.int64),
        frozen(ideal), frozen(both), frozen(legs), frozen(centres), frozen(regions), frozen(tool), False,
        ("measured, nothing corrected", "measured, less what the law predicts"), (*notes, *more),
    )  # fmt: skip


def refuse_other_kind(campaign: Campaign) -> None:
    """Refuse a campaign that measured no poses."""
    if campaign.kind != "hexapod":
        raise ArgumentError(
            f"{campaign.folder} is a campaign of kind {campaign.kind!r}: it measures no poses, and there is no machine "
            "to draw; expected kind 'hexapod'"
        )


def _of_run(rows: HexapodRows, run: int, total: int) -> npt.NDArray[np.int64]:
    """Return the rows of a run that are shown: its share of all frames, three at least."""
    own = np.flatnonzero(rows.run == run)
    return np.asarray(own[evenly(len(own), max(3, FRAMES * len(own) // total))])


def _legs(rows: HexapodRows) -> FloatArray:
    """Return the mean temperature of each leg's thermometers, shape (n, 6) [degC], as it was."""
    from hexathermal.learn.hexapod_data import heat_of_legs

    return np.asarray((rows.heat + heat_of_legs(rows.hexapod, rows.zero_degC)).mean(axis=2))
