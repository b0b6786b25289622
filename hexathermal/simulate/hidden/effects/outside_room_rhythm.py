"""The displacement follows the rhythm of an air conditioning that no recorded channel shows."""

from __future__ import annotations

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.effect import Effect, Parameters
from hexathermal.simulate.hidden.shapes import log_uniform
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth


def draw(truth: CampaignTruth, generator: np.random.Generator) -> Parameters:
    """Draw the period [s], the part of it in which it blows, the height [m], and the seed of its irregularity.

    Source: 20 to 35 min cycles are seen in workshops.
    """
    return {
        "period": float(generator.uniform(1200.0, 2100.0)),
        "duty": float(generator.uniform(0.25, 0.6)),
        "height": log_uniform(0.1e-6, 1e-6, generator),
        "seed": int(generator.integers(2**31)),
    }


def hide(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Add a rhythm that rises and falls as lumps charge and discharge, each cycle some per cent longer or shorter."""
    generator = np.random.default_rng(int(parameters["seed"]))
    period, duty = float(parameters["period"]), float(parameters["duty"])

    def rhythm(run: RunTruth) -> FloatArray:
        """Return the rhythm, -0.5 to 0.5 about."""
        count = int((run.time[-1] - run.time[0]) / (0.8 * period)) + 3
        lengths = period * np.clip(1.0 + 0.04 * generator.standard_normal(count), 0.85, 1.15)
        corners = np.concatenate([[0.0], np.cumsum(lengths)]) - generator.uniform() * lengths[0]
        turn = np.interp(run.time - run.time[0], corners, np.arange(count + 1.0)) % 1.0
        up = (1.0 - np.exp(-2.0 * turn / duty)) / (1.0 - np.exp(-2.0))
        down = (np.exp(-2.0 * (turn - duty) / (1.0 - duty)) - np.exp(-2.0)) / (1.0 - np.exp(-2.0))
        return np.asarray(np.where(turn < duty, up, down) - 0.5)

    height = float(parameters["height"])
    return truth.changed(runs=tuple(run.changed(effect=run.effect + height * rhythm(run)) for run in truth.runs))


EFFECT = Effect("outside: room-rhythm", draw, hide, amplitude="height", limits=(1e-9, 2e-5))
