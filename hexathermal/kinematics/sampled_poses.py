"""Poses drawn at random that a machine can take, from small to wide."""

from __future__ import annotations

import numpy as np

from hexathermal.errors import KinematicsError
from hexathermal.kinematics.limits import margins
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray, pose_from_coordinates

COORDINATE_DIGITS = 4
"""Decimals of the coordinates that are drawn [mm, deg]: a table holds them exactly."""

_TRIES = 400


def reachable_coordinates(
    hexapod: Hexapod, count: int, generator: np.random.Generator, *, share: float = 0.05
) -> FloatArray:
    """Return coordinates, counted from home, of random poses within all limits.

    Directions are uniform in a box of travel and turns, distances from home uniform; what is out of stroke, cones or
    the maker's travel, or nearer to a limit than `share` of it, is drawn again.

    Parameters
    ----------
    hexapod : Hexapod
    count : int
    generator : numpy.random.Generator
    share : float
        Part of each limit (see `Margins.share`) that is kept free.

    Returns
    -------
    array, shape (count, 6) [mm, mm, mm, deg, deg, deg]
        ``fixed-xyz``, see `pose_from_coordinates`.

    Raises
    ------
    KinematicsError
        Hardly a pose was found: the machine can hardly leave its home.

    Examples
    --------
    >>> import hexathermal as ht
    >>> hexapod = ht.load_hexapod("reference")
    >>> reachable_coordinates(hexapod, 5, np.random.default_rng(1)).shape
    (5, 6)
    """
    lengths = hexapod.home_lengths
    low, high = hexapod.length_limits
    room = float(np.where(np.isfinite(high - low), high - low, 0.5 * lengths).max())
    arm = float(np.linalg.norm(hexapod.platform_joints - hexapod.platform_joints.mean(axis=0), axis=1).mean())
    turn = min(room / arm, 0.7)
    box = np.array([room, room, room, turn, turn, turn]) * np.array([1e3, 1e3, 1e3, *np.degrees([1.0, 1.0, 1.0])])
    if hexapod.limits is not None:
        travel = np.array([np.abs(getattr(hexapod.limits, axis)).max() for axis in ("x", "y", "z", "rx", "ry", "rz")])
        box = np.minimum(box, travel * np.array([1e3, 1e3, 1e3, *np.degrees([1.0, 1.0, 1.0])]))
    found: list[FloatArray] = []
    for _try in range(_TRIES):
        six = generator.uniform(-1.0, 1.0, (256, 6)) * generator.uniform(0.05, 1.0, (256, 1)) * box
        six = np.round(six, COORDINATE_DIGITS) + 0.0
        here = margins(hexapod, pose_from_coordinates(six, hexapod=hexapod))
        found.append(six[np.asarray(here.reachable & (here.share >= share))])
        if sum(map(len, found)) >= count:
            return np.concatenate(found)[:count]
    raise KinematicsError(
        f"machine {hexapod.name!r} can hardly leave its home: {sum(map(len, found))} of {_TRIES * 256} random poses "
        f"were within its limits with {share:g} of each to spare; check home, stroke, cones and travel"
    )
