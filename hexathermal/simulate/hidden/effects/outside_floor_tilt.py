"""The floor tilts with the day: sun on a wall, tides of a building; runs begin at any hour."""

from __future__ import annotations

import numpy as np

from hexathermal.simulate.hidden.effect import Effect, Parameters
from hexathermal.simulate.hidden.shapes import log_uniform
from hexathermal.simulate.hidden.truth import CampaignTruth

DAY = 86400.0


def draw(truth: CampaignTruth, generator: np.random.Generator) -> Parameters:
    """Draw the height of the daily wave [m], the half-daily wave's part, and the seed of the hours when runs begin.

    Source: floors tilt by 1 to 10 urad a day; levers of some 0.1 to 0.5 m.
    """
    return {
        "height": log_uniform(0.2e-6, 4e-6, generator),
        "half": float(generator.uniform(0.1, 0.4)),
        "seed": int(generator.integers(2**31)),
    }


def hide(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Add ``height (sin(a + phase) + half sin(2 a))``, ``a = 2 pi t / day``, t the hour of the day."""
    generator = np.random.default_rng(int(parameters["seed"]))
    phase, height = float(generator.uniform(0.0, 2.0 * np.pi)), float(parameters["height"])
    runs = []
    for run in truth.runs:
        a = 2.0 * np.pi * ((run.time - run.time[0]) / DAY + generator.uniform())
        runs.append(
            run.changed(effect=run.effect + height * (np.sin(a + phase) + float(parameters["half"]) * np.sin(2.0 * a)))
        )
    return truth.changed(runs=tuple(runs))


EFFECT = Effect("outside: floor-tilt", draw, hide, amplitude="height", limits=(1e-9, 1e-4))
