"""The noise of a channel: the filter whitens, and evidence is that of a multivariate normal distribution."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import integrate, optimize
from scipy.linalg import solve_triangular
from scipy.stats import multivariate_normal

from hexathermal.learn.diagnosis import channels, whitening_loops
from hexathermal.learn.diagnosis.channels import Channel, Levels
from hexathermal.learn.diagnosis.coefficients import marginal, sized
from tests.learn.diagnosis.campaigns import viewed
from tests.learn.diagnosis.noises import LEVELS, channel_like, dense, noisy

SIZE = st.floats(0.01, 3.0)


@given(SIZE, SIZE, SIZE, SIZE, st.sampled_from([300.0, 2400.0, 86400.0]), st.booleans(), st.integers(0, 10**6))
def test_whitening_is_that_of_the_dense_matrix(
    white: float, landing: float, slow: float, offset: float, slow_time: float, walks: bool, seed: int
) -> None:
    """The three-state filter gives the columns and log det V that a Cholesky factor of the whole matrix gives."""
    rng = np.random.default_rng(seed)
    channel = channel_like(rng, shows=True, walks=walks)
    levels = Levels(white, landing, slow, offset, slow_time)
    columns = rng.standard_normal((len(channel), 3))
    found, logdet = channel.whitened(columns, levels)
    factor = np.linalg.cholesky(dense(channel, levels))
    np.testing.assert_allclose(found, solve_triangular(factor, columns, lower=True), rtol=1e-7, atol=1e-9)
    assert logdet == pytest.approx(2.0 * np.log(np.diag(factor)).sum(), rel=1e-9, abs=1e-8)


@pytest.mark.parametrize("walks", [True, False])
def test_the_covariance_of_weighed_sums_is_that_of_the_dense_matrix(walks: bool, rng: np.random.Generator) -> None:
    """``G' V G`` run by run is that of the whole matrix."""
    channel = channel_like(rng, shows=True, walks=walks)
    G = rng.standard_normal((len(channel), 4))
    np.testing.assert_allclose(channel.spread(G, LEVELS), G.T @ dense(channel, LEVELS) @ G, rtol=1e-10, atol=1e-12)


def test_runs_left_out_are_told_by_the_others_alone(rng: np.random.Generator) -> None:
    """What a run leaves is its data less the columns by the coefficients that all other runs' data alone give.

    One column is there in one run only, ten thousand times as large: left out, its coefficient is not known at all.
    """
    channel = noisy(channel_like(rng), LEVELS, rng)
    X, sd = rng.standard_normal((len(channel), 3)), np.array([1.0, 2.0, 0.5])
    X[:, 2] = 1e4 * (channel.run == 1)
    left, white = channel.left_out(X, sd, LEVELS)
    factor = np.linalg.cholesky(dense(channel, LEVELS))
    y, Z = (solve_triangular(factor, item, lower=True) for item in (channel.y, X))
    for k in range(3):
        own, others = channel.run == k, channel.run != k
        M = Z[others].T @ Z[others] + np.diag(1.0 / sd**2)
        b = np.linalg.solve(M, Z[others].T @ y[others])
        np.testing.assert_allclose(left[own], channel.y[own] - X[own] @ b, rtol=1e-8, atol=1e-8)
        np.testing.assert_allclose(white[own], y[own] - Z[own] @ b, rtol=1e-8, atol=1e-8)


def test_the_filter_starts_anew_in_each_run(rng: np.random.Generator) -> None:
    """Runs are independent: a run whitened alone is what it is among others, and log det V is the sum."""
    channel = channel_like(rng, shows=True)
    columns = rng.standard_normal((len(channel), 2))
    whole, logdet = channel.whitened(columns, LEVELS)
    assert channel.floor is not None
    total = 0.0
    for k in range(3):
        own = channel.run == k
        whole_run = (channel.y, channel.start, channel.fresh, channel.step, channel.rows, channel.run)
        parts = {"shown": channel.wander[own], "floor": channel.floor[own], "walks": True}
        alone = Channel(*(item[own] for item in whole_run), **parts)
        part, value = alone.whitened(columns[own], LEVELS)
        np.testing.assert_array_equal(part, whole[own])
        total += value
    assert logdet == pytest.approx(total, rel=1e-12)


def test_evidence_is_a_multivariate_normal(rng: np.random.Generator) -> None:
    """Evidence less that of another model is the difference of dense log densities N(0, V + X D X')."""
    channel = noisy(channel_like(rng, shows=True), LEVELS, rng)
    X, sd = rng.standard_normal((len(channel), 3)), np.array([0.3, 2.0, 0.05])
    V = dense(channel, LEVELS)
    wanted = multivariate_normal(None, V + (X * sd**2) @ X.T).logpdf(channel.y) - multivariate_normal(None, V).logpdf(
        channel.y
    )
    nothing = np.zeros((len(channel), 1))
    found = channel.evidence(X, sd, LEVELS) - channel.evidence(nothing, np.ones(1), LEVELS)
    assert found == pytest.approx(wanted, abs=1e-8)


def test_evidence_is_an_integral_over_the_coefficient(rng: np.random.Generator) -> None:
    """One coefficient integrated by quadrature over its prior gives the same evidence; mean and variance as well."""
    r, x, sd = rng.standard_normal(40), rng.standard_normal(40), 0.4

    def density(b: float) -> float:
        return float(
            np.exp(-0.5 * ((r - x * b) ** 2).sum() + 0.5 * (r**2).sum() - 0.5 * (b / sd) ** 2)
            / np.sqrt(2.0 * np.pi)
            / sd
        )

    total = integrate.quad(density, -5.0, 5.0, epsabs=1e-12)[0]
    mean = integrate.quad(lambda b: b * density(b), -5.0, 5.0, epsabs=1e-12)[0] / total
    square = integrate.quad(lambda b: b * b * density(b), -5.0, 5.0, epsabs=1e-12)[0] / total
    value, found, covariance = marginal(r, x[:, None], np.array([sd]))
    assert value + 0.5 * (r**2).sum() == pytest.approx(np.log(total), abs=1e-8)
    assert found[0] == pytest.approx(mean, abs=1e-8)
    assert covariance[0, 0] == pytest.approx(square - mean**2, abs=1e-8)


def test_levels_of_drawn_noise_are_found(rng: np.random.Generator) -> None:
    """Fitted to drawn noise of 9 runs: white, landings, and slow parts together are right within 1.5, in the median.

    A run's offset and a process as slow as the run cannot be told apart by few runs: their sum counts.
    """
    channel = channel_like(rng, runs=9, windows=60)
    X, sd = rng.standard_normal((len(channel), 2)), np.ones(2)
    ratios = []
    for _ in range(10):
        levels, value = noisy(channel, LEVELS, rng).fitted(X, sd)
        slow, wanted = np.hypot(levels.slow, levels.offset), np.hypot(LEVELS.slow, LEVELS.offset)
        ratios.append([levels.white / LEVELS.white, levels.landing / LEVELS.landing, slow / wanted])
        assert np.isfinite(value)
    ratio = np.median(ratios, axis=0)
    assert (ratio > 1.0 / 1.5).all(), ratio
    assert (ratio < 1.5).all(), ratio


def test_fitted_levels_are_as_likely_as_those_of_the_draw(rng: np.random.Generator) -> None:
    """The levels that noise of 9 runs was drawn with explain it by at most 1 log unit more than the fitted ones."""
    channel = channel_like(rng, runs=9, windows=40)
    X, sd = rng.standard_normal((len(channel), 2)), np.ones(2)
    for _ in range(5):
        drawn = noisy(channel, LEVELS, rng)
        assert drawn.fitted(X, sd)[1] > drawn.evidence(X, sd, LEVELS) - 1.0


@pytest.mark.parametrize("walks", [True, False])
@pytest.mark.parametrize("landings", [True, False])
def test_levels_and_their_logarithms_tell_the_same(walks: bool, landings: bool, rng: np.random.Generator) -> None:
    """Logarithms give levels that give them back; of what walks the offset is never less than the slow process."""
    channel = replace(noisy(channel_like(rng), LEVELS, rng), walks=walks, has_landings=landings)
    for theta in rng.uniform(-3.0, 3.0, (20, 4)):
        levels = channel.levels(theta.tolist(), 2400.0)
        known = [0, 2, 3] + [1] * landings
        np.testing.assert_allclose(np.array(channel.theta(levels))[known], theta[known], atol=1e-6)
        assert not walks or levels.offset > levels.slow


def test_the_covariance_is_that_of_what_counts_from_the_first_row(rng: np.random.Generator) -> None:
    """Draws of a process that is anywhere when a run begins, less its value there and a noise of that row."""
    channel, levels, count = channel_like(rng, runs=2, windows=12, shows=True), LEVELS, 100_000
    begun = channel.start[:, None] & np.ones(count, dtype=bool)
    slow, landing = np.zeros((2, len(channel), count))
    for k in range(len(channel)):
        a = np.exp(-channel.step[k] / levels.slow_time)
        drawn = levels.slow * rng.standard_normal(count)
        slow[k] = drawn if channel.start[k] else a * slow[k - 1] + np.sqrt(1.0 - a * a) * drawn
        landing[k] = levels.landing * rng.standard_normal(count) if channel.fresh[k] else landing[k - 1]
    own = np.sqrt(levels.offset**2 - levels.slow**2) * rng.standard_normal((2, count))
    zero = np.where(begun, slow, 0.0)[channel.start][channel.run] + own[channel.run]
    white = np.sqrt(channel.alone(levels))[:, None] * rng.standard_normal((len(channel), count))
    y = channel.wander[:, None] * (slow - zero) + landing + white
    white_y, _ = channel.whitened(y, levels)
    np.testing.assert_allclose(white_y @ white_y.T / count, np.eye(len(channel)), atol=0.03)
    counted, plain = channel.counted(levels), replace(channel, shown=None)
    alone = np.diag(dense(plain, levels)).mean()
    assert np.mean(counted.variance(plain.rows) + counted.offset**2 + plain._least) == pytest.approx(alone)


def test_only_what_walks_is_asked_for_a_walk(rng: np.random.Generator) -> None:
    """A leg whose runs count from their own first rows; of one zero, or a part, what wanders is an offset apart."""
    view, _ = viewed("quiet", 2, (), 1.0)
    assert view.channel.walks
    assert not replace(view, zeroed_by_run=False).channel.walks
    assert not replace(view, kind="component").channel.walks
    channel = noisy(
        channel_like(rng, runs=9, windows=60), replace(LEVELS, slow_time=86400.0, slow=3.0, offset=3.01), rng
    )
    X, sd = np.zeros((len(channel), 1)), np.ones(1)
    assert channel.fitted(X, sd)[0].slow_time == channels.WALKING_S
    assert replace(channel, walks=False).fitted(X, sd)[0].slow_time in channels.SLOW_TIMES


def test_a_walk_that_counts_from_the_first_row_is_a_slow_process(rng: np.random.Generator) -> None:
    """Sums of independent steps from each run's first row on: as likely by the levels as by the walk's own covariance.

    A process that is anywhere when a run begins explains them worse by 10 log units or more.
    """
    channel = channel_like(rng, runs=12, windows=60)
    time = np.cumsum(channel.step) - np.cumsum(channel.step)[channel.start][channel.run]
    same = channel.run[:, None] == channel.run
    walk = 0.02**2 * np.minimum(time[:, None], time) * same + np.diag(0.2**2 / channel.rows)
    X, sd = np.zeros((len(channel), 1)), np.ones(1)
    walked = channel.with_y(np.linalg.cholesky(walk) @ rng.standard_normal(len(channel)))
    levels, _ = walked.fitted(X, sd)
    told = [multivariate_normal(None, V).logpdf(walked.y) for V in (walk, dense(walked, levels))]
    assert told[1] > told[0] - 10.0
    anywhere = replace(walked, walks=False)
    assert multivariate_normal(None, dense(anywhere, anywhere.fitted(X, sd)[0])).logpdf(walked.y) < told[1] - 10.0


def test_noise_beside_what_walked_is_as_quick_as_it_is(rng: np.random.Generator) -> None:
    """A slope in all runs, half of the noise an hour, over noise of minutes: alone it seems a walk as slow as a run.

    Beside the slope a fit that begins there ends with a shorter time, nearly as likely as any fit; one that keeps the
    time of the walk takes 8 log units or more from the slope.
    """
    quick = replace(LEVELS, slow=0.15, offset=0.2, slow_time=900.0)
    noise = noisy(channel_like(rng, runs=9, windows=60), quick, rng)
    hours = noise._since[:, None] / 3600.0
    channel, sd = noise.with_y(noise.y + 0.5 * hours[:, 0]), np.ones(1)
    walk, _ = channel.fitted(np.zeros_like(hours), sd)
    assert walk.slow_time == channels.WALKING_S
    levels, value = channel.fitted(hours, sd, walk)
    assert levels.slow_time < channels.WALKING_S
    assert value > channel.fitted(hours, sd)[1] - 5.0
    kept = channel._closer(sized(channel.y, hours, sd), walk, 200, 0.35)
    assert kept[0].slow_time == channels.WALKING_S
    assert value > kept[1] + 8.0


@pytest.mark.parametrize("tied", [True, False])
@pytest.mark.parametrize("landings", [True, False])
def test_what_a_fit_maximises_is_the_evidence(tied: bool, landings: bool, rng: np.random.Generator) -> None:
    """The value of a fit is the evidence at its levels, and no level a tenth off has more by 0.05."""
    channel = replace(noisy(channel_like(rng, runs=6), LEVELS, rng), tied_offsets=tied, has_landings=landings)
    X, sd = rng.standard_normal((len(channel), 2)), np.ones(2)
    levels, value = channel.fitted(X, sd)
    assert value == pytest.approx(channel.evidence(X, sd, levels), abs=1e-9)
    for name in ("white", "slow", "offset", *(["landing"] if landings else [])):
        for times in (0.9, 1.1):
            other = replace(levels, **{name: times * getattr(levels, name)})
            assert channel.evidence(X, sd, other) < value + 0.05


def test_landings_of_a_component_are_not_fitted(rng: np.random.Generator) -> None:
    """A component has no landings: their level stays 0."""
    base = noisy(channel_like(rng), LEVELS, rng)
    channel = replace(base, has_landings=False)
    levels, _ = channel.fitted(rng.standard_normal((len(base), 1)), np.ones(1))
    assert levels.landing == 0.0
    assert levels.white > 0.0


def test_offsets_of_runs_are_free_where_a_campaign_counts_from_one_row(rng: np.random.Generator) -> None:
    """Offsets ten times the noise are found where nothing ties them; tied, they are held towards a row's noise."""
    levels = replace(LEVELS, offset=10.0 * LEVELS.rms)
    tied = noisy(channel_like(rng, runs=12), levels, rng)
    X, sd = rng.standard_normal((len(tied), 1)), np.ones(1)
    found = replace(tied, tied_offsets=False).fitted(X, sd)[0].offset
    assert 0.2 < found / levels.offset < 3.0
    assert tied.fitted(X, sd)[0].offset < 0.8 * found


def test_a_reading_in_coarse_steps_has_a_noise(rng: np.random.Generator) -> None:
    """Most neighbours are alike: their middle difference is no noise of nothing, which no matrix bears."""
    plain = channel_like(rng)
    coarse = plain.with_y(np.round(np.sin(np.arange(len(plain)) / 7.0)))
    assert np.median(np.abs(np.diff(coarse.y))) == 0.0
    assert coarse.scale > 0.1
    X = np.column_stack([np.ones(len(plain)), np.arange(len(plain)) / len(plain), coarse.y])
    levels, evidence = coarse.fitted(X, np.full(3, 10.0))
    assert np.isfinite([levels.rms, evidence]).all()


def test_a_fit_beside_many_columns_leaves_out_only_what_says_nothing(
    rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Beside 30 columns, of which 20 have tiny priors, a fit turns to fewer: its value is the evidence of all columns,
    within 0.1 of that of a fit with all of them.
    """
    channel = noisy(channel_like(rng, runs=8, windows=60), LEVELS, rng)
    X = rng.standard_normal((len(channel), 30))
    sd = np.where(np.arange(30) < 10, 1.0, 1e-3) * LEVELS.rms
    begin = replace(LEVELS, white=1.3 * LEVELS.white, slow=0.8 * LEVELS.slow)
    assert 1 < channel._telling(sized(channel.y, X, sd), begin).shape[1] <= 11
    levels, value = channel.fitted(X, sd, begin, 200)
    assert value == pytest.approx(channel.evidence(X, sd, levels), abs=1e-9)
    near = channel.fitted(X, sd, near=begin)[1]
    monkeypatch.setattr(channels, "MANY", 1000)
    assert value > channel.fitted(X, sd, begin, 200)[1] - 0.1
    assert near > channel.fitted(X, sd)[1] - 0.1


@pytest.mark.parametrize(("landings", "tied", "walks"), [(True, True, True), (False, True, True), (True, False, False)])
def test_the_simplex_ends_where_that_of_scipy_does(
    landings: bool, tied: bool, walks: bool, rng: np.random.Generator
) -> None:
    """From the same places, without a limit: levels and log posterior are those of the library's Nelder and Mead.

    With a limit it ends soon after so many evaluations, no worse than it began.
    """
    drawn = noisy(channel_like(rng, shows=True, tied_offsets=tied, walks=walks), LEVELS, rng)
    channel = replace(drawn, has_landings=landings)
    begin, spread, axes = np.log([0.7, 0.7, 0.4, 1.0]), 0.8, np.array([0, *[1] * landings, 2, 3])
    table = np.column_stack([channel.y, rng.standard_normal((len(channel), 3))])
    own = (table, channel.start, channel.fresh, np.exp(-channel.step / 2400.0), channel.wander, 1.0 / channel.rows,
           channel._least, channel.scale, landings, tied, walks)  # fmt: skip

    def lost(point: np.ndarray) -> float:
        theta = begin.copy()
        theta[axes] = point
        return -float(whitening_loops.log_posterior(theta, *own))

    simplex = np.vstack([begin[axes], begin[axes] + spread * np.eye(len(axes))])
    options = {"maxfev": 10_000, "xatol": whitening_loops.CLOSE, "fatol": whitening_loops.CLOSE,
               "initial_simplex": simplex}  # fmt: skip
    wanted = optimize.minimize(lost, begin[axes], method="Nelder-Mead", options=options)
    theta = begin.copy()
    value = whitening_loops.likeliest(theta, spread, 10_000, *own)
    np.testing.assert_allclose(theta[axes], wanted.x, atol=1e-8)
    assert value == pytest.approx(-wanted.fun, abs=1e-8)
    assert landings or theta[1] == begin[1]
    short = begin.copy()
    value = whitening_loops.likeliest(short, spread, 12, *own)
    assert -lost(begin[axes]) <= value == pytest.approx(-lost(short[axes]))
    assert value < -wanted.fun


def test_a_noise_that_rounding_loses_is_not_the_likeliest(rng: np.random.Generator) -> None:
    """Columns of a size beyond all sense beside little noise: no error, and levels that are finite."""
    channel = noisy(channel_like(rng), LEVELS, rng)
    X = np.repeat(rng.standard_normal((len(channel), 1)), 4, axis=1)
    levels, value = channel.fitted(X, np.full(4, 1e12))
    assert np.isfinite([levels.white, levels.slow, levels.offset, value]).all()
