"""Static balance of the platform: the axial force in each leg under a weight, and how far the legs give way.

Joints carry no torque, so that the virtual work of the six axial forces is that of the weight.  Joints count where they
are drawn: what expansion of the plates does to the forces is some 1e-5 of them.
"""

from __future__ import annotations

import numpy as np

from hexathermal.errors import SingularPoseError
from hexathermal.kinematics.batches import place, where
from hexathermal.kinematics.constants import LARGEST_CONDITION
from hexathermal.kinematics.inverse import poses_of
from hexathermal.kinematics.jacobian import condition_number, jacobian
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray, PoseLike


def leg_forces(hexapod: Hexapod, pose: PoseLike, weight: FloatArray, centre: FloatArray) -> FloatArray:
    """Return the axial force in each leg that holds a weight, compression positive.

    ``J^T F = -[w, (R r) x w]`` with the weight ``w`` at ``r`` (virtual work: Merlet, Parallel Robots, 2006, ch. 9).
    Linear in ``w`` and in ``r w``.

    Parameters
    ----------
    hexapod : Hexapod
    pose : SE3 or array, shape (..., 4, 4) [m]
        Platform in base.
    weight : array, shape (3,) or (..., 3) [N]
        Force on the platform, base axes.
    centre : array, shape (3,) or (..., 3) [m]
        Where it acts, platform frame.

    Returns
    -------
    array, shape (..., 6) [N]

    Raises
    ------
    SingularPoseError
        The legs do not hold the platform: the condition number of the Jacobian is above 1e7.
    ArgumentError, KinematicsError
        As `jacobian`.

    Examples
    --------
    >>> import hexathermal as ht
    >>> hexapod = ht.load_hexapod("reference")
    >>> F = leg_forces(hexapod, hexapod.home, np.array([0.0, 0.0, -600.0]), np.zeros(3))
    >>> upright = hexapod.jacobian(hexapod.home)[:, 2]
    >>> round(float(upright @ F), 9)                          # the legs together carry 600 N
    600.0
    """
    poses = poses_of(pose)
    J, conditions = jacobian(hexapod, poses), np.asarray(condition_number(hexapod, poses))
    held = conditions <= LARGEST_CONDITION
    if not held.all():
        worst = int(np.flatnonzero(~held.ravel())[0])
        number = float(conditions.ravel()[worst])
        raise SingularPoseError(
            f"leg forces are not defined{where(place(worst, held.shape))}: the legs do not hold the platform; "
            f"condition number {number:.3g}, allowed {LARGEST_CONDITION:g}: move away from the singular pose",
            value=number, upper=LARGEST_CONDITION, index=place(worst, held.shape),
        )  # fmt: skip
    return forces_in_balance(J, poses, weight, centre)


def forces_in_balance(J: FloatArray, poses: FloatArray, weight: FloatArray, centre: FloatArray) -> FloatArray:
    """Return `leg_forces` from Jacobians (..., 6, 6) at poses (..., 4, 4) that are known to be regular."""
    arm = np.einsum("...ij,...j->...i", poses[..., :3, :3], np.asarray(centre))
    arm, force = np.broadcast_arrays(arm, weight)
    wrench = np.concatenate([force, np.cross(arm, force)], axis=-1)
    return np.asarray(np.linalg.solve(np.swapaxes(J, -1, -2), -wrench[..., None])[..., 0])


def payload_sag(hexapod: Hexapod, pose: PoseLike, *, held: bool = False) -> FloatArray:
    """Return how much longer each leg is under the machine's payload, ``-c_i F_i``: below 0 where it is compressed.

    See `hexathermal.machine.compliance.Compliance`.

    Parameters
    ----------
    hexapod, pose
        As `leg_forces`.
    held : bool
        The legs are known to hold the platform at these poses: their condition is not asked again.

    Returns
    -------
    array, shape (..., 6) [m]
        Zeros without a compliance.

    Examples
    --------
    >>> import dataclasses
    >>> import hexathermal as ht
    >>> from hexathermal.machine.compliance import Compliance
    >>> soft = dataclasses.replace(ht.load_hexapod("reference"), compliance=Compliance(2e-8, 60.0))
    >>> bool((payload_sag(soft, soft.home) < 0.0).all())              # all legs are pressed
    True
    """
    own = hexapod.compliance
    if own is None:
        return np.zeros((*poses_of(pose).shape[:-2], 6))
    if held:
        try:
            poses = poses_of(pose)
            forces = forces_in_balance(jacobian(hexapod, poses), poses, own.weight, own.payload_centre)
            return np.asarray(-own.leg_compliance * forces)
        except np.linalg.LinAlgError:  # not held after all: refused below
            pass
    return np.asarray(-own.leg_compliance * leg_forces(hexapod, pose, own.weight, own.payload_centre))
