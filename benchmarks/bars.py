"""The bars: ratios of two measurements of one run, and the thresholds they are held against.

Ratios are those of the best turns: other work on the machine only ever adds time.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.case import Quantity
from benchmarks.contenders import cpp_yardstick, mujoco_tendons
from benchmarks.fresh_processes import ImportTimes, Memory
from benchmarks.measuring import Measurement

OURS, YARDSTICK, MUJOCO = "hexathermal", "C++ yardstick", "MuJoCo"


LARGEST_ERROR = 2e-14
"""Some 30 times the rounding of a length."""


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
    """Return how many times faster ours is; None where either is missing."""
    return None if ours is None or other is None else other.best_seconds / ours.best_seconds


def _inverted(ratio: float | None) -> float | None:
    return None if ratio is None else 1.0 / ratio


def error_bar(measurements: Sequence[Measurement]) -> Bar:
    """Return the bar on hexathermal's own errors: speed bought with wrong digits would not count."""
    # NumPy's maximum lets a NaN through, Python's may not
    worst = float(np.max([error for one in measurements if one.contender == OURS for error in one.errors]))
    return Bar("largest error of any answer of hexathermal (m, or an entry)", worst, LARGEST_ERROR, False)


def speed_bars(measurements: Sequence[Measurement], missing: Mapping[str, str]) -> list[Bar]:
    """Return the bars on speed; `missing` says for each peer's module why it was not there."""
    no_mujoco, no_yardstick = missing.get("mujoco_tendons", ""), missing.get("cpp_yardstick", "")

    def ours(quantity: Quantity, batch: bool) -> Measurement | None:
        return found(measurements, OURS, quantity, batch)

    tendons = found(measurements, MUJOCO, Quantity.LENGTHS, False, mujoco_tendons.LENGTHS_ONLY)
    newton = found(measurements, MUJOCO, Quantity.POSES, False, mujoco_tendons.NUMPY)
    bars = [
        Bar(
            "one-pose corrected_leg_lengths: time over that of MuJoCo's tendon lengths alone",
            _inverted(_faster(ours(Quantity.CORRECTED, False), tendons)), 1.0, False, reason=no_mujoco,
        ),
        Bar(
            "one-pose forward_kinematics from home: times faster than Newton on MuJoCo's tendons",
            _faster(ours(Quantity.POSES, False), newton), 30.0, True, 80.0, no_mujoco,
        ),
    ]  # fmt: skip
    for quantity, method in ((Quantity.LENGTHS, "inverse_kinematics"), (Quantity.POSES, "forward_kinematics")):
        yardstick = found(measurements, YARDSTICK, quantity, True, cpp_yardstick.SAME_JOB)
        mine = ours(quantity, True)
        count = f"{mine.poses:.0e}".replace("e+0", "e") if mine else "many"
        name = f"batch {method}, {count} poses: part of the C++ yardstick's rate per core"
        bars.append(Bar(name, _faster(mine, yardstick), 0.4, True, 0.6, no_yardstick))
    return bars


def other_bars(imports: Sequence[ImportTimes], memories: Sequence[Memory], no_memory: str = "") -> list[Bar]:
    """Return the bars on imports and memory."""
    seconds = {one.package: one.best_seconds for one in imports}
    compiled = {one.package: one.compiler_loaded for one in imports}
    bars = [
        Bar("import hexathermal: time over that of import pinocchio", seconds[OURS] / seconds["pinocchio"], 2.0, False),
        Bar("import hexathermal: compilers that it loads", float(compiled[OURS]), 0.0, False),
    ]
    bars += [
        Bar(f"memory of {one.method}, {one.poses} poses: over input and output", one.ratio, 3.0, False)
        for one in memories
    ]
    if not memories:
        bars.append(Bar("memory of a batch: over input and output", None, 3.0, False, reason=no_memory))
    return bars
