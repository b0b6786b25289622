"""The difference of two poses, and poses moved by a small motion: translations and rotation vectors in base axes."""

from __future__ import annotations

import numpy as np

from hexathermal.poses import FloatArray


def pose_errors(wanted: FloatArray, reached: FloatArray) -> FloatArray:
    """Return reached minus wanted poses: ``[t - t_w, log(R R_w^T)]`` in base axes.

    Parameters
    ----------
    wanted, reached : array, shape (..., 4, 4) [m]
        They broadcast against each other.

    Returns
    -------
    array, shape (..., 6) [m, m, m, rad, rad, rad]
    """
    from scipy.spatial.transform import Rotation

    turn = reached[..., :3, :3] @ np.swapaxes(wanted[..., :3, :3], -1, -2)
    vectors = Rotation.from_matrix(turn.reshape(-1, 3, 3)).as_rotvec().reshape(*turn.shape[:-2], 3)
    return np.concatenate([reached[..., :3, 3] - wanted[..., :3, 3], vectors], axis=-1)


def moved_poses(poses: FloatArray, motion: FloatArray, centre: FloatArray) -> FloatArray:
    """Return poses after a rigid motion of the frame they are seen in.

    ``R' = exp(w) R`` and ``t' = c + exp(w) (t - c) + v`` with ``motion = [v, w]``.

    Parameters
    ----------
    poses : array, shape (..., 4, 4) [m]
    motion : array, shape (..., 6) [m, m, m, rad, rad, rad]
        One for all, or one for each pose.
    centre : array, shape (3,) [m]
        Point ``c`` that the turn leaves where it is.

    Examples
    --------
    >>> moved_poses(np.eye(4), np.array([1e-6, 0, 0, 0, 0, 0]), np.zeros(3))[0, 3].item()
    1e-06
    """
    from scipy.spatial.transform import Rotation

    R = Rotation.from_rotvec(np.array(motion[..., 3:]).reshape(-1, 3)).as_matrix().reshape(*motion.shape[:-1], 3, 3)
    out = np.array(np.broadcast_to(poses, np.broadcast_shapes(poses.shape, (*motion.shape[:-1], 4, 4))))
    out[..., :3, :3] = R @ poses[..., :3, :3]
    arm = poses[..., :3, 3] - centre
    out[..., :3, 3] = centre + np.einsum("...ij,...j->...i", R, arm) + motion[..., :3]
    return out


def moved_back(poses: FloatArray, motion: FloatArray, centre: FloatArray) -> FloatArray:
    """Return the poses that `moved_poses` moved, exactly: ``R = exp(-w) R'``, ``t = c + exp(-w) (t' - c - v)``.

    Parameters as `moved_poses`.

    Examples
    --------
    >>> motion = np.array([1e-3, 0, 2e-3, 0, 0.1, 0.2])
    >>> bool(abs(moved_back(moved_poses(np.eye(4), motion, np.ones(3)), motion, np.ones(3)) - np.eye(4)).max() < 1e-15)
    True
    """
    shift = np.zeros(motion.shape)
    shift[..., :3] = -motion[..., :3]
    turn = -motion - shift
    return moved_poses(moved_poses(poses, shift, centre), turn, centre)
