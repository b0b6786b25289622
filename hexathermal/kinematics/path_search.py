"""The search for the first pose of a straight move that breaks a limit, with nothing missed between two samples.

A move goes with ``s`` from 0 to 1: the platform's origin along a straight line, the platform about one fixed axis.
Every limit is a function of ``s`` whose second derivative is bounded, so that between two samples ``w`` apart it
stays above the smaller of them less ``bound w^2 / 8``.  With the shift ``a`` of the origin, the angle ``e`` of the
turn, the distance ``r`` of a platform joint from the axis of the turn and its speed ``V = a + e r``:

=========================================  ===================
function of s                              bound
=========================================  ===================
length ``L``                               V^2 / L + e^2 r
``L cos(lean)`` at the base                e^2 r
``L cos(lean)`` at the platform            e^2 |t - b| + 2 e a
sines of the turns of the maker's travel   e^2
=========================================  ===================

The smallest singular value of the dimensionless Jacobian and the distance of two legs have no such curvature bound;
they change by no more than the matrix does (Weyl), and by ``2 max(V)``, for a unit of ``s``.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from hexathermal.kinematics.constants import constants
from hexathermal.kinematics.limit_functions import limit_functions
from hexathermal.kinematics.limits import (
    Limit,
    Standing,
    clearances,
    leg_margins,
    standing,
    travel_coordinates,
    travel_range,
)
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray

TOLERANCE = 1e-9
"""Limits are held to this: metres for strokes, travel, and cones (at the platform joint); radians for turns."""

CLEARANCE_TOLERANCE = 1e-5
"""Legs that are apart at the samples overlap by no more than this between them [m]."""

SHORTEST_STEP = 1e-9
"""Samples are never closer: the first place that fails is known to this part of the way."""

STEEPEST_TILT = np.radians(75.0)
COARSEST_TURN, FINEST_TURN = 0.25, 0.01
"""Largest turn between samples [rad] where the maker limits turns; the finer one beyond a tilt ``ry`` of 75 degrees."""

Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]


class Moves:
    """Flat moves: starts and ends (P, 4, 4), shifts of the origin and turns (P, 3), the latter in platform axes."""

    def __init__(self, start: FloatArray, end: FloatArray) -> None:
        from scipy.spatial.transform import Rotation

        self.start, self.end = start, end
        self.shift = end[:, :3, 3] - start[:, :3, 3]
        between = np.swapaxes(start[:, :3, :3], 1, 2) @ end[:, :3, :3]
        self.turn = Rotation.from_matrix(between).as_rotvec() if len(start) else np.zeros((0, 3))

    def __len__(self) -> int:
        return len(self.start)

    def poses(self, path: Ints, s: FloatArray) -> FloatArray:
        """Return the poses of the moves `path` at the parts `s` of their way; the ends are met exactly."""
        from scipy.spatial.transform import Rotation

        poses = self.start[path]
        if len(path):
            turned = Rotation.from_rotvec(s[:, None] * self.turn[path]).as_matrix()
            poses[:, :3, :3] = poses[:, :3, :3] @ turned
            poses[:, :3, 3] += s[:, None] * self.shift[path]
            at_end = s == 1.0
            poses[at_end] = self.end[path[at_end]]
        return poses


class Samples(NamedTuple):
    """Poses on the way (N,), and the value of every limit there (N, m), allowed where it is not negative."""

    path: Ints
    s: FloatArray
    values: FloatArray
    lengths: FloatArray
    smallest_singular: FloatArray
    clearance: FloatArray
    tilt: FloatArray
    good: Bools

    def take(self, which: Ints | Bools) -> Samples:
        """Return some of them."""
        arrays: tuple[Any, ...] = self
        return Samples(*(array[which] for array in arrays))


class Note(NamedTuple):
    """What is kept of samples: the margins of `Margins`, sides, and nearest legs."""

    path: Ints
    s: FloatArray
    margins: dict[str, FloatArray]
    side: npt.NDArray[np.int8]
    clearance: FloatArray
    legs: npt.NDArray[np.int8]


class Search:
    """The search over a batch of moves; `first` (P,) is infinity where nothing fails."""

    def __init__(self, hexapod: Hexapod, moves: Moves, collisions: bool) -> None:
        self.hexapod, self.moves, self.collisions = hexapod, moves, collisions
        self.functions, self.travel = limit_functions(hexapod), travel_range(hexapod)
        self.first = np.full(len(moves), np.inf)
        self.notes: list[Note] = []
        self.diameter = 1.0
        self.angle = np.linalg.norm(moves.turn, axis=1)
        self.shift = np.linalg.norm(moves.shift, axis=1)
        axis = moves.turn / np.where(self.angle > 0.0, self.angle, 1.0)[:, None]
        self.arm = np.linalg.norm(np.cross(axis[:, None], hexapod.platform_joints), axis=2)
        self.speed = self.shift[:, None] + self.angle[:, None] * self.arm
        ends = (np.linalg.norm(T[:, None, :3, 3] - hexapod.base_joints, axis=2) for T in (moves.start, moves.end))
        self.far = np.maximum(*ends)

    def run(self, samples: int) -> None:
        """Look at evenly spaced poses, then halve every stretch that is not yet shown to be allowed."""
        count = len(self.moves)
        path = np.repeat(np.arange(count), samples)
        found = self.look(path, np.tile(np.linspace(0.0, 1.0, samples), count))
        begins = np.arange(count * samples).reshape(count, samples)
        a, b = found.take(begins[:, :-1].ravel()), found.take(begins[:, 1:].ravel())
        while True:
            open_ = (a.s < self.first[a.path]) & ~self.shown(a, b)
            a, b = a.take(open_), b.take(open_)
            ends = b.s - a.s <= SHORTEST_STEP
            # what cannot be shown even here is a singular pose, or one too near to tell
            np.minimum.at(self.first, a.path[ends], b.s[ends])
            a, b = a.take(~ends), b.take(~ends)
            if not len(a.path):
                return
            middle = self.look(a.path, 0.5 * (a.s + b.s))
            a, b = _both(a, middle), _both(middle, b)

    def look(self, path: Ints, s: FloatArray) -> Samples:
        """Return samples, and note how far the first failing one of each move is."""
        now = standing(self.hexapod, self.moves.poses(path, s))
        values, tilt = self.values(now)
        near, legs = np.full(len(path), np.inf), np.zeros((len(path), 2), dtype=np.int8)
        if self.collisions:
            near, legs, self.diameter = clearances(self.hexapod, now.poses)
        good = (values >= -0.5 * TOLERANCE).all(axis=1) & (now.side == 1) & (near > 0.0)
        np.minimum.at(self.first, path[~good], s[~good])
        self.notes.append(Note(path, s, leg_margins(self.hexapod, now), now.side, near, legs))
        return Samples(path, s, values, now.lengths, now.singular_values[:, 5], near, tilt, good)

    def values(self, now: Standing) -> tuple[FloatArray, FloatArray]:
        """Return the values of all limits (N, m), those of the travel last (12), and the tilt ``|ry|`` (N,)."""
        values, tilt = self.functions.values(now), np.zeros(len(now.poses))
        if self.travel is not None:
            x = travel_coordinates(self.hexapod, now.poses)
            values = np.concatenate([values, _travel_values(x, self.travel)], axis=1)
            tilt = np.abs(x[:, 4])
        return np.where(np.isnan(values), -np.inf, values), tilt

    def shown(self, a: Samples, b: Samples) -> Bools:
        """Return which stretches are shown to be allowed from end to end."""
        w, path = b.s - a.s, a.path
        shortest = np.minimum(a.lengths, b.lengths) - 0.5 * self.speed[path] * w[:, None]
        rate = np.where(shortest > 0.0, self.speed[path] / np.where(shortest > 0.0, shortest, 1.0), np.inf)
        least = np.minimum(a.values, b.values) - self._bends(path, rate) * (w**2 / 8.0)[:, None]
        shown = a.good & b.good & (least >= -TOLERANCE).all(axis=1)
        shown &= a.smallest_singular + b.smallest_singular > self._matrix_rate(path, rate) * w
        apart = 0.5 * (a.clearance + b.clearance) - self.speed[path].max(axis=1) * w
        shown &= apart >= -CLEARANCE_TOLERANCE
        if self.travel is not None:
            turned = self.angle[path] * w
            steep = np.maximum(a.tilt, b.tilt) + 0.5 * turned > STEEPEST_TILT
            shown &= turned <= np.where(steep, FINEST_TURN, COARSEST_TURN)
        return np.asarray(shown)

    def _bends(self, path: Ints, rate: FloatArray) -> FloatArray:
        """Return the bounds of the second derivatives (N, m); ``rate`` is ``V / L`` (N, 6)."""
        angle, arm, shift = self.angle[path, None], self.arm[path], self.shift[path, None]
        of_length = self.speed[path] * rate + angle**2 * arm
        of_joint = {
            Limit.STROKE: np.zeros_like(arm),
            Limit.BASE_CONE: angle**2 * arm,
            Limit.PLATFORM_CONE: angle**2 * self.far[path] + 2.0 * angle * shift,
        }
        columns = [np.zeros((len(path), 0))]
        for kind, k in zip(self.functions.kind[::6].tolist(), np.abs(self.functions.k).reshape(-1, 6), strict=True):
            with np.errstate(invalid="ignore"):
                bend = of_joint[Limit(kind)] + k * of_length
            columns.append(np.where(np.isnan(bend), np.inf, bend))
        if self.travel is not None:
            columns.append(angle**2 * np.array([0.0, 0.0, 0.0, 1.0, 1.0, 1.0] * 2))
        return np.asarray(np.concatenate(columns, axis=1))

    def _matrix_rate(self, path: Ints, rate: FloatArray) -> FloatArray:
        """Return a bound (N,) of the norm of ``dJ/ds`` for the dimensionless Jacobian about the joints' centroid."""
        made = constants(self.hexapod)
        lever = np.linalg.norm(self.hexapod.platform_joints - made.centre, axis=1) / made.radius
        of_moment = lever * (self.angle[path, None] + rate)
        return np.asarray(np.sqrt((rate**2 + of_moment**2).sum(axis=1)))


def _both(one: Samples, two: Samples) -> Samples:
    return Samples(*(np.concatenate(pair) for pair in zip(one, two, strict=True)))


def _travel_values(x: FloatArray, travel: FloatArray) -> FloatArray:
    """Return the maker's travel as functions (N, 12) [m, rad] of coordinates (N, 6): six lower limits, six upper.

    Distances for x, y, z; ``sin(ry) - sin(low)`` for ry; ``cos(ry) sin(rx - low)`` for rx and rz, which are products of
    unit vectors of base and platform and so have second derivatives below ``e^2``; beyond 90 degrees from its limit
    an angle counts as 90 degrees from it.
    """
    right = 0.5 * np.pi
    inside = np.concatenate([x - travel[:, 0], travel[:, 1] - x], axis=1)
    turns = np.cos(x[:, 4:5]) * np.sin(np.clip(inside, -right, right))
    low, high = np.sin(np.clip(travel[4], -right, right))
    values = np.where(np.arange(12) % 6 < 3, inside, turns)
    values[:, 4], values[:, 10] = np.sin(x[:, 4]) - low, high - np.sin(x[:, 4])
    return np.asarray(values)
