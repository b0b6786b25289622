"""Humidity swells something that is no metal, late: a glued carrier, a polymer foot."""

from __future__ import annotations

import numpy as np

from hexathermal.simulate.hidden.effect import Effect, Parameters
from hexathermal.simulate.hidden.shapes import add, cascade, log_uniform
from hexathermal.simulate.hidden.truth import CampaignTruth


def possible(truth: CampaignTruth) -> bool:
    """Return whether humidity changes."""
    return all(np.isfinite(run.air[:, 2]).all() for run in truth.runs) and any(
        np.ptp(run.air[:, 2]) > 0.005 for run in truth.runs
    )


def draw(truth: CampaignTruth, generator: np.random.Generator) -> Parameters:
    """Draw the swelling [m] from dry to wet air and its time constant [s].

    Source: epoxies and nylons swell by 1e-5 to 1e-4 per per cent; some 5 to 20 mm of them carry a target.
    """
    return {"swelling": log_uniform(5e-6, 100e-6, generator), "time": log_uniform(900.0, 5400.0, generator)}


def hide(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Add ``swelling`` times the late relative humidity."""
    stages = (0.7 * float(parameters["time"]), 0.3 * float(parameters["time"]))
    return add(truth, lambda run: float(parameters["swelling"]) * cascade(run.time, run.air[:, 2], stages, past=True))


EFFECT = Effect("outside: humidity", draw, hide, possible, "swelling", (1e-9, 2e-3))
