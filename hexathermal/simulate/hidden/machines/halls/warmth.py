"""Temperatures of legs, plates and air on even steps; how heat of the air, of motors and of a side gets into a leg."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.machines.motion import Course
from hexathermal.simulate.hidden.shapes import cascade, first_order, log_uniform


@dataclass(frozen=True, eq=False)
class Warmth:
    """Temperatures of a course [degC]: legs (m, 6, s), plates (m, 2), air (m,)."""

    legs: FloatArray
    plates: FloatArray
    air: FloatArray

    def at(self, course: Course, time: FloatArray) -> Warmth:
        """Return the temperatures at times, shape (n,) [s]."""
        flat = np.column_stack([self.legs.reshape(len(self.legs), -1), self.plates, self.air])
        rows = np.column_stack([np.interp(time, course.time, column) for column in flat.T])
        return Warmth(rows[:, :-3].reshape(-1, *self.legs.shape[1:]), rows[:, -3:-1], rows[:, -1])


def warmed_legs(
    course: Course,
    air: FloatArray,
    sensors: int,
    generator: np.random.Generator,
    *,
    minutes: tuple[float, float],
    apart: float,
    motors: float,
    side: FloatArray | None = None,
) -> FloatArray:
    """Return the temperatures of the legs, shape (m, 6, sensors).

    Parameters
    ----------
    course : Course
    air : array, shape (m,)
    sensors : int
        The second sits on the rod, behind one more stage, and shares less of the motor's heat.
    generator : numpy.random.Generator
    minutes : (float, float)
        In which a leg's body follows the air.
    apart : float
        Relative standard deviation of times and of the share of the air's changes from leg to leg.
    motors : float
        By which a leg at full work stands above the air [K].
    side : array, shape (m, 6), optional
        What else heats each leg [K].
    """
    common, rod = 60.0 * log_uniform(*minutes, generator), 60.0 * log_uniform(5.0, 30.0, generator)
    start = float(air[0])
    legs = np.empty((air.size, 6, sensors))
    for leg in range(6):
        constant = common * float(np.exp(apart * generator.standard_normal()))
        share = 1.0 + 0.5 * apart * float(generator.standard_normal())
        power = motors * float(np.exp(0.3 * generator.standard_normal())) * course.busy[:, leg]
        around = start + share * (air - start) + (0.0 if side is None else side[:, leg])
        body = cascade(course.time, around + power, (constant, 0.2 * constant))
        legs[:, leg, 0] = body
        if sensors > 1:
            cooler = cascade(course.time, around + 0.35 * power, (constant,))
            legs[:, leg, 1] = first_order(course.time, cooler, rod)
    return legs


def warmed_plate(
    course: Course, air: FloatArray, hours: tuple[float, float], generator: np.random.Generator
) -> FloatArray:
    """Return the temperature of a plate that follows what is about it within hours, shape (m,)."""
    constant = 3600.0 * log_uniform(*hours, generator)
    return cascade(course.time, air, (constant,))
