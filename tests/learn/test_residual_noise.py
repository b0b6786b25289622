"""The noise of a law's residual is that of the largest restricted likelihood, written out with dense matrices."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import optimize

from hexathermal.learn.noise import USUAL_TIME_S, ResidualNoise, estimated_noise
from hexathermal.learn.windows import Windows
from hexathermal.poses import FloatArray

ROW = 2e-8


def runs_of(rng: np.random.Generator, count: int = 4, windows: int = 40) -> list[Windows]:
    """Return runs of windows of unequal length, whose drift is a law's and the noise of landings, time and runs."""
    found = []
    for k in range(count):
        time = np.cumsum(rng.uniform(60.0, 300.0, windows))
        X, rows = rng.standard_normal((windows, 2)), rng.integers(4, 20, windows).astype(float)
        lag = np.abs(time[:, None] - time)
        V = (1e-7) ** 2 * np.exp(-lag / 2400.0) + (6e-8) ** 2 + np.diag(ROW**2 / rows + (1.2e-7) ** 2)
        drift = X @ np.array([1e-6, -3e-7]) + np.linalg.cholesky(V) @ rng.standard_normal(windows)
        found.append(Windows(f"run-{k}", time, X, drift, np.zeros(windows), rows, np.ones(windows)))
    return found


def deviance(noise: ResidualNoise, runs: list[Windows], fixed: list[FloatArray]) -> float:
    """Return minus twice the restricted log likelihood by dense matrices, the prior of the slow time with it."""
    n = [len(run) for run in runs]
    V, edges = np.zeros((sum(n), sum(n))), np.cumsum([0, *n])
    for run, part, a, b in zip(runs, fixed, edges[:-1], edges[1:], strict=True):
        V[a:b, a:b] = part + noise.covariance(run)
    X, y = np.concatenate([run.X for run in runs]), np.concatenate([run.drift for run in runs])
    W = np.linalg.inv(V)
    left = y - X @ np.linalg.solve(X.T @ W @ X, X.T @ W @ y)
    log_dets = np.linalg.slogdet(V)[1] + np.linalg.slogdet(X.T @ W @ X)[1]
    return float(log_dets + left @ W @ left + np.log(noise.slow_time / USUAL_TIME_S) ** 2)


@pytest.mark.parametrize("seed", range(3))
def test_the_noise_is_where_the_restricted_likelihood_is_largest(seed: int) -> None:
    """No noise that a search without slopes finds, on dense matrices, is likelier by 0.01; wherever it is begun."""
    rng = np.random.default_rng(seed)
    runs = runs_of(rng)
    fixed = [1e-15 * np.outer(c, c) for c in (rng.standard_normal(len(run)) for run in runs)]

    def at(theta: FloatArray) -> ResidualNoise:
        landing, slow, time, offset = np.exp(theta)
        return ResidualNoise(ROW, 1e-7 * landing, 1e-7 * slow, USUAL_TIME_S * time, 1e-7 * offset)

    options = {"maxiter": 2000, "xatol": 1e-4, "fatol": 1e-4}
    bounds = [(-4.0, 2.0), (-4.0, 2.0), (-2.3, 1.97), (-4.0, 2.0)]
    best = optimize.minimize(lambda theta: deviance(at(theta), runs, fixed), np.zeros(4), method="Nelder-Mead",
                             bounds=bounds, options=options)  # fmt: skip
    X = [run.X for run in runs]
    cold = estimated_noise(runs, X, fixed, ROW)
    warm = estimated_noise(runs, X, fixed, ROW, at(np.array([0.5, -1.0, 0.3, 0.4])))
    assert deviance(cold, runs, fixed) < best.fun + 0.02
    assert deviance(warm, runs, fixed) < best.fun + 0.02
