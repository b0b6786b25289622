"""The case that all contenders work on: one machine, poses inside its stroke, and the right answers.

The answers come from the equations written once more, in NumPy's long double (64 bits of mantissa on x86-64), so that
they share no code with any contender and no rounding with a double.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum

import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

import hexathermal as ht

FloatArray = npt.NDArray[np.float64]

TRAVEL_MM, TURN_DEG = 50.0, 10.0
"""Poses are drawn uniformly within these from home, every coordinate on its own."""

ROOM_M = 1e-4
"""Poses keep this far from the ends of the stroke: a warm leg moves by some 0.01 mm."""

TEMPERATURES_DEGC = (15.0, 30.0)
SEED = 20260101
CHUNK = 20_000


class Quantity(Enum):
    """What is asked for."""

    LENGTHS = "inverse kinematics"
    CORRECTED = "corrected leg lengths"
    POSES = "forward kinematics"
    JACOBIANS = "Jacobian"


@dataclass(frozen=True, eq=False)
class Case:
    """Poses, temperatures and true answers.

    Attributes
    ----------
    poses : array, shape (N, 4, 4) [m]
    motions : array, shape (N, 7)
        The same poses as ``x, y, z, qx, qy, qz, qw``, the form that MuJoCo and the yardstick's columns take.
    temps : array, shape (N, 6) [degC]
    lengths, corrected : array, shape (N, 6) [m]
        True answers, rounded to doubles once.
    jacobians : array, shape (N, 6, 6)
    """

    hexapod: ht.Hexapod
    poses: FloatArray
    temps: FloatArray
    motions: FloatArray = field(init=False)
    lengths: FloatArray = field(init=False)
    corrected: FloatArray = field(init=False)
    jacobians: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "motions", motions_of(self.poses))
        set_(self, "lengths", self._in_chunks((6,), self._true_lengths))
        set_(self, "corrected", self._in_chunks((6,), self._true_corrected))
        set_(self, "jacobians", self._in_chunks((6, 6), self._true_jacobians))

    def __len__(self) -> int:
        return len(self.poses)

    @property
    def law(self) -> FloatArray:
        """Rows ``A, B, q0, reference`` of the six legs: this case has one thermometer a leg and no other."""
        thermal = self.hexapod.thermal
        if thermal is None or self.hexapod.retracted_length is None or len(thermal.sensor_names) != 6:
            raise ValueError(f"{self.hexapod.name!r} is no machine for this case: it needs one thermometer a leg")
        A, B = [leg.A[0] for leg in thermal.legs], [leg.B[0] for leg in thermal.legs]
        return np.array([A, B, self.hexapod.retracted_length, np.broadcast_to(thermal.reference_temperature_degC, 6)])

    def answers(self, quantity: Quantity) -> FloatArray:
        """Return the true answers."""
        return {
            Quantity.LENGTHS: self.lengths,
            Quantity.CORRECTED: self.corrected,
            Quantity.POSES: self.poses,
            Quantity.JACOBIANS: self.jacobians,
        }[quantity]

    def _in_chunks(self, shape: tuple[int, ...], true: Callable[[int, int], npt.NDArray[np.longdouble]]) -> FloatArray:
        """Return true answers of all poses; long doubles of a million Jacobians would not fit."""
        out = np.empty((len(self), *shape))
        for i in range(0, len(self), CHUNK):
            out[i : i + CHUNK] = true(i, i + CHUNK)
        return out

    def _legs(self, i: int, j: int) -> tuple[npt.NDArray[np.longdouble], npt.NDArray[np.longdouble]]:
        """Return ``s = R p`` and ``d = t + s - b``."""
        T = self.poses[i:j].astype(np.longdouble)
        s = np.einsum("nij,kj->nki", T[:, :3, :3], self.hexapod.platform_joints.astype(np.longdouble))
        return s, T[:, None, :3, 3] + s - self.hexapod.base_joints.astype(np.longdouble)

    def _true_lengths(self, i: int, j: int) -> npt.NDArray[np.longdouble]:
        _s, d = self._legs(i, j)
        return np.asarray(np.sqrt((d * d).sum(axis=-1)))

    def _true_corrected(self, i: int, j: int) -> npt.NDArray[np.longdouble]:
        A, B, q0, reference = self.law.astype(np.longdouble)
        dT = self.temps[i:j] - reference
        return np.asarray(q0 + (self._true_lengths(i, j) - q0 - A * dT * q0) / (1 + B * dT))

    def _true_jacobians(self, i: int, j: int) -> npt.NDArray[np.longdouble]:
        s, d = self._legs(i, j)
        u = d / np.sqrt((d * d).sum(axis=-1, keepdims=True))
        return np.concatenate([u, np.cross(s, u)], axis=-1)


def motions_of(poses: FloatArray) -> FloatArray:
    """Return rows ``x, y, z, qx, qy, qz, qw`` of poses (N, 4, 4)."""
    return np.concatenate([poses[:, :3, 3], Rotation.from_matrix(poses[:, :3, :3]).as_quat()], axis=1)


def poses_of(motions: FloatArray) -> FloatArray:
    """Return poses (N, 4, 4) of rows ``x, y, z, qx, qy, qz, qw``; all NaN where an entry is NaN."""
    out = np.full((len(motions), 4, 4), np.nan)
    good = np.isfinite(motions).all(axis=1)
    out[good] = np.eye(4)
    out[good, :3, :3] = Rotation.from_quat(motions[good, 3:]).as_matrix()
    out[good, :3, 3] = motions[good, :3]
    return out


def drawn_case(count: int, machine: str = "reference") -> Case:
    """Return a case of `count` poses inside the stroke of a bundled machine."""
    hexapod = ht.load_hexapod(machine)
    rng = np.random.default_rng(SEED)
    shortest, longest = hexapod.length_limits
    found: list[FloatArray] = []
    while sum(map(len, found)) < count:
        travel = rng.uniform(-TRAVEL_MM, TRAVEL_MM, (count + 1000, 3))
        turn = rng.uniform(-TURN_DEG, TURN_DEG, (count + 1000, 3))
        poses = ht.pose_from_coordinates(np.concatenate([travel, turn], axis=1), hexapod=hexapod)
        lengths = hexapod.inverse_kinematics(poses)
        inside = (lengths > shortest + ROOM_M) & (lengths < longest - ROOM_M)
        found.append(poses[inside.all(axis=1)])
    temps = rng.uniform(*TEMPERATURES_DEGC, (count, 6))
    return Case(hexapod, np.concatenate(found)[:count].copy(), temps)
