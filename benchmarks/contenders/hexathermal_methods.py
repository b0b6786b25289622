"""hexathermal itself, through the public methods of `Hexapod` and nothing else: every check is included."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from benchmarks.case import Case, FloatArray, Quantity
from benchmarks.contender import ONE_BY_ONE, Job, first, rows, single

ALL_CORES = "all processors"


class HexathermalMethods:
    """The public methods."""

    name = "hexathermal"
    note = "public methods of Hexapod, all checks included; arrays in, new arrays out"

    def jobs(self, case: Case) -> list[Job]:
        """Return one job for one pose and two for a batch (one processor, all of them) of every quantity."""
        hexapod = case.hexapod
        methods: dict[Quantity, tuple[Callable[..., Any], tuple[FloatArray, ...]]] = {
            Quantity.LENGTHS: (hexapod.inverse_kinematics, (case.poses,)),
            Quantity.CORRECTED: (hexapod.corrected_leg_lengths, (case.poses, case.temps)),
            Quantity.POSES: (hexapod.forward_kinematics, (case.lengths,)),
            Quantity.JACOBIANS: (hexapod.jacobian, (case.poses,)),
        }
        jobs = []
        for quantity, (method, arrays) in methods.items():
            singles = list(zip(*(rows(array, ONE_BY_ONE) for array in arrays), strict=True))
            jobs.append(single(quantity, method, singles))
            jobs.append(Job(quantity, True, method, [arrays], len(case), first))
            jobs.append(Job(quantity, True, method, [arrays], len(case), first, ALL_CORES, all_cores=True))
        return jobs


def enter(case: Case) -> HexathermalMethods:
    """Return the contender."""
    return HexathermalMethods()
