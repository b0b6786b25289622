"""From where a budget is looked at: the axes of its errors, and the point that they are told of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypedDict

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError, UnknownNameError
from hexathermal.poses import FloatArray, Frames, finite_array
from hexathermal.predict.budget_plates import Plates

FRAMES = ("machine", "user", "object")

LONGEST_ARM = 1e3
"""From the platform's origin to the point of a tool [m]: above it a unit is taken for wrong."""


class View(TypedDict, total=False):
    """How a machine is driven and looked at: keywords that all budgets share, see `error_budget`."""

    correction: bool
    frame: str
    frames: Frames | None
    at_tool: npt.ArrayLike | None
    plates: Plates | None
    air_degC: float | None


@dataclass(frozen=True, eq=False)
class Look:
    """The axes and the point of a budget.

    Attributes
    ----------
    frame : str
        One of `FRAMES`.
    arm : array, shape (3,) [m]
        The point, from the platform's origin, in platform axes.
    turn : array, shape (3, 3)
        Of the user frame in the machine, or of the object in the platform; the unit matrix for the machine frame.
    """

    frame: str
    arm: FloatArray
    turn: FloatArray

    def axes(self, poses: FloatArray) -> FloatArray:
        """Return what turns base axes into the frame's at poses (..., 4, 4), shape (..., 3, 3)."""
        turn = poses[..., :3, :3] @ self.turn if self.frame == "object" else self.turn
        return np.ascontiguousarray(np.broadcast_to(np.swapaxes(turn, -1, -2), poses[..., :3, :3].shape))


def look(frame: str = "machine", frames: Frames | None = None, at_tool: npt.ArrayLike | None = None) -> Look:
    """Return a checked look; parameters and errors as in `hexathermal.predict.budget.error_budget`."""
    if frame not in FRAMES:
        raise UnknownNameError(f"frame {frame!r} is not known; choose from {', '.join(FRAMES)}", FRAMES)
    if frames is not None and not isinstance(frames, Frames):
        raise ArgumentError(f"frames must be a Frames, found {type(frames).__name__}")
    own = Frames() if frames is None else frames
    T_platform_object = np.asarray(Frames(object=own.object, convention=own.convention).user_pose(np.eye(4)))
    T_machine_user = np.asarray(Frames(user=own.user, convention=own.convention).machine_pose(np.eye(4)))
    arm = T_platform_object[:3, 3] if at_tool is None else finite_array(at_tool, (3,), "at_tool")
    if arm.shape != (3,):
        raise ArgumentError(f"at_tool has shape {arm.shape}; expected (3,), metres from the platform's origin")
    if np.abs(arm).max() > LONGEST_ARM:
        what = "the origin of the object frame" if at_tool is None else "at_tool"
        raise ArgumentError(
            f"{what} holds {np.abs(arm).max():g} m, above {LONGEST_ARM:g} m; metres are meant, were millimetres given?"
        )
    turns = {"machine": np.eye(3), "user": T_machine_user[:3, :3], "object": T_platform_object[:3, :3]}
    return Look(frame, np.array(arm), turns[frame])


def settings(
    *,
    correction: bool = True,
    frame: str = "machine",
    frames: Frames | None = None,
    at_tool: npt.ArrayLike | None = None,
    plates: Plates | None = None,
    air_degC: float | None = None,
) -> tuple[bool, Look, Plates | None, float | None]:
    """Return the keywords of a `View`, its look checked; a keyword that it does not have is a `TypeError`."""
    return bool(correction), look(frame, frames, at_tool), plates, air_degC
