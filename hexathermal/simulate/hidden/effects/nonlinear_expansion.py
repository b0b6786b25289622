"""Expansion that is not proportional to temperature: as a square, or as Invar that leaves its flat range smoothly.

A square is one of the temperature from 20 degC, or of the warming since the zero, by which a law was identified.
"""

from __future__ import annotations

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.effect import Effect, Parameters
from hexathermal.simulate.hidden.shapes import add, either_sign, log_uniform, share_of_length
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth

REFERENCE_DEGC = 20.0

BY_WARMING = 1.0 / 3.0
"""How often a square is one of the warming since the zero."""


def draw(truth: CampaignTruth, generator: np.random.Generator) -> Parameters:
    """Draw the curve, the sensor, the bend [m/K2]; of Invar the middle [degC] and the width [K] of its bend.

    Source: the expansion of Invar rises by some 1e-8 to 3e-8 /K per kelvin; of steel by some 1e-8.
    """
    sensor = str(generator.choice(truth.base))
    j = truth.sensors.index(sensor)
    hot = max(float(run.temperatures[:, j].max()) for run in truth.runs)
    cold = min(float(run.temperatures[:, j].min()) for run in truth.runs)
    found: dict[str, float | int | str] = {
        "curve": str(generator.choice(["square", "invar"])),
        "target": sensor,
        "bend": either_sign(generator) * log_uniform(5e-9, 1e-7, generator),
        "middle": float(generator.uniform(cold, 0.5 * (cold + hot))),
        "width": float(generator.uniform(0.3, 0.8) * (hot - cold)),
    }
    if generator.random() < BY_WARMING:
        found["curve"] = "warming"
    return found


def hide(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Add ``bend u^2``, u from 20 degC or the zero; or ``bend width^2 log cosh(u / width)``, u from the middle.

    Each goes with the length. The last curve is the square near its middle, and a straight line far from it.
    """
    j, bend = truth.sensors.index(str(parameters["target"])), float(parameters["bend"])
    middle, width = float(parameters["middle"]), float(parameters["width"])

    def strain(run: RunTruth) -> FloatArray:
        """Return the growth of the retracted length beside the law [m]."""
        if parameters["curve"] != "invar":
            first = run if truth.zero == "run" else truth.runs[0]
            zero = REFERENCE_DEGC if parameters["curve"] == "square" else first.temperatures[0, j]
            return np.asarray(bend * (run.temperatures[:, j] - zero) ** 2)
        u = (run.temperatures[:, j] - middle) / width
        return np.asarray(bend * width**2 * (np.logaddexp(u, -u) - np.log(2.0)))

    return add(truth, lambda run: strain(run) * share_of_length(truth, run))


EFFECT = Effect("nonlinear-expansion", draw, hide, amplitude="bend", limits=(1e-11, 2e-6))
