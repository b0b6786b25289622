"""Poses as a drifting measuring frame tells them, and what they are in the machine's frame."""

from __future__ import annotations

import numpy.typing as npt

from hexathermal.errors import ArgumentError
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.measuring_frame import MeasuringFrame
from hexathermal.poses import FloatArray, PoseLike, pose_array
from hexathermal.predict.pose_errors import moved_back, moved_poses


def measured_poses(
    hexapod: Hexapod, pose: PoseLike, dT: npt.ArrayLike, time: npt.ArrayLike | None = None
) -> FloatArray:
    """Return what is measured where the platform stands at poses: moved with the machine's measuring frame.

    ``T_measured = motion(dT) T_base_platform``, turned about the platform's origin at home; without a measuring frame
    the poses themselves. Commands, corrections and predictions do not know the frame.

    Parameters
    ----------
    hexapod : Hexapod
    pose : SE3 or array, shape (..., 4, 4) [m]
    dT : float or array, shape (...) [K]
        Of the frame's recorded temperature, since the zero that measured poses count from.
    time : array, shape (n,) [s], optional
        Of the rows of one run; needed where the frame follows late.

    Returns
    -------
    array, shape (..., 4, 4) [m]

    Examples
    --------
    >>> import dataclasses
    >>> import hexathermal as ht
    >>> from hexathermal.machine.measuring_frame import MeasuringFrame
    >>> room = MeasuringFrame("air_temperature", [1e-6, 0, 0])
    >>> hexapod = dataclasses.replace(ht.load_hexapod("reference"), measuring_frame=room)
    >>> measured_poses(hexapod, hexapod.home, 3.0)[0, 3].item()
    3e-06
    """
    poses, frame = pose_array(pose), hexapod.measuring_frame
    return poses if frame is None else moved_poses(poses, _motion(frame, dT, time), hexapod.home[:3, 3])


def machine_poses(
    hexapod: Hexapod, measured: PoseLike, dT: npt.ArrayLike, time: npt.ArrayLike | None = None
) -> FloatArray:
    """Return measured poses in the machine's frame: what `measured_poses` did is undone.

    Parameters and result as `measured_poses`.
    """
    poses, frame = pose_array(measured), hexapod.measuring_frame
    return poses if frame is None else moved_back(poses, _motion(frame, dT, time), hexapod.home[:3, 3])


def _motion(frame: MeasuringFrame, dT: npt.ArrayLike, time: npt.ArrayLike | None) -> FloatArray:
    """Return the motion of a frame, at once or late."""
    if frame.time_constant == 0.0:
        return frame.motion(dT)
    if time is None:
        raise ArgumentError(
            f"the measuring frame follows {frame.sensor} with a time constant of {frame.time_constant:g} s: give the "
            "time of the rows of one run"
        )
    return frame.motion(frame.followed(dT, time))
