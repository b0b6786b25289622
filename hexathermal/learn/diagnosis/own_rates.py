"""Straight lines in time in each run: rates of each run's own, beside a common one or without."""

from __future__ import annotations

import numpy as np

from hexathermal.learn.diagnosis.view import View
from hexathermal.poses import FloatArray

OWN_RATES = "time (a rate of each run's own)"
"""What such lines without a name follow."""

FEWEST_RATES = 4
"""With fewer runs nobody tells rates that differ from a slow noise."""

HOUR_S = 3600.0


def each_run(view: View) -> FloatArray:
    """Return ones in the windows of each run, shape (n, runs)."""
    return np.asarray((view.channel.run[:, None] == np.arange(len(view.runs))).astype(np.float64))


def own_rates(view: View) -> FloatArray | None:
    """Return the time in each run, shape (n, runs) [h]; None of few runs.

    None either where zeros count on from run to run: such lines would leap between them.
    """
    if not view.zeroed_by_run or len(view.runs) < FEWEST_RATES:
        return None
    return each_run(view) * view.time[:, None] / HOUR_S
