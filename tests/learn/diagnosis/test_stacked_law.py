"""The coefficients of a law lie between two estimates, where runs left out leave least; their covariance is that."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.campaign_laws import validate_campaign
from hexathermal.learn.diagnosis import diagnose
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign
from tests.learn.diagnosis.campaigns import viewed
from tests.learn.diagnosis.noises import dense


def estimators(X: FloatArray, K: FloatArray, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Matrices that make coefficients of values: by the noise's covariance, and by plain least squares of rows."""
    weighted = np.linalg.solve(K, X)
    plain = X * rows[:, None]
    return np.linalg.solve(weighted.T @ X, weighted.T), np.linalg.solve(plain.T @ X, plain.T)


@pytest.mark.long
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


@pytest.mark.long
def test_an_extended_law_is_as_sure_as_what_it_leaves_lets_it(tmp_path: Path) -> None:
    """Prediction intervals of the extended law shrink with its residual, and still hold most rows never fitted."""
    truth, answer = campaign_of("modal", 733, causes=("hidden-heat",), strength=2.5)
    write_campaign(tmp_path / "campaign", truth, answer)
    campaign = load_campaign(tmp_path / "campaign")
    found = diagnose(campaign, answer.base)
    assert found.cause == "hidden-heat"
    assert found.extended.noise.variance < 0.6 * found.law.noise.variance
    assert validate_campaign(found.extended, campaign).coverage > 0.7
