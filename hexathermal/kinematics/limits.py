"""How far poses are from every limit of the machine: stroke, joint cones, travel, singularity, other legs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from hexathermal.errors import KinematicsError
from hexathermal.kinematics.batches import in_chunks
from hexathermal.kinematics.constants import LARGEST_CONDITION, constants, dimensionless
from hexathermal.kinematics.inverse import inverse_kinematics, poses_of
from hexathermal.kinematics.jacobian import at_centre, jacobian
from hexathermal.kinematics.lean import angles_of
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray, PoseLike, coordinates_from_pose

ROUNDING = 1e-12
"""Margins [m, rad] above minus this count as inside: a pose on its limit is reachable."""


class Limit(IntEnum):
    """Which limit decides; in arrays its number stands."""

    NONE = 0
    STROKE = 1
    BASE_CONE = 2
    PLATFORM_CONE = 3
    TRAVEL = 4
    SINGULAR = 5
    COLLISION = 6


@dataclass(frozen=True, eq=False)
class Margins:
    """What is left to each limit at poses of leading shape (...): negative outside, infinity where none is given.

    Attributes
    ----------
    stroke : array, shape (..., 6) [m]
        ``min(L - shortest, longest - L)``.
    base_cone, platform_cone : array, shape (..., 6) [rad]
        ``cone - angle``, the angle of `lean_angles`.
    limits : array, shape (..., 6) [m, m, m, rad, rad, rad]
        To the maker's travel `Hexapod.limits`: ``min(x - low, high - x)``, coordinates counted from home in its own
        convention.
    condition_number : float, or array, shape (...)
        As `condition_number`: 1 perfect, infinity singular.  A plain value for a single pose, and so are those below.
    side : int, or array, shape (...)
        Sign of ``det J`` as compared with home: 1 the same, -1 beyond a singular pose, 0 singular (condition number
        above 1e7).
    clearance : float, or array, shape (...) [m]
        Smallest distance between two legs, negative where they overlap; NaN when not asked for, or where a leg stands
        so that its joints cannot be placed.
    clearance_legs : array, shape (..., 2), int
        The two legs that are nearest, 1 to 6; 0 without `clearance`.
    share : float, or array, shape (...)
        Smallest share that is left of any limit: of half the stroke, of the cone, of half the travel, of home's
        ``1 / condition_number`` (with the sign of `side`), of the diameter of a leg's body for the clearance.  1 is
        mid-range, 0 on the limit.
    worst : Limit, or array, shape (...), int
        The `Limit` with the smallest share.
    worst_leg : int, or array, shape (...)
        Its leg, 1 to 6; 0 where it is no limit of a leg.
    reachable : bool, or array, shape (...)
        Within stroke, cones and travel (to 1e-12 m, rad), on home's side of all singular poses, and legs apart where
        asked for.  Necessary, not sufficient: `check_path` tells whether a move gets there.
    """

    stroke: FloatArray
    base_cone: FloatArray
    platform_cone: FloatArray
    limits: FloatArray
    condition_number: Any
    side: Any
    clearance: Any
    clearance_legs: npt.NDArray[np.int8]
    share: Any
    worst: Any
    worst_leg: Any
    reachable: Any

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if isinstance(value, np.ndarray):
                value.setflags(write=False)


class Standing(NamedTuple):
    """Flat poses, how their legs stand, and the singular values (N, 6) of the dimensionless Jacobian, falling."""

    poses: FloatArray
    lengths: FloatArray
    units: FloatArray
    singular_values: FloatArray
    side: npt.NDArray[np.int8]


def standing(hexapod: Hexapod, poses: FloatArray) -> Standing:
    """Return how the legs stand at poses (N, 4, 4); a leg of length 0 has no direction (NaN): a singular pose."""

    def part(first: int, last: int) -> tuple[FloatArray, FloatArray, FloatArray, npt.NDArray[np.int8]]:
        lengths, J = rates(hexapod, poses[first:last])
        return lengths, J[..., :3], *conditioning(hexapod, J, poses[first:last])

    parts = in_chunks(len(poses), part)
    return Standing(poses, *(np.concatenate(column) for column in zip(*parts, strict=True)))


def rates(hexapod: Hexapod, poses: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return lengths (N, 6) and Jacobians (N, 6, 6), the latter NaN at poses where a leg has length 0."""
    lengths = inverse_kinematics(hexapod, poses)
    whole = np.asarray((lengths > 0.0).all(axis=1))
    if whole.all():
        return lengths, jacobian(hexapod, poses)
    J = jacobian(hexapod, np.where(whole[:, None, None], poses, hexapod.home))
    return lengths, np.where(whole[:, None, None], J, np.nan)


def conditioning(hexapod: Hexapod, J: FloatArray, poses: FloatArray) -> tuple[FloatArray, npt.NDArray[np.int8]]:
    """Return the singular values (N, 6) of the dimensionless Jacobian, falling, and the side of each pose."""
    made = constants(hexapod)
    home = np.array(hexapod.home)[None]
    both, at_both = np.concatenate([jacobian(hexapod, home), J]), np.concatenate([home, poses])
    scaled = np.nan_to_num(dimensionless(at_centre(both, at_both, made.centre), made.radius))
    values = np.linalg.svd(scaled, compute_uv=False)
    regular = values[:, 0] < LARGEST_CONDITION * values[:, 5]
    sign = np.where(regular, np.sign(np.linalg.det(scaled)), 0.0)
    return np.asarray(values[1:]), (sign[1:] * sign[0]).astype(np.int8)


def travel_range(hexapod: Hexapod) -> FloatArray | None:
    """Return the maker's travel (6, 2) [m, rad] from home, or None."""
    limits = hexapod.limits
    if limits is None:
        return None
    return np.array([limits.x, limits.y, limits.z, limits.rx, limits.ry, limits.rz])


def travel_coordinates(hexapod: Hexapod, poses: FloatArray) -> FloatArray:
    """Return the six coordinates [m, rad] from home in the convention of the maker's travel, shape (..., 6)."""
    convention = "fixed-xyz" if hexapod.limits is None else hexapod.limits.convention
    six = coordinates_from_pose(poses, convention, hexapod)
    return np.concatenate([six[..., :3] / 1000.0, np.radians(six[..., 3:])], axis=-1)


def leg_margins(hexapod: Hexapod, now: Standing) -> dict[str, FloatArray]:
    """Return the margins (N, 6) of stroke, cones and travel, and the condition number (N,)."""
    shortest, longest = hexapod.length_limits
    infinite = np.full(now.lengths.shape, np.inf)
    stroke = infinite if hexapod.stroke is None else np.minimum(now.lengths - shortest, longest - now.lengths)
    found = {"stroke": stroke, "base_cone": infinite, "platform_cone": infinite, "limits": infinite}
    angles = angles_of(hexapod, now.units, now.poses[:, :3, :3])
    for name, cone, angle in zip(
        ("base_cone", "platform_cone"), (hexapod.base_cone, hexapod.platform_cone), angles, strict=True
    ):
        if cone is not None:
            found[name] = np.where(np.isnan(angle), -np.inf, cone - angle)
    travel = travel_range(hexapod)
    if travel is not None:
        x = travel_coordinates(hexapod, now.poses)
        found["limits"] = np.minimum(x - travel[:, 0], travel[:, 1] - x)
    with np.errstate(divide="ignore", invalid="ignore"):
        condition = now.singular_values[:, 0] / now.singular_values[:, 5]
    found["condition_number"] = np.where(np.isnan(condition), np.inf, condition)
    return found


def clearances(hexapod: Hexapod, poses: FloatArray) -> tuple[FloatArray, npt.NDArray[np.int8], float]:
    """Return the smallest distance of two legs (N,) [m], those legs (N, 2), and the diameter of a leg's body [m]."""
    from hexathermal.machine.pinocchio_model import PinocchioMachine

    machine = PinocchioMachine(hexapod)
    nearest, legs = np.full(len(poses), np.nan), np.zeros((len(poses), 2), dtype=np.int8)
    for k, pose in enumerate(poses):
        try:
            found = machine.distances(pose)
        except KinematicsError:  # a joint that cannot be placed: no length, or 90 degrees from home
            continue
        nearest[k], legs[k] = found.smallest, found.legs
    return nearest, legs, machine.shapes.bodies.leg_body_diameter


def decided(
    hexapod: Hexapod,
    found: Mapping[str, FloatArray],
    side: npt.NDArray[np.int8],
    near: tuple[FloatArray, npt.NDArray[np.int8], float] | None,
) -> Margins:
    """Return `Margins` from margins per limit: which is the worst, and whether all hold."""
    n = len(side)
    nearest, legs, diameter = near or (np.full(n, np.nan), np.zeros((n, 2), dtype=np.int8), 1.0)
    home = standing(hexapod, hexapod.home[None]).singular_values[0]
    shortest, longest = hexapod.length_limits
    half = 0.5 * (longest - shortest) if hexapod.stroke is not None else np.ones(6)
    travel = travel_range(hexapod)
    span = np.ones(6) if travel is None else 0.5 * (travel[:, 1] - travel[:, 0])
    apart = np.where(np.isnan(nearest), np.inf if near is None else -np.inf, nearest / diameter)
    shares = np.column_stack([
        found["stroke"] / half,
        found["base_cone"] / (1.0 if hexapod.base_cone is None else hexapod.base_cone),
        found["platform_cone"] / (1.0 if hexapod.platform_cone is None else hexapod.platform_cone),
        found["limits"] / span,
        side * (home[0] / max(home[5], np.finfo(float).tiny)) / found["condition_number"],
        apart,
    ])  # fmt: skip
    column = shares.argmin(axis=1)
    worst = np.minimum(column // 6, 4) + 1 + (column == 25)
    leg = np.where(column < 18, column % 6 + 1, np.where(column == 25, legs[:, 0], 0))
    inside = (side == 1) & (apart > 0.0)
    for name in ("stroke", "base_cone", "platform_cone", "limits"):
        inside &= (found[name] >= -ROUNDING).all(axis=1)
    return Margins(
        **found, side=side, clearance=nearest, clearance_legs=legs, share=shares.min(axis=1),
        worst=worst.astype(np.int8), worst_leg=leg.astype(np.int8), reachable=inside,
    )  # fmt: skip


def margins(hexapod: Hexapod, poses: PoseLike, *, collisions: bool = False) -> Margins:
    """Return what is left to every limit of the cold machine at each pose.

    Parameters
    ----------
    hexapod : Hexapod
    poses : SE3 or array, shape (..., 4, 4) [m]
    collisions : bool
        Also measure the distances between the legs, pose by pose with Pinocchio (about 0.3 ms each).

    Returns
    -------
    Margins
        Arrays with the leading shape of `poses`.

    Raises
    ------
    ArgumentError
        As `inverse_kinematics`.

    Examples
    --------
    >>> import hexathermal as ht
    >>> hexapod = ht.load_hexapod("reference")
    >>> found = margins(hexapod, ht.pose_from_coordinates([0, 0, 150, 0, 0, 0]))
    >>> found.reachable, found.worst.name, round(float(found.stroke.min()), 4)
    (False, 'STROKE', -0.0144)
    """
    array = poses_of(poses, "poses")
    lead = array.shape[:-2]
    flat = array.reshape(-1, 4, 4)
    now = standing(hexapod, flat)
    near = clearances(hexapod, flat) if collisions else None
    return shaped(decided(hexapod, leg_margins(hexapod, now), now.side, near), lead)


def shaped(found: Margins, lead: tuple[int, ...]) -> Margins:
    """Return flat margins with leading shape `lead`."""
    return Margins(**{item.name: reshaped(getattr(found, item.name), lead, item.name) for item in fields(found)})


def reshaped(flat: npt.NDArray[Any], lead: tuple[int, ...], name: str) -> Any:
    """Return a flat array with leading shape `lead`; a single number as a plain value, a limit as `Limit`."""
    array = flat.reshape((*lead, *flat.shape[1:]))
    if array.ndim:
        return array
    return Limit(array.item()) if name in ("worst", "limit") else array.item()
