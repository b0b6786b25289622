"""A logger whose cold junction drifts: every thermometer reads the same error besides its own."""

from __future__ import annotations

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.bench.thermocouples import slow_process
from hexathermal.simulate.hidden.shapes import log_uniform
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth

OFTEN = 1.0 / 3.0
"""How often a campaign's logger drifts enough to be seen."""

ERRORS_K, TIMES_S = (0.01, 0.06), (1800.0, 14400.0)
"""RMS of what all thermometers share, and the time in which it forgets itself. Engineering value: 0.05 to 0.2 K over a
day in a workshop, less with an isothermal block."""


def with_shared_errors(truth: CampaignTruth, generator: np.random.Generator) -> tuple[CampaignTruth, float]:
    """Return the campaign with what its logger adds to all readings, and its RMS [K]: 0 in most campaigns."""
    often, error, time = generator.random(), log_uniform(*ERRORS_K, generator), log_uniform(*TIMES_S, generator)
    if often > OFTEN:
        return truth, 0.0
    shared = [error * slow_process(run.time, time, 1, generator) for run in truth.runs]
    runs = [run.changed(sensor_errors=run.sensor_errors + own) for run, own in zip(truth.runs, shared, strict=True)]
    notes = dict(truth.notes)
    if "thermometers_rms_um" in notes:
        parts = [
            _feigned(truth, *item) for item in zip(truth.runs, shared, strict=True) if item[0].role != "validation"
        ]
        added = 1e6 * float(np.sqrt(np.mean(np.concatenate(parts) ** 2)))
        notes["thermometers_rms_um"] = float(np.hypot(float(str(notes["thermometers_rms_um"])), added))
    return truth.changed(runs=tuple(runs), notes=notes), error


def _feigned(truth: CampaignTruth, run: RunTruth, shared: FloatArray) -> FloatArray:
    """Return the drift that errors of all thermometers feign on settled rows, counted from its mean [m]."""
    slopes = truth.coefficients.sum()
    if truth.kind == "leg":
        A, B = np.split(truth.coefficients, 2)
        slopes = A.sum() * truth.retracted_length + B.sum() * run.q[run.settled]
    wrong = shared[run.settled, 0] * slopes
    return np.asarray(wrong - wrong.mean())
