"""The Jacobian of the leg lengths."""

from __future__ import annotations

import numpy as np

from hexathermal.errors import KinematicsError
from hexathermal.kinematics.batches import in_chunks, loops, place, slices, where
from hexathermal.kinematics.constants import constants, dimensionless
from hexathermal.kinematics.inverse import poses_of, refuse_pose
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray, PoseLike, pose_array


def jacobian(hexapod: Hexapod, pose: PoseLike) -> FloatArray:
    """Return ``J`` with ``dL/dt = J [v, w]``: the rates of the leg lengths for a twist of the platform.

    Row ``i`` is ``[u_i^T, (R p_i x u_i)^T]`` with the unit vector ``u_i`` from base joint to platform joint.  The twist
    is taken at the platform's origin: ``v`` its velocity, ``w`` the angular velocity, both in base axes.

    Parameters
    ----------
    hexapod : Hexapod
    pose : SE3 or array, shape (..., 4, 4) [m]

    Returns
    -------
    array, shape (..., 6, 6) [1 | m/rad]

    Raises
    ------
    ArgumentError
        As `inverse_kinematics`.
    KinematicsError
        A leg has length 0: it has no direction.

    Examples
    --------
    >>> import hexathermal as ht
    >>> hexapod = ht.load_hexapod("reference")
    >>> J = hexapod.jacobian(hexapod.home)
    >>> J.shape, bool(abs((J[:, :3] ** 2).sum(axis=1) - 1).max() < 1e-12)          # unit vectors
    ((6, 6), True)
    """
    c = constants(hexapod).machine
    if type(pose) is np.ndarray:
        out = np.empty((6, 6))
        try:
            if loops().jacobian_one(c, pose, out) == 0:
                return out
        except TypeError:  # not one writable 4 x 4 array of doubles: the way for all that follows
            pass
    poses = poses_of(pose)
    lead = poses.shape[:-2]
    flat = poses.reshape(-1, 4, 4)
    out = np.empty((flat.shape[0], 6, 6))

    def work(first: int, last: int) -> int:
        bad = loops().jacobians_many(c, flat[first:last], out[first:last])
        return -1 if bad < 0 else first + int(bad)

    for bad in in_chunks(flat.shape[0], work):
        if bad >= 0:
            index = place(bad, lead)
            pose_array(flat[bad], f"pose{where(index)}")
            if not np.isfinite(out[bad]).all():
                _refuse_vanished_leg(out[bad], index)
            refuse_pose(hexapod, flat[bad], index)
    return out.reshape(*lead, 6, 6)


def _refuse_vanished_leg(rows: FloatArray, index: tuple[int, ...]) -> None:
    """Name the leg whose two joints coincide."""
    leg = int(np.argmax(~np.isfinite(rows).all(axis=1))) + 1
    raise KinematicsError(f"leg {leg} has length 0{where(index)}: it has no direction", leg=leg, value=0.0, index=index)


def condition_number(hexapod: Hexapod, pose: PoseLike) -> FloatArray:
    """Return the condition number of the Jacobian at a pose, rotations counted as motions of the platform's joints.

    The Jacobian is taken at the centroid of the platform joints and its rotational columns are divided by the joints'
    root-mean-square radius, so that the number has no unit and does not depend on where the platform's origin is.

    Returns
    -------
    array, shape (...)
        1 is perfect, infinity singular.
    """
    made = constants(hexapod)
    poses = poses_of(pose)
    flat = poses.reshape(-1, 4, 4)
    out = np.empty(flat.shape[0])
    for part in slices(flat.shape[0]):
        J = at_centre(jacobian(hexapod, flat[part]), flat[part], made.centre)
        out[part] = np.linalg.cond(dimensionless(J, made.radius))
    return out.reshape(poses.shape[:-2])


def at_centre(J: FloatArray, poses: FloatArray, centre: FloatArray) -> FloatArray:
    """Return Jacobians with the twist taken at the point ``centre`` of the platform: ``v = v_c - w x (R c)``."""
    arm = np.einsum("...ij,j->...i", poses[..., :3, :3], centre)
    moved = J.copy()
    moved[..., 3:] -= np.cross(np.broadcast_to(arm[..., None, :], J[..., :3].shape), J[..., :3])
    return moved
