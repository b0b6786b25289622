"""The scale is too long or too short at any temperature, and bends a little."""

from __future__ import annotations

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.effect import Effect, Parameters, with_stroke
from hexathermal.simulate.hidden.shapes import add, either_sign, log_uniform, place_in_stroke
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth


def draw(truth: CampaignTruth, generator: np.random.Generator) -> Parameters:
    """Draw the error over the whole stroke [m], and the part of it that a cubic has.

    Source: linear encoders are specified within 1 to 15 um/m.
    """
    return {
        "error": either_sign(generator) * log_uniform(0.2e-6, 4e-6, generator),
        "cubic": float(generator.uniform(-0.06, 0.06)),
    }


def hide(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Add ``error (x + cubic (20 x^3 - 30 x^2 + 12 x - 1))``, x the place in the stroke, 0 to 1."""

    def error(run: RunTruth) -> FloatArray:
        """Return the scale's error [m]."""
        x = place_in_stroke(truth, run)
        bent = 20.0 * x**3 - 30.0 * x**2 + 12.0 * x - 1.0
        return np.asarray(float(parameters["error"]) * (x + float(parameters["cubic"]) * bent))

    return add(truth, error)


EFFECT = Effect("scale-error", draw, hide, with_stroke, "error", (1e-9, 3e-5))
