"""Pose accuracy, pose repeatability and their drift, as ISO 9283:1998 defines them.

One pose is commanded n times and measured each time.  ``p_j`` and ``R_j`` are measured position and rotation, ``p_c``
and ``R_c`` the commanded ones, all in the same axes::

    AP    = |mean p_j - p_c|                         AP_x, AP_y, AP_z: its components
    RP    = mean l_j + 3 S_l,   l_j = |p_j - mean p_j|,   S_l^2 = sum (l_j - mean l)^2 / (n - 1)
    AP_r  = log(R_mean R_c^T)                        AP_rx, AP_ry, AP_rz: turns about the axes; AP_rotation: its length
    RP_rx = 3 S_rx,   S_rx^2 = sum (r_j)_x^2 / (n - 1),   r_j = log(R_j R_mean^T)
    RP_rotation = mean |r_j| + 3 S of |r_j|
    AP_angle_rx = rx(R_mean) - rx(R_c)               ISO's AP_a, AP_b, AP_c; likewise ry and rz
    RP_angle_rx = 3 S of rx(R_j) - rx(R_mean)        ISO's RP_a, RP_b, RP_c, with n - 1
    dAP   = max over later groups |AP(first) - AP(later)|,   dRP likewise, and likewise for each turn

Rotations are averaged as rotations: ``R_mean`` is the rotation with the least sum of squared differences of matrices
(chordal mean: the rotation nearest to the mean of the matrices), and turns are rotation vectors about the axes in which
poses are given.  Numbers of Euler angles are never averaged: they jump at +-180 degrees and mix near ry = +-90 degrees.
ISO's own quantities are differences of the angles ``rx``, ``ry``, ``rz`` of the coordinates (in the convention of the
data), taken here from the mean rotation and brought into +-180 degrees; at rotated commands they are no turns about
axes.  Near ``ry = +-90`` degrees ``rx`` and ``rz`` cannot be told apart: the angles are then NaN.  Which angle the
letters a, b, c mean depends on the maker.

ISO 9283's drift compares lengths: a platform that moves from one side of the command to the other has ``dAP = 0``.
`PoseDrift.shift`, the largest move of the mean position itself, does not miss that.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import pinocchio as pin
from scipy.spatial.transform import Rotation

from hexathermal.errors import ArgumentError
from hexathermal.machine.thermal import frozen
from hexathermal.poses import FloatArray, PoseLike, coordinates_from_pose, pose_array

ASKED_CYCLES = 30
"""Visits of each pose that ISO 9283 asks for; fewer are evaluated, and said."""

WIDEST_SPREAD = np.pi / 4
"""Visits turned further from their mean than this are not visits of one pose [rad]."""

LARGEST_RY = np.radians(89.0)
"""Nearer to 90 degrees the other two angles cannot be told apart."""


@dataclass(frozen=True, eq=False)
class PoseAccuracy:
    """Pose accuracy and repeatability at one commanded pose.

    Attributes
    ----------
    count : int
        Visits.
    position : array, shape (3,) [m]
        ``mean p_j - p_c``: AP_x, AP_y, AP_z.
    rotation : array, shape (3,) [rad]
        Rotation vector of ``R_mean R_c^T``: AP_rx, AP_ry, AP_rz.
    AP, RP : float [m]
    AP_rotation, RP_rotation : float [rad]
    RP_axes : array, shape (3,) [rad]
        ``3 S`` about x, y and z: RP_rx, RP_ry, RP_rz.
    angles, RP_angles : array, shape (3,) [rad]
        Of the coordinates rx, ry and rz: AP_angle_rx .., RP_angle_rx ..; NaN near ``ry = +-90`` degrees.
    """

    count: int
    position: FloatArray
    rotation: FloatArray
    RP: float
    RP_rotation: float
    RP_axes: FloatArray
    angles: FloatArray
    RP_angles: FloatArray

    @property
    def AP(self) -> float:
        """Positional pose accuracy [m]."""
        return float(np.linalg.norm(self.position))

    @property
    def AP_rotation(self) -> float:
        """Angle between the mean and the commanded rotation [rad]."""
        return float(np.linalg.norm(self.rotation))


@dataclass(frozen=True, eq=False)
class PoseDrift:
    """Drift of pose accuracy and repeatability over groups of visits, and the groups (from 0) where it is largest.

    Attributes
    ----------
    dAP, dRP : float [m]
    dAP_axes : array, shape (3,) [m]
        Of AP_x, AP_y and AP_z.
    dAP_rotations, dRP_rotations : array, shape (3,) [rad]
        Of the turns about x, y and z.
    dAP_angles, dRP_angles : array, shape (3,) [rad]
        Of the angles rx, ry and rz.
    shift : float [m]
        Largest move of the mean position from that of the first group.
    worst : dict of str to int
        Group in which each of ``dAP``, ``dRP`` and ``shift`` was largest.
    """

    dAP: float
    dRP: float
    dAP_axes: FloatArray
    dAP_rotations: FloatArray
    dRP_rotations: FloatArray
    dAP_angles: FloatArray
    dRP_angles: FloatArray
    shift: float
    worst: dict[str, int]


def pose_accuracy(
    measured: PoseLike | Iterable[Any], commanded: PoseLike, convention: str = "fixed-xyz"
) -> PoseAccuracy:
    """Return pose accuracy and repeatability of one commanded pose (ISO 9283:1998, 7.2).

    Parameters
    ----------
    measured : array, shape (n, 4, 4) [m], or n SE3
        Measured poses, n >= 2; the standard asks for 30.
    commanded : SE3 or array, shape (4, 4) [m]
        In the same axes as the measured ones.
    convention : str
        Of the angles rx, ry, rz, see `hexathermal.poses`.

    Returns
    -------
    PoseAccuracy

    Raises
    ------
    ArgumentError
        Fewer than two visits, another shape, not rigid motions, or visits that are turned more than 45 degrees away
        from their mean.

    Examples
    --------
    Four visits about the origin, commanded (3, 4, 0):

    >>> visits = np.broadcast_to(np.eye(4), (4, 4, 4)).copy()
    >>> visits[:, :2, 3] = [[1, 0], [-1, 0], [0, 1], [0, -1]]
    >>> command = np.eye(4)
    >>> command[:2, 3] = [3, 4]
    >>> found = pose_accuracy(visits, command)
    >>> found.AP, found.RP
    (5.0, 1.0)
    """
    visits = _visits(measured)
    command = pose_array(commanded, "commanded pose")
    if command.shape != (4, 4):
        raise ArgumentError(f"commanded pose has shape {command.shape}; expected one pose (4, 4) for all its visits")
    return accuracies_of_poses(visits, command[None], np.zeros(1, dtype=np.intp), convention)[0]


def accuracies_of_poses(
    visits: FloatArray,
    commands: FloatArray,
    starts: npt.NDArray[np.intp],
    convention: str,
    places: Sequence[str] = ("",),
) -> list[PoseAccuracy]:
    """Return `pose_accuracy` of many commanded poses at once.

    Parameters
    ----------
    visits : array, shape (n, 4, 4) [m]
        Known to be poses, those of one command side by side, at least two of each.
    commands : array, shape (m, 4, 4) [m]
    starts : array, shape (m,)
        First visit of each command.
    convention : str
    places : sequence of str
        Of each command, for errors.
    """
    counts = np.diff(np.append(starts, len(visits)))
    which = np.repeat(np.arange(len(commands)), counts)

    def mean(values: FloatArray) -> FloatArray:
        """Return the mean over the visits of each command."""
        total = np.add.reduceat(values, starts, axis=0)
        return np.asarray(total / counts.reshape(-1, *[1] * (values.ndim - 1)))

    def spread(squares: FloatArray) -> FloatArray:
        """Return ``3 S`` of squared differences."""
        return np.asarray(3.0 * np.sqrt(np.add.reduceat(squares, starts, axis=0) / (counts - 1.0)[:, None]))

    shifts = visits[:, :3, 3] - commands[which, :3, 3]
    positions = mean(shifts)
    turned = visits[:, :3, :3] @ np.swapaxes(commands[which, :3, :3], -1, -2)
    middles = _nearest_rotations(mean(turned))
    deviations = Rotation.from_matrix(turned @ np.swapaxes(middles[which], -1, -2)).as_rotvec()
    _check_spread(deviations, starts, which, places)
    whole = commands.copy()
    whole[:, :3, :3] = middles @ commands[:, :3, :3]
    angles = angle_differences(np.concatenate([visits, commands]), np.concatenate([whole[which], whole]), convention)
    position, rotation = frozen(positions), frozen(Rotation.from_matrix(middles).as_rotvec())
    distances = np.stack([np.linalg.norm(own, axis=1) for own in (shifts - positions[which], deviations)], axis=1)
    typical = mean(distances)
    radii = typical + spread((distances - typical[which]) ** 2)
    axes, own = frozen(spread(deviations**2)), frozen(-angles[len(visits) :])
    spreads = frozen(spread(angles[: len(visits)] ** 2))
    return [
        PoseAccuracy(int(counts[k]), position[k], rotation[k], float(radii[k, 0]), float(radii[k, 1]), axes[k], own[k],
                     spreads[k])
        for k in range(len(commands))
    ]  # fmt: skip


def _nearest_rotations(means: FloatArray) -> FloatArray:
    """Return the rotations (m, 3, 3) nearest to means of rotations: the chordal means."""
    left, _sizes, right = np.linalg.svd(means)
    left[..., -1] *= np.linalg.det(left @ right)[:, None]
    return np.asarray(left @ right)


def angle_differences(measured: FloatArray, commanded: FloatArray, convention: str) -> FloatArray:
    """Return differences (n, 3) of the angles of poses (n, 4, 4) and (n or 1, 4, 4), within +-pi.

    They are NaN near ``ry = +-90`` degrees.
    """
    both = np.concatenate([measured.reshape(-1, 4, 4), commanded.reshape(-1, 4, 4)])
    angles = np.radians(coordinates_from_pose(both, convention)[:, 3:])
    own, other = angles[: -commanded.size // 16], angles[-commanded.size // 16 :]
    locked = np.maximum(np.abs(own[:, 1]), np.abs(other[:, 1])) > LARGEST_RY
    difference = (own - other + np.pi) % (2.0 * np.pi) - np.pi
    return np.asarray(np.where(locked[:, None], np.nan, difference))


def pose_drift(groups: Sequence[PoseAccuracy]) -> PoseDrift:
    """Return how pose accuracy and repeatability drift from the first group of visits on (ISO 9283:1998, 7.2.3).

    Parameters
    ----------
    groups : sequence of PoseAccuracy
        One commanded pose, in the order of time, at least two; the first is the cold machine.

    Returns
    -------
    PoseDrift

    Raises
    ------
    ArgumentError
        Fewer than two groups.
    """
    if len(groups) < 2:
        raise ArgumentError(f"found {len(groups)} group of visits; drift needs at least two: the cold one and a later")
    first, later = groups[0], groups[1:]
    curves = {
        "dAP": [abs(group.AP - first.AP) for group in later],
        "dRP": [abs(group.RP - first.RP) for group in later],
        "shift": [float(np.linalg.norm(group.position - first.position)) for group in later],
    }
    return PoseDrift(
        dAP=max(curves["dAP"]),
        dRP=max(curves["dRP"]),
        dAP_axes=frozen(np.abs([group.position - first.position for group in later]).max(axis=0)),
        dAP_rotations=frozen(np.abs([group.rotation - first.rotation for group in later]).max(axis=0)),
        dRP_rotations=frozen(np.abs([group.RP_axes - first.RP_axes for group in later]).max(axis=0)),
        dAP_angles=frozen(np.abs([group.angles - first.angles for group in later]).max(axis=0)),
        dRP_angles=frozen(np.abs([group.RP_angles - first.RP_angles for group in later]).max(axis=0)),
        shift=max(curves["shift"]),
        worst={name: 1 + int(np.argmax(values)) for name, values in curves.items()},
    )


def _visits(measured: Any) -> FloatArray:
    """Return the visits of a pose as an array (n, 4, 4), at least two."""
    if not isinstance(measured, np.ndarray | pin.SE3) and isinstance(measured, Iterable):
        measured = [item.homogeneous if isinstance(item, pin.SE3) else item for item in measured]
    visits = pose_array(measured, "measured poses") if np.size(measured) else np.zeros((0, 4, 4))
    if visits.ndim != 3:
        raise ArgumentError(f"measured poses have shape {visits.shape}; expected (n, 4, 4), the visits of one pose")
    if len(visits) < 2:
        raise ArgumentError(
            f"found {len(visits)} measured visit{'s' * (len(visits) != 1)} of a pose; expected at least 2, ISO 9283 "
            f"asks for {ASKED_CYCLES}: a single visit has no repeatability"
        )
    return visits


def _check_spread(
    deviations: FloatArray, starts: npt.NDArray[np.intp], which: npt.NDArray[np.intp], places: Sequence[str]
) -> None:
    """Refuse visits that have no common mean rotation."""
    angles = np.linalg.norm(deviations, axis=1)
    if angles.max() <= WIDEST_SPREAD:
        return
    k = int(which[np.argmax(angles > WIDEST_SPREAD)])
    own = np.where(which == k, angles, 0.0)
    worst = int(own.argmax())
    where = f"{places[k]}: " if places[k] else ""
    raise ArgumentError(
        f"{where}visit {worst - starts[k] + 1} is turned {np.degrees(own[worst]):.3g} degrees from the mean of all, "
        "allowed 45: these are not visits of one pose, or angles are in another unit or convention"
    )
