"""Straight-line moves between two poses: whether every pose on the way is allowed, and where it first is not."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError
from hexathermal.kinematics.constants import LARGEST_CONDITION
from hexathermal.kinematics.limits import (
    Limit,
    Margins,
    clearances,
    decided,
    leg_margins,
    reshaped,
    shaped,
    standing,
    travel_coordinates,
)
from hexathermal.kinematics.path_search import TOLERANCE, Moves, Search
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray, PoseLike, as_array, pose_array

MOVES_AT_ONCE = 1024
"""Moves that are followed together."""

SAMPLES = 17
"""Poses of each move that are looked at in any case."""


@dataclass(frozen=True, eq=False)
class PathCheck:
    """Whether moves are allowed; arrays of the moves' leading shape, plain values for a single move.

    Attributes
    ----------
    ok : bool, or array, shape (...)
        Every pose on the way, also between the samples, holds every limit to 1e-9 m (cones: at the platform joint;
        turns: 1e-9 rad), stays on home's side of all singular poses, and keeps the legs apart where asked for (an
        overlap below 0.01 mm between samples may be missed).
    first : float, or array, shape (...)
        Part ``s`` of the way, 0 to 1, of the first pose that fails, to 1e-9; NaN where `ok`.
    limit : Limit, or array, shape (...), int
        The `Limit` that fails there; `Limit.NONE` where `ok`.
    leg : int, or array, shape (...)
        Its leg, 1 to 6; 0 where it is no limit of a leg.
    axis : int, or array, shape (...)
        Coordinate of a failing travel: 0 to 5 for x, y, z, rx, ry, rz; -1 otherwise.
    value, bound : float, or array, shape (...)
        What was found there, and the limit it was held against: length [m], lean [rad], coordinate from home [m or
        rad], condition number (a move that crosses a singular pose shows a large one), distance of legs [m]; NaN where
        `ok`.
    smallest : Margins
        Smallest margins and largest condition number over the samples up to `first`.
    samples : int, or array, shape (...)
        Poses that were looked at.
    """

    ok: Any
    first: Any
    limit: Any
    leg: Any
    axis: Any
    value: Any
    bound: Any
    smallest: Margins
    samples: Any


def _joint_shape(start: FloatArray, end: FloatArray, s: FloatArray) -> tuple[int, ...]:
    """Return the joint leading shape of poses and parts of the way."""
    try:
        return np.broadcast_shapes(start.shape[:-2], end.shape[:-2], s.shape)
    except ValueError:
        raise ArgumentError(
            f"start {start.shape[:-2]}, end {end.shape[:-2]} and s {s.shape} do not broadcast; add an axis"
        ) from None


def path_poses(start: PoseLike, end: PoseLike, s: npt.ArrayLike) -> FloatArray:
    """Return poses on the straight move from `start` to `end`.

    ``t(s) = t_0 + s (t_1 - t_0)`` and ``R(s) = R_0 exp(s log(R_0^T R_1))``: the platform's origin runs along a line,
    the platform turns about one axis, the short way round.

    Parameters
    ----------
    start, end : SE3 or array, shape (..., 4, 4) [m]
    s : array, shape (...)
        Part of the way, 0 to 1; broadcasts against the leading shapes of the poses.

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
    one, two, part = pose_array(start, "start"), pose_array(end, "end"), as_array(s, "s")
    if not ((part >= 0.0) & (part <= 1.0)).all():
        raise ArgumentError(f"s must lie in [0, 1], found {part.min():g} .. {part.max():g}")
    lead = _joint_shape(one, two, part)
    flat = Moves(*(np.broadcast_to(pose, (*lead, 4, 4)).reshape(-1, 4, 4) for pose in (one, two)))
    return flat.poses(np.arange(len(flat)), np.broadcast_to(part, lead).ravel()).reshape((*lead, 4, 4))


def check_path(
    hexapod: Hexapod, start: PoseLike, end: PoseLike, *, samples: int | None = None, collisions: bool = False
) -> PathCheck:
    """Return whether straight moves are allowed all the way, and the first pose, limit and leg where one is not.

    The way is that of `path_poses`.  Between two samples ``w`` apart a limit stays above the smaller of their two
    values less ``B w^2 / 8`` with a bound ``B`` of its second derivative; stretches where that is not enough are halved
    (`hexathermal.kinematics.path_search` lists the bounds).  A singular pose between samples is excluded by the
    smallest singular value, which changes no faster than the Jacobian; where even 1e-9 of the way does not exclude it,
    the move fails there.

    Parameters
    ----------
    hexapod : Hexapod
    start, end : SE3 or array, shape (..., 4, 4) [m]
        Leading shapes broadcast.
    samples : int
        Evenly spaced poses of each move that are looked at in any case, at least 2; default 17.
    collisions : bool
        Also measure the distances between the legs, pose by pose with Pinocchio (about 0.3 ms each).

    Returns
    -------
    PathCheck

    Raises
    ------
    ArgumentError
        Wrong shape, no rigid motion, shapes that do not broadcast, or fewer than 2 samples.

    Examples
    --------
    >>> import hexathermal as ht
    >>> hexapod = ht.load_hexapod("reference")
    >>> up = ht.pose_from_coordinates([0, 0, 200, 0, 0, 0], hexapod=hexapod)
    >>> found = check_path(hexapod, hexapod.home, up)
    >>> found.ok, found.limit.name, round(found.first, 4), round(found.value, 6)
    (False, 'STROKE', 0.6736, 0.85)
    """
    count = SAMPLES if samples is None else samples
    if not isinstance(count, int | np.integer) or count < 2:
        raise ArgumentError(f"samples must be a whole number, at least 2, found {samples!r}")
    one, two = pose_array(start, "start"), pose_array(end, "end")
    lead = _joint_shape(one, two, np.zeros(()))
    one, two = (np.broadcast_to(pose, (*lead, 4, 4)).reshape(-1, 4, 4) for pose in (one, two))
    parts = [
        _checked(hexapod, Moves(one[k : k + MOVES_AT_ONCE], two[k : k + MOVES_AT_ONCE]), int(count), collisions)
        for k in range(0, max(len(one), 1), MOVES_AT_ONCE)
    ]
    joined = {
        item.name: reshaped(np.concatenate([getattr(part, item.name) for part in parts]), lead, item.name)
        for item in fields(PathCheck)
        if item.name != "smallest"
    }
    smallest = {
        item.name: np.concatenate([getattr(part.smallest, item.name) for part in parts]) for item in fields(Margins)
    }
    return PathCheck(smallest=shaped(Margins(**smallest), lead), **joined)


def _checked(hexapod: Hexapod, moves: Moves, samples: int, collisions: bool) -> PathCheck:
    """Return the check of flat moves."""
    search = Search(hexapod, moves, collisions)
    search.run(samples)
    ok = np.isinf(search.first)
    bad = np.flatnonzero(~ok)
    found = np.full((5, len(moves)), np.nan)
    found[:3] = np.array([[Limit.NONE], [0], [-1]])
    found[:, bad] = _causes(search, bad)
    return PathCheck(
        ok=ok, first=np.where(ok, np.nan, search.first),
        limit=found[0].astype(np.int8), leg=found[1].astype(np.int8), axis=found[2].astype(np.int8),
        value=found[3], bound=found[4], smallest=_smallest(search),
        samples=np.bincount(np.concatenate([note.path for note in search.notes]), minlength=len(moves)),
    )  # fmt: skip


def _causes(search: Search, bad: npt.NDArray[np.int64]) -> FloatArray:
    """Return limit, leg, axis, value and bound (5, N) of the moves that fail, at the pose where they first do."""
    hexapod, functions = search.hexapod, search.functions
    now = standing(hexapod, search.moves.poses(bad, search.first[bad]))
    margins = leg_margins(hexapod, now)
    values, _tilt = search.values(now)
    of_legs = len(functions.leg)
    rows = np.empty((5, len(bad)))
    near = clearances(hexapod, now.poses) if search.collisions and len(bad) else None
    for n in range(len(bad)):
        m = int(values[n].argmin()) if values.shape[1] else -1
        if m >= 0 and values[n, m] < -0.5 * TOLERANCE:
            if m >= of_legs:
                axis, upper = (m - of_legs) % 6, (m - of_legs) // 6
                limit = search.travel[axis, upper] if search.travel is not None else np.nan
                rows[:, n] = Limit.TRAVEL, 0, axis, travel_coordinates(hexapod, now.poses[n])[axis], limit
                continue
            kind, leg = Limit(int(functions.kind[m])), int(functions.leg[m])
            value = now.lengths[n, leg]
            if kind != Limit.STROKE:
                value = functions.bound[m] - margins[kind.name.lower()][n, leg]
            rows[:, n] = kind, leg + 1, -1, value, functions.bound[m]
        elif now.side[n] == 1 and near is not None and not near[0][n] > 0.0:
            rows[:, n] = Limit.COLLISION, near[1][n, 0], -1, near[0][n], 0.0
        else:
            rows[:, n] = Limit.SINGULAR, 0, -1, margins["condition_number"][n], LARGEST_CONDITION
    return rows


def _smallest(search: Search) -> Margins:
    """Return the smallest margins over the samples up to the first failing one."""
    count = len(search.moves)
    path = np.concatenate([note.path for note in search.notes])
    s = np.concatenate([note.s for note in search.notes])
    used = s <= search.first[path]
    path = path[used]
    least: dict[str, FloatArray] = {}
    for name in search.notes[0].margins:
        every = np.concatenate([note.margins[name] for note in search.notes])[used]
        sign = -1.0 if name == "condition_number" else 1.0
        least[name] = np.full((count, *every.shape[1:]), np.inf)
        np.minimum.at(least[name], path, sign * every)
        least[name] *= sign
    side = np.ones(count, dtype=np.int8)
    np.minimum.at(side, path, np.concatenate([note.side for note in search.notes])[used])
    if not search.collisions:
        return decided(search.hexapod, least, side, None)
    nearest = np.full(count, np.inf)
    apart = np.concatenate([note.clearance for note in search.notes])[used]
    legs = np.zeros((count, 2), dtype=np.int8)
    order = np.lexsort((-np.nan_to_num(apart, nan=-np.inf), path))
    nearest[path[order]], legs[path[order]] = apart[order], np.concatenate([n.legs for n in search.notes])[used][order]
    return decided(search.hexapod, least, side, (nearest, legs, search.diameter))
