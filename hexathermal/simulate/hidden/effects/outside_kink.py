"""A kink in temperature: above it, something touches that was free below."""

from __future__ import annotations

import numpy as np

from hexathermal.simulate.hidden.effect import Effect, Parameters
from hexathermal.simulate.hidden.shapes import add, either_sign, log_uniform
from hexathermal.simulate.hidden.truth import CampaignTruth


def draw(truth: CampaignTruth, generator: np.random.Generator) -> Parameters:
    """Draw the sensor, the temperature of the kink [degC] and the slope above it [m/K].

    Engineering value: 0.1 to 2 um/K, from the middle of the warmest run's range on.
    """
    sensor = str(generator.choice(truth.base))
    warm = np.concatenate([run.temperatures[:, truth.sensors.index(sensor)] for run in truth.runs])
    return {
        "sensor": sensor,
        "kink": float(np.quantile(warm, generator.uniform(0.4, 0.75))),
        "slope": either_sign(generator) * log_uniform(0.1e-6, 2e-6, generator),
    }


def hide(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Add ``slope max(T - kink, 0)``."""
    j = truth.sensors.index(str(parameters["sensor"]))
    slope, kink = float(parameters["slope"]), float(parameters["kink"])
    return add(truth, lambda run: slope * np.clip(run.temperatures[:, j] - kink, 0.0, None))


EFFECT = Effect("outside: kink", draw, hide, amplitude="slope", limits=(1e-9, 5e-5))
