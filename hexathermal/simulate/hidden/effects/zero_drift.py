"""The zero of the displacement moves with time, nearly straight, in some campaigns at another rate in each run."""

from __future__ import annotations

import numpy as np

from hexathermal.simulate.hidden.effect import Effect, Parameters
from hexathermal.simulate.hidden.shapes import either_sign, log_uniform, since_start
from hexathermal.simulate.hidden.truth import CampaignTruth

UNLIKE = 1.0 / 3.0
"""How often runs that count from zeros of their own differ."""


def draw(truth: CampaignTruth, generator: np.random.Generator) -> Parameters:
    """Draw the rate [m/s], by which part of it the rate changes over a run, and by which runs differ.

    Engineering value: 0.02 to 0.5 um/h of optics, glue and electronics.
    """
    return {
        "rate": either_sign(generator) * log_uniform(0.02e-6, 0.5e-6, generator) / 3600.0,
        "curvature": float(generator.uniform(-0.3, 0.3)),
        "unlike": float(generator.uniform(0.0, 0.3)) * bool(generator.random() < UNLIKE),
        "runs": int(generator.integers(2**31)),
    }


def hide(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Add ``rate (t + curvature t^2 / (2 duration))``, from each run's start; with a campaign's zero from its start.

    Each run's own rate is ``rate (1 + unlike)``.
    """
    rate, curvature = float(parameters["rate"]), float(parameters["curvature"])
    own = truth.zero == "run"
    times = [run.time - run.time[0] for run in truth.runs] if own else list(since_start(truth))
    duration = max(float(time[-1]) for time in times)
    unlike = float(parameters["unlike"]) * np.random.default_rng(int(parameters["runs"])).standard_normal(len(times))
    rates = rate * (1.0 + own * unlike)
    return truth.changed(
        runs=tuple(
            run.changed(effect=run.effect + one * (time + 0.5 * curvature * time**2 / duration))
            for run, time, one in zip(truth.runs, times, rates.tolist(), strict=True)
        )
    )


EFFECT = Effect("zero-drift", draw, hide, amplitude="rate", limits=(1e-14, 3e-9))
