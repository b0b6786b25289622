"""A steady measuring room: the machine warms up by its own work in each run, plates through the legs."""

from __future__ import annotations

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.bench.thermocouples import slow_process
from hexathermal.simulate.hidden.machines.halls.warmth import Warmth, warmed_legs, warmed_plate
from hexathermal.simulate.hidden.machines.motion import Course
from hexathermal.simulate.hidden.shapes import log_uniform

NAME = "warm-up"


def warm(course: Course, sides: FloatArray, sensors: int, generator: np.random.Generator) -> Warmth:
    """Return temperatures: a room of 0.1 to 0.5 K, motors of 2 to 15 K, plates that take a part of the legs' heat.

    Engineering values throughout.
    """
    room = log_uniform(0.1, 0.5, generator) * slow_process(course.time, 14400.0, 1, generator)[:, 0]
    air = 20.0 + room
    legs = warmed_legs(course, air, sensors, generator, minutes=(20.0, 70.0), apart=log_uniform(0.05, 0.3, generator),
                       motors=log_uniform(2.0, 15.0, generator))  # fmt: skip
    above = legs[:, :, 0].mean(axis=1) - air
    plates = np.column_stack([
        warmed_plate(course, air + generator.uniform(*share) * above, (0.5, 3.0), generator)
        for share in ((0.2, 0.9), (0.05, 0.4))
    ])  # fmt: skip
    return Warmth(legs, plates, air)
