"""The residual of a law: noise of rows, scatter of landings, a slow process, an offset of each run.

``drift = x b + offset_r + slow(t) + landing_l + row``, and the errors of the thermometers, ``(A q0 + B q) u_s(t)``,
which are known from elsewhere. Standard deviations and the slow process's correlation time maximise the restricted
likelihood; runs are independent. Generalised least squares with that covariance gives the coefficients.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hexathermal.learn.sensor_errors import SensorErrors
from hexathermal.learn.windows import Windows
from hexathermal.poses import FloatArray

SHORTEST_TIME_S, LONGEST_TIME_S = 300.0, 6 * 3600.0
"""Bounds of the correlation time."""

USUAL_TIME_S = 3000.0
"""Correlation time where the search starts, and about which it is held loosely: benches settle in some 50 min."""


@dataclass(frozen=True)
class ResidualNoise:
    """Standard deviations of what a law leaves [m], and the slow process's correlation time [s]."""

    row: float
    landing: float
    slow: float
    slow_time: float
    offset: float

    def covariance(self, run: Windows) -> FloatArray:
        """Return the covariance of a run's windows, shape (w, w) [m^2]."""
        lag = np.abs(run.time[:, None] - run.time[None, :])
        V = self.offset**2 + self.slow**2 * np.exp(-lag / self.slow_time)
        V[np.diag_indices_from(V)] += self.row**2 / run.rows + self.landing**2 / run.landings
        return V

    @property
    def variance(self) -> float:
        """Variance of a single row of a new run."""
        return self.row**2 + self.landing**2 + self.slow**2 + self.offset**2


@dataclass(frozen=True, eq=False)
class NormalEquations:
    """One run's part of weighted least squares with weights W, where the residual's covariance is V.

    ``S = X' W X``, ``z = X' W y``, ``K = X' W V W X``, and ``D``, what the thermometers' errors add to S on average.
    """

    S: FloatArray
    z: FloatArray
    K: FloatArray
    D: FloatArray


def slopes(b: FloatArray, run: Windows, centre: float, stroke: bool) -> FloatArray:
    """Return each sensor's ``A q0 + B q`` in the windows, shape (w, k) [m/K]."""
    if not stroke:
        return np.broadcast_to(b, (len(run), len(b)))
    k = len(b) // 2
    return np.asarray(b[:k] + b[k:] * (run.q - centre)[:, None])


def sensor_part(run: Windows, errors: SensorErrors, c: FloatArray) -> FloatArray:
    """Return the covariance that the thermometers' errors bring into the residual, shape (w, w) [m^2]."""
    V = np.zeros((len(run), len(run)))
    for s in range(c.shape[1]):
        V += np.outer(c[:, s], c[:, s]) * errors.covariance(s, run.time, run.rows)
    return V


def normal_equations(
    run: Windows, X: FloatArray, V: FloatArray, W: FloatArray, errors: SensorErrors, centre: float, stroke: bool
) -> NormalEquations:
    """Return one run's part of weighted least squares; `W` are the weights, `V` is the residual's covariance."""
    k = len(errors.noise)
    D = np.zeros((X.shape[1], X.shape[1]))
    g = [np.ones(len(run)), run.q - centre] if stroke else [np.ones(len(run))]
    for s in range(k):
        weighted = W * errors.covariance(s, run.time, run.rows)
        for i, gi in enumerate(g):
            for j, gj in enumerate(g):
                D[s + i * k, s + j * k] = gi @ weighted @ gj
    return NormalEquations(X.T @ W @ X, X.T @ W @ run.drift, X.T @ W @ V @ W @ X, D)


def estimated_noise(
    runs: Sequence[Windows], X: Sequence[FloatArray], fixed: Sequence[FloatArray], row: float,
    near: ResidualNoise | None = None,
) -> ResidualNoise:  # fmt: skip
    """Return the residual's noise by restricted maximum likelihood.

    Parameters
    ----------
    runs : sequence of Windows
    X : sequence of array, shape (w, p)
        Columns of the law.
    fixed : sequence of array, shape (w, w) [m^2]
        Covariance that is known already: that of the thermometers.
    row : float [m]
        Noise of single rows, from their differences.
    near : ResidualNoise, optional
        Where the search starts.
    """
    from scipy.optimize import minimize

    unit, p = _residual_rms(runs, X), X[0].shape[1]

    def noise(theta: npt.NDArray[np.float64]) -> ResidualNoise:
        landing, slow, offset = unit * np.exp(theta[:3])
        return ResidualNoise(row, float(landing), float(slow), float(USUAL_TIME_S * np.exp(theta[3])), float(offset))

    lags = [np.abs(run.time[:, None] - run.time[None, :]) for run in runs]
    tables = [np.asfortranarray(np.column_stack([x, run.drift / unit])) for run, x in zip(runs, X, strict=True)]
    known = [part / unit**2 for part in fixed]

    def objective(theta: npt.NDArray[np.float64]) -> tuple[float, FloatArray]:
        """Minus twice the log likelihood, and its slopes ``tr(P dV) - y'P dV P y`` (Searle, 1992, chapter 6)."""
        guess = noise(theta)
        white, landing, slow, offset = (np.array([row, guess.landing, guess.slow, guess.offset]) / unit) ** 2
        value, parts, total = float(theta[3] ** 2), [], np.zeros((p + 1, p + 1))
        for run, table, part, lag in zip(runs, tables, known, lags, strict=True):
            likeness = np.exp(lag / -guess.slow_time)
            likeness *= slow
            V = part + likeness
            V += offset
            V[np.diag_indices_from(V)] += white / run.rows + landing / run.landings
            W, weighed, log_det = _weighed(V, table)
            value += log_det
            total += table.T @ weighed
            parts.append((weighed, W, likeness))
        S, z = total[:-1, :-1], total[:-1, -1]
        b = np.linalg.solve(S, z)
        value += float(np.linalg.slogdet(S)[1]) + float(total[-1, -1] - z @ b)
        gradient, inverse = np.array([0.0, 0.0, 0.0, 2.0 * theta[3]]), np.linalg.inv(S)
        for run, lag, (weighed, W, likeness) in zip(runs, lags, parts, strict=True):
            A, e = weighed[:, :-1], weighed[:, -1] - weighed[:, :-1] @ b
            P = _Projector(W, A, A @ inverse, e)
            gradient += [2.0 * landing * float(P.diagonal @ (1.0 / run.landings)), 2.0 * P.trace(likeness),
                         2.0 * offset * P.total, P.trace(likeness * lag) / guess.slow_time]  # fmt: skip
        return value, gradient

    bounds = [(-5.0, 2.0)] * 3 + [tuple(np.log(np.array([SHORTEST_TIME_S, LONGEST_TIME_S]) / USUAL_TIME_S))]
    start, options = np.array([-0.7, -0.7, -0.7, 0.0]), {"maxiter": 60, "ftol": 1e-7}
    if near is not None:
        start = np.log([near.landing / unit, near.slow / unit, near.offset / unit, near.slow_time / USUAL_TIME_S])
    return noise(minimize(objective, start, jac=True, method="L-BFGS-B", bounds=bounds, options=options).x)


@dataclass(frozen=True, eq=False)
class _Projector:
    """``P = W - A S^-1 A' - e e'`` of a run, which no table holds: ``A = W X``, ``B = A S^-1``, ``e = P y``.

    Of W (w, w) the lower half is given, with zeros above it.
    """

    W: FloatArray
    A: FloatArray
    B: FloatArray
    e: FloatArray

    @property
    def diagonal(self) -> FloatArray:
        """The diagonal of P."""
        return np.asarray(np.diagonal(self.W) - (self.B * self.A).sum(axis=1) - self.e**2)

    @property
    def total(self) -> float:
        """The sum of all numbers of P."""
        whole = 2.0 * self.W.sum() - np.trace(self.W)
        return float(whole - self.A.sum(axis=0) @ self.B.sum(axis=0) - self.e.sum() ** 2)

    def trace(self, dV: FloatArray) -> float:
        """Return ``tr(P dV)``."""
        whole = 2.0 * np.vdot(self.W.T, dV) - np.diagonal(self.W) @ np.diagonal(dV)
        return float(whole - np.vdot(self.B, dV @ self.A) - self.e @ dV @ self.e)


def _residual_rms(runs: Sequence[Windows], X: Sequence[FloatArray]) -> float:
    """Return the RMS of what plain least squares leave, at least 1e-12 m."""
    stacked, y = np.concatenate(list(X)), np.concatenate([run.drift for run in runs])
    residual = y - stacked @ np.linalg.lstsq(stacked, y, rcond=None)[0]
    return max(float(np.sqrt(residual @ residual / max(len(y) - stacked.shape[1], 1))), 1e-12)


def _weighed(V: FloatArray, table: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Return the lower half of ``W = V^-1`` with zeros above it, ``W table``, and log det V; V is overwritten."""
    from scipy.linalg import LinAlgError, blas, lapack

    factor, failed = lapack.dpotrf(V.T, lower=1, clean=1, overwrite_a=1)
    if failed:
        raise LinAlgError("the covariance of the windows is not positive definite")
    log_det = 2.0 * float(np.log(np.diagonal(factor)).sum())
    W = np.asarray(lapack.dpotri(factor, lower=1, overwrite_c=1)[0])
    return W, np.asarray(blas.dsymm(1.0, W, table, lower=1)), log_det
