"""Inverse kinematics: the six leg lengths of a pose."""

from __future__ import annotations

from typing import Any, NoReturn

import numpy as np
import pinocchio as pin
from numpy import empty, ndarray

from hexathermal.errors import ArgumentError
from hexathermal.kinematics.batches import in_chunks, loops, place, where
from hexathermal.kinematics.constants import constants, reach
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray, PoseLike, as_array, pose_array

_FLOAT = np.dtype(np.float64)


def plain(value: Any) -> bool:
    """Whether the compiled loops can read an array as it is."""
    return type(value) is np.ndarray and value.dtype is _FLOAT and value.flags.carray


def poses_of(pose: PoseLike, what: str = "pose") -> FloatArray:
    """Return poses as a writable, contiguous array ``(..., 4, 4)``; entries are checked later, in the loop."""
    if isinstance(pose, pin.SE3):
        return np.array(pose.homogeneous)
    array = as_array(pose, what)
    if array.ndim < 2 or array.shape[-2:] != (4, 4):
        raise ArgumentError(f"{what} has shape {array.shape}; expected (..., 4, 4), or a pinocchio.SE3")
    return array if plain(array) else np.array(array, dtype=np.float64, order="C")


def inverse_kinematics(hexapod: Hexapod, pose: PoseLike) -> FloatArray:
    """Return the inter-articular length of each leg at a pose.

    ``L_i = |t + R p_i - b_i| = q0_i + q_i`` (paper, eq. 2).

    Lengths outside the stroke are returned as they are; `Hexapod.strokes` and the limits tell.  A pose is refused
    where a leg would be more than 10 times longer than the longest allowed (without a
    stroke: than at home): millimetres were meant.

    Parameters
    ----------
    hexapod : Hexapod
    pose : SE3 or array, shape (..., 4, 4) [m]
        Platform in base, ``T_base_platform``.

    Returns
    -------
    array, shape (..., 6) [m]

    Raises
    ------
    ArgumentError
        Wrong shape, not finite, no rigid motion (``|R^T R - I| > 1e-9``), or far too large.

    Examples
    --------
    >>> import hexathermal as ht
    >>> hexapod = ht.load_hexapod("reference")
    >>> hexapod.inverse_kinematics(hexapod.home).shape
    (6,)
    """
    if type(pose) is ndarray:
        try:
            measure, c = hexapod._prepared["inverse"]
        except KeyError:
            measure, c = hexapod._prepared["inverse"] = (loops().lengths_one, constants(hexapod).machine)
        out = empty(6)
        try:
            if measure(c, pose, out) == 0:
                return out
        except TypeError:  # not one writable 4 x 4 array of doubles: the way for all that follows
            pass
    c = constants(hexapod).machine
    poses = poses_of(pose)
    lead = poses.shape[:-2]
    flat = poses.reshape(-1, 4, 4)
    out = np.empty((flat.shape[0], 6))
    many = loops().lengths_many

    def work(first: int, last: int) -> int:
        bad = many(c, flat[first:last], out[first:last])
        return -1 if bad < 0 else first + int(bad)

    for bad in in_chunks(flat.shape[0], work):
        if bad >= 0:
            refuse_pose(hexapod, flat[bad], place(bad, lead))
    return out.reshape(*lead, 6)


def refuse_pose(hexapod: Hexapod, pose: FloatArray, index: tuple[int, ...] = ()) -> NoReturn:
    """Say what is wrong with a pose that a loop refused."""
    pose_array(pose, f"pose{where(index)}")
    with np.errstate(over="ignore"):
        lengths = np.linalg.norm(hexapod.platform_joints @ pose[:3, :3].T + pose[:3, 3] - hexapod.base_joints, axis=1)
    raise ArgumentError(
        f"pose{where(index)} is far outside the machine: a leg would be {lengths.max():.6g} m long, its reach is "
        f"taken as {reach(hexapod):.6g} m; poses are in metres, were millimetres given?"
    )
