"""What the sag under a payload adds to a budget: how it changes where compliance, payload or pose are off."""

from __future__ import annotations

import numpy as np

from hexathermal.kinematics.jacobian import jacobian
from hexathermal.kinematics.statics import forces_in_balance
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray
from hexathermal.predict.budget_blocks import blocks, deviation_size
from hexathermal.predict.pose_errors import moved_poses

OF_LOAD = ("compliance", "payload mass", "payload centre")
"""Quantities of a deviation that tell how far load and legs' compliance are off."""

SMALL_MOTION = 1e-5
"""Half the motion [m, rad] over which the sag's change with the pose is taken: its square is lost."""


def deviated_sag(hexapod: Hexapod, poses: FloatArray, x: FloatArray) -> FloatArray:
    """Return the sag of legs, shape (n, 6) [m], where compliance and payload deviate; 0 without a compliance.

    Parameters
    ----------
    hexapod : Hexapod
    poses : array, shape (n, 4, 4) [m]
        True poses, regular.
    x : array, shape (n or 1, size)
        Deviations, see `hexathermal.predict.budget_blocks`.
    """
    own = hexapod.compliance
    if own is None:
        return np.zeros((len(poses), 6))
    compliance, mass, centre = (x[:, blocks(hexapod, quantity)[0]] for quantity in OF_LOAD)
    weight, point = (own.payload_mass + mass) * own.gravity, own.payload_centre + centre
    forces = forces_in_balance(jacobian(hexapod, poses), poses, weight, np.broadcast_to(point, (len(poses), 3)))
    return np.asarray(-(own.leg_compliance + compliance) * forces)


def sag_rates(hexapod: Hexapod, pose: FloatArray) -> FloatArray:
    """Return the derivatives of `deviated_sag` for each deviation at one pose, shape (6, size).

    The sag is linear in each single deviation: differences about the middle are exact.
    """
    chosen = np.concatenate([blocks(hexapod, quantity)[0] for quantity in OF_LOAD])
    rates = np.zeros((6, deviation_size(hexapod)))
    if chosen.size:
        steps = np.eye(rates.shape[1])[chosen]
        above, below = (
            deviated_sag(hexapod, np.repeat(pose[None], len(steps), axis=0), sign * steps) for sign in (1.0, -1.0)
        )
        rates[:, chosen] = np.transpose(0.5 * (above - below))
    return rates


def sag_stiffness(hexapod: Hexapod, poses: FloatArray, points: FloatArray) -> FloatArray:
    """Return how the sag changes with small motions of poses about points, shape (n, 6, 6) [1 | m/rad].

    Parameters
    ----------
    poses : array, shape (n, 4, 4) [m]
    points : array, shape (n, 3) [m]
        Base frame.
    """
    none = np.zeros((1, deviation_size(hexapod)))
    out = np.empty((len(poses), 6, 6))
    for k in range(6):
        step = np.zeros(6)
        step[k] = SMALL_MOTION
        above, below = (deviated_sag(hexapod, moved_poses(poses, sign * step, points), none) for sign in (1.0, -1.0))
        out[:, :, k] = (above - below) / (2.0 * SMALL_MOTION)
    return out
