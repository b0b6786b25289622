"""A thermometer of the law drifts, at once, from some time on or in one run alone: straight on, and as it likes."""

from __future__ import annotations

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.effect import Effect, Parameters
from hexathermal.simulate.hidden.shapes import either_sign, log_uniform, misread, since_start
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth

MINUTES = 60.0


def draw(truth: CampaignTruth, generator: np.random.Generator) -> Parameters:
    """Draw the sensor, the drift over the mean run [K], the wandering's part, the seed of the walk, and the onset.

    That is a part of the campaign, of every third one up to a half; every sixth drifts in one run alone, from up to
    half of that on. Engineering value: 0.05 to 1 K a shift of a bad junction or a warm logger.
    """
    found: dict[str, float | int | str] = {
        "target": str(generator.choice(truth.base)),
        "drift": either_sign(generator) * log_uniform(0.05, 1.0, generator),
        "wandering": float(generator.uniform(0.1, 0.4)),
        "seed": int(generator.integers(2**31)),
    }
    kind, place = divmod(int(found["seed"]), 3)
    alone = kind // 2 % len(truth.runs) if place == 1 and kind % 2 else -1
    return found | {"onset": 0.0 if place and alone < 0 else kind % 1000 / 2000.0, "alone": alone}


def hide(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Add ``drift (max(t - onset, 0) / run + wandering w(t))`` to the sensor; w is a walk of a step a minute.

    It is held within -1 and 1. A drift in one run alone begins in that one, and is gone in the next.
    """
    j = truth.sensors.index(str(parameters["target"]))
    generator, times = np.random.default_rng(int(parameters["seed"])), since_start(truth)
    mean = float(np.mean([time[-1] - time[0] for time in times]))
    minutes = np.arange(0.0, times[-1][-1] + 2.0 * MINUTES, MINUTES)
    free = np.cumsum(generator.standard_normal(minutes.size)) * np.sqrt(MINUTES / mean)
    # a walk between walls: turned back where it would pass them
    walk = np.abs((free + 1.0) % 4.0 - 2.0) - 1.0
    drift, part = float(parameters["drift"]), float(parameters["wandering"])
    alone, onset = int(parameters["alone"]), float(parameters["onset"]) * times[-1][-1]
    if alone >= 0:
        own = times[alone]
        onset = own[0] + float(parameters["onset"]) * (own[-1] - own[0])

    def reads(k: int, run: RunTruth) -> FloatArray:
        """Return what it reads."""
        gone = np.maximum(times[k] - onset, 0.0) / mean + part * np.interp(times[k], minutes, walk)
        if alone >= 0:
            gone = gone * (times[k] >= onset) * (k == alone)
        return np.asarray(run.temperatures[:, j] + run.sensor_errors[:, j] + drift * gone)

    return misread(truth, truth.sensors[j], reads)


EFFECT = Effect("sensor-drift", draw, hide, amplitude="drift", limits=(1e-4, 1.5), readings=True, lost=True)
