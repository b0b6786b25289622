"""All postures that six leg lengths allow: the forward problem of a hexapod solved completely.

Six lengths fix the platform up to at most 40 complex postures, and for some machines all 40 are real
(Dietmaier 1998).  They are found by parameter homotopy: the 40 solutions of a generic complex machine, stored
in `modes_start.npz` (made by `tools/make_modes_start.py`), are followed while that machine is deformed into
the caller's (`modes_tracker` has the equations).  Generically the 40 paths end at the 40 solutions, and 40
distinct ends prove that none is missing.
"""

from __future__ import annotations

import dataclasses
import functools
import pathlib
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError

if TYPE_CHECKING:
    C128 = npt.NDArray[np.complex128]
    F64 = npt.NDArray[np.float64]
    I64 = npt.NDArray[np.int64]

MOST_SOLUTIONS = 40
_FRACTIONS = (0.3, 0.25, 0.2, 0.15, 0.1)  # step / radius of convergence, one per start machine
_SAME = 1e-7  # solutions closer than this (unit vectors of P^7) are one
_GONE = 1e-15  # |e.e| / |x|^2 below this: no posture (translation beyond 3e7 machine sizes)
_LEAVING = 1e-4  # the same, for a path seen to fall further; a real posture has 1 / (1 + |t|^2) >= 1 / 4
_CLOSE = 3e-7  # postures closer than this (lengths in machine sizes, entries of R) are one
_SENSITIVE = 1e6  # a solution is singular if its equations are solved with a larger gain than this
_CLUSTER = 1e-3  # singular ends closer than this are one multiple solution


@dataclasses.dataclass(frozen=True, eq=False)
class AssemblyModes:
    """Every real posture of a hexapod with given leg lengths, and how surely the list is complete.

    A general machine has 40 complex solutions, and 40 distinct ends of the 40 paths make `complete` a proof
    up to rounding.  A special one (joints shared by two legs, symmetric rings, ...) has fewer: some paths
    leave towards infinity, and `complete` says that runs from two start machines agreed.  Two real postures
    closer than 3e-7 sizes (a pose at a singularity) are listed once.  Lengths that a machine can hold while
    moving (architectural singularities) have no finite list: `complete` is False.

    Attributes
    ----------
    poses : array, shape (k, 4, 4) [-, m]
        T_base_platform of each posture, read-only; k = 0 where the lengths allow none.  Sorted by
        descending t_z, then t_y, then t_x, then the entries of R row by row, each compared after rounding to
        1e-9 (t in machine sizes).
    complete : bool
        True if every one of the 40 paths is accounted for: it ended at a solution of its own, or where no
        real posture can be.  False: postures may be missing, or the machine can move with its legs locked.
    complex_solutions : int
        Distinct finite complex solutions found, real ones included (40 for a machine of general geometry).
    residuals : array, shape (k,) [m]
        max_i | |t + R p_i - b_i| - L_i | of each posture, read-only.
    paths_failed : int
        Paths that are not accounted for; 0 if `complete`.
    """

    poses: F64
    complete: bool
    complex_solutions: int
    residuals: F64
    paths_failed: int


class _Scaled(NamedTuple):
    """The machine about the centroids of its joints, in units of its size."""

    base: F64  # (6, 3)
    platform: F64  # (6, 3)
    lengths: F64  # (6,)
    base_centre: F64  # (3,) [m]
    platform_centre: F64  # (3,) [m]
    unit: float  # [m]


class _Census(NamedTuple):
    """Where the 40 paths ended."""

    regular: C128  # (n, 8) distinct finite solutions, unit vectors
    sharp: C128  # (l, 8) those of them that stand well apart from all others
    singular: C128  # (m, 8) finite ends that paths come near but do not reach
    group: I64  # (m,) which of them belong to one solution
    failed: int


def assembly_modes(
    base_joints: npt.ArrayLike,
    platform_joints: npt.ArrayLike,
    lengths: npt.ArrayLike,
    *,
    tolerance: float = 1e-12,
) -> AssemblyModes:
    """Find all poses of the platform that give the six leg lengths.

    Mirrored, twisted and upside-down postures fit the same lengths; joint limits and collisions are not
    looked at.  When the list is complete, and when it cannot be: see `AssemblyModes`.

    ::

        |t + R p_i - b_i| = L_i,   i = 1 .. 6,   T_base_platform = (R, t)

    Parameters
    ----------
    base_joints : array, shape (6, 3) [m]
        b_i, base frame.
    platform_joints : array, shape (6, 3) [m]
        p_i, platform frame; they may lie far from the platform's origin.
    lengths : array, shape (6,) [m]
        L_i > 0.
    tolerance : float [-]
        A posture is kept when max_i |length error| <= tolerance * size in coordinates about the joints'
        centroids; size^2 = (mean |b_i - b|^2 + mean |p_i - p|^2 + mean L_i^2) / 3.  From 1e-14 to 1e-6.

    Returns
    -------
    AssemblyModes
        The postures, whether all were found, and their length errors.

    Raises
    ------
    ArgumentError
        A shape is wrong, a value is not finite, a length is not positive, or `tolerance` is out of range.

    Examples
    --------
    >>> import numpy as np
    >>> angles = np.deg2rad([-10.0, 12.0, 108.0, 131.0, 229.0, 255.0])
    >>> base = np.c_[np.cos(angles), np.sin(angles), np.zeros(6)]
    >>> angles = np.deg2rad([-48.0, 49.0, 70.0, 172.0, 187.0, 290.0])
    >>> platform = 0.6 * np.c_[np.cos(angles), np.sin(angles), np.zeros(6)]
    >>> modes = assembly_modes(base, platform, np.full(6, 1.3))
    >>> modes.complete, modes.complex_solutions
    (True, 40)
    """
    base = _checked("base_joints", base_joints, (6, 3))
    platform = _checked("platform_joints", platform_joints, (6, 3))
    length = _checked("lengths", lengths, (6,))
    if not np.all(length > 0):
        raise ArgumentError(f"lengths must be positive; got {length.tolist()} m")
    if not 1e-14 <= tolerance <= 1e-6:
        raise ArgumentError(f"tolerance must lie between 1e-14 and 1e-6; got {tolerance}")
    return _listed(base, platform, length, tolerance)


def _listed(base: F64, platform: F64, length: F64, tolerance: float) -> AssemblyModes:
    """Return the postures of checked input."""
    scaled = _scale(base, platform, length)
    census = _solve(scaled)
    poses, lost = _real_poses(scaled, census, tolerance)
    poses = _sort(poses, scaled.unit)
    points = np.einsum("kij,nj->kni", poses[:, :3, :3], platform) + poses[:, None, :3, 3]
    residuals = np.abs(np.linalg.norm(points - base, axis=2) - length).max(axis=1)
    poses.setflags(write=False)
    residuals.setflags(write=False)
    found = len(census.regular) + int((np.bincount(census.group) > 1).sum())
    return AssemblyModes(poses, census.failed + lost == 0, found, residuals, census.failed + lost)


def _checked(name: str, values: npt.ArrayLike, shape: tuple[int, ...]) -> F64:
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


def _scale(base: F64, platform: F64, lengths: F64) -> _Scaled:
    base_centre, platform_centre = base.mean(axis=0), platform.mean(axis=0)
    base, platform = base - base_centre, platform - platform_centre
    squares = (base**2).sum() + (platform**2).sum() + (lengths**2).sum()
    unit = float(np.sqrt(squares / 18))
    return _Scaled(base / unit, platform / unit, lengths / unit, base_centre, platform_centre, unit)


@functools.cache
def _starts() -> tuple[C128, C128]:
    """Return the start machines (5, 6, 7) and the 40 solutions of each (5, 40, 8)."""
    with np.load(pathlib.Path(__file__).with_name("modes_start.npz")) as data:
        return data["legs"], data["solutions"]


def _solve(scaled: _Scaled) -> _Census:
    """Follow 40 paths from one start machine after the other, until all are accounted for.

    One round is enough where 40 distinct solutions are found; else two rounds must find the same ones.
    Solutions of all rounds are united, with their complex conjugates (the target is real).
    """
    from hexathermal.kinematics import modes_tracker as tracker

    b, p, length = scaled.base, scaled.platform, scaled.lengths
    squares = (p**2).sum(axis=1) + (b**2).sum(axis=1) - length**2
    target = np.column_stack([squares, p, b]).astype(np.complex128)
    regular = sharp = np.empty((0, 8), np.complex128)
    agreed, census = False, _Census(regular, sharp, regular, np.empty(0, np.int64), MOST_SOLUTIONS)
    for legs, points, fraction in zip(*_starts(), _FRACTIONS, strict=True):
        ends, states, reports = tracker.track_all(legs, target, points, fraction)
        census = _take_census(ends, states == tracker.REGULAR, reports)
        before = len(sharp)
        regular = _distinct(np.concatenate([regular, census.regular, census.regular.conj()]))
        sharp = _distinct(np.concatenate([sharp, census.sharp, census.sharp.conj()]))
        if len(regular) == MOST_SOLUTIONS:
            return _Census(regular, sharp, regular[:0], census.group[:0], 0)
        agreed = census.failed == 0 and len(census.sharp) == before == len(sharp)
        if agreed and fraction < _FRACTIONS[0]:
            break
    failed = max(census.failed, len(regular) - MOST_SOLUTIONS, 0 if agreed else 1)
    return census._replace(regular=regular, sharp=sharp, failed=failed)


def _take_census(ends: C128, arrived: npt.NDArray[np.bool_], reports: F64) -> _Census:
    """Tell finite ends, multiple ends, ends at e = 0 and failures apart."""
    size, slope, sensitivity = reports[:, 1], reports[:, 2], reports[:, 4]
    gone = (size < _GONE) | ((size < _LEAVING) & ~arrived & (slope > 0.5))
    sound = ends[arrived & ~gone]
    sharp = ends[arrived & ~gone & (sensitivity < _SENSITIVE)]
    failed = len(sharp) - len(_distinct(sharp))
    singular = ends[~arrived & ~gone]
    group = np.array([(_distances(singular, x[None]) < _CLUSTER).argmax() for x in singular], np.int64)
    failed += int((np.bincount(group) == 1).sum())
    return _Census(_distinct(sound), _distinct(sharp), singular, group, failed)


def _distances(first: C128, second: C128) -> F64:
    """Return the distances (n, m) of unit vectors regardless of their phase."""
    products = first @ second.conj().T
    apart: F64 = np.linalg.norm(first[:, None, :] - products[:, :, None] * second[None, :, :], axis=2)
    return apart


def _distinct(points: C128) -> C128:
    """Keep the first of every group of points closer than _SAME."""
    near = _distances(points, points) < _SAME
    return points[~np.tril(near, -1).any(axis=1)]


def _real_poses(scaled: _Scaled, census: _Census, tolerance: float) -> tuple[F64, int]:
    """Return the real postures (k, 4, 4) in the caller's frames and how many did not reach the tolerance.

    A solution is real if it is its own complex conjugate, which another solution is never closer to than
    _SAME.  A singular end is real if Newton's method on the real equations converges next to it.
    """
    own = np.array([_distances(x[None], x[None].conj())[0, 0] for x in census.regular], np.float64)
    points = np.concatenate([census.regular[own < _SAME], census.singular])
    certain = np.arange(len(points)) < len(points) - len(census.singular)
    phase = np.take_along_axis(points, np.abs(points[:, :4]).argmax(axis=1)[:, None], axis=1)
    points = points * np.exp(-1j * np.angle(phase))
    near = np.linalg.norm(points.imag, axis=1) < 0.01
    turns, shifts = _pose_of(points.real[near])
    turns, shifts, worst, moved = _refine_real(scaled, turns, shifts)
    good = (worst <= tolerance) & (moved < np.where(certain[near], 1e-5, 0.03))
    lost = int((certain[near] & ~good).sum())
    rotations, shifts = _rotations(turns[good]), shifts[good]
    flat = np.concatenate([rotations.reshape(-1, 9), shifts], axis=1)
    apart = np.linalg.norm(flat[:, None] - flat[None], axis=2)
    single = ~np.tril(apart < _CLOSE, -1).any(axis=1)
    poses = np.zeros((int(single.sum()), 4, 4))
    poses[:, :3, :3] = rotations[single]
    poses[:, :3, 3] = scaled.base_centre + scaled.unit * shifts[single]
    poses[:, :3, 3] -= poses[:, :3, :3] @ scaled.platform_centre
    poses[:, 3, 3] = 1
    return poses, lost


def _pose_of(points: F64) -> tuple[F64, F64]:
    """Return the unit quaternions (k, 4), scalar first, and translations (k, 3) of real points (k, 8)."""
    points = points / np.linalg.norm(points[:, :4], axis=1, keepdims=True)
    e, h = points[:, :4], points[:, 4:]
    return e, e[:, :1] * h[:, 1:] - h[:, :1] * e[:, 1:] + np.cross(e[:, 1:], h[:, 1:])


def _rotations(turns: F64) -> F64:
    """Return the rotation matrices (k, 3, 3) of unit quaternions (k, 4), scalar first."""
    w, v = turns[:, 0, None, None], turns[:, 1:]
    skew = np.cross(v[:, None, :], np.eye(3)).transpose(0, 2, 1)
    return np.eye(3) + 2 * (w * skew + skew @ skew)


def _refine_real(scaled: _Scaled, turns: F64, shifts: F64) -> tuple[F64, F64, F64, F64]:
    """Improve poses by Newton steps on the six lengths; return them, max |error| and the way moved (k,).

    ::

        dL_i = u_i . dt + (R p_i x u_i) . w,   u_i = (t + R p_i - b_i) / L_i,   e <- (1, w / 2) e / |.|
    """
    best = (turns.copy(), shifts.copy(), np.full(len(shifts), np.inf), np.zeros(len(shifts)))
    moved = np.zeros(len(shifts))
    for _ in range(12):
        arms = np.einsum("kij,nj->kni", _rotations(turns), scaled.platform)
        legs = arms + shifts[:, None] - scaled.base
        size = np.linalg.norm(legs, axis=2)
        errors = size - scaled.lengths
        worst = np.abs(errors).max(axis=1)
        better = worst < best[2]
        for kept, now in zip(best, (turns, shifts, worst, moved), strict=True):
            kept[better] = now[better]
        if not better.any():
            break
        units = legs / size[:, :, None]
        jacobian = np.concatenate([units, np.cross(arms, units)], axis=2)
        step = -np.einsum("kij,kj->ki", np.linalg.pinv(jacobian, rcond=1e-11), errors)
        shifts = shifts + step[:, :3]
        half = 0.5 * step[:, 3:]
        scalar = turns[:, :1] - (half * turns[:, 1:]).sum(axis=1, keepdims=True)
        vector = turns[:, 1:] + turns[:, :1] * half + np.cross(half, turns[:, 1:])
        turns = np.concatenate([scalar, vector], axis=1)
        turns = turns / np.linalg.norm(turns, axis=1, keepdims=True)
        moved = moved + np.linalg.norm(step, axis=1)
    return best


def _sort(poses: F64, unit: float) -> F64:
    """Return the poses highest first (the rule of `AssemblyModes.poses`)."""
    places = poses[:, 2::-1, 3] / unit
    keys = np.concatenate([places, poses[:, :3, :3].reshape(-1, 9)], axis=1)
    return poses[np.lexsort(np.round(-keys, 9).T[::-1])]
