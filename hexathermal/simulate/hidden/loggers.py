"""A logger whose cold junction drifts: every thermometer reads the same error besides its own."""

from __future__ import annotations

from collections.abc import Sequence

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
    return with_errors(truth, [np.repeat(own, len(truth.sensors), axis=1) for own in shared]), error


def with_errors(truth: CampaignTruth, errors: Sequence[FloatArray]) -> CampaignTruth:
    """Return a campaign whose thermometers err besides, by an array, shape (n, s) [K], for each run."""
    runs = [run.changed(sensor_errors=run.sensor_errors + own) for run, own in zip(truth.runs, errors, strict=True)]
    notes = dict(truth.notes)
    if "thermometers_rms_um" in notes:
        parts = [
            _feigned(truth, *item) for item in zip(truth.runs, errors, strict=True) if item[0].role != "validation"
        ]
        added = 1e6 * float(np.sqrt(np.mean(np.concatenate(parts) ** 2)))
        notes["thermometers_rms_um"] = float(np.hypot(float(str(notes["thermometers_rms_um"])), added))
    return truth.changed(runs=tuple(runs), notes=notes)


def _feigned(truth: CampaignTruth, run: RunTruth, errors: FloatArray) -> FloatArray:
    """Return the drift that errors of the law's thermometers feign on settled rows, counted from its mean [m]."""
    own = errors[run.settled][:, [truth.sensors.index(name) for name in truth.base]]
    wrong = (own * truth.slopes(run.q[run.settled])).sum(axis=1)
    return np.asarray(wrong - wrong.mean())
