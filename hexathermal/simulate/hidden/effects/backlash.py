"""Lost motion at reversals: gaps that engage one after the other while the rod turns back."""

from __future__ import annotations

import numpy as np

from hexathermal.simulate.hidden.effect import Effect, Parameters, with_stroke
from hexathermal.simulate.hidden.shapes import add, either_sign, log_uniform, play_of_many
from hexathermal.simulate.hidden.truth import CampaignTruth


def draw(truth: CampaignTruth, generator: np.random.Generator) -> Parameters:
    """Draw the lost motion [m], over which way it engages [m], and where the nut sits at first.

    Source: 0.2 to 2 um remain in preloaded drives. Engineering value: they engage within 0.05 to 3 mm; smaller
    reversals engage in part.
    """
    return {
        "gap": either_sign(generator) * log_uniform(0.2e-6, 2e-6, generator),
        "engagement": log_uniform(0.05e-3, 3e-3, generator),
        "start": float(generator.uniform(-0.5, 0.5)),
    }


def hide(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Add the gap times where the nut sits in it, -0.5 to 0.5."""
    engagement, start = float(parameters["engagement"]), float(parameters["start"])
    return add(truth, lambda run: float(parameters["gap"]) * play_of_many(run.q, engagement, start))


EFFECT = Effect("backlash", draw, hide, with_stroke, "gap", (1e-9, 1e-5))
