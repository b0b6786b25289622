"""An error that repeats with the turns of the screw, twice a turn too; its phase belongs to the screw, not to a run."""

from __future__ import annotations

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.effect import Effect, Parameters, with_stroke
from hexathermal.simulate.hidden.shapes import add, log_uniform
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth

ALIASED = (0.002, 0.0025, 0.005, 0.010)
"""Pitches [m] that steps of 10 mm meet in one phase."""


def draw(truth: CampaignTruth, generator: np.random.Generator) -> Parameters:
    """Draw pitch [m], amplitude [m], the second harmonic's part, and both phases [rad].

    Source: leads of 2 to 20 mm; an eccentricity makes 0.1 to 2 um once a turn, a wobble of the bearing twice a turn.
    One screw in five has a pitch that steps of 10 mm alias.
    """
    aliased = generator.uniform() < 0.2
    return {
        "pitch": float(generator.choice(ALIASED)) if aliased else log_uniform(0.002, 0.020, generator),
        "amplitude": log_uniform(0.1e-6, 2e-6, generator),
        "second": float(generator.uniform(0.1, 0.5)),
        "phase": float(generator.uniform(0.0, 2.0 * np.pi)),
        "second_phase": float(generator.uniform(0.0, 2.0 * np.pi)),
    }


def hide(truth: CampaignTruth, parameters: Parameters) -> CampaignTruth:
    """Add ``amplitude (sin(a + phase) + second sin(2 a + second_phase))``, ``a = 2 pi q / pitch``."""

    def error(run: RunTruth) -> FloatArray:
        """Return the screw's error [m]."""
        turn = 2.0 * np.pi * run.q / float(parameters["pitch"])
        once = np.sin(turn + float(parameters["phase"]))
        twice = np.sin(2.0 * turn + float(parameters["second_phase"]))
        return np.asarray(float(parameters["amplitude"]) * (once + float(parameters["second"]) * twice))

    return add(truth, error)


EFFECT = Effect("periodic-screw-error", draw, hide, with_stroke, "amplitude", (1e-9, 1e-5))
