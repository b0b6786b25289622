"""Worked examples that others published: GUM H.2, JCGM 101 clause 9, and the verdicts that are printed there."""

from __future__ import annotations

import numpy as np
import pytest

import hexathermal as ht
from hexathermal.predict.budget_gum import contributed, coverage_factor, effective_dof, total
from hexathermal.predict.montecarlo import monte_carlo
from hexathermal.predict.montecarlo_draws import shortest_interval
from hexathermal.predict.sources import Source

DRAWS = 400_000


def shortest(values: np.ndarray) -> list[float]:
    """Return the shortest 95 % interval of values."""
    return [float(end[0]) for end in shortest_interval(values[:, None], 0.95)]


def test_resistance_and_reactance_of_the_gum() -> None:
    """GUM H.2: three results of three correlated inputs: uncertainties and correlations with their printed digits."""
    V, current, phase = 4.9990, 19.661e-3, 1.04446
    r = [[1.0, -0.355, 0.858], [-0.355, 1.0, -0.645], [0.858, -0.645, 1.0]]
    source = Source("readings", "coefficients", [0.0032, 9.5e-6, 0.00075], dof=4, correlation=r)
    R, X, Z = V / current * np.cos(phase), V / current * np.sin(phase), V / current
    rates = np.array([
        [np.cos(phase) / current, -R / current, -X],
        [np.sin(phase) / current, -X / current, R],
        [1.0 / current, -Z / current, 0.0],
    ])  # fmt: skip
    item = contributed(
        rates @ source.factors(1, 3), source.dof, source.joint, label="", quantity="", standard=1.0, unit="",
        distribution="t", correlation="matrix",
    )  # fmt: skip
    covariance = total([item], 3)
    u = np.sqrt(np.diag(covariance))
    assert (round(R, 3), round(X, 3), round(Z, 3)) == (127.732, 219.847, 254.260)
    assert u == pytest.approx([0.071, 0.295, 0.236], abs=5.1e-4)
    correlation = covariance / np.outer(u, u)
    # the inputs are printed rounded, and so the last digit of the correlations is not reached
    assert correlation[[0, 0, 1], [1, 2, 2]] == pytest.approx([-0.588, -0.485, 0.993], abs=0.003)
    assert effective_dof([item], 3) == pytest.approx([4.0] * 3)
    assert float(coverage_factor(4.0, 0.95)) == pytest.approx(2.776, abs=5e-4)


def test_mass_calibration_of_jcgm_101(rng: np.random.Generator) -> None:
    """JCGM 101, 9.3: a product of differences: 1.2341 mg, u = 0.0754 mg (first order: 0.0539), 1.0834 to 1.3825 mg."""
    m, dm = rng.normal(100e3, 0.050, DRAWS), rng.normal(1.234, 0.020, DRAWS)
    air, weight = rng.uniform(1.10, 1.30, DRAWS), rng.uniform(7e3, 9e3, DRAWS)
    reference = rng.uniform(7.95e3, 8.05e3, DRAWS)
    y = (m + dm) * (1.0 + (air - 1.2) * (1.0 / weight - 1.0 / reference)) - 100e3
    assert y.mean() == pytest.approx(1.2341, abs=4e-4)
    assert y.std() == pytest.approx(0.0754, abs=2e-4)
    assert shortest(y) == pytest.approx([1.0834, 1.3825], abs=6e-3)


@pytest.mark.parametrize(
    ("x", "mean", "u", "interval"),
    [(0.0, 50, 50, (0, 150)), (0.010, 150, 112, (0, 367)), (0.050, 2551, 502, (1590, 3543))],
)
def test_comparison_loss_of_jcgm_101(
    x: float, mean: float, u: float, interval: tuple[float, float], rng: np.random.Generator
) -> None:
    """JCGM 101, 9.4: a sum of squares: mean, uncertainty, shortest interval; it begins at 0 where the density falls."""
    y = 1e6 * (rng.normal(x, 0.005, DRAWS) ** 2 + rng.normal(0.0, 0.005, DRAWS) ** 2)
    assert y.mean() == pytest.approx(mean, rel=0.01)
    assert y.std() == pytest.approx(u, rel=0.01)
    assert shortest(y) == pytest.approx(interval, abs=0.06 * u)


def test_gauge_block_of_jcgm_101(rng: np.random.Generator) -> None:
    """JCGM 101, 9.5: the gauge block of GUM H.1 by draws: 838 nm, u = 36 nm, 99 % from 745 to 932 nm.

    Inputs follow t, arcsine and rectangles, two of them with inexact limits; the first order has 32 nm.
    """

    def curved(low: float, high: float, unsure: float) -> np.ndarray:
        """Return draws of a rectangle whose limits are themselves uncertain by a rectangle (JCGM 101, 6.4.3.4)."""
        a = low - unsure + 2.0 * unsure * rng.random(DRAWS)
        return np.asarray(a + (low + high - 2.0 * a) * rng.random(DRAWS))

    standard = 50_000_623.0 + 25.0 * rng.standard_t(18, DRAWS)
    comparator = 215.0 + 6.0 * rng.standard_t(24, DRAWS) + 4.0 * rng.standard_t(5, DRAWS)
    comparator += 7.0 * rng.standard_t(8, DRAWS)
    expansion = rng.uniform(9.5e-6, 13.5e-6, DRAWS)
    temperature = -0.1 + 0.2 * rng.standard_normal(DRAWS) + 0.5 * np.sin(rng.uniform(0.0, 2.0 * np.pi, DRAWS))
    apart, warmer = curved(-1.0e-6, 1.0e-6, 0.1e-6), curved(-0.050, 0.050, 0.025)
    # both blocks from 20 degC: the test block's expansion and temperature are the standard's plus differences
    y = (standard * (1.0 + expansion * temperature) + comparator) / (
        1.0 + (expansion + apart) * (temperature + warmer)
    ) - 50e6
    assert y.mean() == pytest.approx(838.0, abs=0.5)
    assert y.std() == pytest.approx(36.0, abs=0.5)
    low, high = (float(end[0]) for end in shortest_interval(y[:, None], 0.99))
    assert (low, high) == pytest.approx((745.0, 932.0), abs=2.5)


def test_welch_satterthwaite_of_the_gum() -> None:
    """GUM G.4.1: three inputs of 0.25, 0.57 and 0.82 % from 10, 5 and 15 values: 1.03 %, 19 degrees, 2.2 %."""
    items = [
        contributed(
            np.array([[u]]), n - 1, False, label="", quantity="", standard=1.0, unit="", distribution="t",
            correlation="independent",
        )
        for u, n in ((0.25, 10), (0.57, 5), (0.82, 15))
    ]  # fmt: skip
    u, dof = float(np.sqrt(total(items, 1)[0, 0])), effective_dof(items, 1)
    assert (round(u, 2), round(float(dof[0]), 1)) == (1.03, 19.0)
    assert float(coverage_factor(dof, 0.95)[0]) == pytest.approx(2.09, abs=5e-3)
    assert round(float(coverage_factor(dof, 0.95)[0]) * u, 1) == 2.2


@pytest.mark.long
@pytest.mark.parametrize(
    ("distribution", "last", "u", "half_width", "used"),
    [("normal", 1, 2.0, 3.92, True), ("uniform", 1, 2.0, 3.88, True), ("uniform", 10, 10.1, 17.0, False)],
)
def test_verdicts_of_jcgm_101(
    reference: ht.Hexapod, distribution: str, last: float, u: float, half_width: float, used: bool
) -> None:
    """JCGM 101, 9.2.2 to 9.2.4: sums of four inputs: linear limits hold to 0.1 for the first two, not for the third."""
    sources = [
        Source(name, "pose", [standard * 1e-6, 0, 0, 0, 0, 0], distribution)
        for name, standard in zip("abcd", (1, 1, 1, last), strict=True)
    ]
    found = monte_carlo(
        reference, reference.home, [20.0] * 6, sources, tolerance=0.1e-6 * u / 2.0, least_draws=DRAWS, seed=5
    )
    assert found.uncertainty[0] * 1e6 == pytest.approx(u, rel=0.01)
    assert [found.low[0] * 1e6, found.high[0] * 1e6] == pytest.approx([-half_width, half_width], abs=0.015 * u)
    assert found.linear_may_be_used is used
    assert bool(found.agrees[0]) is used


def test_two_digits_are_ten_of_the_last(reference: ht.Hexapod) -> None:
    """JCGM 101, 7.9.2: u = 9.96 with two digits is 10 x 10^0 and tolerates 0.5; 35 with one is 4 x 10^1, 5."""
    for standard, digits, wanted in ((9.96, 2, 0.5), (35.0, 1, 5.0), (0.035, 2, 0.0005), (1.0, 1, 0.5)):
        sources = [Source("x", "pose", [standard * 1e-6] * 6)]
        found = monte_carlo(
            reference, reference.home, [20.0] * 6, sources, digits=digits, least_draws=1, most_draws=20_000
        )
        assert found.tolerance * 1e6 == pytest.approx(np.full(6, wanted))
