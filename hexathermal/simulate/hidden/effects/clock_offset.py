"""Two loggers, two clocks: that of the temperatures is fast or slow against that of the displacement."""

from __future__ import annotations

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.effect import Effect, Parameters
from hexathermal.simulate.hidden.shapes import either_sign, log_uniform
from hexathermal.simulate.hidden.truth import CampaignTruth


def draw(truth: CampaignTruth, generator: np.random.Generator) -> Parameters:
    """Draw the offset [s], either sign.

    Engineering value: 30 s to 10 min of clocks that somebody set by hand.
    """
    return {"offset": either_sign(generator) * log_uniform(30.0, 600.0, generator)}


def at_other_times(time: FloatArray, values: FloatArray, offset: float) -> FloatArray:
    """Return values at ``time + offset``; beyond either end they go on as if turned about their last point."""
    before, after = 2.0 * time[0] - time[:0:-1], 2.0 * time[-1] - time[-2::-1]
    longer = np.concatenate([before, time, after])
    found = np.empty_like(values)
    for j, column in enumerate(values.T):
        around = np.concatenate([2.0 * column[0] - column[:0:-1], column, 2.0 * column[-1] - column[-2::-1]])
        found[:, j] = np.interp(time + offset, longer, around)
    return found


def hide(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Let every thermometer read, at time t, what was at ``t + offset``; its noise stays as it is."""
    offset = float(parameters["offset"])
    return truth.changed(
        runs=tuple(
            run.changed(
                sensor_errors=run.sensor_errors + at_other_times(run.time, run.temperatures, offset) - run.temperatures
            )
            for run in truth.runs
        )
    )


EFFECT = Effect("clock-offset", draw, hide, amplitude="offset", limits=(30.0, 600.0), readings=True)
