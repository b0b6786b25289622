"""The bars: ratios of two measurements of one run, and the thresholds they are held against."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from benchmarks.case import Quantity
from benchmarks.contenders import cpp_yardstick, mujoco_tendons
from benchmarks.fresh_processes import ImportTimes, Memory
from benchmarks.measuring import Measurement

OURS, YARDSTICK, MUJOCO = "hexathermal", "C++ yardstick", "MuJoCo"


@dataclass(frozen=True)
class Bar:
    """One promise.

    Attributes
    ----------
    ratio : float or None
        None: not measured here, `reason` says why.
    at_least : bool
        The ratio must reach `threshold`; else it must not exceed it.
    aim : float or None
        What would be good; not needed to pass.
    """

    name: str
    ratio: float | None
    threshold: float
    at_least: bool
    aim: float | None = None
    reason: str = ""

    @property
    def passed(self) -> bool | None:
        """Whether the bar is met; None where it was not measured."""
        if self.ratio is None:
            return None
        return self.ratio >= self.threshold if self.at_least else self.ratio <= self.threshold


def found(
    measurements: Sequence[Measurement], contender: str, quantity: Quantity, batch: bool, variant: str = ""
) -> Measurement | None:
    """Return one measurement on one processor, or None where there is none."""
    for one in measurements:
        same = (one.contender, one.quantity, one.batch, one.variant) == (contender, quantity, batch, variant)
        if same and not one.all_cores:
            return one
    return None


def _faster(ours: Measurement | None, other: Measurement | None) -> float | None:
    """Return how many times faster ours is, by the medians; None where either is missing."""
    return None if ours is None or other is None else other.seconds / ours.seconds


def _inverted(ratio: float | None) -> float | None:
    return None if ratio is None else 1.0 / ratio


def speed_bars(measurements: Sequence[Measurement], missing: str) -> list[Bar]:
    """Return the bars on speed; `missing` says why a peer was not there."""

    def ours(quantity: Quantity, batch: bool) -> Measurement | None:
        return found(measurements, OURS, quantity, batch)

    tendons = found(measurements, MUJOCO, Quantity.LENGTHS, False, mujoco_tendons.LENGTHS_ONLY)
    newton = found(measurements, MUJOCO, Quantity.POSES, False, mujoco_tendons.NUMPY)
    bars = [
        Bar(
            "one-pose corrected_leg_lengths: time over that of MuJoCo's tendon lengths alone",
            _inverted(_faster(ours(Quantity.CORRECTED, False), tendons)), 1.0, False, reason=missing,
        ),
        Bar(
            "one-pose forward_kinematics from home: times faster than Newton on MuJoCo's tendons",
            _faster(ours(Quantity.POSES, False), newton), 30.0, True, 80.0, missing,
        ),
    ]  # fmt: skip
    for quantity, method in ((Quantity.LENGTHS, "inverse_kinematics"), (Quantity.POSES, "forward_kinematics")):
        yardstick = found(measurements, YARDSTICK, quantity, True, cpp_yardstick.SAME_JOB)
        mine = ours(quantity, True)
        count = f"{mine.poses:.0e}".replace("e+0", "e") if mine else "many"
        ratio = _faster(mine, yardstick)
        bars.append(Bar(f"batch {method}, {count} poses: part of the C++ yardstick's rate per core", ratio, 0.4, True, 0.6, missing))
    return bars


def other_bars(imports: Sequence[ImportTimes], memories: Sequence[Memory], no_memory: str = "") -> list[Bar]:
    """Return the bars on imports and memory."""
    seconds = {one.package: one.seconds for one in imports}
    compiled = {one.package: one.compiler_loaded for one in imports}
    bars = [
        Bar("import hexathermal: time over that of import pinocchio", seconds[OURS] / seconds["pinocchio"], 2.0, False),
        Bar("import hexathermal: compilers loaded", float(compiled[OURS]), 0.0, False),
    ]
    for one in memories:
        bars.append(Bar(f"memory of {one.method}, {one.poses} poses: over input and output", one.ratio, 3.0, False))
    if not memories:
        bars.append(Bar("memory of a batch: over input and output", None, 3.0, False, reason=no_memory))
    return bars
