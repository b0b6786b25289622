"""How a virtual hexapod moves in a run: from pose to pose, with errands between, and rests; where it is measured."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError, OutOfStrokeError
from hexathermal.kinematics.inverse import inverse_kinematics
from hexathermal.kinematics.refusals import refuse_stroke
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.thermal import frozen
from hexathermal.poses import FloatArray, pose_from_coordinates
from hexathermal.simulate.machine.parts import MachineScenario

MOVING_STEP, RESTING_STEP = 20.0, 60.0
"""Longest steps of time [s]: halving both changes no leg's growth in a run by more than 10 nm (tested)."""


@dataclass(frozen=True, eq=False)
class MachineMotion:
    """The motion of a run: a fine course of time, and the rows that are measured.

    Attributes
    ----------
    time : array, shape (n,) [s]
    q : array, shape (n, 6) [m]
        Nominal displacements ``L - q0``.
    rows : array, shape (k,), int
        Which times are measured.
    coordinates : array, shape (k, 6) [mm, deg]
        Commanded there, from home.
    """

    time: FloatArray
    q: FloatArray
    rows: npt.NDArray[np.int64]
    coordinates: FloatArray


@dataclass
class _Course:
    """A motion that is being made."""

    speed: float
    step: float
    time: list[float] = field(default_factory=lambda: [0.0])
    q: list[FloatArray] = field(default_factory=list)
    rows: list[int] = field(default_factory=list)

    def go(self, target: FloatArray) -> None:
        """Move in a straight line of displacements; the slowest leg decides."""
        start, now = self.q[-1], self.time[-1]
        duration = float(np.abs(target - start).max()) / self.speed
        parts = int(np.ceil(duration / (MOVING_STEP * self.step)))
        for k in range(1, parts + 1):
            self.time.append(now + duration * k / parts)
            self.q.append(start + (target - start) * (k / parts))

    def hold(self, duration: float) -> None:
        """Stay for a time."""
        now, parts = self.time[-1], int(np.ceil(duration / (RESTING_STEP * self.step)))
        for k in range(1, parts + 1):
            self.time.append(now + duration * k / parts)
            self.q.append(self.q[-1])

    def measure(self) -> None:
        """Note that the pose is measured now."""
        self.rows.append(len(self.time) - 1)


def displacements(hexapod: Hexapod, coordinates: FloatArray, what: str = "pose") -> FloatArray:
    """Return the displacements of the legs at coordinates from home, shape (n, 6) [m].

    Raises
    ------
    OutOfStrokeError
        Names the pose, the leg and its limits.
    """
    lengths = inverse_kinematics(hexapod, pose_from_coordinates(coordinates, hexapod=hexapod))
    low, high = hexapod.length_limits
    out = np.flatnonzero(((lengths < low) | (lengths > high)).any(axis=1))
    if out.size:
        row = int(out[0])
        try:
            refuse_stroke(hexapod, lengths[row], ())
        except OutOfStrokeError as error:
            raise OutOfStrokeError(f"{what} {row + 1}: {error}", leg=error.leg, value=error.value) from None
    return hexapod.strokes(lengths)


def planned_motion(
    hexapod: Hexapod,
    scenario: MachineScenario,
    coordinates: FloatArray,
    errands: FloatArray,
    speed: float,
    generator: np.random.Generator,
    *,
    count: int,
    load: float = 1.0,
    step: float = 1.0,
) -> MachineMotion:
    """Return the motion of one run: phases of work and of rest, until `count` rows are measured.

    Parameters
    ----------
    hexapod : Hexapod
    scenario : MachineScenario
    coordinates : array, shape (m, 6) [mm, deg]
        Poses that are measured, in their order; they begin anew where a run needs more.
    errands : array, shape (e, 6) [mm, deg]
        Poses of the work between; each phase of work goes back and forth between two of them.
    speed : float [m/s]
        Of the fastest leg.
    generator : numpy.random.Generator
    count : int
    load : float
        Part of the errands that are run.
    step : float
        Scales the steps of time, for the proof that they are short enough.
    """
    if count < 2:
        raise ArgumentError(f"a run needs two measured poses or more, found {count}")
    q, work = displacements(hexapod, coordinates), displacements(hexapod, errands)
    course = _Course(speed, step, q=[q[0]])
    which = [0]
    course.measure()
    while len(which) < count:
        ends = work[generator.choice(len(work), 2, replace=False)]
        for _pose in range(int(generator.integers(scenario.working[0], scenario.working[1] + 1))):
            for _errand in range(scenario.errands):
                if generator.random() < load:
                    course.go(ends[0])
                    course.hold(scenario.pause)
                    ends = ends[::-1]
            which.append((which[-1] + 1) % len(q))
            course.go(q[which[-1]])
            course.hold(scenario.settling)
            course.measure()
            if len(which) == count:
                break
        for _look in range(int(generator.integers(scenario.resting[0], scenario.resting[1] + 1))):
            if len(which) == count:
                break
            course.hold(scenario.interval)
            course.measure()
            which.append(which[-1])
    return MachineMotion(
        frozen(np.array(course.time)), frozen(np.array(course.q)), np.array(course.rows, dtype=np.int64),
        frozen(coordinates[which]),
    )  # fmt: skip
