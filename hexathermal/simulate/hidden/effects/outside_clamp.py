"""A clamp that holds the better the warmer it is: how far one place pushes depends on how warm another is."""

from __future__ import annotations

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.effect import Effect, Parameters
from hexathermal.simulate.hidden.shapes import add, either_sign, first_order, log_uniform
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth


def possible(truth: CampaignTruth) -> bool:
    """Return whether the air's temperature changes."""
    return any(np.ptp(run.air[:, 0]) > 0.2 for run in truth.runs)


def draw(truth: CampaignTruth, generator: np.random.Generator) -> Parameters:
    """Draw the place that pushes, how late the clamp follows the room [s], and the size of both together [m/K^2].

    Engineering value: a clamp in a room that warms by 2 K while the leg warms by 5 K moves by 0.1 to some micrometres.
    """
    return {
        "sensor": str(generator.choice(truth.sensors)),
        "late": log_uniform(60.0, 900.0, generator),
        "size": either_sign(generator) * log_uniform(0.01e-6, 0.3e-6, generator),
    }


def hide(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Add ``size (T - T_0) (T_clamp - T_clamp,0)``, both since the run began."""
    j = truth.sensors.index(str(parameters["sensor"]))

    def both(run: RunTruth) -> FloatArray:
        """Return the product of both warmings [K^2]."""
        clamp = first_order(run.time, run.air[:, 0], float(parameters["late"]))
        pushes = run.temperatures[:, j]
        return np.asarray((pushes - pushes[0]) * (clamp - clamp[0]))

    return add(truth, lambda run: float(parameters["size"]) * both(run))


EFFECT = Effect("outside: clamp", draw, hide, possible, "size", (1e-12, 1e-5))
