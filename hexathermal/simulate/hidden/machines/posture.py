"""Where a platform stands: position and quaternion that solve six equations of squared lengths, by Newton's method."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.machines.rotation import turned

SETTLED, STEPS = 1e-13, 30
"""Newton's steps end when the position moves less [m]; most steps."""


class Posture(NamedTuple):
    """Where a platform stands in the base: position (n, 3) [m] and unit quaternion (n, 4)."""

    position: FloatArray
    turn: FloatArray

    def points(self, platform: FloatArray) -> FloatArray:
        """Return points of the platform, shape (6, 3) or (n, 6, 3) [m], as they stand in the base, (n, 6, 3)."""
        return np.asarray(self.position[:, None] + turned(self.turn[:, None], platform))


def legs_of(posture: Posture, base: FloatArray, platform: FloatArray) -> FloatArray:
    """Return the vectors along the legs, from base to platform joint, shape (n, 6, 3) [m]."""
    return np.asarray(posture.points(platform) - base)


def lengths_of(posture: Posture, base: FloatArray, platform: FloatArray) -> FloatArray:
    """Return the lengths of the legs, shape (n, 6) [m]."""
    return np.asarray(np.linalg.norm(legs_of(posture, base, platform), axis=-1))


def standing(lengths: FloatArray, base: FloatArray, platform: FloatArray, near: Posture) -> Posture:
    """Return where platforms stand on legs of given lengths, next to where they are thought to stand.

        |t + R(e) p_i - b_i|^2 = L_i^2,  i = 1 .. 6;   |e|^2 = 1

    seven equations for the position t and the quaternion e, in which ``R(e) p`` is a form of second degree.

    Parameters
    ----------
    lengths : array, shape (n, 6) [m]
    base, platform : array, shape (6, 3) or (n, 6, 3) [m]
        Joints in the base and in the platform.
    near : Posture

    Raises
    ------
    ArithmeticError
        Newton's method did not settle.

    Examples
    --------
    >>> base = np.array([[1.0, 0, 0], [0.9, 0.4, 0], [-0.5, 0.9, 0], [-0.8, 0.6, 0], [-0.8, -0.6, 0], [-0.4, -0.9, 0]])
    >>> there = Posture(np.array([[0.01, 0.02, 1.0]]), np.array([[1.0, 0.0, 0.0, 0.0]]))
    >>> platform = 0.6 * base[[1, 2, 3, 4, 5, 0]]
    >>> near = Posture(there.position + 0.03, there.turn)
    >>> standing(lengths_of(there, base, platform), base, platform, near).position.round(9).tolist()
    [[0.01, 0.02, 1.0]]
    """
    t, e = near.position.copy(), near.turn.copy()
    points = np.broadcast_to(platform, (len(t), 6, 3))
    for _step in range(STEPS):
        w, v = e[:, None, :1], e[:, None, 1:]
        along = (v * points).sum(-1, keepdims=True)
        place = (w**2 - (v * v).sum(-1, keepdims=True)) * points + 2.0 * along * v + 2.0 * w * np.cross(v, points)
        leg = t[:, None] + place - base
        slope = np.zeros((len(t), 7, 7))
        slope[:, :6, :3] = 2.0 * leg
        slope[:, :6, 3:4] = 4.0 * (leg * (w * points + np.cross(v, points))).sum(-1, keepdims=True)
        # leg . d(R p)/dv, row by row: (v.p) leg + (leg.v) p - (leg.p) v + w p x leg, twice
        across = along * leg + (leg * v).sum(-1, keepdims=True) * points - (leg * points).sum(-1, keepdims=True) * v
        slope[:, :6, 4:] = 4.0 * (across + w * np.cross(points, leg))
        slope[:, 6, 3:] = 2.0 * e
        left = np.concatenate([(leg**2).sum(-1) - lengths**2, (e**2).sum(-1, keepdims=True) - 1.0], axis=1)
        change = np.linalg.solve(slope, left[..., None])[..., 0]
        t, e = t - change[:, :3], e - change[:, 3:]
        if np.abs(change[:, :3]).max() < SETTLED:
            return Posture(t, e / np.linalg.norm(e, axis=1, keepdims=True))
    raise ArithmeticError(f"no posture found for legs of {lengths.min():.6g} to {lengths.max():.6g} m")
