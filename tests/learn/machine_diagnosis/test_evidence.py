"""Evidence from small tables is that of the full covariance of all rows."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from hexathermal.learn.hexapod_model import row_covariance
from hexathermal.learn.machine_diagnosis.case import case_of
from hexathermal.learn.machine_diagnosis.chance import chance_threshold
from hexathermal.learn.machine_diagnosis.evidence import hypothesis, prior_of
from hexathermal.learn.machine_diagnosis.law_columns import law_columns
from hexathermal.learn.machine_diagnosis.noise_levels import leg_noise
from hexathermal.learn.machine_diagnosis.search import candidates_left
from hexathermal.learn.machine_diagnosis.tables import Levels, run_columns
from tests.learn.machine_diagnosis.machines import Fault, drawn


def test_evidence_is_that_of_the_dense_covariance() -> None:
    """``log p(y | cause) - log p(y | none)`` by tables equals that of two normal distributions of all lengths."""
    rows = drawn(1, Fault(platform=5e-6), runs=2, poses=30, frame=2e-6)
    case = case_of(rows)
    levels = Levels(frame=3.2, slow=0.4, leg=0.2, campaign=1.6)
    k = next(i for i, one in enumerate(case.candidates) if one.called == "joint-offset of base joint 2")
    one, view, sigma = case.candidates[k], case.view, case.noise.coordinates
    sd = 0.3 * one.scale
    n = 6 * len(rows)
    V = np.zeros((n, n))
    for row, block in enumerate(row_covariance(view.hexapod, view.poses, sigma, 0.0)):
        V[6 * row : 6 * row + 6, 6 * row : 6 * row + 6] = block
    shared = np.concatenate([law_columns(view).columns, view.frame * sigma * levels.campaign], axis=2).reshape(n, -1)
    own = (run_columns(view, sigma, leg_noise(view, sigma)) * levels.run_sizes).reshape(n, -1)
    same = np.repeat(view.run, 6)[:, None] == np.repeat(view.run, 6)
    V += shared @ shared.T + np.where(same, own @ own.T, 0.0)
    Z = (one.columns * sd).reshape(n, -1)
    y = (case.y - law_columns(view).known).reshape(-1)
    scale = 1e6
    dense = [multivariate_normal(cov=scale**2 * C).logpdf(scale * y) for C in (V, V + Z @ Z.T)]
    place = case.tables.places[k]
    small = [hypothesis(case.tables, levels, adopted)[0] for adopted in ([], [(place, one.mean, sd)])]
    assert np.isinf(case.noise.freedom)
    assert small[1] - small[0] == pytest.approx(dense[1] - dense[0], abs=1e-4)


def test_prior_of_levels_is_a_distribution() -> None:
    """Over all levels of the grid the prior sums to 1."""
    from itertools import product

    from hexathermal.learn.machine_diagnosis.evidence import LEVEL_GRID

    total = sum(np.exp(prior_of(Levels(*four))) for four in product((0.0, *LEVEL_GRID), repeat=4))
    assert total == pytest.approx(1.0)


def test_threshold_grows_with_what_is_asked() -> None:
    """The threshold of chance is finite, and no lower where candidates are more likely before."""
    case = case_of(drawn(2, runs=2, poses=30))
    S = candidates_left(case, Levels(), [])[:-1, :-1]
    threshold = chance_threshold(case, S)
    from dataclasses import replace

    assert np.isfinite(threshold)
    assert chance_threshold(replace(case, prior=case.prior + 1.0), S) == pytest.approx(threshold + 1.0)
