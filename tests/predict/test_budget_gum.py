"""The arithmetic of the GUM on its own published examples, and against the library of the field (GTC)."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hexathermal.errors import ArgumentError
from hexathermal.predict.budget_gum import (
    Contribution,
    contributed,
    coverage_factor,
    effective_dof,
    joint_dof,
    region_factor,
    total,
)
from hexathermal.predict.sources import Source, root


def part(rates, dof: float = np.inf, together: bool = False) -> Contribution:
    """Return a contribution whose label does not matter."""
    return contributed(
        np.atleast_2d(rates), dof, together, label="x", quantity="length", standard=1.0, unit="m",
        distribution="normal", correlation="independent",
    )  # fmt: skip


GAUGE_BLOCK_NM = [  # sensitivity times standard uncertainty [nm] and degrees of freedom: GUM, table H.1
    (25.0, 18.0),  # standard
    (5.8, 24.0),  # mean of repeated comparisons
    (3.9, 5.0),  # random effects of the comparator
    (6.7, 8.0),  # systematic effects of the comparator
    (50e6 * 0.1 * 0.58e-6, 50.0),  # difference of expansion coefficients
    (50e6 * 11.5e-6 * 0.029, 2.0),  # difference of temperatures
]


def test_end_gauge_of_the_gum() -> None:
    """GUM H.1: an end gauge compared at another temperature: u = 32 nm, nu = 16, U(99 %) = 93 nm."""
    parts = [part(rate, nu) for rate, nu in GAUGE_BLOCK_NM]
    u = np.sqrt(total(parts, 1)[0, 0])
    nu = effective_dof(parts, 1)[0]
    assert round(u) == 32
    assert int(nu) == 16
    assert round(float(coverage_factor(int(nu), 0.99)) * u) == 93


def test_calibration_of_a_thermometer_of_the_gum() -> None:
    """GUM H.3: a line through 11 corrections; slope and intercept correlate by -0.930: u(b(30)) = 0.0041, nu = 9."""
    t = np.array([21.521, 22.012, 22.512, 23.003, 23.507, 23.999, 24.513, 25.002, 25.503, 26.010, 26.511])
    b = np.array([-0.171, -0.169, -0.166, -0.159, -0.164, -0.165, -0.156, -0.157, -0.159, -0.161, -0.160])
    X = np.stack([np.ones(11), t - 20.0], axis=1)
    y, rest = np.linalg.lstsq(X, b, rcond=None)[:2]
    C = np.linalg.inv(X.T @ X) * rest[0] / 9
    u = np.sqrt(np.diag(C))
    r = C[0, 1] / u[0] / u[1]
    assert (round(y[0], 4), round(u[0], 4), round(y[1], 5), round(u[1], 5)) == (-0.1712, 0.0029, 0.00218, 0.00067)
    assert round(r, 3) == -0.930
    source = Source("line", "coefficients", u, dof=9, within=[[1.0, r], [r, 1.0]])
    rates = np.array([[1.0, 10.0]]) @ source.factors(1, 2)
    parts = [part(rates, source.dof, source.joint)]
    assert round(float(y @ [1.0, 10.0]), 4) == -0.1494
    assert round(float(np.sqrt(total(parts, 1)[0, 0])), 4) == 0.0041
    assert effective_dof(parts, 1)[0] == pytest.approx(9.0)


@given(
    rates=st.lists(st.tuples(st.floats(0.1, 10), st.floats(0.1, 10)), min_size=1, max_size=6),
    dofs=st.lists(st.floats(2, 60), min_size=6, max_size=6),
)
def test_sums_are_those_of_gtc(rates: list[tuple[float, float]], dofs: list[float]) -> None:
    """Uncertainty, degrees of freedom and covariance of two results are those of GTC, for independent inputs."""
    gtc = pytest.importorskip("GTC", reason="GTC is not installed (extra 'test')")
    inputs = [gtc.ureal(0.0, 1.0, df) for df in dofs]
    results = [sum(row[k] * x for row, x in zip(rates, inputs, strict=False)) for k in (0, 1)]
    parts = [part(np.array(row)[:, None], nu) for row, nu in zip(rates, dofs, strict=False)]
    V, nu = total(parts, 2), effective_dof(parts, 2)
    for k in (0, 1):
        assert np.sqrt(V[k, k]) == pytest.approx(results[k].u, rel=1e-12)
        assert nu[k] == pytest.approx(results[k].df, rel=1e-9)
    assert V[0, 1] == pytest.approx(gtc.get_covariance(*results), rel=1e-12)


def test_joint_degrees_of_freedom_at_their_ends() -> None:
    """One number: Welch-Satterthwaite; one source: its own; units and frames change nothing."""
    one = [part(3.0, 5.0), part(4.0, 20.0)]
    assert joint_dof(one, 1) == pytest.approx(effective_dof(one, 1)[0])
    rng = np.random.default_rng(1)
    S, T = rng.normal(size=(2, 6, 6))
    assert joint_dof([part(S, 12.0, True)], 6) == pytest.approx(12.0)
    two = [part(S, 12.0, True), part(T, 40.0, True)]
    A = np.diag([1, 1, 1, 1e3, 1e3, 1e3]) @ np.kron(np.eye(2), np.linalg.qr(rng.normal(size=(3, 3)))[0])
    turned = [part(A @ S, 12.0, True), part(A @ T, 40.0, True)]
    assert joint_dof(turned, 6) == pytest.approx(joint_dof(two, 6), rel=1e-9)
    assert np.isinf(joint_dof([part(S)], 6))


def test_region_of_an_estimated_covariance_covers() -> None:
    """Hotelling's region of three numbers with a covariance from 8 degrees of freedom covers 94 to 96 %."""
    rng = np.random.default_rng(2)
    n, nu, k = 20_000, 8, region_factor(3, 8.0)
    x, z = rng.normal(size=(n, 3)), rng.normal(size=(n, nu, 3))
    V = np.einsum("nij,nik->njk", z, z) / nu
    inside = np.einsum("ni,ni->n", x, np.linalg.solve(V, x[..., None])[..., 0]) <= k**2
    assert 0.94 < inside.mean() < 0.96
    assert region_factor(1, np.inf) == pytest.approx(1.959964, abs=1e-6)


@pytest.mark.parametrize("nu", [6, 10, 20])
def test_region_of_six_lengths_estimated_one_by_one_covers(nu: int) -> None:
    """6-D regions of six independent lengths, each estimated from nu values, cover 94 to 96 % of 10^4 machines."""
    rng = np.random.default_rng(11)
    n, J = 10_000, rng.normal(size=(6, 6))
    sd, errors = np.sqrt(rng.chisquare(nu, (n, 6)) / nu), rng.normal(size=(n, 6)) @ J.T
    k = region_factor(6, joint_dof([part(J * sd[0], nu)], 6))
    whitened = np.linalg.solve(J, errors.T).T / sd
    inside = (whitened**2).sum(axis=1) <= k**2
    assert 0.94 < inside.mean() < 0.96
    assert joint_dof([part(J * sd[1], nu)], 6) == pytest.approx(3.5 * nu)


@pytest.mark.parametrize("dof", [5.0, np.nextafter(5.0, 6.0), 5.001, 5.05, 5.5, 6.0, 1e3])
def test_regions_are_finite_or_refused(dof: float) -> None:
    """Degrees of freedom hardly above 5 give a finite region or an error, and no overflow."""
    try:
        assert np.isfinite(region_factor(6, dof))
    except ArgumentError:
        assert dof < 5.3


def test_intervals_of_few_data_cover() -> None:
    """t_p(nu) u covers 94 to 96 % where two standard deviations come from 4 and 9 degrees of freedom."""
    rng = np.random.default_rng(3)
    n, hits = 4_000, 0
    for _ in range(n):
        s = [np.sqrt(rng.chisquare(nu) / nu) for nu in (4, 9)]
        parts = [part(s[0], 4.0), part(2.0 * s[1], 9.0)]
        U = coverage_factor(effective_dof(parts, 1), 0.95) * np.sqrt(total(parts, 1)[0, 0])
        hits += abs(rng.normal() + 2.0 * rng.normal()) <= U[0]
    assert 0.94 < hits / n < 0.965


def test_root_of_a_matrix() -> None:
    """S S^T is the matrix, also where it is singular."""
    for matrix in (np.ones((3, 3)), np.eye(3), np.array([[1, 0.5, 0], [0.5, 1, -0.2], [0, -0.2, 1]])):
        assert np.allclose(root(matrix) @ root(matrix).T, matrix, rtol=0, atol=1e-14)


@pytest.mark.parametrize("p", [0.0, 1.0, -1.0, "0.95", np.nan])
def test_senseless_probabilities_are_refused(p) -> None:
    """A coverage probability lies between 0 and 1."""
    with pytest.raises(ArgumentError, match="between 0 and 1"):
        coverage_factor(5.0, p)
    with pytest.raises(ArgumentError, match="effective degrees of freedom"):
        region_factor(6, 5.0)
