"""All trials of a campaign: those of the catalogue, and what has no name."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from hexathermal.learn.diagnosis.causes import catalogue
from hexathermal.learn.diagnosis.feigning import erring, feigned_by
from hexathermal.learn.diagnosis.trials import Trial, Workbench
from hexathermal.learn.diagnosis.unexplained import THERMAL, WANDERING, flexible_trials
from hexathermal.poses import FloatArray


def all_trials(bench: Workbench, slow: float | None = None) -> list[Trial]:
    """Return the trials of the catalogue and the nameless ones; `slow` as in `feigned_by`."""
    thermometers, found = feigned_by(bench, slow), []

    def feigns(*, thermal: bool, wanders: bool) -> float:
        """Return the misfit that errors of the thermometers may feign, RMS [m]."""
        return math.hypot(thermometers * thermal, bench.wandered * wanders)

    for module in catalogue().values():
        own = module.CAUSE.misfit * bench.noise
        feigned = math.hypot(own, feigns(thermal=module.CAUSE.thermal, wanders=module.CAUSE.wanders))
        found += [_feigning(trial, math.hypot(feigned, erring(bench, trial))) for trial in module.trials(bench)]
    for trial in flexible_trials(bench):
        feigned = feigns(thermal=trial.target in THERMAL, wanders=trial.target in WANDERING)
        found.append(_feigning(trial, feigned))
    varied = [trial for trial in found if trial.base is not None or _varies(trial.columns)]
    return [trial for trial in varied if trial.term is None or _varies(trial.term.columns)]


def _feigning(trial: Trial, feigned: float) -> Trial:
    """Return a trial with the misfit that errors of the thermometers may feign."""
    feigned = 0.0 if trial.unfeigned else feigned
    return trial if trial.feigned == feigned else replace(trial, feigned=feigned)


def _varies(columns: FloatArray) -> bool:
    """Return whether a column is no constant; columns with missing values say nothing."""
    varies = (columns[-1] != columns[0]).any() or (columns != columns[0]).any()  # most differ at once
    return bool(varies and not np.isnan(columns.sum()))
