"""The index of air was not applied, or not to the dead path: beams follow the air's pressure and temperature."""

from __future__ import annotations

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.bench.interferometers import index_of_air
from hexathermal.simulate.hidden.effect import Effect, Parameters, with_beams
from hexathermal.simulate.hidden.shapes import add, either_sign
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth

WAVELENGTH = 632.99e-9


def draw(truth: CampaignTruth, generator: np.random.Generator) -> Parameters:
    """Draw the path that lacks the index, and the share of it.

    The whole path lacks it where compensation is off (share 1) or the station is wrong by a factor; the dead path where
    its length was typed in wrongly, too long or too short.
    """
    path = str(generator.choice(["whole", "dead"]))
    sign = 1.0 if path == "whole" else either_sign(generator)
    return {"path": path, "share": sign * float(generator.uniform(0.2, 1.0))}


def hide(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Add ``share path (n / n_first - 1)``, n of each run's first row."""

    def seen(run: RunTruth) -> FloatArray:
        """Return what the laser shows too much [m]."""
        index = index_of_air(WAVELENGTH, *run.air.T)
        path = truth.dead_path + (run.q if parameters["path"] == "whole" else 0.0)
        return np.asarray(float(parameters["share"]) * path * (index / index[0] - 1.0))

    return add(truth, seen)


EFFECT = Effect("air-refraction", draw, hide, with_beams, "share", (0.005, 2.0))
