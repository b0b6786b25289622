"""Three beams about the leg: where they run, and how they differ in any campaign, which tells nothing of the leg."""

from __future__ import annotations

from math import pi

import numpy as np

from hexathermal.simulate.bench.thermocouples import slow_process
from hexathermal.simulate.hidden.truth import CampaignTruth

RADIUS = 0.060
"""Of the beams about the leg's axis [m]."""

AZIMUTHS = (0.0, 2.0 * pi / 3.0, 4.0 * pi / 3.0)
"""Of the beams [rad]."""

STRAIGHTNESS, SLOW, SLOW_TIME, SINGLE = 3e-6, 0.7e-6, 3600.0, 10e-9
"""Tilt per metre of the stroke [rad/m], slow tilt [rad] and its time [s], noise of single beams [m]: usual sizes."""


def with_usual_differences(truth: CampaignTruth, generator: np.random.Generator) -> CampaignTruth:
    """Return the campaign with beams that differ as always: by tilts, and by noise of each; their mean stays."""
    if truth.kind != "leg":
        return truth
    lever = RADIUS * np.stack([np.cos(AZIMUTHS), np.sin(AZIMUTHS)])
    straightness = STRAIGHTNESS * generator.standard_normal(2)
    runs = []
    for run in truth.runs:
        tilt = np.outer(run.q, straightness) + SLOW * slow_process(run.time, SLOW_TIME, 2, generator)
        apart = tilt @ lever + SINGLE * generator.standard_normal((run.time.size, 3))
        runs.append(run.changed(beam_effects=run.beam_effects + apart - apart.mean(axis=1, keepdims=True)))
    return truth.changed(runs=tuple(runs))
