"""A thermometer, or the structure under it, follows late: stages one behind the other, or heat that must diffuse."""

from __future__ import annotations

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.effect import Effect, Parameters
from hexathermal.simulate.hidden.shapes import add, cascade, diffused, log_uniform, misread
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth

SHARES = (0.62, 0.28, 0.10)
"""Of the delay, in each stage of the cascade."""


def draw(truth: CampaignTruth, generator: np.random.Generator) -> Parameters:
    """Draw side, form, sensor and delay [s].

    Engineering values: a thermometer under tape or in a pocket follows within half a minute to a quarter of an hour,
    the core of a spindle or of a thick tube within minutes to an hour.
    """
    side = str(generator.choice(["sensor", "structure"]))
    return {
        "side": side,
        "form": str(generator.choice(["cascade", "diffusion"])),
        "target": str(generator.choice(truth.base)),
        "delay": log_uniform(30.0, 900.0, generator) if side == "sensor" else log_uniform(180.0, 3600.0, generator),
    }


def late(run: RunTruth, values: FloatArray, parameters: Parameters) -> FloatArray:
    """Return what follows values late."""
    delay = float(parameters["delay"])
    if parameters["form"] == "diffusion":
        return diffused(run.time, values, delay)
    return cascade(run.time, values, [share * delay for share in SHARES])


def hide(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Let the sensor read, or the structure follow, late."""
    sensor = str(parameters["target"])
    j, own = truth.sensors.index(sensor), truth.base.index(sensor)

    def behind(run: RunTruth) -> FloatArray:
        """Return by how much it is behind [K]."""
        return np.asarray(late(run, run.temperatures[:, j], parameters) - run.temperatures[:, j])

    if parameters["side"] == "sensor":
        return misread(truth, sensor, lambda _, run: run.temperatures[:, j] + run.sensor_errors[:, j] + behind(run))
    return add(truth, lambda run: truth.slopes(run.q)[:, own] * behind(run))


EFFECT = Effect("thermal-lag", draw, hide, amplitude="delay", limits=(15.0, 7200.0), readings=True)
