"""A bump at one position: a dent in a rail, a joint of a scale."""

from __future__ import annotations

import numpy as np

from hexathermal.simulate.hidden.effect import Effect, Parameters, with_stroke
from hexathermal.simulate.hidden.shapes import add, either_sign, log_uniform
from hexathermal.simulate.hidden.truth import CampaignTruth


def draw(truth: CampaignTruth, generator: np.random.Generator) -> Parameters:
    """Draw where it is [m], its width [m] and height [m]: where the rod rests now and then.

    Engineering values: 3 to 10 % of the stroke wide, 0.3 to 3 um high.
    """
    rests = np.concatenate([run.q[run.settled] for run in truth.runs if run.role == "identification"])
    return {
        "place": float(generator.choice(rests)),
        "width": float(generator.uniform(0.03, 0.10) * np.ptp(rests)),
        "height": either_sign(generator) * log_uniform(0.3e-6, 3e-6, generator),
    }


def hide(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Add ``height exp(-((q - place) / width)^2)``."""
    place, width = float(parameters["place"]), float(parameters["width"])
    return add(truth, lambda run: float(parameters["height"]) * np.exp(-(((run.q - place) / width) ** 2)))


EFFECT = Effect("outside: bump", draw, hide, with_stroke, "height", (1e-9, 1e-4))
