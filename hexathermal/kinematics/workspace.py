"""The workspace: margins at poses and over grids, reachable volume, straight-line moves."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError
from hexathermal.kinematics.limits import Limit, Margins, margins
from hexathermal.kinematics.path import PathCheck, check_path, path_poses
from hexathermal.kinematics.volume import Volume, poses_from_home, reachable_volume, rotation_array
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray, finite_array

__all__ = [
    "Limit",
    "Margins",
    "PathCheck",
    "Volume",
    "check_path",
    "margins",
    "path_poses",
    "reachable_volume",
    "workspace_grid",
]


def workspace_grid(
    hexapod: Hexapod,
    x: npt.ArrayLike,
    y: npt.ArrayLike,
    z: npt.ArrayLike,
    rotation: npt.ArrayLike | None = None,
    collisions: bool = False,
) -> tuple[FloatArray, Margins]:
    """Return the poses of a grid about home, and what is left to every limit there.

    ``T[i, j, k] = T_base_home [rotation | (x_i, y_j, z_k)]``: positions and turns count from home, as controllers do.

    Parameters
    ----------
    hexapod : Hexapod
    x, y, z : array, shape (nx,), (ny,), (nz,) [m]
        A single number is an axis of one.
    rotation : array, shape (..., 3, 3), optional
        Turns from home, ``R_base_platform = R_base_home rotation``; default none.
    collisions : bool
        See `margins`.

    Returns
    -------
    poses : array, shape (..., nx, ny, nz, 4, 4) [m]
    margins : Margins
        With leading shape (..., nx, ny, nz).

    Raises
    ------
    ArgumentError
        An axis that is no list of finite numbers, or no rotation.

    Examples
    --------
    >>> import hexathermal as ht
    >>> hexapod = ht.load_hexapod("reference")
    >>> heights = [-0.15, 0.0, 0.15]
    >>> poses, found = workspace_grid(hexapod, 0.0, 0.0, heights)
    >>> found.reachable[0, 0].tolist()
    [False, True, False]
    """
    axes = []
    for name, values in (("x", x), ("y", y), ("z", z)):
        axis = np.atleast_1d(finite_array(values, (), name))
        if axis.ndim != 1:
            raise ArgumentError(f"{name} has shape {axis.shape}; expected (n,), one axis of the grid")
        axes.append(axis)
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    poses = poses_from_home(hexapod, points, rotation_array(rotation)[..., None, None, None, :, :])
    return poses, margins(hexapod, poses, collisions=collisions)
