"""A climate chamber: the air goes by steps and ramps between set points, the machine works little."""

from __future__ import annotations

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.machines.halls.warmth import Warmth, warmed_legs, warmed_plate
from hexathermal.simulate.hidden.machines.motion import Course
from hexathermal.simulate.hidden.shapes import either_sign, first_order, log_uniform

NAME = "climate chamber"


def warm(course: Course, sides: FloatArray, sensors: int, generator: np.random.Generator) -> Warmth:
    """Return temperatures: set points 2 to 14 K apart are held for one to five hours; the air follows within minutes.

    Engineering values throughout.
    """
    time, end = course.time, float(course.time[-1])
    span, middle = log_uniform(2.0, 14.0, generator), float(generator.uniform(18.0, 24.0))
    corners, points = [0.0], [middle]
    while corners[-1] < end:
        ramp = float(generator.choice([0.0, generator.uniform(600.0, 5400.0)]))
        points += [points[-1], middle + span * float(generator.uniform(-0.5, 0.5))]
        held = corners[-1] + float(generator.uniform(3600.0, 18000.0))
        corners += [held, held + max(ramp, 1.0)]
    ripple = 0.08 * np.sin(2.0 * np.pi * time / 700.0 + generator.uniform(0.0, 2.0 * np.pi))
    air = first_order(time, np.interp(time, corners, points), 300.0) + ripple
    # the fan blows from one side: legs behind follow later and less
    wind = np.cos(sides - generator.uniform(-np.pi, np.pi))
    behind = 0.08 * generator.random() * np.outer(air - air[0], wind)
    legs = warmed_legs(course, air, sensors, generator, minutes=(15.0, 60.0), apart=log_uniform(0.03, 0.4, generator),
                       motors=log_uniform(0.1, 2.0, generator), side=behind)  # fmt: skip
    plates = np.column_stack([warmed_plate(course, air, hours, generator) for hours in ((0.6, 2.5), (1.0, 5.0))])
    if generator.random() < 0.3:  # a heater on one of the plates, switched as the experiment wants
        plate = int(generator.integers(2))
        on = (np.floor(time / float(generator.uniform(5400.0, 21600.0))) % 2.0) * either_sign(generator)
        plates[:, plate] += first_order(time, log_uniform(0.5, 5.0, generator) * on, 3600.0)
    return Warmth(legs, plates, air)
