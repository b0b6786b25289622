"""Wear: the part changes with the way that it has travelled, fast at first."""

from __future__ import annotations

import numpy as np

from hexathermal.simulate.hidden.effect import Effect, Parameters, with_stroke
from hexathermal.simulate.hidden.shapes import either_sign, log_uniform, step_sizes
from hexathermal.simulate.hidden.truth import CampaignTruth


def draw(truth: CampaignTruth, generator: np.random.Generator) -> Parameters:
    """Draw the wear over the campaign [m] and its power of the way.

    Engineering value: running in goes with the root of the way, later wear straight on (Archard).
    """
    return {
        "wear": either_sign(generator) * log_uniform(1e-6, 10e-6, generator),
        "power": float(generator.uniform(0.5, 1.0)),
    }


def hide(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Add ``wear (way / whole way)^power``, the way from the campaign's first row on."""
    ways, gone = [], 0.0
    for run in truth.runs:
        ways.append(gone + np.cumsum(np.abs(step_sizes(run))))
        gone = float(ways[-1][-1])
    wear, power = float(parameters["wear"]), float(parameters["power"])
    return truth.changed(
        runs=tuple(
            run.changed(effect=run.effect + wear * (way / gone) ** power)
            for run, way in zip(truth.runs, ways, strict=True)
        )
    )


EFFECT = Effect("outside: wear", draw, hide, with_stroke, "wear", (1e-9, 1e-3))
