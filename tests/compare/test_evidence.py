"""Evidence and estimates from whitened sums, held against dense Gaussian densities."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from hexathermal.compare.evidence import CONTACT_SD, GAIN_SD, Normal
from hexathermal.compare.parameters import FREE, NAMES, TOLERANCES

P = len(NAMES)
RUNS, ROWS = 3, 25


def drawn(rng: np.random.Generator) -> tuple[Normal, np.ndarray, np.ndarray, np.ndarray]:
    """Return sums of runs whose noise is white, with their columns, residuals and point."""
    k = P + 2
    A = rng.standard_normal((RUNS, ROWS, k))
    point = np.concatenate([0.3 * rng.standard_normal(P), np.zeros(2)])
    r = rng.standard_normal((RUNS, ROWS)) + A @ (0.1 * rng.standard_normal(k))
    table = np.concatenate([A, r[..., None]], axis=2)
    grams = np.einsum("rni,rnj->rij", table, table)
    return Normal(point, grams, np.full(RUNS, ROWS * np.log(2.0 * np.pi)), 1), A, r, point


def test_evidence_is_the_density_of_the_data(rng: np.random.Generator) -> None:
    """The evidence from sums equals the dense Gaussian density with the prior's covariance in it."""
    sums, A, r, point = drawn(rng)
    for free in ((), (2,), (0, 7, P)):
        W = 1.0 / sums.precision(free)
        whole = A.reshape(-1, P + 2)
        C = np.eye(RUNS * ROWS) + whole @ np.diag(W) @ whole.T
        dense = multivariate_normal(-whole @ point, C).logpdf(r.ravel())
        assert sums.evidence(sums.precision(free)) == pytest.approx(dense, abs=1e-6)


def test_the_estimate_weighs_data_and_prior(rng: np.random.Generator) -> None:
    """The estimate solves the least squares of residuals and prior together; leaving a run out leaves it out."""
    sums, A, r, point = drawn(rng)
    precision = sums.precision((1,))
    for one, rows in ((sums, slice(None)), (sums.without(0), slice(1, None))):
        whole = A[rows].reshape(-1, P + 2)
        left = np.vstack([whole, np.diag(np.sqrt(precision))])
        right = np.concatenate([r[rows].ravel() + whole @ point, np.zeros(P + 2)])
        x, covariance = one.estimate(precision)
        np.testing.assert_allclose(x, np.linalg.lstsq(left, right)[0], atol=1e-9)
        np.testing.assert_allclose(np.linalg.inv(covariance), left.T @ left, rtol=1e-6, atol=1e-6)


def test_information_is_that_of_the_estimate(rng: np.random.Generator) -> None:
    """What data say of two numbers is the inverse of their joint covariance, their own prior taken out."""
    sums, _A, _r, _point = drawn(rng)
    precision = sums.precision((3,))
    chosen = [3, 5]
    _x, covariance = sums.estimate(precision)
    expected = np.linalg.inv(covariance[np.ix_(chosen, chosen)]) - np.diag(precision[chosen])
    np.testing.assert_allclose(sums.information(chosen, precision), expected, rtol=1e-8, atol=1e-8)


def test_misfit_is_smallest_at_the_truth_of_a_run(rng: np.random.Generator) -> None:
    """Half the whitened square of one run, all numbers free within tolerance, as the dense form gives it."""
    sums, A, r, point = drawn(rng)
    W = np.concatenate([np.square(TOLERANCES), [CONTACT_SD**2, GAIN_SD**2]])
    x = 0.2 * rng.standard_normal(P + 2)
    rest = r[1] - A[1] @ (x - point)
    C = np.eye(ROWS) + A[1] @ np.diag(W) @ A[1].T
    assert sums.misfit(x, 1) == pytest.approx(0.5 * rest @ np.linalg.solve(C, rest), rel=1e-9)


def test_what_may_differ_has_a_wide_prior() -> None:
    """Tolerances are narrow, what is free is wide, for parameters and thermocouples alike."""
    sums = Normal(np.zeros(P + 2), np.zeros((1, P + 3, P + 3)), np.zeros(1), 1)
    precision = sums.precision((0,))
    assert precision[0] == pytest.approx(FREE**-2.0)
    assert precision[1] == pytest.approx(TOLERANCES[1] ** -2.0)
    assert sums.precision((P,))[P] < 0.01 * precision[P]
