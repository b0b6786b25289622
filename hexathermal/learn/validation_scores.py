"""What a law leaves of the drift, with 95 % intervals.

Runs are the independent units. With two or more, the logarithms of RMSE, of the mean residual and of the ratios
residual to drift are jackknifed over runs, with Student's factor: drawing three runs with replacement, as a bootstrap
does, gives intervals that hold the truth in some three of four cases only. With one run, and for the largest residual,
landings are drawn: such an interval speaks of the run at hand, and says nothing about other runs. Of one landing alone,
of less than an hour, there is no interval: its ends are infinite.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hexathermal.poses import FloatArray

FEWEST_DEGREES = 2
"""Degrees of freedom that Student's factor is given at least: with two runs there is one, and its factor is 12.7."""

LEAST_M = 1e-12
"""What a measure counts as at least when its logarithm is taken [m]."""

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
    own = np.array([table[:, SUMS].sum(axis=0) for table in tables])

    alone = all(len(table) == 1 for table in tables)  # drawn again they are the same

    def drawn(value: float, draws: FloatArray) -> Figure:
        if alone:
            return Figure(float(value), -math.inf, math.inf)
        low, high = np.quantile(draws, [0.025, 0.975])
        return Figure(float(value), float(min(low, value)), float(max(high, value)))

    def size(k: int) -> Figure:
        if len(tables) < 2:
            return drawn(now[k], m[k])
        return magnitude(now[k], half_width(own, lambda part: _logarithm(part, k)))

    def reduced(k: int) -> Figure:
        value = 1.0 - now[k] / now[k + 3] if now[k + 3] > 0.0 else 0.0
        if len(tables) > 1 and k != 1 and now[k + 3] > 0.0:
            half = half_width(own, lambda part: _logarithm(part, k) - _logarithm(part, k + 3))
            return reduction(now[k] / now[k + 3], half)
        with np.errstate(divide="ignore", invalid="ignore"):
            return drawn(value, np.where(m[k + 3] > 0.0, 1.0 - m[k] / m[k + 3], 0.0))

    return Scores(
        size(0), drawn(now[1], m[1]), size(2), float(now[3]), float(now[4]), float(now[5]),
        reduced(2), reduced(1), reduced(0),
    )  # fmt: skip


def magnitude(value: float, half: float) -> Figure:
    """Return a positive number whose logarithm has the half-width `half`."""
    spread = float(np.exp(half))
    return Figure(float(value), float(value) / spread, float(value) * spread)


def reduction(ratio: float, half: float) -> Figure:
    """Return ``1 - ratio`` of a ratio whose logarithm has the half-width `half`."""
    spread = float(np.exp(half))
    return Figure(1.0 - float(ratio), 1.0 - float(ratio) * spread, 1.0 - float(ratio) / spread)


def _logarithm(sums: FloatArray, k: int) -> float:
    """Return the logarithm of a measure (see `_measures`) of all runs together, `sums` (runs, 5)."""
    measures = _measures(sums.sum(axis=0), np.zeros(len(LARGEST)))
    return float(np.log(max(measures[k], LEAST_M)))


def half_width(sums: FloatArray, measure: Callable[[FloatArray], float], fewest: int = FEWEST_DEGREES) -> float:
    """Return half the 95 % interval of a measure from the jackknife.

    Parameters
    ----------
    sums : array, shape (R, k)
        Of two or more units (runs, or stretches of rows) that are independent of each other.
    measure : callable
        Of the sums of some of them, shape (m, k).
    fewest : int
        Degrees of freedom that Student's factor is given at least.

    Examples
    --------
    Of a mean it is Student's interval: 4.30 times the standard error of three numbers.

    >>> round(half_width(np.array([[1.0], [2.0], [3.0]]), lambda part: float(part.mean())) * 3**0.5, 2)
    4.3
    """
    from scipy.special import stdtrit

    R = len(sums)
    without = np.array([measure(np.delete(sums, r, axis=0)) for r in range(R)])
    spread = np.sqrt((R - 1) / R * ((without - without.mean()) ** 2).sum())
    return float(stdtrit(max(R - 1, fewest), 0.975) * spread)


def _drawn(tables: list[FloatArray], rng: np.random.Generator) -> FloatArray:
    """Return the measures of draws: runs are drawn, and within a run that is drawn twice its landings twice."""
    runs = rng.multinomial(len(tables), np.full(len(tables), 1.0 / len(tables)), size=DRAWS)
    sums, tops = np.zeros((DRAWS, len(SUMS))), np.zeros((DRAWS, len(LARGEST)))
    for r, table in enumerate(tables):
        n = len(table)
        step = max(DRAWN_COUNTS // n, 1)
        for i in range(0, DRAWS, step):
            part = slice(i, i + step)
            counts = _counts(runs[part, r] * n, n, rng)
            sums[part] += counts @ table[:, SUMS]
            drawn = counts > 0
            for j, column in enumerate(LARGEST):
                tops[part, j] = np.maximum(tops[part, j], (drawn * table[:, column]).max(axis=1))
    return _measures(sums.T, tops.T)


def _counts(sizes: npt.NDArray[np.int64], n: int, rng: np.random.Generator) -> npt.NDArray[np.int64]:
    """Return how often each of n landings is in draws of so many, shape (draws, n)."""
    place = np.repeat(np.arange(len(sizes)) * n, sizes) + rng.integers(n, size=int(sizes.sum()))
    return np.bincount(place, minlength=len(sizes) * n).reshape(len(sizes), n)


def _measures(sums: FloatArray, tops: FloatArray) -> FloatArray:
    """Return RMSE, largest and mean |e|, then RMS, largest and mean of the drift."""
    n = sums[0]
    return np.stack([np.sqrt(sums[1] / n), tops[0], sums[2] / n, np.sqrt(sums[3] / n), tops[1], sums[4] / n])
