"""Lost motion of one leg at reversals: gaps that engage one after the other while its rod turns back."""

from __future__ import annotations

import numpy as np

from hexathermal.simulate.hidden.effect import Parameters
from hexathermal.simulate.hidden.machines.effect import MachineEffect, draw_leg, number_of, stretch_leg
from hexathermal.simulate.hidden.machines.truth import MachineTruth
from hexathermal.simulate.hidden.shapes import either_sign, log_uniform, play_of_many


def draw(truth: MachineTruth, generator: np.random.Generator) -> Parameters:
    """Draw the leg, its lost motion [m], over which way it engages [m], and where the nut sits at first.

    Source: 0.2 to 2 um remain in preloaded drives. Engineering value: they engage within 5 to 300 um.
    """
    return {
        "target": draw_leg(generator), "gap": either_sign(generator) * 1e-6,
        "engagement": log_uniform(5e-6, 3e-4, generator), "start": float(generator.uniform(-0.5, 0.5)),
    }  # fmt: skip


def hide(truth: MachineTruth, parameters: Parameters) -> MachineTruth:
    """Add the gap times where the nut sits in it, -0.5 to 0.5; runs follow each other."""
    leg = str(parameters["target"])
    way = truth.all("q")[:, number_of(leg)]
    place = play_of_many(way, float(parameters["engagement"]), float(parameters["start"]))
    return stretch_leg(truth, leg, float(parameters["gap"]) * place)


EFFECT = MachineEffect("leg-backlash", draw, hide, amplitude="gap", limits=(1e-10, 1e-3))
