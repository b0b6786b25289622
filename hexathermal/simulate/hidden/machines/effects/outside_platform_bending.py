"""The platform bends under its own weight when it tilts: into a saddle, not by a turn."""

from __future__ import annotations

import numpy as np

from hexathermal.simulate.hidden.effect import Parameters
from hexathermal.simulate.hidden.machines.effect import MachineEffect, add
from hexathermal.simulate.hidden.machines.physics import nominal
from hexathermal.simulate.hidden.machines.rotation import turned
from hexathermal.simulate.hidden.machines.truth import MachineTruth


def draw(truth: MachineTruth, generator: np.random.Generator) -> Parameters:
    """Draw how far joints move along the platform's axis for a tilt by one radian [m]."""
    return {"size": 1e-5, "about": float(generator.uniform(-np.pi, np.pi))}


def hide(truth: MachineTruth, parameters: Parameters) -> MachineTruth:
    """Bend the platform by its tilt."""
    joints = truth.platform_joints - truth.platform_joints.mean(axis=0)
    angle = np.arctan2(joints[:, 1], joints[:, 0]) - float(parameters["about"])
    saddle = np.stack([np.cos(2.0 * angle), np.sin(2.0 * angle)])
    turn = nominal(truth, truth.all("commanded")).turn
    back = turn * np.array([1.0, -1.0, -1.0, -1.0])
    down = turned(back, np.broadcast_to([0.0, 0.0, -1.0], (len(turn), 3)))
    bend = np.zeros((len(turn), 6, 3))
    bend[:, :, 2] = float(parameters["size"]) * down[:, :2] @ saddle
    return add(truth, "platform_bend", bend)


EFFECT = MachineEffect("outside: platform bending", draw, hide, amplitude="size", limits=(1e-9, 1e-1))
