"""What a law leaves of a platform's errors: root mean squares before and after, reductions, the best factor.

Intervals are those of legs (`hexathermal.learn.validation_scores`): the jackknife over runs, of logarithms, with
Student's factor. What a few runs agree on by chance is not believed beyond what their rows can tell: intervals are at
least those of the jackknife over stretches of consecutive rows, which is all that one run has.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from hexathermal.learn.validation_scores import FEWEST_DEGREES, Figure, half_width, magnitude, reduction
from hexathermal.poses import FloatArray

QUANTITIES = ("x", "y", "z", "rx", "ry", "rz", "translation", "rotation")
STRETCH, FEWEST_STRETCHES = 10, 5
"""Consecutive rows that count as one; shorter runs are cut into so many stretches."""

LEAST = 1e-12
"""What a root mean square [m, rad] counts as at least when its logarithm is taken."""


@dataclass(frozen=True)
class PoseScore:
    """One quantity before and after correction, with 95 % intervals; m or rad.

    Attributes
    ----------
    before, after : Figure
        Root mean square.
    largest_before, largest_after : float
    reduction : Figure
        ``1 - after / before``; negative where the law makes it worse.
    """

    before: Figure
    after: Figure
    largest_before: float
    largest_after: float
    reduction: Figure


def pose_scores(before: list[FloatArray], after: list[FloatArray]) -> dict[str, PoseScore]:
    """Return the scores of runs by `QUANTITIES`.

    Parameters
    ----------
    before, after : list of array, shape (n, 6) [m, m, m, rad, rad, rad]
        Errors of each run without and with correction.
    """
    near, far = ([_distances(part) for part in errors] for errors in (before, after))
    tables = [np.column_stack([np.ones(len(b)), b**2, a**2]) for b, a in zip(near, far, strict=True)]
    count, scores = len(QUANTITIES), dict[str, PoseScore]()
    whole = np.array([table.sum(axis=0) for table in tables]).sum(axis=0)
    rms = np.sqrt(whole[1:] / whole[0])
    top, low = (np.max([part.max(axis=0) for part in one], axis=0) for one in (near, far))
    for k, name in enumerate(QUANTITIES):
        halves = [_half(tables, partial(_logarithm, k=1 + j)) for j in (k, k + count)]
        part = _half(tables, partial(_logarithm, k=1 + k + count, over=1 + k))
        scores[name] = PoseScore(
            magnitude(rms[k], halves[0]), magnitude(rms[k + count], halves[1]), float(top[k]), float(low[k]),
            reduction(rms[k + count] / rms[k], part) if rms[k] > 0.0 else Figure(0.0, 0.0, 0.0),
        )  # fmt: skip
    return scores


def best_factor(before: list[FloatArray], after: list[FloatArray]) -> Figure:
    """Return by what the predicted drift would have to be multiplied: ``sum p m / sum p p``, each less its run's mean.

    `p` and `m` are the translations predicted and measured. The interval has Student's factor of one less than the
    number of runs, 12.7 for two: what is said of a factor below or above 1 is wrong in 5 % of exact laws at most.
    """
    tables = []
    for b, a in zip(before, after, strict=True):
        predicted, measured = (b - a)[:, :3], b[:, :3]
        predicted, measured = predicted - predicted.mean(axis=0), measured - measured.mean(axis=0)
        tables.append(np.column_stack([(predicted * measured).sum(axis=1), (predicted**2).sum(axis=1)]))
    whole = np.array([table.sum(axis=0) for table in tables]).sum(axis=0)
    if not whole[1] > 0.0:
        return Figure(float("nan"), float("nan"), float("nan"))

    def factor(sums: FloatArray) -> float:
        """Return the factor of some runs or stretches."""
        top, bottom = sums.sum(axis=0)
        return float(top / bottom) if bottom > 0.0 else 1.0

    half, value = _half(tables, factor, fewest=1), float(whole[0] / whole[1])
    return Figure(value, value - half, value + half)


def _distances(errors: FloatArray) -> FloatArray:
    """Return the absolute errors by `QUANTITIES`, shape (n, 8)."""
    shift, turn = np.linalg.norm(errors[:, :3], axis=1), np.linalg.norm(errors[:, 3:], axis=1)
    return np.column_stack([np.abs(errors), shift, turn])


def _logarithm(sums: FloatArray, k: int, over: int = 0) -> float:
    """Return the logarithm of the root mean square of column k; less that of column `over`, where it is not 0."""
    whole = sums.sum(axis=0)
    rms = np.maximum(np.sqrt(whole[[k, over]] / whole[0]), LEAST)
    return float(np.log(rms[0]) - (np.log(rms[1]) if over else 0.0))


def _half(tables: list[FloatArray], measure: Callable[[FloatArray], float], fewest: int = FEWEST_DEGREES) -> float:
    """Return half the 95 % interval of a measure of sums: between runs, and at least that between stretches."""
    runs = np.array([table.sum(axis=0) for table in tables])
    stretches = np.concatenate([_stretches(table) for table in tables])
    between = half_width(runs, measure, fewest) if len(runs) > 1 else 0.0
    within = half_width(stretches, measure, 1) if len(stretches) > 1 else float("nan")
    return float(np.fmax(between, within)) if len(runs) > 1 else within


def _stretches(table: FloatArray) -> FloatArray:
    """Return sums over stretches of consecutive rows, shape (stretches, k)."""
    step = max(1, min(STRETCH, len(table) // FEWEST_STRETCHES))
    return np.asarray(np.add.reduceat(table, np.arange(0, len(table), step)))
