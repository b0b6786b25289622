"""The screw or scale of one leg errs with a period; of the catalogue for a leg."""

from __future__ import annotations

import numpy as np

from hexathermal.simulate.hidden.effect import Parameters
from hexathermal.simulate.hidden.machines.effect import MachineEffect, draw_leg, number_of, stretch_leg
from hexathermal.simulate.hidden.machines.truth import MachineTruth


def draw(truth: MachineTruth, generator: np.random.Generator) -> Parameters:
    """Draw the leg, the period [m], 2 to 10 mm as leads of screws are, and the phase [rad]."""
    return {
        "target": draw_leg(generator), "size": 1e-6, "phase": float(generator.uniform(-np.pi, np.pi)),
        "period": float(generator.choice([2e-3, 4e-3, 5e-3, 10e-3])),
    }  # fmt: skip


def hide(truth: MachineTruth, parameters: Parameters) -> MachineTruth:
    """Add the error along the stroke."""
    leg = str(parameters["target"])
    turn = 2.0 * np.pi * truth.all("q")[:, number_of(leg)] / float(parameters["period"])
    return stretch_leg(truth, leg, float(parameters["size"]) * np.sin(turn + float(parameters["phase"])))


EFFECT = MachineEffect("periodic-screw-error", draw, hide, amplitude="size", limits=(1e-10, 1e-3))
