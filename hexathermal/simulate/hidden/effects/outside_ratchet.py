"""A seat that creaks: it slips by a little whenever it is warmer than ever before in the run, and stays."""

from __future__ import annotations

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.effect import Effect, Parameters
from hexathermal.simulate.hidden.shapes import add, either_sign, log_uniform, swing_of
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth


def draw(truth: CampaignTruth, generator: np.random.Generator) -> Parameters:
    """Draw the sensor, by how much it must be warmer for the next slip [K], and the height of a slip over that [m/K].

    Source: screws and seats under a load slip by a tenth of a micrometre to some micrometres as parts grow apart.
    """
    sensor = str(generator.choice(truth.base))
    swing = swing_of(truth, sensor)
    return {
        "sensor": sensor,
        "every": float(generator.uniform(0.02, 0.12) * swing),
        "slope": either_sign(generator) * log_uniform(0.1e-6, 2e-6, generator),
    }


def hide(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Add a slip of ``slope every`` each time that it is warmer by `every` than at the last slip, or at the begin."""
    j = truth.sensors.index(str(parameters["sensor"]))
    every, slope = float(parameters["every"]), float(parameters["slope"])

    def slipped(run: RunTruth) -> FloatArray:
        """Return how far it has slipped [K]."""
        found, at = np.empty(run.time.size), float(run.temperatures[0, j])
        gone = 0.0
        for k, now in enumerate(run.temperatures[:, j]):
            while now > at + every:
                at, gone = at + every, gone + every
            found[k] = gone
        return found

    return add(truth, lambda run: slope * slipped(run))


EFFECT = Effect("outside: ratchet", draw, hide, amplitude="slope", limits=(1e-9, 5e-5))
