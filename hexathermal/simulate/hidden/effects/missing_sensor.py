"""Another recorded temperature matters too: a bracket, a joint or a plate that the law's sensors do not stand for."""

from __future__ import annotations

import numpy as np

from hexathermal.simulate.hidden.effect import Effect, Parameters
from hexathermal.simulate.hidden.shapes import add, either_sign, log_uniform
from hexathermal.simulate.hidden.truth import CampaignTruth

PLACES = ("fixed", "stroke")


def possible(truth: CampaignTruth) -> bool:
    """Return whether there is another sensor."""
    return len(truth.sensors) > len(truth.base)


def draw(truth: CampaignTruth, generator: np.random.Generator) -> Parameters:
    """Draw the sensor, where it acts, and its coefficient [m/K].

    Source: 100 mm of steel are 1.15 um/K, of Invar 0.15 um/K.
    """
    others = [sensor for sensor in truth.sensors if sensor not in truth.base]
    place = "fixed" if truth.kind != "leg" or generator.uniform() < 0.7 else "stroke"
    return {
        "target": str(generator.choice(others)),
        "place": place,
        "coefficient": either_sign(generator) * log_uniform(0.1e-6, 2e-6, generator),
    }


def hide(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Add the sensor's term, ``coefficient dT``; in the stroke ``coefficient dT q / stroke``."""
    j, slope = truth.sensors.index(str(parameters["target"])), float(parameters["coefficient"])
    stroke = truth.stroke[1] - truth.stroke[0]
    first = truth.runs[0].temperatures[0, j]

    return add(
        truth,
        lambda run: (
            slope
            * (run.temperatures[:, j] - (run.temperatures[0, j] if truth.zero == "run" else first))
            * (run.q / stroke if parameters["place"] == "stroke" else 1.0)
        ),
    )


EFFECT = Effect("missing-sensor", draw, hide, possible, "coefficient", (1e-9, 6e-6))
