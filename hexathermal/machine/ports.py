"""What a machine can be asked, and who answers.

`Hexapod` is the lowest storey: it may not import the kinematics and predictions that its methods stand for.  This
protocol states them, and the package puts the functions of `hexathermal.predict.answers` in place when it is imported:
each takes the machine first, so it serves as the method itself, documentation included, and a call costs no detour.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Protocol

import numpy.typing as npt

from hexathermal.machine.thermal import TemperaturesLike
from hexathermal.poses import FloatArray, Frames, PoseLike

if TYPE_CHECKING:
    from hexathermal.machine.hexapod import Hexapod


class Answers(Protocol):
    """The functions behind the methods of `Hexapod`; each takes the machine first."""

    def inverse_kinematics(self, hexapod: Hexapod, pose: PoseLike, /) -> FloatArray: ...
    def forward_kinematics(self, hexapod: Hexapod, lengths: npt.ArrayLike, guess: PoseLike | None, /) -> Any: ...
    def solve_forward(self, hexapod: Hexapod, lengths: npt.ArrayLike, guess: PoseLike | None, /) -> Any: ...
    def jacobian(self, hexapod: Hexapod, pose: PoseLike, /) -> FloatArray: ...
    def assembly_modes(self, hexapod: Hexapod, lengths: npt.ArrayLike, /) -> FloatArray: ...
    def corrected_leg_lengths(self, hexapod: Hexapod, pose: PoseLike, temps: TemperaturesLike, /) -> FloatArray: ...
    def corrected_pose(self, hexapod: Hexapod, pose: PoseLike, temps: TemperaturesLike, /) -> Any: ...
    def predicted_pose(self, hexapod: Hexapod, lengths: npt.ArrayLike, temps: TemperaturesLike, /) -> FloatArray: ...
    def leg_controllers(self, hexapod: Hexapod, /) -> Any: ...
    def leg_drift(self, hexapod: Hexapod, lengths: npt.ArrayLike, temps: TemperaturesLike, /) -> FloatArray: ...
    def error_budget(
        self, hexapod: Hexapod, pose: PoseLike, temps: TemperaturesLike, sources: Iterable[Any] | None = None, /, *,
        correction: bool = True, frame: str = "machine", frames: Frames | None = None,
        at_tool: npt.ArrayLike | None = None, plates: Any = None, air_degC: float | None = None,
    ) -> Any: ...  # fmt: skip


def install(machine: type[Hexapod], answers: Answers) -> None:
    """Put the functions of `answers` in place as methods of the machine's class."""
    for name in vars(Answers):
        if not name.startswith("_"):
            setattr(machine, name, getattr(answers, name))
