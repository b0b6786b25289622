"""One law, fitted with care: noise of the residual, errors of the thermometers, intervals that hold, a robust twin."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hexathermal.errors import DataError
from hexathermal.learn.coverage import TWO_SIDED
from hexathermal.learn.noise import (
    NormalEquations,
    ResidualNoise,
    estimated_noise,
    normal_equations,
    sensor_part,
    slopes,
)
from hexathermal.learn.sensor_errors import SensorErrors
from hexathermal.learn.windows import Windows, WindowSet
from hexathermal.poses import FloatArray

LEAST_RELIABILITY = 0.6
"""Below, the correction for errors of the thermometers would rest on their model more than on the data: left out."""

DOUBT_OF_CORRECTION = 0.2
"""Standard uncertainty of that correction, as a part of it: the slow bias is an upper estimate."""

HUBER = 1.345
"""Residuals beyond so many standard deviations count less; 95 % efficient where they are normal (Huber 1981)."""


@dataclass(frozen=True, eq=False)
class LawFit:
    """A law fitted to windows.

    Attributes
    ----------
    sensors : tuple of int
    coefficients, covariance : array, shape (p,), (p, p)
        ``[A .. B ..]`` (or C), corrected for the errors of the thermometers.
    uncorrected : array, shape (p,)
        The same without that correction.
    least_squares : array, shape (p,)
        Ordinary least squares of the windows, weighted by their rows.
    robust : array, shape (p,)
        Huber's estimate of the windows; `least_squares` is its twin without robustness.
    by_run : array, shape (p, p)
        Covariance as the spread between runs shows it (cluster-robust, small-sample factor): a cross-check.
    reliability : float
        Part of the columns' weakest direction that is temperature, not error; 1 is perfect.
    corrected : bool
        Whether the correction was made.
    generalised : array, shape (p,)
        Generalised least squares, which weighs fast changes most. Where the law holds, it agrees within uncertainty;
        where a sensor lags or heat hides, it errs more than ordinary least squares, which is therefore the law.
    noise : ResidualNoise
    errors : SensorErrors
    factor : float
        Half-width of 95 % prediction intervals over their standard deviation, from runs left out.
    left_out : tuple of array [m]
        Residuals of each run's windows under the law fitted without the run; empty with one run.
    left_out_z : tuple of array
        The same over their predicted standard deviations.
    """

    sensors: tuple[int, ...]
    coefficients: FloatArray
    covariance: FloatArray
    uncorrected: FloatArray
    least_squares: FloatArray
    robust: FloatArray
    by_run: FloatArray
    reliability: float
    corrected: bool
    generalised: FloatArray
    noise: ResidualNoise
    errors: SensorErrors
    factor: float
    left_out: tuple[FloatArray, ...]
    left_out_z: tuple[FloatArray, ...]


def fit_law(windows: WindowSet, sensors: Sequence[int], errors: SensorErrors) -> LawFit:
    """Return the law of a set of sensors.

    Parameters
    ----------
    windows : WindowSet
    sensors : sequence of int
        Numbers of the sensors.
    errors : SensorErrors
        Of all sensors.

    Raises
    ------
    DataError
        There are fewer windows than needed, or their columns depend on each other.
    """
    columns, runs = windows.columns, windows.runs
    chosen = columns.of(np.array(sensors))
    X = [run.X[:, chosen] for run in runs]
    _enough(X, windows)
    own = errors.of(sensors)
    stacked, y = np.concatenate(X), np.concatenate([run.drift for run in runs])
    weights = np.sqrt(np.concatenate([run.rows for run in runs]))
    plain = np.linalg.lstsq(stacked * weights[:, None], y * weights, rcond=None)[0]
    noise, V = _noise(windows, X, own, plain)
    found = _estimate(windows, X, V, [np.diag(run.rows) for run in runs], own)
    generalised = _estimate(windows, X, V, [_inverse(v) for v in V], own).b
    b, covariance, by_run = found.b, found.covariance, found.by_run
    covariance = _balanced(covariance, by_run, len(runs))
    robust = _robust(X, runs, V, b)
    M = columns.law_matrix(len(b))
    return LawFit(
        tuple(sensors), M @ b, M @ covariance @ M.T, M @ found.uncorrected, M @ plain, M @ robust, M @ by_run @ M.T,
        found.reliability, found.corrected, M @ generalised, noise, own, prediction_factor(found.z),
        found.left_out, found.z,
    )  # fmt: skip


def _inverse(V: FloatArray) -> FloatArray:
    """Return the inverse of a covariance, symmetric to the last bit."""
    W = np.linalg.inv(V)
    return np.asarray(0.5 * (W + W.T))


def _noise(
    windows: WindowSet, X: Sequence[FloatArray], own: SensorErrors, start: FloatArray
) -> tuple[ResidualNoise, list[FloatArray]]:
    """Return the residual's noise, and its covariance in each run; the thermometers' part needs a law: twice round."""
    columns, runs = windows.columns, windows.runs

    def fitted(b: FloatArray, near: ResidualNoise | None) -> tuple[ResidualNoise, list[FloatArray]]:
        fixed = [sensor_part(run, own, slopes(b, run, columns.centre, columns.stroke)) for run in runs]
        noise = estimated_noise(runs, X, fixed, windows.drift_noise, near)
        return noise, [known + noise.covariance(run) for known, run in zip(fixed, runs, strict=True)]

    first, V = fitted(start, None)
    return fitted(_estimate(windows, X, V, [_inverse(v) for v in V], own).uncorrected, first)


@dataclass(frozen=True, eq=False)
class _Estimate:
    """The coefficients of the columns as one way of weighting gives them."""

    b: FloatArray
    uncorrected: FloatArray
    covariance: FloatArray
    by_run: FloatArray
    reliability: float
    corrected: bool
    left_out: tuple[FloatArray, ...]
    z: tuple[FloatArray, ...]


def _estimate(
    windows: WindowSet, X: Sequence[FloatArray], V: Sequence[FloatArray], W: Sequence[FloatArray], own: SensorErrors
) -> _Estimate:
    """Return the estimate with weights W."""
    columns, runs = windows.columns, windows.runs
    parts = [
        normal_equations(run, x, v, w, own, columns.centre, columns.stroke)
        for run, x, v, w in zip(runs, X, V, W, strict=True)
    ]
    uncorrected = _solution(parts, False)
    reliability = _reliability(parts)
    corrected = reliability >= LEAST_RELIABILITY
    b = _solution(parts, corrected)
    left_out, z = _left_out(parts, X, runs, V, corrected)
    return _Estimate(
        b, uncorrected, _covariance(parts, corrected, b - uncorrected), _by_run(parts, corrected, b),
        reliability, corrected, left_out, z,
    )  # fmt: skip


def _enough(X: Sequence[FloatArray], windows: WindowSet) -> None:
    """Refuse what cannot be fitted."""
    stacked = np.concatenate(X)
    p = stacked.shape[1]
    if len(stacked) < p + 3:
        raise DataError(
            f"{len(stacked)} windows of rest cannot determine {p} coefficients and their uncertainty; "
            f"at least {p + 3} are needed: record longer, or choose fewer sensors"
        )
    size = np.sqrt((stacked**2).sum(axis=0))
    if not size.all():
        which = " and ".join(str(k + 1) for k in np.flatnonzero(size == 0.0))
        raise DataError(
            f"column {which} of the law's {p} is zero in every window of rest: the temperature of that sensor never "
            "leaves its zero, or q does not; its coefficient cannot be told"
        )
    sizes = np.linalg.svd(stacked / size, compute_uv=False)
    if sizes[-1] < 1e-9 * sizes[0]:
        raise DataError(
            "the chosen sensors' columns depend on each other: their coefficients cannot be told apart; choose fewer "
            "sensors, or record a campaign in which q and the temperatures change independently"
        )
    for k, own in enumerate(X):
        others = [item for other, item in enumerate(X) if other != k]
        if others and np.linalg.matrix_rank(np.concatenate(others) / size, tol=1e-9 * float(sizes[0])) < p:
            raise DataError(
                f"one run alone, of {len(own)} windows of rest, tells the law's {p} coefficients: in all others the "
                "temperatures hardly leave their zero, or q does not, so that nothing can be judged on runs left out; "
                "record longer runs with moves, or choose fewer sensors"
            )


def _solution(parts: Sequence[NormalEquations], corrected: bool) -> FloatArray:
    """Return the coefficients of the columns."""
    S, D = sum(part.S for part in parts), sum(part.D for part in parts)
    z = sum(part.z for part in parts)
    return np.asarray(np.linalg.solve(S - D if corrected else S, z))


def _reliability(parts: Sequence[NormalEquations]) -> float:
    """Return the smallest part of any direction of the columns that is temperature, not error."""
    S, D = np.asarray(sum(part.S for part in parts)), np.asarray(sum(part.D for part in parts))
    size = np.sqrt(np.diagonal(S))
    L = np.linalg.cholesky(S / np.outer(size, size))
    inside = np.linalg.solve(L, np.linalg.solve(L, D / np.outer(size, size)).T)
    return float(1.0 - np.linalg.eigvalsh(0.5 * (inside + inside.T))[-1])


def _covariance(parts: Sequence[NormalEquations], corrected: bool, shift: FloatArray) -> FloatArray:
    """Return the coefficients' covariance, with the doubt of the correction."""
    S, D = np.asarray(sum(part.S for part in parts)), np.asarray(sum(part.D for part in parts))
    inverse = np.linalg.inv(S - D if corrected else S)
    value = inverse @ np.asarray(sum(part.K for part in parts)) @ inverse.T
    doubt = DOUBT_OF_CORRECTION * shift if corrected else np.linalg.solve(S, D) @ np.linalg.solve(S, S @ shift)
    return np.asarray(0.5 * (value + value.T) + np.outer(doubt, doubt))


def _by_run(parts: Sequence[NormalEquations], corrected: bool, b: FloatArray) -> FloatArray:
    """Return the covariance from the spread of the runs' scores; NaN with one run."""
    R, p = len(parts), len(b)
    if R < 2:
        return np.full((p, p), np.nan)
    inner = [part.S - part.D if corrected else part.S for part in parts]
    inverse = np.linalg.inv(sum(inner))
    scores = [part.z - s @ b for part, s in zip(parts, inner, strict=True)]
    # without its own pull on the answer: each run's score over the part of the others (jackknife)
    moved = [np.linalg.lstsq(np.eye(p) - s @ inverse, u, rcond=None)[0] for s, u in zip(inner, scores, strict=True)]
    meat = sum((np.outer(u, u) for u in moved), np.zeros((p, p))) * (R - 1) / R
    return np.asarray(inverse @ meat @ inverse.T)


def _balanced(model: FloatArray, by_run: FloatArray, runs: int) -> FloatArray:
    """Return the covariance that weighs the noise model as much as the spread of the runs.

    Each variance is the mean of both, with ``nu = 2 (R - 1)`` degrees of freedom; the covariance is that of Student's
    distribution, ``nu / (nu - 2)`` times as large (GUM supplement 1, 6.4.9), so that +-1.96 standard uncertainties
    hold 95 %. With fewer than three runs the noise model stands alone.
    """
    nu = 2.0 * (runs - 1)
    if nu <= 2.0:
        return model
    ratio = np.diagonal(by_run) / np.diagonal(model)
    scale = np.sqrt(0.5 * (1.0 + ratio) * nu / (nu - 2.0))
    return np.asarray(model * np.outer(scale, scale))


def _robust(X: Sequence[FloatArray], runs: Sequence[Windows], V: Sequence[FloatArray], b: FloatArray) -> FloatArray:
    """Return Huber's estimate of the windows, each weighed by its own standard deviation.

    Windows are not whitened: that would spread an outlier over its neighbours. The scale is the residuals' median.
    """
    from scipy.optimize import least_squares as minimum

    spread = np.sqrt(np.concatenate([np.diagonal(v) for v in V]))[:, None]
    stacked = np.concatenate([np.column_stack([x, run.drift]) for x, run in zip(X, runs, strict=True)]) / spread
    size = np.sqrt((stacked[:, :-1] ** 2).sum(axis=0))
    A, y, c = stacked[:, :-1] / size, stacked[:, -1], b * size
    for _round in range(3):
        scale = max(1.4826 * float(np.median(np.abs(A @ c - y))), 1e-9)
        c = minimum(lambda c: A @ c - y, c, jac=lambda _c: A, loss="huber", f_scale=HUBER * scale).x
    return np.asarray(c / size)


def _left_out(
    parts: Sequence[NormalEquations],
    X: Sequence[FloatArray],
    runs: Sequence[Windows],
    V: Sequence[FloatArray],
    corrected: bool,
) -> tuple[tuple[FloatArray, ...], tuple[FloatArray, ...]]:
    """Return each run's residuals under the law fitted without it, and the same over their standard deviations."""
    if len(parts) < 2:
        return (), ()
    residuals, z = [], []
    for r, (x, run, v) in enumerate(zip(X, runs, V, strict=True)):
        others = [part for k, part in enumerate(parts) if k != r]
        b = _solution(others, corrected)
        e = run.drift - x @ b
        own = np.einsum("np,pq,nq->n", x, _covariance(others, corrected, np.zeros_like(b)), x)
        residuals.append(e)
        z.append(e / np.sqrt(np.diagonal(v) + own))
    return tuple(residuals), tuple(z)


def prediction_factor(z: Sequence[npt.NDArray[np.float64]]) -> float:
    """Return half of a 95 % interval over the standard deviation, from standardised residuals of runs left out.

    The normal law's 1.96 is scaled by the root of the mean square of what the runs left out show, where they show more
    or less scatter than their predicted standard deviations, drawn towards 1 as if two more runs agreed; the variances
    being estimates of ``3 R`` degrees of freedom widens it as Student's distribution does.
    """
    if not z:
        return TWO_SIDED
    runs = np.array([float(np.mean(one**2)) for one in z])
    nu = 3.0 * len(runs)
    return float(TWO_SIDED * np.sqrt((runs.sum() + 2.0) / (len(runs) + 2.0) * nu / (nu - 2.0)))
