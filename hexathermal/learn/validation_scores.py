"""What a law leaves of the drift, with 95 % intervals from drawing runs and, within each, landings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hexathermal.poses import FloatArray

DRAWS = 2000
DRAWN_COUNTS = 1_000_000
"""Counts of landings that are drawn at a time."""

SUMS, LARGEST = (0, 1, 2, 4, 5), (3, 6)
"""Columns of a table of landings: n, e^2, |e|, y^2, |y|, and the largest |e| and |y|; e residual, y drift."""


@dataclass(frozen=True)
class Figure:
    """A number with its 95 % interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Scores:
    """What a law leaves of the drift, with 95 % intervals.

    Attributes
    ----------
    rmse, linf, mean : Figure [m]
        Root mean square, largest and mean absolute residual.
    drift_rms, drift_largest, drift_mean : float [m]
    mean_reduction, largest_reduction, rms_reduction : Figure
        ``1 - residual / drift``; negative where the law makes it worse.
    """

    rmse: Figure
    linf: Figure
    mean: Figure
    drift_rms: float
    drift_largest: float
    drift_mean: float
    mean_reduction: Figure
    largest_reduction: Figure
    rms_reduction: Figure


def scores(tables: list[FloatArray], rng: np.random.Generator) -> Scores:
    """Return the scores of runs.

    Parameters
    ----------
    tables : list of array, shape (landings, 7 or more)
        One a run; columns as in `SUMS` and `LARGEST`.
    rng : numpy.random.Generator
    """
    now = _measures(
        np.array([table[:, SUMS].sum(axis=0) for table in tables]).sum(axis=0),
        np.array([table[:, LARGEST].max(axis=0) for table in tables]).max(axis=0),
    )
    m = _drawn(tables, rng)

    def figure(value: float, draws: FloatArray) -> Figure:
        low, high = np.quantile(draws, [0.025, 0.975])
        return Figure(float(value), float(min(low, value)), float(max(high, value)))

    def reduction(k: int) -> Figure:
        with np.errstate(divide="ignore", invalid="ignore"):
            value = 1.0 - now[k] / now[k + 3] if now[k + 3] > 0.0 else 0.0
            draws = np.where(m[k + 3] > 0.0, 1.0 - m[k] / m[k + 3], 0.0)
        return figure(value, draws)

    return Scores(
        figure(now[0], m[0]), figure(now[1], m[1]), figure(now[2], m[2]), float(now[3]), float(now[4]), float(now[5]),
        reduction(2), reduction(1), reduction(0),
    )  # fmt: skip


def _drawn(tables: list[FloatArray], rng: np.random.Generator) -> FloatArray:
    """Return the measures of draws: runs are drawn, and within a run that is drawn twice its landings twice."""
    runs = rng.multinomial(len(tables), np.full(len(tables), 1.0 / len(tables)), size=DRAWS)
    sums, tops = np.zeros((DRAWS, len(SUMS))), np.zeros((DRAWS, len(LARGEST)))
    for r, table in enumerate(tables):
        n = len(table)
        step = max(DRAWN_COUNTS // n, 1)
        for i in range(0, DRAWS, step):
            part = slice(i, i + step)
            counts = rng.multinomial(runs[part, r] * n, np.full(n, 1.0 / n))
            sums[part] += counts @ table[:, SUMS]
            for j, column in enumerate(LARGEST):
                tops[part, j] = np.maximum(tops[part, j], np.where(counts > 0, table[:, column], 0.0).max(axis=1))
    return _measures(sums.T, tops.T)


def _measures(sums: FloatArray, tops: FloatArray) -> FloatArray:
    """Return RMSE, largest and mean |e|, then RMS, largest and mean of the drift."""
    n = sums[0]
    return np.stack([np.sqrt(sums[1] / n), tops[0], sums[2] / n, np.sqrt(sums[3] / n), tops[1], sums[4] / n])
