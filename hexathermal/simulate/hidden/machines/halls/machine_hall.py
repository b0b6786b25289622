"""A machine hall: the air follows the day and the doors, motors heat the legs, a warm neighbour shines on one side."""

from __future__ import annotations

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.bench.thermocouples import slow_process
from hexathermal.simulate.hidden.machines.halls.warmth import Warmth, warmed_legs, warmed_plate
from hexathermal.simulate.hidden.machines.motion import Course
from hexathermal.simulate.hidden.shapes import first_order, log_uniform

NAME = "machine hall"
DAY = 86400.0


def warm(course: Course, sides: FloatArray, sensors: int, generator: np.random.Generator) -> Warmth:
    """Return temperatures: days of 1 to 5 K, doors of up to 3 K, motors of 0.5 to 8 K, a neighbour of up to 2 K.

    Engineering values throughout.
    """
    time = course.time
    phase = float(generator.uniform(0.0, 2.0 * np.pi))
    day = 0.5 * log_uniform(1.0, 5.0, generator) * np.sin(2.0 * np.pi * time / DAY + phase)
    weather = log_uniform(0.2, 1.0, generator) * slow_process(time, 7200.0, 1, generator)[:, 0]
    opened = np.zeros(time.size)
    for _door in range(int(generator.poisson(time[-1] / 14400.0))):
        since = time - generator.uniform(0.0, time[-1])
        opened -= log_uniform(0.3, 3.0, generator) * np.where(
            since > 0.0, np.exp(-np.maximum(since, 0.0) / 1500.0), 0.0
        )
    air = float(generator.uniform(19.0, 25.0)) + first_order(time, day + weather + opened, 400.0)
    neighbour = log_uniform(0.1, 2.0, generator) * np.abs(slow_process(time, 10800.0, 1, generator)[:, 0])
    facing = np.clip(np.cos(sides - generator.uniform(-np.pi, np.pi)), 0.0, None)
    legs = warmed_legs(course, air, sensors, generator, minutes=(20.0, 90.0), apart=log_uniform(0.03, 0.3, generator),
                       motors=log_uniform(0.5, 8.0, generator), side=np.outer(neighbour, facing))  # fmt: skip
    work = course.busy.mean(axis=1)
    above = (log_uniform(0.05, 4.0, generator), log_uniform(0.05, 1.5, generator))
    plates = np.column_stack([
        warmed_plate(course, air + power * work, hours, generator)
        for power, hours in zip(above, ((0.8, 3.0), (2.0, 6.0)), strict=True)
    ])  # fmt: skip
    return Warmth(legs, plates, air)
