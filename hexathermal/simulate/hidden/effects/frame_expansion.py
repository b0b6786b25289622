"""The frame of the bench follows the room, late: plates within minutes, the frame behind them within hours."""

from __future__ import annotations

import numpy as np

from hexathermal.simulate.hidden.effect import Effect, Parameters
from hexathermal.simulate.hidden.shapes import add, cascade, either_sign, log_uniform
from hexathermal.simulate.hidden.truth import CampaignTruth


def possible(truth: CampaignTruth) -> bool:
    """Return whether the room changes at all."""
    return all(np.isfinite(run.air[:, 0]).all() for run in truth.runs) and any(
        np.ptp(run.air[:, 0]) > 0.05 for run in truth.runs
    )


def draw(truth: CampaignTruth, generator: np.random.Generator) -> Parameters:
    """Draw two time constants [s] and the slope [m/K].

    Engineering values: skin of a bench 5 to 30 min, granite or castings 0.5 to 2 h. Source: 100 mm of steel are
    1.15 um/K.
    """
    return {
        "skin": log_uniform(300.0, 1800.0, generator),
        "core": log_uniform(1800.0, 7200.0, generator),
        "slope": either_sign(generator) * log_uniform(0.3e-6, 5e-6, generator),
    }


def hide(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Add the slope times the room's temperature behind both stages."""
    constants = (float(parameters["skin"]), float(parameters["core"]))
    return add(truth, lambda run: float(parameters["slope"]) * cascade(run.time, run.air[:, 0], constants, past=True))


EFFECT = Effect("frame-expansion", draw, hide, possible, "slope", (1e-9, 3e-5))
