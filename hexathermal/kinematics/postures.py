"""All postures of a machine at given leg lengths."""

from __future__ import annotations

from typing import NoReturn

import numpy as np
import numpy.typing as npt

from hexathermal.errors import KinematicsError
from hexathermal.kinematics.batches import place, where
from hexathermal.kinematics.forward import checked_lengths
from hexathermal.kinematics.holding import architecturally_singular
from hexathermal.kinematics.modes import AssemblyModes
from hexathermal.kinematics.modes import assembly_modes as all_modes
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray


def assembly_modes(hexapod: Hexapod, lengths: npt.ArrayLike) -> FloatArray:
    """Return every real posture with the given leg lengths, up to 40, each polished; limits are not applied.

    All solutions of ``|t + R p_i - b_i| = L_i``, found by following the 40 complex solutions of a generic machine; see
    `hexathermal.kinematics.modes.assembly_modes` for method and record.

    Parameters
    ----------
    hexapod : Hexapod
    lengths : array, shape (..., 6) [m]

    Returns
    -------
    array, shape (..., k, 4, 4) [m]
        Ordered by falling z, y, x; ``k = 0`` where no posture exists. In a batch the shorter lists are filled up with
        NaN.

    Raises
    ------
    KinematicsError
        The machine is architecturally singular (see `hexathermal.kinematics.holding`): its legs hold it at no pose.
        Or not every solution could be accounted for, as at lengths that let the machine move with locked legs.
    ArgumentError
        Wrong shape, not finite, or lengths not above 0.

    Examples
    --------
    >>> import hexathermal as ht
    >>> hexapod = ht.load_hexapod("reference")
    >>> modes = hexapod.assembly_modes(hexapod.inverse_kinematics(hexapod.home))
    >>> bool((abs(modes - hexapod.home).max(axis=(1, 2)) < 1e-12).sum() == 1)          # home is one of them
    True
    """
    array = checked_lengths(lengths)
    lead = array.shape[:-1]
    found = []
    for k, row in enumerate(array.reshape(-1, 6)):
        modes = all_modes(hexapod.base_joints, hexapod.platform_joints, row)
        if not modes.complete:
            _refuse(hexapod, modes, place(k, lead))
        found.append(modes.poses)
    most = max((len(poses) for poses in found), default=0)
    out = np.full((len(found), most, 4, 4), np.nan)
    for row_out, poses in zip(out, found, strict=True):
        row_out[: len(poses)] = poses
    return out.reshape(*lead, most, 4, 4)


def _refuse(hexapod: Hexapod, modes: AssemblyModes, index: tuple[int, ...]) -> NoReturn:
    """Say why a list of postures cannot be complete."""
    if architecturally_singular(hexapod.base_joints, hexapod.platform_joints):
        raise KinematicsError(
            f"the postures{where(index)} cannot be listed: the machine is architecturally singular, its legs do not "
            "hold it at any pose and it moves with locked legs; check the joints: two plates that are "
            "scaled, mirrored or stretched copies with joints on a circle do so, and plates that are a point or a line",
            index=index,
        )
    raise KinematicsError(
        f"the postures{where(index)} could not all be found: {modes.paths_failed} of 40 paths stayed open "
        f"({len(modes.poses)} real postures were met); the machine may move with locked legs",
        value=float(modes.paths_failed),
        index=index,
    )
