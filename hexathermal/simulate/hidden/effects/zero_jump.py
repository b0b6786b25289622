"""The zero of the displacement jumps in one run: a target slips or a cable pulls in minutes, or a beam loses count.

Of a beam that was broken the fringes are counted on from another one, from one row to the next.
"""

from __future__ import annotations

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.beams import AZIMUTHS
from hexathermal.simulate.hidden.effect import Effect, Parameters, with_beams
from hexathermal.simulate.hidden.shapes import either_sign, log_uniform
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth

BEAMS = len(AZIMUTHS)

ONE_BEAM = 1.0 / 3.0
"""How often it is one of three beams that loses count."""


def draw(truth: CampaignTruth, generator: np.random.Generator) -> Parameters:
    """Draw the run (of identification), the moment [s] since its first row, how long it takes [s], the height [m].

    Engineering values: 0.2 to 5 um within one to eight minutes. A beam that loses count, at once and by three times the
    height, is drawn by its number, 1 to 3; 0: all jump alike.
    """
    runs = [run for run in truth.runs if run.role == "identification"]
    run = runs[int(generator.integers(len(runs)))]
    found: dict[str, float | int | str] = {
        "run": run.name,
        "moment": float(generator.uniform(0.2, 0.8) * (run.time[-1] - run.time[0])),
        "ramp": log_uniform(60.0, 480.0, generator),
        "height": either_sign(generator) * log_uniform(0.2e-6, 5e-6, generator),
    }
    alone = with_beams(truth) and generator.random() < ONE_BEAM
    if not alone:
        return found | {"beam": 0}
    return found | {"beam": int(generator.integers(1, BEAMS + 1)), "ramp": 0.0}


def hide(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Add a step to the run; with a campaign's zero later runs keep it.

    It is smooth, or of a beam sharp and three times as high: their mean jumps as high as all would.
    """
    names = [run.name for run in truth.runs]
    which, beam = names.index(str(parameters["run"])), int(parameters.get("beam", 0))
    ramp = float(parameters["ramp"])

    def step(k: int, run: RunTruth) -> FloatArray:
        """Return the step [m]."""
        if k != which:
            kept = 1.0 if k > which and truth.zero == "campaign" else 0.0
            return np.full(run.time.size, kept * float(parameters["height"]))
        since = run.time - run.time[0] - float(parameters["moment"])
        x = np.clip(since / ramp, 0.0, 1.0) if ramp else (since >= 0.0).astype(np.float64)
        return np.asarray(float(parameters["height"]) * x * x * (3.0 - 2.0 * x))

    def jumped(k: int, run: RunTruth) -> RunTruth:
        """Return the run with its step."""
        if not beam:
            return run.changed(effect=run.effect + step(k, run))
        alone = np.outer(step(k, run), BEAMS * (np.arange(1, BEAMS + 1) == beam))
        return run.changed(beam_effects=run.beam_effects + alone)

    return truth.changed(runs=tuple(jumped(k, run) for k, run in enumerate(truth.runs)))


EFFECT = Effect("zero-jump", draw, hide, amplitude="height", limits=(1e-9, 1e-4))
