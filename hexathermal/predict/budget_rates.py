"""Exact errors of machines that deviate, and the derivatives of the error, at many poses side by side.

Arrays lead with the N places of a map; a budget of one pose is the case N = 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from types import ModuleType

import numpy as np
import numpy.typing as npt

from hexathermal.errors import NotConvergedError
from hexathermal.kinematics.constants import constants
from hexathermal.kinematics.inverse import inverse_kinematics
from hexathermal.kinematics.jacobian import at_centre, jacobian
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray
from hexathermal.predict.budget_blocks import blocks, deviation_size
from hexathermal.predict.budget_load import deviated_sag, sag_rates, sag_stiffness
from hexathermal.predict.leg_drift import deviated_drift, deviated_rates

MOST_STEPS = 40
"""Steps to the balance under a payload."""

SAG_CHANGE = 1e-15
"""Change of the sag [m] below which it is settled."""

LARGE_STEPS = ("temperature", "gain", "contact", "plate temperature", "plate gradient", "reference temperature")
"""Quantities that move a machine by micrometres for each unit: differences over a larger step lose no digits."""


@cache
def drawers() -> ModuleType:
    """Return the compiled loops over deviations."""
    from hexathermal.kinematics import draws_loops

    return draws_loops


def pose_numbers(hexapod: Hexapod, poses: FloatArray, axes: FloatArray, arm: FloatArray) -> FloatArray:
    """Return the numbers (N, k) of poses (N, 4, 4) that `draw_errors` reads; errors are told in `axes` (N, 3, 3)."""
    d, made, n = drawers(), constants(hexapod), len(poses)
    R = poses[:, :3, :3]
    platform = (hexapod.platform_joints - made.centre) @ np.swapaxes(R, -1, -2)
    origin = poses[:, :3, 3] + R @ made.centre
    base = hexapod.base_joints - origin[:, None]
    inverse = np.linalg.inv(at_centre(jacobian(hexapod, poses), poses, made.centre))
    f = np.zeros((n, d.DRAW_LENGTH))
    f[:, d.D_PLATFORM : d.D_PLATFORM + 18], f[:, d.D_BASE : d.D_BASE + 18] = (
        platform.reshape(n, 18),
        base.reshape(n, 18),
    )
    f[:, d.D_INVERSE : d.D_INVERSE + 36] = (inverse / inverse_kinematics(hexapod, poses)[:, None]).reshape(n, 36)
    f[:, d.D_ARM : d.D_ARM + 3], f[:, d.D_AXES : d.D_AXES + 9] = R @ (arm - made.centre), axes.reshape(n, 9)
    f[:, d.D_INVERSE_SIZE] = 1.0 / made.size
    f[:, d.D_ROTATION : d.D_ROTATION + 9] = R.reshape(n, 9)
    f[:, d.D_CENTRE : d.D_CENTRE + 3], f[:, d.D_ORIGIN : d.D_ORIGIN + 3] = made.centre, origin
    return f


def chord_solved(
    numbers: FloatArray, lengths: FloatArray, joints: FloatArray
) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
    """Return errors (N, 6) of one pose's point, and which of them are certain.

    Parameters
    ----------
    numbers : array
        One row of `pose_numbers`.
    lengths, joints : array, shape (N, 6), (N, 36)
        True lengths and joints; no joints: the machine's own.
    """
    out, codes = np.empty((len(lengths), 6)), np.zeros(len(lengths), dtype=np.int8)
    drawers().draw_errors(numbers, lengths, joints, out, codes)
    return out, codes == 0


def chord_errors(numbers: FloatArray, lengths: FloatArray, joints: FloatArray, expected: bool = False) -> FloatArray:
    """Return the errors of `chord_solved`; `expected`: nothing deviates in them.

    Raises
    ------
    NotConvergedError
        The branch of a pose is not certain.
    """
    return certain(*chord_solved(numbers, lengths, joints), expected)


def certain(out: FloatArray, good: npt.NDArray[np.bool_], expected: bool) -> FloatArray:
    """Return errors of which all are certain; raises as `chord_errors`."""
    if not good.all():
        if expected:
            raise NotConvergedError(f"the temperatures {TOO_FAR}; check the temperatures of the plates and gradients")
        first = int(np.flatnonzero(~good)[0])
        many = f"{np.count_nonzero(~good)} of {len(good)} deviations (the first at index {first})"
        raise NotConvergedError(f"{many} {TOO_FAR}; {CHECK_SOURCES}")
    return out


TOO_FAR = (
    "move the platform too far for the branch of its pose to be certain (more than 3 % of the machine's size, or "
    "across a singular pose)"
)
CHECK_SOURCES = "check the standard uncertainties and their units, or choose a pose farther from singular ones"


@dataclass(frozen=True, eq=False)
class Places:
    """One machine at N poses, each with its temperatures, ready to be deviated from.

    Attributes
    ----------
    hexapod : Hexapod
    poses : array, shape (N, 4, 4) [m]
    told : array, shape (N, 6) [m]
        Commanded lengths.
    dT, lag : array, shape (N, n) [K]
    plates : array, shape (N, 2, 8)
    axes : array, shape (N, 3, 3)
    arm : array, shape (3,) [m]
        As in `hexathermal.predict.budget_inputs.Situation`.
    numbers : array, shape (N, k)
        Of `pose_numbers`.
    """

    hexapod: Hexapod
    poses: FloatArray
    told: FloatArray
    dT: FloatArray
    lag: FloatArray
    plates: FloatArray
    axes: FloatArray
    arm: FloatArray
    numbers: FloatArray

    def machine(
        self, k: int, plates: FloatArray | None = None, told: FloatArray | None = None, x: FloatArray | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Return lengths (M, 6) without the payload and joints (M, 36) at place `k`, with deviations `x` (M, size)."""
        off = np.zeros((1, deviation_size(self.hexapod))) if x is None else x
        lengths, joints = np.empty((len(off), 6)), np.empty((len(off), 36))
        drawers().deviated_many(
            constants(self.hexapod).both_law, self.told[k] if told is None else told, self.dT[k], self.lag[k],
            self.plates[k] if plates is None else plates, off, lengths, joints,
        )  # fmt: skip
        lengths += deviated_drift(self.hexapod, self.told[k] if told is None else told, self.dT[k], self.lag[k], off)
        return lengths, joints

    def solved(
        self, k: int, lengths: FloatArray, joints: FloatArray, x: FloatArray | None = None,
        load: FloatArray | float = 1.0,
    ) -> tuple[FloatArray, npt.NDArray[np.bool_]]:  # fmt: skip
        """Return exact errors (M, 6) at place `k`, the payload in balance, and which of them are certain.

        Parameters
        ----------
        lengths, joints, x
            As `machine` makes them.
        load : float or array, shape (M, 1)
            Part of the payload's sag that is there: 0 or 1.
        """
        errors, good = chord_solved(self.numbers[k], lengths, joints)
        if self.hexapod.compliance is None:
            return errors, good
        off = np.zeros((1, deviation_size(self.hexapod))) if x is None else x
        last = np.zeros((len(lengths), 6))
        one = slice(k, k + 1)
        for _step in range(MOST_STEPS):
            T = _reached(self.poses[one], self.axes[one], self.arm, np.where(good[:, None], errors, 0.0))
            now = load * deviated_sag(self.hexapod, T, off)
            change, last = np.abs(now - last).max(axis=1), now
            errors, sure = chord_solved(self.numbers[k], lengths + now, joints)
            good = good & sure
            if not (change[good] > SAG_CHANGE).any():
                return errors, good
        return errors, good & (change <= SAG_CHANGE)

    def rates(self, errors: FloatArray, joints: FloatArray) -> FloatArray:
        """Return the derivatives (N, 6, size + 6) of the error for each deviation, at the expected true poses.

        Implicit derivative of ``|t + R p - b| = l + sag``: ``(J - S) dx = dl - u . R dp + u . db`` with the rates ``S``
        of the sag; the last six are the pose's own.  It is moved to the point and turned into the axes.

        Parameters
        ----------
        errors, joints : array, shape (N, 6), (N, 36)
            Expected error, and true joints where nothing deviates.
        """
        T = _reached(self.poses, self.axes, self.arm, errors)
        R, t = np.ascontiguousarray(T[:, :3, :3]), T[:, :3, 3]
        s = joints[:, :18].reshape(-1, 6, 3) @ np.swapaxes(R, -1, -2)
        legs = s + t[:, None] - joints[:, 18:].reshape(-1, 6, 3)
        units = legs / np.linalg.norm(legs, axis=-1, keepdims=True)
        moved = np.empty((len(R), 6, deviation_size(self.hexapod)))
        both, steps = constants(self.hexapod).both_law, self._steps()
        for k in range(len(R)):
            drawers().length_rates(
                both, self.told[k], self.dT[k], self.lag[k], self.plates[k], R[k], units[k], steps, moved[k]
            )
            moved[k] += deviated_rates(self.hexapod, self.told[k], self.dT[k], self.lag[k])
            if self.hexapod.compliance is not None:
                moved[k] += sag_rates(self.hexapod, T[k])
        arms = (R @ self.arm)[:, None]
        J = np.concatenate([units, np.cross(s - arms, units)], axis=-1)
        if self.hexapod.compliance is not None:
            J -= sag_stiffness(self.hexapod, T, t + arms[:, 0])
        turns = np.zeros((len(R), 6, 6))
        turns[:, :3, :3], turns[:, 3:, 3:] = self.axes, _vector_rates(errors[:, 3:]) @ self.axes
        own = np.broadcast_to(np.eye(6), (len(R), 6, 6))
        return np.concatenate([turns @ np.linalg.solve(J, moved), own], axis=-1)

    def _steps(self) -> FloatArray:
        """Return steps that move lengths and joints by metres, so that differences lose no digits."""
        steps = np.ones(deviation_size(self.hexapod))
        for quantity in LARGE_STEPS:
            steps[blocks(self.hexapod, quantity)[0]] = 1e6
        return steps


def _reached(poses: FloatArray, axes: FloatArray, arm: FloatArray, errors: FloatArray) -> FloatArray:
    """Return poses (M, 4, 4) that are off by errors (M, 6) of a point, told in axes; poses and axes of one, or of M."""
    from scipy.spatial.transform import Rotation

    back = np.swapaxes(axes, -1, -2)
    shifts, turns = (np.einsum("nij,nj->ni", np.broadcast_to(back, (len(errors), 3, 3)), part)
                     for part in (errors[:, :3], errors[:, 3:]))  # fmt: skip
    T = np.zeros((len(errors), 4, 4))
    R = Rotation.from_rotvec(turns).as_matrix() @ poses[:, :3, :3]
    T[:, :3, :3], T[:, 3, 3] = R, 1.0
    T[:, :3, 3] = poses[:, :3, 3] + poses[:, :3, :3] @ arm + shifts - R @ arm
    return T


def _vector_rates(r: FloatArray) -> FloatArray:
    """Return rates (N, 3, 3) of rotation vectors for angular velocities: the inverse of SO(3)'s left Jacobian."""
    angle = np.linalg.norm(r, axis=1)
    K = np.zeros((len(r), 3, 3))
    K[:, 2, 1], K[:, 0, 2], K[:, 1, 0] = r.T
    K -= np.swapaxes(K, -1, -2)
    large = np.where(angle < 1e-4, 1.0, angle)
    k = np.where(angle < 1e-4, 1.0 / 12.0, 1.0 / large**2 - (1.0 + np.cos(large)) / (2.0 * large * np.sin(large)))
    return np.asarray(np.eye(3) - 0.5 * K + k[:, None, None] * K @ K)
