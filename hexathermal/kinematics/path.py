"""Straight-line moves between two poses: whether every pose on the way is allowed, and where it first is not.

A move goes with ``s`` from 0 to 1: the platform's origin along a straight line, the platform about one fixed axis.
Every limit is a function of ``s`` whose second derivative is bounded, so that between two samples ``w`` apart it
stays above the smaller of them less ``bound w^2 / 8``.  With the shift ``a`` of the origin, the angle ``e`` of the
turn, the distance ``r`` of a platform joint from the axis of the turn and ``V = a + e r`` of its speed:

====================================  ==============================================
function of s                         bound of its second derivative
====================================  ==============================================
length ``L``                          ``V^2 / L + e^2 r``
``L cos(angle)`` seen from the base   ``e^2 r``
the same, seen from the platform      ``e^2 |t - b| + 2 e a``
sines of the travel's angles          ``e^2``
====================================  ==============================================
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from hexathermal.errors import ArgumentError
from hexathermal.kinematics.constants import LARGEST_CONDITION, constants
from hexathermal.kinematics.inverse import poses_of
from hexathermal.kinematics.limit_functions import LimitFunctions, limit_functions
from hexathermal.kinematics.limits import (
    Limit,
    Margins,
    Standing,
    clearances,
    decided,
    leg_margins,
    shaped,
    standing,
    travel_coordinates,
    travel_range,
)
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray, PoseLike, as_array, pose_array

TOLERANCE = 1e-9
"""A limit may be passed by this much: metres for strokes, cones (at the platform joint) and travel, radians for turns."""

CLEARANCE_TOLERANCE = 1e-5
"""Legs must stay this far apart between samples [m]."""

SHORTEST_STEP = 1e-9
"""Samples are never closer: the first place that fails is known to this part of the way."""

PATHS_AT_ONCE = 4096
"""Paths that are followed together."""

STEEPEST_TILT = np.radians(75.0)
COARSEST_TURN, FINEST_TURN = 0.25, 0.01
"""Largest turn between samples [rad] where travel limits turns: finer beyond a tilt of 75 deg, near gimbal lock."""


@dataclass(frozen=True, eq=False)
class PathCheck:
    """Whether moves are allowed; arrays of the moves' leading shape.

    Attributes
    ----------
    ok : array, shape (...), bool
        No limit is passed by more than 1e-9 m (cones: at the platform joint; turns: 1e-9 rad) anywhere on the way, no
        singular pose is met, and legs stay apart where asked for: shown also between the samples.
    first : array, shape (...)
        Part ``s`` of the way, 0 to 1, at which the first pose fails, to 1e-9; NaN where `ok`.
    limit : array, shape (...), int
        The `Limit` that fails there; 0 where `ok`.
    leg : array, shape (...), int
        Its leg, 1 to 6; 0 where it is no limit of a leg.
    value, bound : array, shape (...)
        What was found there and the limit it was held against: length [m], lean angle [rad], coordinate from home
        [m or rad], condition number, distance of legs [m]; NaN where `ok`.
    axis : array, shape (...), int
        Coordinate whose travel fails, 0 to 5 for x, y, z, rx, ry, rz; -1 otherwise.
    smallest : Margins
        Smallest margins and largest condition number over the samples up to `first`.
    samples : array, shape (...), int
        Poses that were looked at.
    """

    ok: npt.NDArray[np.bool_]
    first: FloatArray
    limit: npt.NDArray[np.int8]
    leg: npt.NDArray[np.int8]
    value: FloatArray
    bound: FloatArray
    axis: npt.NDArray[np.int8]
    smallest: Margins
    samples: npt.NDArray[np.int64]


def path_poses(start: PoseLike, end: PoseLike, s: npt.ArrayLike) -> FloatArray:
    """Return poses on the straight move from `start` to `end`.

    ``t(s) = t_0 + s (t_1 - t_0)`` and ``R(s) = R_0 exp(s log(R_0^T R_1))``.

    Parameters
    ----------
    start, end : SE3 or array, shape (..., 4, 4) [m]
    s : array, shape (...)
        Part of the way, 0 to 1; broadcasts against the leading shape of the poses.

    Returns
    -------
    array, shape (..., 4, 4) [m]

    Examples
    --------
    >>> import hexathermal as ht
    >>> there = ht.pose_from_coordinates([0, 0, 10, 0, 0, 30])
    >>> ht.coordinates_from_pose(path_poses(np.eye(4), there, 0.5)).round(9).tolist()
    [0.0, 0.0, 5.0, 0.0, 0.0, 15.0]
    """
    one, two = pose_array(start, "start"), pose_array(end, "end")
    where = as_array(s, "s")
    try:
        lead = np.broadcast_shapes(one.shape[:-2], two.shape[:-2], where.shape)
    except ValueError:
        raise ArgumentError(
            f"start {one.shape[:-2]}, end {two.shape[:-2]} and s {where.shape} do not broadcast; add an axis"
        ) from None
    one, two = (np.broadcast_to(pose, (*lead, 4, 4)).reshape(-1, 4, 4) for pose in (one, two))
    return _Moves(one, two).poses(np.arange(len(one)), np.broadcast_to(where, lead).ravel()).reshape((*lead, 4, 4))


class _Moves:
    """Flat moves: starts (P, 4, 4), shifts and turns (P, 3)."""

    def __init__(self, start: FloatArray, end: FloatArray) -> None:
        self.start = start
        self.shift = end[:, :3, 3] - start[:, :3, 3]
        between = np.swapaxes(start[:, :3, :3], 1, 2) @ end[:, :3, :3]
        self.turn = Rotation.from_matrix(between).as_rotvec() if len(start) else np.zeros((0, 3))
        self.end = end

    def poses(self, path: npt.NDArray[np.int64], s: FloatArray) -> FloatArray:
        """Return the poses of moves `path` at the parts `s` of the way; the ends are met exactly."""
        poses = self.start[path].copy()
        if len(path):
            turned = Rotation.from_rotvec(s[:, None] * self.turn[path]).as_matrix()
            poses[:, :3, :3] = poses[:, :3, :3] @ turned
            poses[:, :3, 3] += s[:, None] * self.shift[path]
            poses[s == 1.0] = self.end[path[s == 1.0]]
        return poses


class _Samples(NamedTuple):
    """Poses on the way and what was found there: values (N, m) of all limits, and of the singular test."""

    path: npt.NDArray[np.int64]
    s: FloatArray
    values: FloatArray
    lengths: FloatArray
    smallest_singular: FloatArray
    tilt: FloatArray
    good: npt.NDArray[np.bool_]


class _Search:
    """The search of a batch of moves for the first place that fails."""

    def __init__(self, hexapod: Hexapod, moves: _Moves, collisions: bool) -> None:
        self.hexapod, self.moves, self.collisions = hexapod, moves, collisions
        self.functions: LimitFunctions = limit_functions(hexapod)
        self.travel = travel_range(hexapod)
        self.first = np.full(len(moves.start), np.inf)
        self.made = constants(hexapod)
        self.angle = np.linalg.norm(moves.turn, axis=1)
        self.reach = np.linalg.norm(moves.shift, axis=1)
        axis = np.divide(moves.turn, self.angle[:, None], where=self.angle[:, None] > 0.0, out=np.zeros_like(moves.turn))
        self.arm = np.linalg.norm(np.cross(axis[:, None], hexapod.platform_joints), axis=2)
        self.speed = self.reach[:, None] + self.angle[:, None] * self.arm
        far = [np.linalg.norm(T[:, None, :3, 3] - hexapod.base_joints, axis=2) for T in (moves.start, moves.end)]
        self.far = np.maximum(*far)
        self.seen: list[tuple[_Samples, dict[str, FloatArray], Standing, tuple[FloatArray, npt.NDArray[np.int8]]]] = []
        self.diameter = 1.0

    def look(self, path: npt.NDArray[np.int64], s: FloatArray) -> _Samples:
        """Return samples, and note how far the first failing one of each move is."""
        now = standing(self.hexapod, self.moves.poses(path, s))
        found = leg_margins(self.hexapod, now)
        near, legs = np.full(len(path), np.nan), np.zeros((len(path), 2), dtype=np.int8)
        columns = [self.functions.values(now)]
        tilt = np.zeros(len(path))
        if self.travel is not None:
            x = travel_coordinates(self.hexapod, now.poses)
            columns.append(_travel_values(x, self.travel))
            tilt = np.abs(x[:, 4])
        values = np.nan_to_num(np.concatenate(columns, axis=1), nan=-np.inf, posinf=np.inf, neginf=-np.inf)
        good = (values >= -TOLERANCE).all(axis=1) & (now.side == 1)
        if self.collisions:
            near, legs, self.diameter = clearances(self.hexapod, now.poses)
            good &= near > 0.0
        np.minimum.at(self.first, path[~good], s[~good])
        samples = _Samples(path, s, values, now.lengths, now.singular_values[:, 5], tilt, good)
        self.seen.append((samples, found, now, (near, legs)))
        return samples
