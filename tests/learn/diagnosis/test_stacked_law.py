"""The coefficients of a law lie between two estimates, where runs left out leave least; their covariance is that."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.poses import FloatArray
from tests.learn.diagnosis.campaigns import viewed
from tests.learn.diagnosis.noises import dense


def estimators(X: FloatArray, K: FloatArray, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Matrices that make coefficients of values: by the noise's covariance, and by plain least squares of rows."""
    weighted = np.linalg.solve(K, X)
    plain = X * rows[:, None]
    return np.linalg.solve(weighted.T @ X, weighted.T), np.linalg.solve(plain.T @ X, plain.T)


@pytest.mark.parametrize(("bench", "seed"), [("quiet", 733), ("modal", 733), ("finite_volume", 734), ("rough", 735)])
def test_a_law_is_stacked_of_two_estimates(bench: str, seed: int) -> None:
    """Its part of each, and its covariance, are those of dense matrices, run by run left out."""
    view, _ = viewed(bench, seed, ("frame-expansion",), 0.8)
    stage = Stage(view)
    mean, covariance = stage.law
    channel, X = stage.channel, stage.view.base_columns
    K = dense(channel, stage.levels)
    left = []
    for run in np.unique(channel.run):
        out = channel.run == run
        some = estimators(X[~out], K[np.ix_(~out, ~out)], channel.rows[~out])
        left.append([channel.y[out] - X[out] @ G @ channel.y[~out] for G in some])
    weighted, plain = (np.concatenate([item[k] for item in left]) for k in (0, 1))
    best = minimize_scalar(lambda w: channel.rows @ (w * weighted + (1.0 - w) * plain) ** 2, bounds=(0.0, 1.0),
                           method="bounded").x  # fmt: skip
    both = estimators(X, K, channel.rows)
    G = best * both[0] + (1.0 - best) * both[1]
    deviation = np.sqrt(np.diagonal(covariance))
    assert np.abs(mean - G @ channel.y).max() < 0.05 * deviation.max()
    assert covariance == pytest.approx(G @ K @ G.T, rel=0.05, abs=0.01 * float(np.diagonal(covariance).max()))
