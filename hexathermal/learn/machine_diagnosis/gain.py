"""What the extended machine gains on runs for validation, never fitted: translation and rotation, axis by axis."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hexathermal.learn.hexapod_data import HexapodRows
from hexathermal.learn.hexapod_model import measured_lengths
from hexathermal.learn.hexapod_scores import PoseScore, pose_scores
from hexathermal.learn.hexapod_stated import in_machine_frame
from hexathermal.learn.machine_diagnosis.noise_levels import coordinates_of
from hexathermal.learn.machine_diagnosis.view import MachineView, machine_view
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray


@dataclass(frozen=True, eq=False)
class MachineGain:
    """Errors of the platform before and after.

    Attributes
    ----------
    total : dict of str to PoseScore
        By `hexathermal.learn.hexapod_scores.QUANTITIES`.
    runs : dict of str to dict of str to PoseScore
    unframed : dict of str to PoseScore
        Of all runs, each without its own mean motion: what is left where the measuring frame differs between runs.
    """

    total: dict[str, PoseScore]
    runs: dict[str, dict[str, PoseScore]]
    unframed: dict[str, PoseScore]


@dataclass(frozen=True, eq=False)
class MachineResidual:
    """What is left in one run.

    Attributes
    ----------
    run, role : str
    time : array, shape (n,) [s]
    before, after : array, shape (n, 6) [m, m, m, rad, rad, rad]
        Measured less predicted coordinates of the platform.
    legs_before, legs_after : array, shape (n, 6) [m]
        The same in leg lengths.
    """

    run: str
    role: str
    time: FloatArray
    before: FloatArray
    after: FloatArray
    legs_before: FloatArray
    legs_after: FloatArray


def leg_residuals(rows: HexapodRows, hexapod: Hexapod) -> tuple[MachineView, FloatArray]:
    """Return rows as a machine sees them, and measured less predicted leg lengths, shape (n, 6) [m].

    Everything that the machine states counts: laws with their terms, plates, exchanged thermometers, joints, payload
    and the drift of the measuring frame.
    """
    own = replace(rows, hexapod=hexapod)
    view = machine_view(own)
    # where the frame's temperature is missing, its drift is not known: left as measured
    known = replace(own, air=np.nan_to_num(view.air), plates=np.nan_to_num(rows.plates))
    return view, measured_lengths(own, in_machine_frame(known)) - view.law_drift


def residuals(rows: HexapodRows, role: str, before: Hexapod, after: Hexapod) -> tuple[MachineResidual, ...]:
    """Return what both machines leave, run by run."""
    pairs = [leg_residuals(rows, machine) for machine in (before, after)]
    poses = [coordinates_of(view, left) for view, left in pairs]
    return tuple(
        MachineResidual(name, role, rows.time[own], poses[0][own], poses[1][own], pairs[0][1][own], pairs[1][1][own])
        for k, name in enumerate(rows.runs)
        if (own := rows.run == k).any()
    )


def gained(rows: HexapodRows, found: tuple[MachineResidual, ...]) -> MachineGain:
    """Return the gain on runs.

    Parameters
    ----------
    rows : HexapodRows
        Of the runs.
    found : tuple of MachineResidual
    """
    view = machine_view(rows)
    total = pose_scores([one.before for one in found], [one.after for one in found])
    runs = {one.run: pose_scores([one.before], [one.after]) for one in found}
    freed = [
        [_unframed(view, rows.run == rows.runs.index(one.run), left) for one, left in pairs]
        for pairs in ([(one, one.legs_before) for one in found], [(one, one.legs_after) for one in found])
    ]
    return MachineGain(total, runs, pose_scores(freed[0], freed[1]))


def _unframed(view: MachineView, own: FloatArray, left: FloatArray) -> FloatArray:
    """Return coordinates' residuals of a run without its mean motion, from leg lengths (n, 6)."""
    return without_motion(view, own, left)[0]


def without_motion(view: MachineView, own: FloatArray, left: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return residuals without the rigid motion of the measuring frame that suits the rows best, shape (n, 6) each.

    Parameters
    ----------
    view : MachineView
    own : array
        Mask or indices of the rows of one run.
    left : array, shape (n, 6) [m]
        Their residuals in leg lengths.

    Returns
    -------
    coordinates : array, shape (n, 6) [m, m, m, rad, rad, rad]
    legs : array, shape (n, 6) [m]
    """
    frame = view.frame[own]
    motion = np.linalg.lstsq(frame.reshape(-1, 6), left.reshape(-1), rcond=None)[0]
    here = replace(view, poses=view.poses[own], time=view.time[own])
    legs = left - frame @ motion
    return coordinates_of(here, legs), legs
