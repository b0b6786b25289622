"""All postures that six leg lengths allow: the forward problem of a hexapod solved completely.

Six lengths fix the platform up to at most 40 complex postures, and for some machines all 40 are real
(Dietmaier 1998).  They are found by parameter homotopy: the 40 solutions of a generic complex machine, stored
in `modes_start.npz` (made by `tools/make_modes_start.py`), are followed while that machine is deformed into
the caller's (`modes_tracker` has the equations).  Generically the 40 paths end at the 40 solutions, and 40
distinct ends prove that none is missing.

Where a machine moves with its legs locked, the solutions form curves and no list is complete.  Two kinds exist:
machines that do so at every pose (`architecturally_singular`; they are told from the joints alone), and machines
that do so at some lengths only.  The latter show in the ends: on a curve each start machine ends somewhere else,
and a step along the free motion leads to further postures.
"""

from __future__ import annotations

import dataclasses
import functools
import pathlib
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError
from hexathermal.kinematics.holding import (
    architecturally_singular,
    checked,
    moves,
    refine_real,
    rotations,
    singular_poses,
    way_between,
)

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
    leave towards infinity, and `complete` says that runs from two start machines agreed, multiple solutions
    included.  Two real postures closer than 3e-7 sizes, or closer than 1e-3 and both singular (condition number of
    the dimensionless Jacobian above 1e7), are listed once.

    A singular posture that stands alone (a fold, where two postures meet) leaves the list complete.  Lengths that a
    machine can hold while moving have no finite list, and `complete` is False: if the machine is
    `architecturally_singular` (nothing is then searched: no poses, `paths_failed` 40), if the multiple solutions
    found from two start machines differ by more than 1e-3, if a step of 0.02 sizes along the free motion of a
    singular posture leads to another singular posture that meets the tolerance, or if there are more poses than
    `complex_solutions`.

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
        Distinct finite complex solutions found, real ones included (40 for a machine of general geometry); at least
        the number of poses if `complete`.
    residuals : array, shape (k,) [m]
        max_i | |t + R p_i - b_i| - L_i | of each posture, read-only.
    paths_failed : int
        Paths that are not accounted for and postures that are not isolated; 0 if `complete`.
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
    blunt: C128  # (j, 8) finite ends at, or next to, multiple solutions: all that are not sharp
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
    base = checked("base_joints", base_joints, (6, 3))
    platform = checked("platform_joints", platform_joints, (6, 3))
    length = checked("lengths", lengths, (6,))
    if not np.all(length > 0):
        raise ArgumentError(f"lengths must be positive; got {length.tolist()} m")
    if not 1e-14 <= tolerance <= 1e-6:
        raise ArgumentError(f"tolerance must lie between 1e-14 and 1e-6; got {tolerance}")
    return _listed(base, platform, length, tolerance)


def _listed(base: F64, platform: F64, length: F64, tolerance: float) -> AssemblyModes:
    """Return the postures of checked input."""
    if architecturally_singular(base, platform):
        return AssemblyModes(_frozen(np.empty((0, 4, 4))), False, 0, _frozen(np.empty(0)), MOST_SOLUTIONS)
    scaled = _scale(base, platform, length)
    census = _solve(scaled)
    poses, unsettled = _real_poses(scaled, census, tolerance)
    poses = _sort(poses, scaled.unit)
    points = np.einsum("kij,nj->kni", poses[:, :3, :3], platform) + poses[:, None, :3, 3]
    residuals = np.abs(np.linalg.norm(points - base, axis=2) - length).max(axis=1)
    found = len(census.regular) + int((np.bincount(census.group) > 1).sum())
    failed = min(MOST_SOLUTIONS, census.failed + unsettled + max(0, len(poses) - found))
    return AssemblyModes(_frozen(poses), failed == 0, found, _frozen(residuals), failed)


def _frozen(array: F64) -> F64:
    array.setflags(write=False)
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

    One round is enough where 40 distinct solutions are found; else two rounds must find the same ones, and
    the same multiple ones: the ends on a curve of solutions depend on where the paths came from.
    Solutions of all rounds are united, with their complex conjugates (the target is real).
    """
    from hexathermal.kinematics import modes_tracker as tracker

    b, p, length = scaled.base, scaled.platform, scaled.lengths
    squares = (p**2).sum(axis=1) + (b**2).sum(axis=1) - length**2
    target = np.column_stack([squares, p, b]).astype(np.complex128)
    regular = sharp = np.empty((0, 8), np.complex128)
    agreed = False
    earlier: list[C128] = []
    census = _Census(regular, sharp, regular, regular, np.empty(0, np.int64), MOST_SOLUTIONS)
    for legs, points, fraction in zip(*_starts(), _FRACTIONS, strict=True):
        ends, states, reports = tracker.track_all(legs, target, points, fraction)
        census = _take_census(ends, states == tracker.REGULAR, reports)
        before = len(sharp)
        regular = _distinct(np.concatenate([regular, census.regular, census.regular.conj()]))
        sharp = _distinct(np.concatenate([sharp, census.sharp, census.sharp.conj()]))
        if len(regular) == MOST_SOLUTIONS:
            return _Census(regular, sharp, regular[:0], regular[:0], census.group[:0], 0)
        blunt = np.concatenate([census.blunt, census.blunt.conj()])
        agreed = census.failed == 0 and len(census.sharp) == before == len(sharp)
        agreed = agreed and any(_same_places(blunt, other) for other in earlier)
        earlier.append(blunt)
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
    blunt = np.concatenate([ends[arrived & ~gone & (sensitivity >= _SENSITIVE)], singular])
    return _Census(_distinct(sound), _distinct(sharp), blunt, singular, group, failed)


def _same_places(first: C128, second: C128) -> bool:
    """Tell whether each point has one of the other set within _CLUSTER."""
    if not len(first) or not len(second):
        return len(first) == len(second)
    near = _distances(first, second) < _CLUSTER
    return bool(near.any(axis=0).all() and near.any(axis=1).all())


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
    """Return the real postures (k, 4, 4) in the caller's frames and how many are open.

    Open are those that did not reach the tolerance and those that are not isolated.

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
    turns, shifts, worst, moved = refine_real(scaled.base, scaled.platform, scaled.lengths, turns, shifts)
    good = (worst <= tolerance) & (moved < np.where(certain[near], 1e-5, 0.03))
    lost = int((certain[near] & ~good).sum())
    turns, shifts = turns[good], shifts[good]
    singular = singular_poses(scaled.base, scaled.platform, turns, shifts)
    # rounding scatters a multiple solution by its root (1e-8 for a double one)
    limit = np.where(singular[:, None] & singular, _CLUSTER, _CLOSE)
    single = ~np.tril(way_between(turns[:, None], shifts[:, None], turns, shifts) < limit, -1).any(axis=1)
    turns, shifts, singular = turns[single], shifts[single], singular[single]
    lost += sum(
        moves(scaled.base, scaled.platform, scaled.lengths, turns[k], shifts[k], tolerance)
        for k in np.flatnonzero(singular)
    )
    poses = np.zeros((len(turns), 4, 4))
    poses[:, :3, :3] = rotations(turns)
    poses[:, :3, 3] = scaled.base_centre + scaled.unit * shifts
    poses[:, :3, 3] -= poses[:, :3, :3] @ scaled.platform_centre
    poses[:, 3, 3] = 1
    return poses, lost


def _pose_of(points: F64) -> tuple[F64, F64]:
    """Return the unit quaternions (k, 4), scalar first, and translations (k, 3) of real points (k, 8)."""
    points = points / np.linalg.norm(points[:, :4], axis=1, keepdims=True)
    e, h = points[:, :4], points[:, 4:]
    return e, e[:, :1] * h[:, 1:] - h[:, :1] * e[:, 1:] + np.cross(e[:, 1:], h[:, 1:])


def _sort(poses: F64, unit: float) -> F64:
    """Return the poses highest first (the rule of `AssemblyModes.poses`)."""
    places = poses[:, 2::-1, 3] / unit
    keys = np.concatenate([places, poses[:, :3, :3].reshape(-1, 9)], axis=1)
    return poses[np.lexsort(np.round(-keys, 9).T[::-1])]
