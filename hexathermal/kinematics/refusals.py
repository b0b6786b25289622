"""Why a pose or a set of lengths is refused: one error for each cause, with leg, value and limits."""

from __future__ import annotations

from typing import NoReturn

import numpy as np

from hexathermal.errors import (
    ArgumentError,
    JointConeError,
    KinematicsError,
    NotConvergedError,
    OtherBranchError,
    OutOfStrokeError,
    SingularPoseError,
)
from hexathermal.kinematics import layout as at
from hexathermal.kinematics.batches import where
from hexathermal.kinematics.constants import LARGEST_CONDITION, constants, dimensionless
from hexathermal.kinematics.inverse import inverse_kinematics
from hexathermal.kinematics.jacobian import at_centre, jacobian
from hexathermal.kinematics.lean import angles_of
from hexathermal.kinematics.region import unit_determinants
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray

WAY = 1025
"""Poses of a straight move that are looked at for the smallest determinant."""


def refuse_forward(
    hexapod: Hexapod,
    code: int,
    pose: FloatArray,
    lengths: FloatArray,
    index: tuple[int, ...] = (),
    expansions: FloatArray | None = None,
    start: FloatArray | None = None,
) -> NoReturn:
    """Raise the error of a code, with leg, value and limits.

    `pose` is what the solver ended with, `lengths` the true ones it sought, `expansions` those of platform and base,
    `start` where it began (default: home).
    """
    here = where(index)
    if code == at.OUT_OF_STROKE:
        refuse_stroke(hexapod, lengths, index)
    if code == at.OUT_OF_CONE:
        refuse_cone(hexapod, pose, index, expansions)
    if code == at.SINGULAR:
        condition, leg = _condition_and_leg(hexapod, pose)
        raise SingularPoseError(
            f"singular pose{here}: the leg lengths do not hold the platform (condition number {condition:.3g}, allowed "
            f"{LARGEST_CONDITION:g}; leg {leg + 1} is the most dependent); keep away, or start from another guess",
            leg=leg + 1, value=condition, lower=1.0, upper=LARGEST_CONDITION, index=index,
        )  # fmt: skip
    if code == at.OTHER_BRANCH:
        ratio = _smallest_ratio(hexapod, hexapod.home if start is None else start, pose)
        _condition, leg = _condition_and_leg(hexapod, pose)
        why = "the way there passes a singular pose" if ratio <= 0.0 else "more than one can be reached from it"
        raise OtherBranchError(
            f"these lengths{here} were met only in another posture than the one reached from the start: {why} "
            f"(det J falls to {ratio:.3g} of the start's; leg {leg + 1} is the most dependent there); "
            "assembly_modes(lengths) lists all postures, forward_kinematics(lengths, guess=...) starts elsewhere",
            leg=leg + 1, value=ratio, lower=0.0, index=index,
        )  # fmt: skip
    error = np.abs(_lengths(warm_machine(hexapod, expansions), pose) - lengths)
    leg = int(np.nanargmax(error)) if np.isfinite(error).any() else 0
    allowed = 2e-14 * constants(hexapod).size
    raise NotConvergedError(
        f"no pose with these leg lengths{here} was found from the start: leg {leg + 1} stays {error[leg]:.3g} m off "
        f"(allowed {allowed:.1g} m); check the lengths (metres, q0 + q), give a guess, or ask assembly_modes(lengths)",
        leg=leg + 1, value=float(error[leg]), lower=0.0, upper=allowed, index=index,
    )  # fmt: skip


def warm_machine(hexapod: Hexapod, expansions: FloatArray | None) -> Hexapod:
    """Return the machine between expanded plates, without strokes; `expansions`: ``alpha dT`` of platform and base."""
    if expansions is None or not expansions.any():
        return hexapod
    platform, base = hexapod.platform_joints * (1.0 + expansions[0]), hexapod.base_joints * (1.0 + expansions[1])
    return Hexapod(base, platform, home=hexapod.home, name=hexapod.name)


def _smallest_ratio(hexapod: Hexapod, start: FloatArray, pose: FloatArray) -> float:
    """Return the smallest ``det J`` on the straight move between two poses, as a part of that at the start."""
    from hexathermal.kinematics.path import path_poses

    way, centre = path_poses(start, pose, np.linspace(0.0, 1.0, WAY)), constants(hexapod).centre
    R, t = way[:, :3, :3], way[:, :3, 3]
    determinants = unit_determinants(hexapod.platform_joints - centre, hexapod.base_joints, R, t + R @ centre)
    with np.errstate(all="ignore"):
        return float(np.nan_to_num((determinants / determinants[0]).min()))


def _condition_and_leg(hexapod: Hexapod, pose: FloatArray) -> tuple[float, int]:
    """Return the condition number at a pose, and the leg with the largest part in the most dependent lengths."""
    made = constants(hexapod)
    try:
        J = dimensionless(at_centre(jacobian(hexapod, pose), pose, made.centre), made.radius)
    except (ArgumentError, KinematicsError):
        return np.inf, 0
    left, values, _right = np.linalg.svd(J)
    condition = values[0] / values[-1] if values[-1] > 0.0 else np.inf
    return float(condition), int(np.abs(left[:, -1]).argmax())


def _lengths(hexapod: Hexapod, pose: FloatArray) -> FloatArray:
    """Return lengths at a pose, NaN where it is no pose."""
    try:
        return inverse_kinematics(hexapod, pose)
    except ArgumentError:
        return np.full(6, np.nan)


def refuse_stroke(hexapod: Hexapod, lengths: FloatArray, index: tuple[int, ...] = ()) -> NoReturn:
    """Raise for the leg that is furthest out of stroke."""
    shortest, longest = hexapod.length_limits
    leg = int(np.maximum(shortest - lengths, lengths - longest).argmax())
    value, low, high = float(lengths[leg]), float(shortest[leg]), float(longest[leg])
    side = f"{(low - value) * 1e3:.6g} mm too short" if value < low else f"{(value - high) * 1e3:.6g} mm too long"
    found = f"{value * 1e3:.6f} mm"
    if value > 1e6:  # no length of a machine: a thousand kilometres
        found, side = f"{value:g} m", "far too long"
    hint = "; poses and lengths are in metres, were millimetres given?" if value > 2.0 * high else ""
    hint = "; lengths are q0 + q, were strokes given?" if value < 0.5 * low else hint
    raise OutOfStrokeError(
        f"leg {leg + 1} out of stroke{where(index)}: {found}, "
        f"allowed [{low * 1e3:.6f}, {high * 1e3:.6f}] mm: {side}{hint}; choose a pose closer to home",
        leg=leg + 1, value=value, lower=low, upper=high, index=index,
    )  # fmt: skip


def refuse_cone(
    hexapod: Hexapod, pose: FloatArray, index: tuple[int, ...] = (), expansions: FloatArray | None = None
) -> NoReturn:
    """Raise for the joint that is furthest out of its cone, between plates as warm as they are."""
    units = jacobian(warm_machine(hexapod, expansions), pose)[:, :3]
    worst: tuple[float, str, int, float, float] = (-np.inf, "", 0, 0.0, 0.0)
    cones = (("base", hexapod.base_cone), ("platform", hexapod.platform_cone))
    for (joint, cone), angle in zip(cones, angles_of(hexapod, units, pose[:3, :3]), strict=True):
        if cone is not None:
            leg = int((angle - cone).argmax())
            worst = max(worst, (float(angle[leg] - cone[leg]), joint, leg, float(angle[leg]), float(cone[leg])))
    _over, joint, leg, value, upper = worst
    raise JointConeError(
        f"leg {leg + 1} leans {np.degrees(value):.4f} deg at its {joint} joint{where(index)}, "
        f"allowed {np.degrees(upper):.4f} deg from its home direction; choose a pose closer to home",
        leg=leg + 1, value=value, lower=0.0, upper=upper, index=index,
    )  # fmt: skip
