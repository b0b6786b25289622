"""The scale of one leg is too long or too short; of the catalogue for a leg."""

from __future__ import annotations

import numpy as np

from hexathermal.simulate.hidden.effect import Parameters
from hexathermal.simulate.hidden.machines.effect import MachineEffect, draw_leg, number_of, stretch_leg
from hexathermal.simulate.hidden.machines.truth import MachineTruth
from hexathermal.simulate.hidden.shapes import either_sign


def draw(truth: MachineTruth, generator: np.random.Generator) -> Parameters:
    """Draw the leg, and the error of its scale [1]: some 1e-6 to some 1e-4."""
    return {"target": draw_leg(generator), "slope": either_sign(generator) * 1e-5}


def hide(truth: MachineTruth, parameters: Parameters) -> MachineTruth:
    """Add the error along the stroke."""
    leg = str(parameters["target"])
    return stretch_leg(truth, leg, float(parameters["slope"]) * truth.all("q")[:, number_of(leg)])


EFFECT = MachineEffect("scale-error", draw, hide, amplitude="slope", limits=(1e-9, 1e-2))
