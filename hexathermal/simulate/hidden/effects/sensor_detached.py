"""A thermometer of the law loses contact in one run and reads mostly air from then on, until somebody fixes it."""

from __future__ import annotations

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.effect import Effect, Parameters
from hexathermal.simulate.hidden.shapes import log_uniform, misread
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth

FIXED = 0.3
"""How often it is found and fixed before the next run."""


def possible(truth: CampaignTruth) -> bool:
    """Return whether it is known what the air's temperature is."""
    return all(np.isfinite(run.air[:, 0]).all() for run in truth.runs)


def draw(truth: CampaignTruth, generator: np.random.Generator) -> Parameters:
    """Draw the sensor, the run (of identification), the moment [s] since its first row, how long it takes [s], the
    share of air, and whether it is fixed again before the next run.

    Engineering values: tape lets go within seconds to minutes; the junction reads 70 to 100 % air then. Who looks at
    the bench between runs finds some of them.
    """
    runs = [run for run in truth.runs if run.role == "identification"]
    run = runs[int(generator.integers(len(runs)))]
    return {
        "target": str(generator.choice(truth.base)),
        "run": run.name,
        "moment": float(generator.uniform(0.1, 0.97) * (run.time[-1] - run.time[0])),
        "time": log_uniform(5.0, 300.0, generator),
        "share": float(generator.uniform(0.7, 1.0)),
        "fixed": bool(generator.random() < FIXED and run is not runs[-1]),
    }


def hide(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Let the sensor read ``T - share lost(t) (T - T_air)``, ``lost = 1 - exp(-(t - moment) / time)``."""
    sensor, share = str(parameters["target"]), float(parameters["share"])
    j, which = truth.sensors.index(sensor), [run.name for run in truth.runs].index(str(parameters["run"]))

    def reading(k: int, run: RunTruth) -> FloatArray:
        """Return what the sensor reads [degC]."""
        since = run.time - run.time[0] - float(parameters["moment"])
        lost = 1.0 - np.exp(-np.clip(since, 0.0, None) / float(parameters["time"]))
        later = float(k > which and not parameters["fixed"])
        lost = lost if k == which else np.full(run.time.size, later)
        own = run.temperatures[:, j]
        return np.asarray(own + run.sensor_errors[:, j] - share * lost * (own - run.air[:, 0]))

    return misread(truth, sensor, reading)


EFFECT = Effect("sensor-detached", draw, hide, possible, readings=True, lost=True)
