"""A cubic of position: a rail or a scale that bends to an S, without any slope over the stroke."""

from __future__ import annotations

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.effect import Effect, Parameters, with_stroke
from hexathermal.simulate.hidden.shapes import add, either_sign, log_uniform, place_in_stroke
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth


def draw(truth: CampaignTruth, generator: np.random.Generator) -> Parameters:
    """Draw the height [m]. Engineering value: 0.2 to 3 um."""
    return {"height": either_sign(generator) * log_uniform(0.2e-6, 3e-6, generator)}


def hide(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Add ``height (20 x^3 - 30 x^2 + 12 x - 1)``, x the place in the stroke, 0 to 1: it has no slope in the mean."""

    def bent(run: RunTruth) -> FloatArray:
        """Return the S [m]."""
        x = place_in_stroke(truth, run)
        return np.asarray(float(parameters["height"]) * (20.0 * x**3 - 30.0 * x**2 + 12.0 * x - 1.0))

    return add(truth, bent)


EFFECT = Effect("outside: cubic", draw, hide, with_stroke, "height", (1e-9, 5e-5))
