"""One leg grows by other coefficients than its file says."""

from __future__ import annotations

import numpy as np

from hexathermal.simulate.hidden.effect import Parameters
from hexathermal.simulate.hidden.machines.effect import MachineEffect, draw_leg, number_of
from hexathermal.simulate.hidden.machines.truth import MachineTruth
from hexathermal.simulate.hidden.shapes import either_sign


def draw(truth: MachineTruth, generator: np.random.Generator) -> Parameters:
    """Draw the leg, one of its thermometers, and by how much A, B or both are off [1/K]: a scale or body of another
    lot, some tenths to some 1e-6.
    """
    mix = float(generator.choice([0.0, 0.5 * np.pi, generator.uniform(-np.pi, np.pi)], p=[0.4, 0.2, 0.4]))
    return {
        "target": draw_leg(generator), "sensor": str(generator.choice(truth.sensors)),
        "size": either_sign(generator) * 1e-6, "of_A": float(np.cos(mix)), "of_B": float(np.sin(mix)),
    }  # fmt: skip


def hide(truth: MachineTruth, parameters: Parameters) -> MachineTruth:
    """Change the coefficients of the leg."""
    place = number_of(str(parameters["target"])), truth.sensors.index(str(parameters["sensor"]))
    A, B = truth.A.copy(), truth.B.copy()
    A[place] += float(parameters["size"]) * float(parameters["of_A"])
    B[place] += float(parameters["size"]) * float(parameters["of_B"])
    return truth.changed(A=A, B=B)


EFFECT = MachineEffect("leg-coefficient", draw, hide, amplitude="size", limits=(1e-10, 3e-5))
