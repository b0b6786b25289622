"""Whether postures are held by their legs: one posture, a curve of postures, a machine at every pose.

Poses are unit quaternions (k, 4), scalar first, and translations (k, 3); joints are about the centroids of the two
plates, and all lengths in units of a machine's size.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError
from hexathermal.kinematics.constants import LARGEST_CONDITION, dimensionless

if TYPE_CHECKING:
    F64 = npt.NDArray[np.float64]

_STEP = 0.02  # way along a free motion (machine sizes, rad) that tells a curve of postures from a multiple one
_PROBES = 8  # generic poses at which a machine's rank is looked at


def architecturally_singular(base_joints: npt.ArrayLike, platform_joints: npt.ArrayLike) -> bool:
    """Tell whether six legs leave this machine movable at every pose.

    Their lines then belong to one linear complex wherever the platform stands, so that locked legs hold it nowhere.
    Examples: two similar (also mirrored or stretched) plates with their joints on a circle, a plate whose joints lie
    on a line or in one point, four legs from one joint.

    ::

        min over 8 fixed random poses of  cond [u_i, (R p_i x u_i) / r]  >  1e7

    with p_i about the centroid of the platform joints and r their root-mean-square radius; also true if the joints of
    one plate lie within 1e-7 of the other's radius.  Joints within rounding (about 1e-7 radii) of such a machine count
    as well: its postures, though finite in number, could not be told from a motion.

    Parameters
    ----------
    base_joints, platform_joints : array, shape (6, 3) [m]
        b_i in the base frame, p_i in the platform frame.

    Returns
    -------
    bool

    Raises
    ------
    ArgumentError
        A shape is wrong or a value is not finite.

    Examples
    --------
    >>> import numpy as np
    >>> angles = np.deg2rad([0.0, 60.0, 120.0, 180.0, 240.0, 300.0])
    >>> hexagon = np.c_[np.cos(angles), np.sin(angles), np.zeros(6)]
    >>> architecturally_singular(hexagon, 0.5 * hexagon)
    True
    """
    base = checked("base_joints", base_joints, (6, 3))
    platform = checked("platform_joints", platform_joints, (6, 3))
    rounding = 1e-14 * max(np.abs(base).max(), np.abs(platform).max())
    base, platform = base - base.mean(axis=0), platform - platform.mean(axis=0)
    radii = np.sqrt([(base**2).sum() / 6, (platform**2).sum() / 6])
    if radii.min() <= rounding + radii.max() / LARGEST_CONDITION:
        return True
    random = np.random.default_rng(40)
    turns, shifts = random.normal(size=(_PROBES, 4)), 2 * random.normal(size=(_PROBES, 3))
    turns /= np.linalg.norm(turns, axis=1, keepdims=True)
    return bool(singular_poses(base / radii.max(), platform / radii.max(), turns, shifts).all())


def checked(name: str, values: npt.ArrayLike, shape: tuple[int, ...]) -> F64:
    """Return values as a float array of this shape, or say what is wrong with them."""
    try:
        if np.iscomplexobj(values):
            raise TypeError("complex")
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ArgumentError(f"{name} must be an array of real numbers, shape {shape}") from error
    if array.shape != shape:
        raise ArgumentError(f"{name} must have shape {shape}; got {array.shape}")
    if not np.all(np.isfinite(array)):
        raise ArgumentError(f"{name} must be finite; got {array.tolist()}")
    return array


def rotations(turns: F64) -> F64:
    """Return the rotation matrices (k, 3, 3) of unit quaternions (k, 4), scalar first."""
    w, v = turns[:, 0, None, None], turns[:, 1:]
    skew = np.cross(v[:, None, :], np.eye(3)).transpose(0, 2, 1)
    return np.eye(3) + 2 * (w * skew + skew @ skew)


def refine_real(base: F64, platform: F64, lengths: F64, turns: F64, shifts: F64) -> tuple[F64, F64, F64, F64]:
    """Improve poses by Newton steps on the six lengths; return them, max |error| and the way moved (k,).

    ::

        dL_i = u_i . dt + (R p_i x u_i) . w,   u_i = (t + R p_i - b_i) / L_i
    """
    best = (turns.copy(), shifts.copy(), np.full(len(shifts), np.inf), np.zeros(len(shifts)))
    moved = np.zeros(len(shifts))
    for _ in range(12):
        size, jacobian = _rows(base, platform, turns, shifts)
        errors = size - lengths
        worst = np.abs(errors).max(axis=1)
        better = worst < best[2]
        for kept, now in zip(best, (turns, shifts, worst, moved), strict=True):
            kept[better] = now[better]
        if not better.any():
            break
        step = -np.einsum("kij,kj->ki", np.linalg.pinv(jacobian, rcond=1e-11), errors)
        turns, shifts = _stepped(turns, shifts, step)
        moved = moved + np.linalg.norm(step, axis=1)
    return best


def way_between(turns: F64, shifts: F64, other_turns: F64, other_shifts: F64) -> F64:
    """Return how far poses are apart: the root of |R - R'|^2 + |t - t'|^2, where |R - R'|^2 = 8 (1 - (e.e')^2)."""
    # the sine from a difference, not from 1 - cos^2, keeps the digits of small ways
    near = np.linalg.norm(turns - other_turns, axis=-1)
    far = np.linalg.norm(turns + other_turns, axis=-1)
    shift = np.linalg.norm(shifts - other_shifts, axis=-1)
    return np.asarray(np.sqrt(2 * (near * far) ** 2 + shift**2))


def _rows(base: F64, platform: F64, turns: F64, shifts: F64) -> tuple[F64, F64]:
    """Return the leg lengths (k, 6) and the Jacobians (k, 6, 6), rows [u_i, R p_i x u_i], of poses."""
    arms = np.einsum("kij,nj->kni", rotations(turns), platform)
    legs = arms + shifts[:, None] - base
    size = np.linalg.norm(legs, axis=2)
    units = legs / size[:, :, None]
    return size, np.concatenate([units, np.cross(arms, units)], axis=2)


def singular_poses(base: F64, platform: F64, turns: F64, shifts: F64) -> npt.NDArray[np.bool_]:
    """Tell which poses (k,) have a dimensionless Jacobian of condition number above the limit.

    The platform joints are about their centroid.
    """
    _, jacobian = _rows(base, platform, turns, shifts)
    values = np.linalg.svd(dimensionless(jacobian, float(np.sqrt((platform**2).sum() / 6))), compute_uv=False)
    singular: npt.NDArray[np.bool_] = values[:, 0] > LARGEST_CONDITION * values[:, -1]
    return singular


def moves(base: F64, platform: F64, lengths: F64, turn: F64, shift: F64, tolerance: float) -> bool:
    """Tell whether a singular posture is one of a curve: whether the machine can leave it with its legs locked.

    From _STEP away along each free motion (and mixtures, if there are several) the lengths are met again.  Next to
    a multiple posture that stands alone, Newton's method creeps back to it; on a curve it stays away, at postures
    that are singular too.
    """
    _, jacobian = _rows(base, platform, turn[None], shift[None])
    _, values, twists = np.linalg.svd(jacobian[0])
    free = twists[values * LARGEST_CONDITION < 10 * values[0]]
    free = twists[-1:] if len(free) == 0 else free
    mixtures = np.random.default_rng(1).normal(size=(8 if len(free) > 1 else 0, len(free))) @ free
    probes = np.concatenate([free, mixtures])
    probes *= _STEP / np.linalg.norm(probes, axis=1, keepdims=True)
    probes = np.concatenate([probes, -probes])
    there = np.broadcast_to(turn, (len(probes), 4)), np.broadcast_to(shift, (len(probes), 3))
    turns, shifts, worst, _ = refine_real(base, platform, lengths, *_stepped(*there, probes))
    away = (worst <= tolerance) & (way_between(turns, shifts, *there) > 0.25 * _STEP)
    return bool((away & singular_poses(base, platform, turns, shifts)).any())


def _stepped(turns: F64, shifts: F64, twists: F64) -> tuple[F64, F64]:
    """Return poses after twists (k, 6), translation first: e <- (1, w / 2) e / |.|, t <- t + v."""
    half = 0.5 * twists[:, 3:]
    scalar = turns[:, :1] - (half * turns[:, 1:]).sum(axis=1, keepdims=True)
    vector = turns[:, 1:] + turns[:, :1] * half + np.cross(half, turns[:, 1:])
    turns = np.concatenate([scalar, vector], axis=1)
    return turns / np.linalg.norm(turns, axis=1, keepdims=True), shifts + twists[:, :3]
