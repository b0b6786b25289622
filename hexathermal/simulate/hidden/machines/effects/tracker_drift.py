"""The measuring frame moves with the room: the same rigid motion at every pose, perhaps a little late."""

from __future__ import annotations

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.effect import Parameters
from hexathermal.simulate.hidden.machines.effect import MachineEffect, add, draw_direction, each_run
from hexathermal.simulate.hidden.machines.truth import MachineRunTruth, MachineTruth
from hexathermal.simulate.hidden.shapes import cascade

AXES = ("x", "y", "z", "rx", "ry", "rz")
LEVER = 0.5
"""A turn by one radian weighs as much as a shift by so much [m]."""


def draw(truth: MachineTruth, generator: np.random.Generator) -> Parameters:
    """Draw shift [m/K] and turn [rad/K] of the frame about home for each kelvin of the room, and how late it is [s]."""
    mix = float(generator.uniform(0.0, 0.5 * np.pi))
    six = np.concatenate([np.cos(mix) * draw_direction(generator), np.sin(mix) / LEVER * draw_direction(generator)])
    delay = float(generator.choice([0.0, generator.uniform(60.0, 900.0)]))
    return {"size": 1e-6, "delay": delay, **dict(zip(AXES, six.tolist(), strict=True))}


def hide(truth: MachineTruth, parameters: Parameters) -> MachineTruth:
    """Move what is measured."""
    six = float(parameters["size"]) * np.array([float(parameters[axis]) for axis in AXES])
    delay = float(parameters["delay"])

    def room(run: MachineRunTruth) -> FloatArray:
        """Return the room's temperature as it reaches the frame."""
        return cascade(run.time, run.air, (delay,)) if delay > 0.0 else run.air

    first = np.concatenate([
        np.full(run.time.size, (run if truth.zero == "run" else truth.runs[0]).air[0]) for run in truth.runs
    ])  # fmt: skip
    return add(truth, "moved", np.outer(each_run(truth, room) - first, six))


def recorded(truth: MachineTruth) -> bool:
    """Return whether the room's temperature is recorded: nothing else tells of it."""
    return truth.air_recorded


EFFECT = MachineEffect("tracker-drift", draw, hide, recorded, "size", (1e-10, 1e-3))
