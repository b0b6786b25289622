"""How far each leg leans from its direction at home, seen from the base and from the platform."""

from __future__ import annotations

import numpy as np

from hexathermal.kinematics.inverse import poses_of
from hexathermal.kinematics.jacobian import jacobian
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray, PoseLike


def lean_angles(hexapod: Hexapod, pose: PoseLike) -> tuple[FloatArray, FloatArray]:
    """Return the angle of each leg from its home direction, seen from the base and from the platform.

    ``angle(u, u_home)`` and ``angle(R^T u, R_home^T u_home)`` with the leg's unit vector ``u`` in base axes.

    Parameters
    ----------
    hexapod : Hexapod
    pose : SE3 or array, shape (..., 4, 4) [m]

    Returns
    -------
    base, platform : array, shape (..., 6) [rad]

    Raises
    ------
    ArgumentError, KinematicsError
        As `jacobian`.

    Examples
    --------
    >>> import hexathermal as ht
    >>> hexapod = ht.load_hexapod("reference")
    >>> base, platform = lean_angles(hexapod, ht.pose_from_coordinates([0, 0, 0, 0, 0, 10]))
    >>> bool((platform > base).all())         # a turn about z alone: the platform's joints turn further than the legs
    True
    """
    poses = poses_of(pose)
    return angles_of(hexapod, jacobian(hexapod, poses)[..., :3], poses[..., :3, :3])


def home_directions(hexapod: Hexapod) -> tuple[FloatArray, FloatArray]:
    """Return the legs' unit vectors at home (6, 3), in base axes and in platform axes."""
    units = jacobian(hexapod, hexapod.home)[:, :3]
    return units, in_platform(units, hexapod.home[:3, :3])


def in_platform(units: FloatArray, rotations: FloatArray) -> FloatArray:
    """Return vectors (..., 6, 3) given in base axes as the platform sees them: ``R^T u``."""
    return np.asarray(units @ rotations)


def angles_of(hexapod: Hexapod, units: FloatArray, rotations: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return `lean_angles` from the legs' unit vectors (..., 6, 3) and the platform's rotations (..., 3, 3)."""
    base, platform = home_directions(hexapod)
    return _angle(base, units), _angle(platform, in_platform(units, rotations))


def _angle(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the angle between unit vectors, exact also near 0 and 180 degrees."""
    sine = np.linalg.norm(np.cross(np.broadcast_to(a, b.shape), b), axis=-1)
    return np.asarray(np.arctan2(sine, (a * b).sum(axis=-1)))
