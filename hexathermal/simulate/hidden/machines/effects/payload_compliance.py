"""A payload that nobody told of: the legs give way under their share of its weight, which changes with the pose."""

from __future__ import annotations

import numpy as np

from hexathermal.simulate.hidden.effect import Parameters
from hexathermal.simulate.hidden.machines.effect import MachineEffect
from hexathermal.simulate.hidden.machines.truth import Load, MachineTruth
from hexathermal.simulate.hidden.shapes import log_uniform

GRAVITY = np.array([0.0, 0.0, -9.80665])


def draw(truth: MachineTruth, generator: np.random.Generator) -> Parameters:
    """Draw mass and centre of mass in the platform, and the legs' compliance: 30 to 500 N/um. Engineering values."""
    joints = truth.platform_joints
    radius = float(np.linalg.norm(joints - joints.mean(axis=0), axis=1).mean())
    x, y, z = joints.mean(axis=0) + radius * generator.uniform([-0.6, -0.6, 0.0], [0.6, 0.6, 1.0])
    return {"mass": 50.0, "compliance": log_uniform(2e-9, 3e-8, generator),
            "x": float(x), "y": float(y), "z": float(z)}  # fmt: skip


def hide(truth: MachineTruth, parameters: Parameters) -> MachineTruth:
    """Put the payload on the platform."""
    centre = np.array([float(parameters[axis]) for axis in "xyz"])
    weight = float(parameters["mass"]) * GRAVITY
    return truth.changed(load=Load(np.full(6, float(parameters["compliance"])), weight, centre))


EFFECT = MachineEffect("payload-compliance", draw, hide, amplitude="mass", limits=(1e-3, 2e4))
