"""Why a pose or a set of lengths is refused: one error for each cause, with leg, value and limits."""

from __future__ import annotations

from typing import NoReturn

import numpy as np

from hexathermal.errors import (
    ArgumentError,
    JointConeError,
    NotConvergedError,
    OtherBranchError,
    OutOfStrokeError,
    SingularPoseError,
)
from hexathermal.kinematics import layout as at
from hexathermal.kinematics.batches import where
from hexathermal.kinematics.constants import LARGEST_CONDITION, constants
from hexathermal.kinematics.inverse import inverse_kinematics
from hexathermal.kinematics.lean import lean_angles
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray


def refuse_forward(
    hexapod: Hexapod, code: int, pose: FloatArray, lengths: FloatArray, index: tuple[int, ...] = ()
) -> NoReturn:
    """Raise the error of a code, with leg, value and limits."""
    here = where(index)
    if code == at.OUT_OF_STROKE:
        refuse_stroke(hexapod, lengths, index)
    if code == at.OUT_OF_CONE:
        refuse_cone(hexapod, pose, index)
    error = np.abs(_lengths(hexapod, pose) - lengths)
    leg = int(np.nanargmax(error)) if np.isfinite(error).any() else 0
    if code == at.SINGULAR:
        raise SingularPoseError(
            f"singular pose{here}: the leg lengths do not hold the platform (condition number above "
            f"{LARGEST_CONDITION:g}); keep away from it, or start from another guess",
            value=float(np.inf), upper=LARGEST_CONDITION, index=index,
        )  # fmt: skip
    if code == at.OTHER_BRANCH:
        raise OtherBranchError(
            f"these lengths{here} are met only in another posture than the one reached from the start: the way "
            "there passes a singular pose; assembly_modes(lengths) lists all postures, forward_kinematics(lengths, "
            "guess=...) starts elsewhere",
            value=float(error[leg]), index=index,
        )  # fmt: skip
    raise NotConvergedError(
        f"no pose has these leg lengths{here}: leg {leg + 1} stays {error[leg]:.3g} m off "
        f"(allowed {2e-14 * constants(hexapod).size:.1g} m); check the lengths (metres, q0 + q) or give a guess",
        leg=leg + 1, value=float(error[leg]), upper=2e-14 * constants(hexapod).size, index=index,
    )  # fmt: skip


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
    hint = "; lengths are in metres, were millimetres given?" if value > 20.0 * high else ""
    raise OutOfStrokeError(
        f"leg {leg + 1} out of stroke{where(index)}: {value * 1e3:.6f} mm, "
        f"allowed [{low * 1e3:.6f}, {high * 1e3:.6f}] mm: {side}{hint}; choose a pose closer to home",
        leg=leg + 1, value=value, lower=low, upper=high, index=index,
    )  # fmt: skip


def refuse_cone(hexapod: Hexapod, pose: FloatArray, index: tuple[int, ...] = ()) -> NoReturn:
    """Raise for the joint that is furthest out of its cone."""
    worst: tuple[float, str, int, float, float] = (-np.inf, "", 0, 0.0, 0.0)
    cones = (("base", hexapod.base_cone), ("platform", hexapod.platform_cone))
    for (joint, cone), angle in zip(cones, lean_angles(hexapod, pose), strict=True):
        if cone is not None:
            leg = int((angle - cone).argmax())
            worst = max(worst, (float(angle[leg] - cone[leg]), joint, leg, float(angle[leg]), float(cone[leg])))
    _over, joint, leg, value, upper = worst
    raise JointConeError(
        f"leg {leg + 1} leans {np.degrees(value):.4f} deg at its {joint} joint{where(index)}, "
        f"allowed {np.degrees(upper):.4f} deg from its home direction; choose a pose closer to home",
        leg=leg + 1, value=value, lower=0.0, upper=upper, index=index,
    )  # fmt: skip
