"""hexathermal's closed-loop Pinocchio model: the whole mechanism with its joints, for scale and as a second answer."""

from __future__ import annotations

from benchmarks.case import Case, Quantity
from benchmarks.contender import Job, Unavailable, rows, single


class PinocchioLoops:
    """Six legs of universal, prismatic and spherical joints, closed by constraints."""

    name = "Pinocchio closed loops"
    note = "hexathermal.machine.pinocchio_model: 24 joint angles, limits and forces come with it"

    def __init__(self, case: Case) -> None:
        try:
            from hexathermal.machine.pinocchio_model import PinocchioMachine
        except ImportError as error:
            raise Unavailable(f"the closed-loop model cannot be imported: {error}") from error
        self.machine = PinocchioMachine(case.hexapod)

    def jobs(self, case: Case) -> list[Job]:
        """Return jobs for one pose."""
        poses, lengths = [(pose,) for pose in rows(case.poses)], [(row,) for row in rows(case.lengths)]
        return [
            single(Quantity.LENGTHS, self.machine.leg_lengths, poses),
            single(Quantity.POSES, self.machine.forward, lengths),
            single(Quantity.JACOBIANS, self.machine.jacobian, poses),
        ]


def enter(case: Case) -> PinocchioLoops:
    """Return the contender."""
    return PinocchioLoops(case)
