"""How much better one law predicts than another, on the same rows of runs never fitted, with 95 % intervals.

``gain = 1 - residual after / residual before``. The two laws meet the same rows, and the interval is that of the ratio:
what makes a run hard for both cancels. Intervals are made as `hexathermal.learn.validation_scores` tells.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.learn.validation import SEED, LandingsJudged, Validation
from hexathermal.learn.validation_scores import Figure, Scores, scores
from hexathermal.poses import FloatArray

RESIDUAL = (1, 2, 3)
"""Columns of a table of landings that hold e^2, |e| and the largest |e|; those of the drift stand three behind."""


@dataclass(frozen=True)
class RunGain:
    """What a law leaves of a run, or of all runs, before and after.

    Attributes
    ----------
    rmse_before, linf_before : float [m]
    rmse_after, linf_after : Figure [m]
    rmse_gain, linf_gain, mean_gain : Figure
        ``1 - after / before``; negative where it is worse.
    """

    rmse_before: float
    linf_before: float
    rmse_after: Figure
    linf_after: Figure
    rmse_gain: Figure
    linf_gain: Figure
    mean_gain: Figure


@dataclass(frozen=True)
class Gain:
    """Gain of a law over another.

    Attributes
    ----------
    runs : dict of str to RunGain
    total : RunGain
        Of all runs that neither law was fitted to.
    skipped : tuple of str
        Runs in which the two did not meet the same rows, since a sensor of one of them has no values there.
    """

    runs: dict[str, RunGain]
    total: RunGain
    skipped: tuple[str, ...] = ()

    @property
    def proven(self) -> bool:
        """Whether the RMSE falls beyond doubt."""
        return self.total.rmse_gain.low > 0.0


def gain(before: Validation | LandingsJudged, after: Validation | LandingsJudged) -> Gain:
    """Return how much better a law predicts than another.

    Parameters
    ----------
    before, after : Validation or LandingsJudged
        Of the two laws, on the same campaign.

    Raises
    ------
    ArgumentError
        There is no run in which the two met the same rows.
    """
    paired = {
        name: _paired(before.landings[name], table)
        for name, table in after.landings.items()
        if name in before.landings and np.array_equal(before.landings[name][:, 0], table[:, 0])
    }
    if not paired:
        raise ArgumentError(
            "the two laws were not validated on the same rows: take the same campaign, and runs in which the sensors "
            "of both have values"
        )
    fitted = {*before.fitted, *after.fitted}
    judged = [table for name, table in paired.items() if name not in fitted] or list(paired.values())
    rng = np.random.default_rng(SEED)
    total = _told(scores(judged, rng))
    skipped = tuple(name for name in dict.fromkeys((*before.landings, *after.landings)) if name not in paired)
    return Gain({name: _told(scores([table], rng)) for name, table in paired.items()}, total, skipped)


def _paired(before: FloatArray, after: FloatArray) -> FloatArray:
    """Return a table of landings in which the residual before stands for the drift."""
    table = after[:, :7].copy()
    for column in RESIDUAL:
        table[:, column + 3] = before[:, column]
    return table


def _told(found: Scores) -> RunGain:
    """Return scores of a paired table as a gain."""
    return RunGain(found.drift_rms, found.drift_largest, found.rmse, found.linf, found.rms_reduction,
                   found.largest_reduction, found.mean_reduction)  # fmt: skip
