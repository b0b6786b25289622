"""Two thermometers were plugged in the wrong way round, one of them the law's."""

from __future__ import annotations

import numpy as np

from hexathermal.simulate.hidden.effect import Effect, Parameters
from hexathermal.simulate.hidden.truth import CampaignTruth


def possible(truth: CampaignTruth) -> bool:
    """Return whether there is another sensor."""
    return len(truth.sensors) > len(truth.base)


def draw(truth: CampaignTruth, generator: np.random.Generator) -> Parameters:
    """Draw the law's sensor and the other one, any two plugs of a logger."""
    others = [sensor for sensor in truth.sensors if sensor not in truth.base]
    return {"target": str(generator.choice(truth.base)), "other": str(generator.choice(others))}


def hide(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Exchange the two columns in all runs."""
    a, b = (truth.sensors.index(str(parameters[name])) for name in ("target", "other"))
    runs = []
    for run in truth.runs:
        read = run.temperatures + run.sensor_errors
        read[:, [a, b]] = read[:, [b, a]]
        runs.append(run.changed(sensor_errors=read - run.temperatures))
    return truth.changed(runs=tuple(runs))


EFFECT = Effect("swapped-sensors", draw, hide, possible, readings=True)
