"""The limits of the legs as smooth functions of the pose, so that nothing between two poses can be missed.

Each is ``f = k L + d . v + c`` with the leg's vector ``d = L u`` and length ``L``, in metres, and allowed where
``f >= 0``:

====================  ==================  ==========================  =============
limit                 k                   v                           c
====================  ==================  ==========================  =============
shortest              1                   0                           -shortest
longest               -1                  0                           longest
cone at the base      -cos(cone)          u at home                   0
cone at the platform  -cos(cone)          R (R_home^T u_home)         0
====================  ==================  ==========================  =============

The cones are ``L (cos(angle) - cos(cone))``.  For a platform that moves by ``x`` without turning,
``L(x) = L + u . x + r`` with ``0 <= r <= |x|^2 / (2 (L - |x|))``, since the Hessian of a length is ``(I - u u^T) / L``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hexathermal.kinematics.lean import home_directions
from hexathermal.kinematics.limits import Limit, Standing
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray


@dataclass(frozen=True, eq=False)
class LimitFunctions:
    """The functions that a machine has, m of them: 12 for strokes, 6 for each kind of cone.

    Attributes
    ----------
    kind, leg : array, shape (m,), int
        `Limit`, and the leg counted from 0.
    bound : array, shape (m,) [m or rad]
        The limit itself: a length, or a cone.
    k : array, shape (m,)
    v_base, v_platform : array, shape (m, 3)
        ``v = v_base + R v_platform``.
    c : array, shape (m,) [m]
    """

    kind: npt.NDArray[np.int8]
    leg: npt.NDArray[np.int64]
    bound: FloatArray
    k: FloatArray
    v_base: FloatArray
    v_platform: FloatArray
    c: FloatArray

    def directions(self, rotations: FloatArray) -> FloatArray:
        """Return ``v`` for rotations (..., 3, 3), shape (..., m, 3)."""
        return np.asarray(self.v_base + self.v_platform @ np.swapaxes(rotations, -1, -2))

    def values(self, now: Standing) -> FloatArray:
        """Return ``f`` [m], shape (N, m); NaN for a leg of length 0."""
        return self.with_gradients(now.lengths, now.units, self.directions(now.poses[:, :3, :3]))[0]

    def with_gradients(self, lengths: FloatArray, units: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return ``f`` [m] and its gradient ``k u + v`` for the platform's position, shapes (N, m) and (N, m, 3)."""
        u = units[:, self.leg]
        gradients = self.k[:, None] * u + v
        return lengths[:, self.leg] * np.einsum("nmi,nmi->nm", u, gradients) + self.c, gradients


def limit_functions(hexapod: Hexapod) -> LimitFunctions:
    """Return the limits of strokes and cones that the machine states."""
    legs, zero, none = np.arange(6), np.zeros(6), np.zeros((6, 3))
    rows: list[tuple[Limit, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]] = []
    if hexapod.stroke is not None:
        shortest, longest = hexapod.length_limits
        rows.append((Limit.STROKE, shortest, np.ones(6), none, none, -shortest))
        rows.append((Limit.STROKE, longest, -np.ones(6), none, none, longest))
    at_base, at_platform = home_directions(hexapod)
    if hexapod.base_cone is not None:
        rows.append((Limit.BASE_CONE, hexapod.base_cone, -np.cos(hexapod.base_cone), at_base, none, zero))
    if hexapod.platform_cone is not None:
        rows.append(
            (Limit.PLATFORM_CONE, hexapod.platform_cone, -np.cos(hexapod.platform_cone), none, at_platform, zero)
        )

    def column(i: int, width: tuple[int, ...] = ()) -> FloatArray:
        return np.concatenate([row[i] for row in rows]) if rows else np.zeros((0, *width))

    return LimitFunctions(
        kind=np.repeat(np.array([row[0] for row in rows], dtype=np.int8), 6),
        leg=np.tile(legs, len(rows)),
        bound=column(1), k=column(2), v_base=column(3, (3,)), v_platform=column(4, (3,)), c=column(5),
    )  # fmt: skip
