"""Every set of sensors: fitted, judged on runs left out, ranked; the Pareto front; the choice between one and two.

All fits come from the Gram matrices of `hexathermal.learn.gram`. A set's error on a run left out is that of the law
fitted to all other runs. The largest and the mean absolute residual need the rows again: `Criteria` are gathered in a
second pass, for all sets at once by matrix products.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import numpy.typing as npt

from hexathermal.errors import DataError
from hexathermal.learn.campaign import Block
from hexathermal.learn.gram import Columns, Grams
from hexathermal.poses import FloatArray

LARGEST_GRAM_CONDITION = 1e7
"""Largest condition number of a set's scaled columns; above, its products no longer hold its coefficients."""

RESIDUAL_CHUNK = 2_000_000
"""Residuals that are held at a time in the second pass."""


@dataclass(frozen=True, eq=False)
class SetFits:
    """Least squares of all sets of one size.

    Attributes
    ----------
    sets : array, shape (K, k), int
        Numbers of the sensors.
    coefficients : array, shape (R + 1, K, p)
        Of the columns: fitted to all runs, then with each run left out; NaN where they cannot be told apart.
    condition : array, shape (K,)
        Condition number of the scaled columns, all runs.
    vif : array, shape (K,)
        Largest variance inflation factor.
    rmse : array, shape (K,) [m]
        Of the rows fitted.
    left_out : array, shape (R, K) [m^2]
        Mean square error on each run, fitted without it.
    """

    sets: npt.NDArray[np.int64]
    coefficients: FloatArray
    condition: FloatArray
    vif: FloatArray
    rmse: FloatArray
    left_out: FloatArray


def sets_of(sensors: Sequence[int], size: int) -> npt.NDArray[np.int64]:
    """Return all sets of `size` sensors, shape (K, size)."""
    return np.array(list(combinations(sensors, size)), dtype=np.int64).reshape(-1, size)


def fit_sets(grams: Grams, sets: npt.NDArray[np.int64]) -> SetFits:
    """Return the least-squares fits of sets of sensors, on all runs and with each run left out.

    Parameters
    ----------
    grams : Grams
    sets : array, shape (K, k), int

    Returns
    -------
    SetFits
        A set whose columns depend on each other (condition above `LARGEST_GRAM_CONDITION`) has NaN everywhere.
    """
    columns = grams.columns.of(sets)
    G = grams.matrices
    training = np.concatenate([G.sum(axis=0)[None], _all_but_one(G)])
    coefficients, condition, inverse = _solved(training, columns)
    full = training[0]
    square = _square(full, columns, coefficients[0])
    rows = grams.rows
    left_out = np.stack(
        [_square(G[r], columns, coefficients[r + 1]) / rows[r] for r in range(len(G))]
        if len(G) > 1
        else [np.full(len(sets), np.nan)]
    )
    vif = np.where(np.isfinite(condition), inverse.max(axis=-1), np.inf)
    rmse = np.sqrt(square / rows.sum())
    return SetFits(sets, coefficients, condition, vif, rmse, left_out)


def _all_but_one(G: FloatArray) -> FloatArray:
    """Return sums over all runs but one, without subtracting."""
    zero = np.zeros((1, *G.shape[1:]))
    before = np.concatenate([zero, np.cumsum(G[:-1], axis=0)])
    after = np.concatenate([np.cumsum(G[:0:-1], axis=0)[::-1], zero])
    return np.asarray(before + after)


def _solved(G: FloatArray, columns: npt.NDArray[np.int64]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return coefficients (T, K, p), condition (K,) and inflation factors (K, p) of the first."""
    inner = G[:, columns[:, :, None], columns[:, None, :]]
    right = G[:, columns, -1]
    size = np.sqrt(np.diagonal(inner, axis1=-2, axis2=-1))
    alive = (size > 0.0).all(axis=-1)
    size = np.where(size > 0.0, size, 1.0)
    scaled = inner / (size[..., :, None] * size[..., None, :])
    eigen = np.linalg.eigvalsh(scaled)
    with np.errstate(divide="ignore", invalid="ignore"):
        condition = np.sqrt(np.where(eigen[..., 0] > 0.0, eigen[..., -1] / eigen[..., 0], np.inf))
    alive &= condition <= LARGEST_GRAM_CONDITION
    scaled[~alive] = np.eye(columns.shape[1])
    solution = np.linalg.solve(scaled, (right / size)[..., None])[..., 0] / size
    solution[~alive] = np.nan
    inverse = np.diagonal(np.linalg.inv(scaled[0]), axis1=-2, axis2=-1)
    return solution, np.where(alive[0], condition[0], np.inf), inverse


def _square(G: FloatArray, columns: npt.NDArray[np.int64], b: FloatArray) -> FloatArray:
    """Return the sums of squared residuals of sets; rounding below zero counts as zero."""
    inner = G[columns[:, :, None], columns[:, None, :]]
    cross = G[columns, -1]
    value = G[-1, -1] - 2.0 * (b * cross).sum(axis=-1) + np.einsum("kp,kpq,kq->k", b, inner, b)
    return np.asarray(np.where(np.isnan(value), np.nan, np.maximum(value, 0.0)))


@dataclass(frozen=True, eq=False)
class Criteria:
    """What the rows say about the sets of one size; each array has shape (K,).

    `fit` are residuals of the law fitted to all runs, `left_out` those of each run under the law fitted without it.

    Attributes
    ----------
    rmse, linf, mean : array [m]
        Root mean square, largest and mean absolute residual.
    drift_rms, drift_largest, drift_mean : float [m]
        The same of the measured drift: a reduction is ``1 - residual / drift``.
    """

    rmse: FloatArray
    linf: FloatArray
    mean: FloatArray
    drift_rms: float
    drift_largest: float
    drift_mean: float

    @property
    def largest_reduction(self) -> FloatArray:
        """Part by which the largest drift shrinks."""
        return np.asarray(1.0 - self.linf / self.drift_largest) if self.drift_largest else np.zeros_like(self.linf)

    @property
    def mean_reduction(self) -> FloatArray:
        """Part by which the mean absolute drift shrinks."""
        return np.asarray(1.0 - self.mean / self.drift_mean) if self.drift_mean else np.zeros_like(self.mean)


@dataclass(frozen=True, eq=False)
class RankedSets:
    """Sets of sensors of all sizes, with what was found for each.

    Attributes
    ----------
    names : tuple of tuple of str
    sizes : array, shape (K,), int
    condition, vif : array, shape (K,)
    fit, left_out : Criteria
        On the rows fitted, and on runs left out.
    left_out_runs : array, shape (R, K) [m^2]
        Mean square error on each run left out.
    """

    names: tuple[tuple[str, ...], ...]
    sizes: npt.NDArray[np.int64]
    condition: FloatArray
    vif: FloatArray
    fit: Criteria
    left_out: Criteria
    left_out_runs: FloatArray

    def best(self, size: int, by: str = "rmse", left_out: bool = True) -> int:
        """Return the number of the best set of a size."""
        values = getattr(self.left_out if left_out else self.fit, by)
        return int(np.nanargmin(np.where(self.sizes == size, values, np.inf)))

    def front(self, left_out: bool = False, most: int = 2) -> tuple[int, ...]:
        """Return the Pareto front of RMSE and largest residual, among sets of at most `most` sensors."""
        criteria = self.left_out if left_out else self.fit
        allowed = np.flatnonzero((self.sizes <= most) & np.isfinite(criteria.rmse))
        front = pareto_front(np.column_stack([criteria.linf[allowed], criteria.rmse[allowed]]))
        return tuple(int(k) for k in allowed[list(front)])

    def off_front(self, chosen: int, left_out: bool = False, most: int = 2) -> tuple[float, float]:
        """Return how far a set lies from the front's smallest RMSE and smallest largest residual [m]."""
        criteria = self.left_out if left_out else self.fit
        front = list(self.front(left_out, most))
        return (
            float(criteria.rmse[chosen] - criteria.rmse[front].min()),
            float(criteria.linf[chosen] - criteria.linf[front].min()),
        )


def pareto_front(points: npt.ArrayLike) -> tuple[int, ...]:
    """Return the points that no other point beats in both coordinates (smaller is better), by the first coordinate.

    Examples
    --------
    >>> pareto_front([[1.0, 3.0], [2.0, 2.0], [2.5, 2.5], [3.0, 1.0]])
    (0, 1, 3)
    """
    values = np.asarray(points, dtype=np.float64)
    best = np.inf
    front: list[int] = []
    for k in np.lexsort((values[:, 1], values[:, 0])):
        if values[k, 1] < best:
            best = values[k, 1]
            front.append(int(k))
    return tuple(front)


def rank_sets(
    rows: Iterable[Block],
    grams: Grams,
    sizes: Sequence[int] = (1, 2),
    progress: Callable[[int], None] | None = None,
) -> RankedSets:
    """Return all sets of the given sizes with their criteria: the second pass over the rows.

    Parameters
    ----------
    rows : iterable of Block
        The rows that `grams` were gathered from.
    grams : Grams
    sizes : sequence of int
        How many sensors a set has.
    progress : function, optional
        Called with the number of rows done.

    Raises
    ------
    DataError
        No set's coefficients can be told apart.
    """
    kept = grams.kept
    fits = [fit_sets(grams, sets_of(kept, size)) for size in sizes if size <= len(kept)]
    total = _Residuals(grams, fits)
    done = 0
    for block in rows:
        total.add(block)
        done += len(block)
        if progress is not None:
            progress(done)
    names = tuple(tuple(grams.columns.sensors[k] for k in row) for one in fits for row in one.sets)
    fit, left_out = total.criteria()
    if not np.isfinite(fit.rmse).any():
        raise DataError("no sensor's coefficients can be told apart: do the temperatures or q change at all?")
    return RankedSets(
        names,
        np.concatenate([np.full(len(one.sets), one.sets.shape[1]) for one in fits]),
        np.concatenate([one.condition for one in fits]),
        np.concatenate([one.vif for one in fits]),
        fit,
        left_out,
        np.concatenate([one.left_out for one in fits], axis=1),
    )


class _Residuals:
    """Sums over the residuals of all sets, fitted and left out."""

    def __init__(self, grams: Grams, fits: Sequence[SetFits]) -> None:
        self.columns: Columns = grams.columns
        self.kept = grams.kept_mask
        self.runs = {name: k for k, name in enumerate(grams.runs)}
        count = sum(len(one.sets) for one in fits)
        runs = len(grams.runs)
        # coefficients of all columns, zero where a set has none: (R + 1, columns, K)
        self.laws = np.zeros((runs + 1, self.columns.count, count))
        start = 0
        for one in fits:
            K = len(one.sets)
            which = self.columns.of(one.sets)
            for t in range(runs + 1):
                self.laws[t, which, start + np.arange(K)[:, None]] = one.coefficients[t]
            start += K
        self.bad: npt.NDArray[np.bool_] = np.asarray(np.isnan(self.laws).any(axis=1))
        self.laws = np.nan_to_num(self.laws)
        self.square, self.largest, self.absolute = (np.zeros((2, count)) for _ in range(3))
        self.drift = np.zeros(3)
        self.rows = 0

    def add(self, block: Block) -> None:
        """Add the rows of a block."""
        r = self.runs[block.run.name]
        K = self.laws.shape[2]
        step = max(RESIDUAL_CHUNK // max(K, 1), 1)
        B = np.concatenate([self.laws[0], self.laws[r + 1]], axis=1)
        for i in range(0, len(block), step):
            X, y = complete_rows(block, slice(i, i + step), self.columns, self.kept)
            if not len(y):
                continue
            e = y[:, None] - X @ B
            self.square += np.einsum("nk,nk->k", e, e).reshape(2, K)
            np.abs(e, out=e)
            self.largest = np.maximum(self.largest, e.max(axis=0).reshape(2, K))
            self.absolute += e.sum(axis=0).reshape(2, K)
            size = np.abs(y)
            self.drift += [float(y @ y), 0.0, float(size.sum())]
            self.drift[1] = max(self.drift[1], float(size.max()))
            self.rows += len(y)

    def criteria(self) -> tuple[Criteria, Criteria]:
        """Return the criteria of the fit, and of the runs left out."""
        n = max(self.rows, 1)
        alone = len(self.runs) < 2
        bad = [self.bad[0], np.logical_or(self.bad[1:].any(axis=0), alone)]
        drift = (float(np.sqrt(self.drift[0] / n)), float(self.drift[1]), float(self.drift[2] / n))

        def one(k: int) -> Criteria:
            rmse, linf, mean = (
                np.where(bad[k], np.nan, values)
                for values in (np.sqrt(self.square[k] / n), self.largest[k], self.absolute[k] / n)
            )
            return Criteria(rmse, linf, mean, *drift)

        return one(0), one(1)


def complete_rows(
    block: Block, part: slice, columns: Columns, kept: npt.NDArray[np.bool_]
) -> tuple[FloatArray, FloatArray]:
    """Return columns and drift of those rows in which all compared sensors have a value."""
    dT, y = block.dT[part], block.drift[part]
    q = None if block.q is None else block.q[part]
    if not kept.all():
        dT = np.where(kept, dT, 0.0)
    X = columns.made(dT, q)
    good = np.isfinite(y) & np.isfinite(X).all(axis=1)
    return (X, y) if good.all() else (X[good], y[good])
