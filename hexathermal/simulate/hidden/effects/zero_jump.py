"""The zero of the displacement jumps in one run, within minutes: a target slips, a fringe is lost, a cable pulls."""

from __future__ import annotations

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.effect import Effect, Parameters
from hexathermal.simulate.hidden.shapes import either_sign, log_uniform
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth


def draw(truth: CampaignTruth, generator: np.random.Generator) -> Parameters:
    """Draw the run (of identification), the moment [s] since its first row, how long it takes [s], the height [m].

    Engineering values: 0.2 to 5 um within one to eight minutes.
    """
    runs = [run for run in truth.runs if run.role == "identification"]
    run = runs[int(generator.integers(len(runs)))]
    return {
        "run": run.name,
        "moment": float(generator.uniform(0.2, 0.8) * (run.time[-1] - run.time[0])),
        "ramp": log_uniform(60.0, 480.0, generator),
        "height": either_sign(generator) * log_uniform(0.2e-6, 5e-6, generator),
    }


def hide(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Add a smooth step to the run; with a campaign's zero later runs keep it."""
    names = [run.name for run in truth.runs]
    which = names.index(str(parameters["run"]))

    def step(k: int, run: RunTruth) -> FloatArray:
        """Return the step [m]."""
        if k != which:
            kept = 1.0 if k > which and truth.zero == "campaign" else 0.0
            return np.full(run.time.size, kept * float(parameters["height"]))
        since = run.time - run.time[0] - float(parameters["moment"])
        x = np.clip(since / float(parameters["ramp"]), 0.0, 1.0)
        return np.asarray(float(parameters["height"]) * x * x * (3.0 - 2.0 * x))

    return truth.changed(runs=tuple(run.changed(effect=run.effect + step(k, run)) for k, run in enumerate(truth.runs)))


EFFECT = Effect("zero-jump", draw, hide, amplitude="height", limits=(1e-9, 1e-4))
