"""The platform tilts, and the beams do not stand evenly about the leg: part of the differences leaks into the mean."""

from __future__ import annotations

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.beams import AZIMUTHS, RADIUS
from hexathermal.simulate.hidden.effect import Effect, Parameters, with_beams
from hexathermal.simulate.hidden.shapes import either_sign, log_uniform, place_in_stroke
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth


def draw(truth: CampaignTruth, generator: np.random.Generator) -> Parameters:
    """Draw what tilts the platform, the largest angle [rad], its direction [rad], the offset of the beams' centre [m].

    Source: tilts of 10 to 100 urad over a stroke, or with a lateral difference of temperatures, are usual. Engineering
    value: beams are set up about the axis within 5 to 25 mm.
    """
    others = [sensor for sensor in truth.sensors if sensor not in truth.base]
    found: dict[str, float | int | str] = {
        "source": str(generator.choice(["temperatures", "stroke"] if others else ["stroke"])),
        "angle": log_uniform(10e-6, 100e-6, generator),
        "direction": float(generator.uniform(0.0, 2.0 * np.pi)),
        "offset": either_sign(generator) * float(generator.uniform(0.005, 0.025)),
        "waves": float(generator.uniform(0.4, 1.2)),
        "phase": float(generator.uniform(0.0, 2.0 * np.pi)),
    }
    if others:
        found |= {"warm": str(generator.choice(truth.base)), "cold": str(generator.choice(others))}
    return found


def hide(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Tilt the platform: beam k changes by ``angle (radius cos(azimuth_k - direction) + offset)``.

    An offset is one of the beams, not of one tilt: what the platform tilts anyway leaks by it too.
    """

    def source(run: RunTruth) -> FloatArray:
        """Return what tilts the platform, any unit."""
        if parameters["source"] == "stroke":
            turns = float(parameters["waves"]) * place_in_stroke(truth, run)
            return np.asarray(np.sin(2.0 * np.pi * turns + float(parameters["phase"])))
        warm, cold = (truth.sensors.index(str(parameters[name])) for name in ("warm", "cold"))
        apart = run.temperatures[:, warm] - run.temperatures[:, cold]
        return np.asarray(apart - apart[0])

    largest = max(float(np.abs(source(run)).max()) for run in truth.runs)
    scale = float(parameters["angle"]) / largest if largest > 0.0 else 0.0
    toward = np.cos(np.array(AZIMUTHS) - float(parameters["direction"]))

    def tilted(run: RunTruth) -> FloatArray:
        """Return the beams' effects [m]: all tilt along the direction leaks."""
        apart = run.beam_effects + scale * RADIUS * np.outer(source(run), toward)
        tilt = apart @ toward / (RADIUS * (toward @ toward))
        return np.asarray(apart + float(parameters["offset"]) * tilt[:, None])

    return truth.changed(runs=tuple(run.changed(beam_effects=tilted(run)) for run in truth.runs))


EFFECT = Effect("abbe-tilt", draw, hide, with_beams, "angle", (1e-8, 1e-3))
