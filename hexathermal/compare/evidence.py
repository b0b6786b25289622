"""Parameters against measured channels: whitened residuals, their sensitivities, and the evidence of what differs.

About a point ``x0`` the measured channels less the simulated ones are ``r = A d + e`` with ``d = x - x0``; x holds the
logarithms of the factors, and for each thermocouple its contact error and its gain. With covariance of ``e`` and prior
``x ~ N(0, W)`` all integrals are Gaussian (Laplace's method, exact where the bench is linear):

    log p(r) = -1/2 ( |rho|^2 - c' (G + 1/W)^-1 c + log|G + 1/W| - log|1/W| + log|C| + n log 2 pi ),
    G = A'A,   rho = r - A m,   c = A' rho,   m = -x0                                  (all whitened by C)

A number of a bench as it should be has the small W of its tolerance; one that may differ has a large one. So the null
tolerates a small misfit, and the evidence of all candidates is over the same data.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, cholesky, solve_triangular

from hexathermal.compare.bench_runs import UM, BenchRuns, SimulatedRun
from hexathermal.compare.measured import MeasuredRun
from hexathermal.compare.noise import Noise
from hexathermal.compare.parameters import FREE, NAMES, TOLERANCES
from hexathermal.poses import FloatArray

STEP_OF_LOG = 0.02
"""Sensitivities are differences over so much of a factor's logarithm."""

CONTACT_SD, CONTACT_FREE = 0.012, 0.3
"""Standard deviation of a thermocouple's contact error about the usual one: taped as it should be, and not."""

GAIN_SD = 0.004
"""Of a thermocouple's gain (class 1)."""

FREE_ALL = 0.5
"""Of every factor's logarithm while the noise is sought."""


@dataclass(frozen=True, eq=False)
class Sensitivities:
    """Residuals of runs and what parameters do to them, before whitening.

    Attributes
    ----------
    logs : array, shape (p,)
        The point: logarithms of the factors, in the order of `parameters.NAMES`.
    simulated : tuple of SimulatedRun
    tables : tuple of array, shape (n, p + 2 s + 1)
        Columns of the parameters, contact errors, gains, and the residual, for each run.
    used : tuple of array of bool, shape (c w,)
        Which channels and windows have values.
    """

    logs: FloatArray
    simulated: tuple[SimulatedRun, ...]
    tables: tuple[FloatArray, ...]
    used: tuple[np.ndarray[tuple[int], np.dtype[np.bool_]], ...]


def measured_channels(run: MeasuredRun) -> FloatArray:
    """Return what a run's channels showed in its windows, shape (c, w); K, um, um/m, NaN where nothing."""
    windows = run.windows
    good = np.isfinite(run.rises)
    with np.errstate(divide="ignore", invalid="ignore"):
        part = windows.mean(good.astype(float))
        means = np.where(part >= 0.5, windows.mean(np.where(good, run.rises, 0.0)) / part, np.nan)
    slope = np.where(windows.spread > 0.0, windows.slope(run.drift), np.nan)
    return np.vstack([means.T, UM * windows.mean(run.drift), UM * slope])


def sensitivities(
    bench: BenchRuns, logs: FloatArray, before: Sensitivities | None = None, renewed: Sequence[int] | None = None
) -> Sensitivities:
    """Return residuals and sensitivities at a point.

    Parameters
    ----------
    bench : BenchRuns
    logs : array, shape (p,)
    before : Sensitivities, optional
        Its columns are kept for all parameters but those `renewed`: cheaper on the way to a point.
    renewed : sequence of int, optional
    """
    here = dict(zip(NAMES, logs.tolist(), strict=True))
    chosen = range(len(NAMES)) if before is None or renewed is None else renewed
    variants = [here, *({**here, NAMES[j]: here[NAMES[j]] + STEP_OF_LOG} for j in chosen)]
    simulated = bench.simulated(variants)
    tables, used = [], []
    for r, (run, made) in enumerate(zip(bench.runs, simulated, strict=True)):
        y = measured_channels(run)
        keep = np.isfinite(y).ravel()
        base = made.values[0]
        table = np.empty((keep.sum(), len(NAMES) + 2 * len(made.surfaces) + 1))
        if before is not None:
            table[:, : len(NAMES)] = before.tables[r][:, : len(NAMES)]
        for v, j in enumerate(chosen, start=1):
            table[:, j] = ((made.values[v] - base) / STEP_OF_LOG).ravel()[keep]
        for k, surface in enumerate(made.surfaces):
            both = np.zeros((2, *base.shape))
            both[0, k], both[1, k] = made.air - surface, surface
            table[:, [len(NAMES) + k, len(NAMES) + len(made.surfaces) + k]] = both.reshape(2, -1)[:, keep].T
        table[:, -1] = (y - base).ravel()[keep]
        tables.append(table)
        used.append(keep)
    return Sensitivities(np.array(logs, dtype=np.float64), simulated, tuple(tables), tuple(used))


@dataclass(frozen=True, eq=False)
class Normal:
    """Whitened sums of runs at a point: all that evidence and estimates need.

    Attributes
    ----------
    point : array, shape (k,)
        ``x0``: logarithms of the factors, then zeros for the thermocouples.
    grams : array, shape (runs, k + 1, k + 1)
        Of the columns and the residual.
    constants : array, shape (runs,)
        ``log|C| + n log 2 pi``.
    sensors : int
    """

    point: FloatArray
    grams: FloatArray
    constants: FloatArray
    sensors: int

    def precision(self, free: Sequence[int] = ()) -> FloatArray:
        """Return 1 / W of the prior, `free` the places of what may differ, shape (k,)."""
        p = len(NAMES)
        found = np.concatenate([TOLERANCES, np.full(self.sensors, CONTACT_SD),
                                np.full(self.sensors, GAIN_SD)])  # fmt: skip
        for j in free:
            found[j] = FREE if j < p else CONTACT_FREE
        return np.asarray(found**-2.0)

    def without(self, run: int) -> Normal:
        """Return the sums without a run."""
        kept = np.arange(len(self.grams)) != run
        return Normal(self.point, self.grams[kept], self.constants[kept], self.sensors)

    def evidence(self, precision: FloatArray) -> float:
        """Return ``log p(r)`` under a prior."""
        G, c, square = self._centred()
        factor = cho_factor(G + np.diag(precision), lower=True)
        determinant = 2.0 * np.log(np.diagonal(factor[0])).sum() - np.log(precision).sum()
        return -0.5 * float(square - c @ cho_solve(factor, c) + determinant + self.constants.sum())

    def estimate(self, precision: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return mean and covariance of x under a prior."""
        G, c, _square = self._centred()
        covariance = np.asarray(np.linalg.inv(G + np.diag(precision)), dtype=np.float64)
        return covariance @ c, covariance

    def misfit(self, x: FloatArray, run: int) -> float:
        """Return half the whitened square of a run's residual at x, every number free within its tolerance about it."""
        d, gram = x - self.point, self.grams[run]
        G, c = gram[:-1, :-1], gram[:-1, -1] - gram[:-1, :-1] @ d
        square = gram[-1, -1] - 2.0 * d @ gram[:-1, -1] + d @ G @ d
        return 0.5 * float(square - c @ np.linalg.solve(G + np.diag(self.precision()), c))

    def information(self, chosen: Sequence[int], precision: FloatArray) -> FloatArray:
        """Return what the data say of some parameters, the others only within their prior, shape (a, a)."""
        G, own = self.grams[:, :-1, :-1].sum(axis=0), list(chosen)
        others = [k for k in range(len(G)) if k not in own]
        rest = G[np.ix_(others, others)] + np.diag(precision[others])
        cross = G[np.ix_(others, own)]
        return np.asarray(G[np.ix_(own, own)] - cross.T @ np.linalg.solve(rest, cross))

    def _centred(self) -> tuple[FloatArray, FloatArray, float]:
        """Return ``G, c, |rho|^2`` about the prior's mean."""
        whole = self.grams.sum(axis=0)
        G, b, square = whole[:-1, :-1], whole[:-1, -1], whole[-1, -1]
        m = -self.point
        return G, b - G @ m, float(square - 2.0 * m @ b + m @ G @ m)


def normal(found: Sensitivities, runs: Sequence[MeasuredRun], noise: Noise) -> Normal:
    """Return the whitened sums of runs under a noise."""
    grams, constants = [], []
    for run, simulated, table, used in zip(runs, found.simulated, found.tables, found.used, strict=True):
        size = used.size
        C = noise.covariance(run, simulated).reshape(size, size)[np.ix_(used, used)]
        L = cholesky(C, lower=True)
        white = solve_triangular(L, table, lower=True)
        grams.append(white.T @ white)
        constants.append(2.0 * np.log(np.diagonal(L)).sum() + len(table) * np.log(2.0 * np.pi))
    sensors = found.simulated[0].surfaces.shape[0]
    point = np.concatenate([found.logs, np.zeros(2 * sensors)])
    return Normal(point, np.array(grams), np.array(constants), sensors)


def own_factors(found: Sensitivities, runs: Sequence[MeasuredRun], noise: Noise) -> FloatArray:
    """Return by how much each thermocouple's slow error is larger than the usual one, shape (s,).

    From its residual, all parameters free, held against what the noise foretells of it.
    """
    sums = normal(found, runs, noise)
    everything = range(len(NAMES) + sums.sensors)
    x, _covariance = sums.estimate(sums.precision(tuple(everything)))
    squares, expected = np.full(sums.sensors, 10.0), np.full(sums.sensors, 10.0)
    for run, simulated, table, used in zip(runs, found.simulated, found.tables, found.used, strict=True):
        rest = np.full(used.size, np.nan)
        rest[used] = table[:, -1] - table[:, :-1] @ (x - sums.point)
        C = noise.covariance(run, simulated)
        shape = C.shape[:2]
        for k in range(sums.sensors):
            own = rest.reshape(shape)[k]
            good = np.isfinite(own)
            # against what all others foretell, the usual share of the channel's own slow error
            block = C[k][:, k][np.ix_(good, good)]
            white = solve_triangular(cholesky(block, lower=True), own[good], lower=True)
            squares[k] += float(white @ white)
            expected[k] += max(good.sum() - 1.0, 0.0)
    return np.asarray(np.sqrt(np.maximum(squares / expected, 0.25)))


def named_logs(x: FloatArray) -> Mapping[str, float]:
    """Return the logarithms of factors by name from a vector x."""
    return dict(zip(NAMES, x[: len(NAMES)].tolist(), strict=True))
