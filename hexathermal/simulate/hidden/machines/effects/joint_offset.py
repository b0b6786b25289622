"""One joint sits elsewhere than the file says."""

from __future__ import annotations

import numpy as np

from hexathermal.simulate.hidden.effect import Parameters
from hexathermal.simulate.hidden.machines.effect import MachineEffect, draw_direction, number_of
from hexathermal.simulate.hidden.machines.truth import MachineTruth


def draw(truth: MachineTruth, generator: np.random.Generator) -> Parameters:
    """Draw the joint, the direction in the frame of its plate, and how far [m]: what a shop leaves, 1 to 300 um."""
    x, y, z = draw_direction(generator)
    joint = f"{generator.choice(['base', 'platform'])} joint {int(generator.integers(1, 7))}"
    return {"target": joint, "size": 20e-6, "x": float(x), "y": float(y), "z": float(z)}


def hide(truth: MachineTruth, parameters: Parameters) -> MachineTruth:
    """Move the joint."""
    target = str(parameters["target"])
    field = f"{target.split()[0]}_joints"
    joints = getattr(truth, field).copy()
    joints[number_of(target)] += float(parameters["size"]) * np.array([float(parameters[axis]) for axis in "xyz"])
    return truth.changed(**{field: joints})


EFFECT = MachineEffect("joint-offset", draw, hide, amplitude="size", limits=(1e-9, 5e-3))
