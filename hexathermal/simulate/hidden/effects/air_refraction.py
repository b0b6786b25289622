"""The index of air was not applied, or not to the dead path: beams follow the air's pressure and temperature."""

from __future__ import annotations

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.bench.interferometers import index_of_air
from hexathermal.simulate.hidden.effect import Effect, Parameters, with_beams
from hexathermal.simulate.hidden.shapes import add, either_sign
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth

WAVELENGTH = 632.99e-9

OFTEN, NO_BAROMETER, NO_THERMOMETER = 0.4, 0.25, 0.15
"""How often light passes along the leg, and how often compensation is set once for a campaign; how often it lacks the
pressure alone, or the air's temperature alone, since the station does not read it."""


def draw(truth: CampaignTruth, generator: np.random.Generator) -> Parameters:
    """Draw the path that lacks the index, and the share of it.

    The whole path lacks it where compensation is off (share 1) or the station is wrong by a factor; the dead path where
    its length was typed in wrongly, too long or too short. The whole one is the dead path with the stroke, with the leg
    too where light passes along it; compensation was set at the first row of each run, or once for the campaign.
    """
    path = str(generator.choice(["whole", "dead"]))
    sign = 1.0 if path == "whole" else either_sign(generator)
    found: dict[str, float | int | str] = {"path": path, "share": sign * float(generator.uniform(0.2, 1.0))}
    along, once = generator.random(2) < OFTEN
    read = generator.random()
    if read < NO_BAROMETER or read >= 1.0 - NO_THERMOMETER:
        found |= {"weather": "pressure" if read < NO_BAROMETER else "temperature"}
    if path == "whole":
        found |= {"path": "leg" if along else path, "set": "once" if once else "each run"}
    return found


def hide(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Add ``share path (n / n_set - 1)``, n_set of each run's first row, or of the campaign's."""

    def seen(run: RunTruth) -> FloatArray:
        """Return what the laser shows too much [m]."""
        index = index_of_air(WAVELENGTH, *_lacking(run.air, parameters.get("weather")).T)
        path = truth.dead_path + (run.q if parameters["path"] != "dead" else 0.0)
        path = path + (truth.retracted_length if parameters["path"] == "leg" else 0.0)
        # compensation that was set once is right at the first row of the campaign, which no run's zero hides
        fixed = index_of_air(WAVELENGTH, *truth.runs[0].air[:1].T) if parameters.get("set") == "once" else index[:1]
        return np.asarray(float(parameters["share"]) * path * (index / fixed - 1.0))

    return add(truth, seen)


def _lacking(air: FloatArray, weather: object) -> FloatArray:
    """Return air in which the pressure, or the temperature, alone changes from the first row on; all where not said."""
    if weather is None:
        return air
    still, column = np.tile(air[0], (len(air), 1)), {"temperature": 0, "pressure": 1}[str(weather)]
    still[:, column] = air[:, column]
    return still


EFFECT = Effect("air-refraction", draw, hide, with_beams, "share", (0.005, 2.0))
