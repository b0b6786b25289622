"""A joint slips as the temperature turns: the drift follows it with a gap, so it draws a loop."""

from __future__ import annotations

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.effect import Effect, Parameters
from hexathermal.simulate.hidden.shapes import add, either_sign, log_uniform, play_of_many, swing_of
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth


def draw(truth: CampaignTruth, generator: np.random.Generator) -> Parameters:
    """Draw the sensor, the gap [K] as a part of its swing, and the height of the loop [m].

    Source: bolted joints slip by tenths of a micrometre to some micrometres as they warm and cool.
    """
    sensor = str(generator.choice(truth.base))
    swing = swing_of(truth, sensor)
    return {
        "sensor": sensor,
        "gap": float(generator.uniform(0.1, 0.35) * swing),
        "height": either_sign(generator) * log_uniform(0.2e-6, 3e-6, generator),
    }


def hide(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Add the height times where the joint sits in its gaps, -0.5 to 0.5; a run begins in the middle."""
    j = truth.sensors.index(str(parameters["sensor"]))

    def sits(run: RunTruth) -> FloatArray:
        """Return where it sits."""
        return play_of_many(run.temperatures[:, j], float(parameters["gap"]), 0.0)

    return add(truth, lambda run: float(parameters["height"]) * sits(run))


EFFECT = Effect("outside: hysteresis", draw, hide, amplitude="height", limits=(1e-9, 5e-5))
