"""Sets of sensors: Gram matrices against plain least squares, runs left out, missing values, ranking, choice."""

from __future__ import annotations

import dataclasses
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hexathermal.errors import ArgumentError
from hexathermal.learn.campaign import Block
from hexathermal.learn.choice import choose
from hexathermal.learn.common import fit_common
from hexathermal.learn.gram import CHUNK_ROWS, Grams, columns_for, gather
from hexathermal.learn.least_squares import least_squares
from hexathermal.learn.selection import fit_sets, pareto_front, rank_sets, sets_of
from tests.learn.legs import LEG, SENSORS, drawn_leg

COLUMNS = columns_for(SENSORS, LEG)


def cut(blocks: list[Block], size: int) -> list[Block]:
    """Return the same rows in smaller blocks."""
    names = ("time", "dT", "drift", "q", "landing", "inputs", "air")
    return [
        dataclasses.replace(block, **{name: getattr(block, name)[i : i + size] for name in names})
        for block in blocks
        for i in range(0, len(block), size)
    ]


def raw(blocks: list[Block], sensors: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Return the regression of eq. 4 on the rows themselves."""
    dT, q = np.concatenate([b.dT[:, sensors] for b in blocks]), np.concatenate([b.q for b in blocks])
    return np.concatenate([dT * LEG.retracted_length, dT * q[:, None]], axis=1), np.concatenate(
        [b.drift for b in blocks]
    )


@pytest.mark.parametrize("size", [1, 2, 3])
def test_gram_fits_equal_least_squares_on_the_rows(rng: np.random.Generator, size: int) -> None:
    """Coefficients of sets, fitted to all runs and with each left out, agree with refined QR on raw rows to 1e-9."""
    blocks = drawn_leg(rng, runs=3, hours=1.5)
    grams = gather(blocks, COLUMNS)
    sets = sets_of(grams.kept, size)[:: 1 if size == 1 else 17]
    fits = fit_sets(grams, sets)
    for out in range(-1, 3):
        kept = [block for k, block in enumerate(blocks) if k != out]
        for k, one in enumerate(sets):
            X, y = raw(kept, tuple(one))
            exact = least_squares(X, y).coefficients
            found = COLUMNS.to_law(fits.coefficients[out + 1, k])
            assert np.abs(found - exact).max() <= 1e-9 * np.abs(exact).max()


def test_errors_are_those_of_the_rows(rng: np.random.Generator) -> None:
    """RMSE, largest and mean residual, fitted and left out, are those that the rows give when each is refitted."""
    blocks = drawn_leg(rng, runs=3, hours=1.0)
    grams = gather(blocks, COLUMNS)
    ranked = rank_sets(blocks, grams)
    assert len(ranked.names) == 17 + 136
    k = ranked.names.index(("T03", "T14"))
    X, y = raw(blocks, (2, 13))
    e = y - X @ least_squares(X, y).coefficients
    assert ranked.fit.rmse[k] == pytest.approx(np.sqrt(np.mean(e**2)), rel=1e-9)
    assert ranked.fit.linf[k] == pytest.approx(np.abs(e).max(), rel=1e-9)
    assert ranked.fit.mean[k] == pytest.approx(np.abs(e).mean(), rel=1e-9)
    assert ranked.fit.largest_reduction[k] == pytest.approx(1.0 - np.abs(e).max() / np.abs(y).max(), rel=1e-9)
    left = []
    for out in range(3):
        X, y = raw([block for r, block in enumerate(blocks) if r != out], (2, 13))
        b = least_squares(X, y).coefficients
        X, y = raw([blocks[out]], (2, 13))
        left.append(y - X @ b)
    e = np.concatenate(left)
    assert ranked.left_out.rmse[k] == pytest.approx(np.sqrt(np.mean(e**2)), rel=1e-9)
    assert ranked.left_out.linf[k] == pytest.approx(np.abs(e).max(), rel=1e-9)
    assert ranked.left_out.mean_reduction[k] == pytest.approx(
        1.0 - np.abs(e).mean() / np.abs(y_all(blocks)).mean(), rel=1e-9
    )


def y_all(blocks: list[Block]) -> np.ndarray:
    return np.concatenate([block.drift for block in blocks])


@pytest.mark.parametrize("size", [7, 360, CHUNK_ROWS + 1])
def test_blocks_do_not_matter(rng: np.random.Generator, size: int) -> None:
    """Rows in blocks of any size give the same sums to rounding."""
    blocks = drawn_leg(rng, runs=2)
    whole, parts = gather(blocks, COLUMNS), gather(cut(blocks, size), COLUMNS)
    assert np.allclose(whole.matrices, parts.matrices, rtol=1e-12, atol=0.0)
    assert (whole.rows == parts.rows).all()


def test_missing_values_leave_their_rows_out_for_every_set(rng: np.random.Generator) -> None:
    """A few gaps cost their rows, for all sets alike; a sensor with many gaps is left out and named; nothing is
    silent.
    """
    blocks = drawn_leg(rng, runs=3, hours=1.0)
    for block in blocks:
        block.dT[5:8, 3] = np.nan
        block.dT[: len(block) // 3, 9] = np.nan
    grams = gather(cut(blocks, 50), COLUMNS)
    assert set(grams.left_out) == {"T10"}
    assert grams.left_out["T10"] == pytest.approx(1.0 / 3.0, abs=0.02)
    assert (grams.rows_left_out == 3).all()
    full = np.concatenate([np.delete(block.dT, 9, axis=1) for block in blocks])
    good = np.isfinite(full).all(axis=1)
    X, y = raw(blocks, (6,))
    exact = least_squares(X[good], y[good]).coefficients
    fits = fit_sets(grams, np.array([[6]]))
    assert np.allclose(COLUMNS.to_law(fits.coefficients[0, 0]), exact, rtol=1e-9)
    ranked = rank_sets(blocks, grams)
    assert all("T10" not in names for names in ranked.names)
    assert ranked.fit.rmse[ranked.names.index(("T07",))] == pytest.approx(fits.rmse[0], rel=1e-9)


def test_sensors_that_show_the_same_are_named_not_fitted(rng: np.random.Generator) -> None:
    """A pair whose columns depend on each other has no coefficients: NaN, infinite condition, never the best."""
    blocks = drawn_leg(rng, runs=3, hours=1.0)
    for block in blocks:
        block.dT[:, 4] = block.dT[:, 3]
    grams = gather(blocks, COLUMNS)
    ranked = rank_sets(blocks, grams)
    k = ranked.names.index(("T04", "T05"))
    assert np.isnan(ranked.fit.rmse[k])
    assert ranked.condition[k] == np.inf
    assert k not in ranked.front()


def test_what_cannot_be_used_is_refused(rng: np.random.Generator) -> None:
    """No rows, infinite values, every sensor full of gaps: one clear error each."""
    blocks = drawn_leg(rng, runs=1, hours=0.5)
    with pytest.raises(ArgumentError, match="no rows to learn from"):
        gather([], COLUMNS)
    bad = dataclasses.replace(blocks[0], dT=np.full_like(blocks[0].dT, np.nan))
    with pytest.raises(ArgumentError, match="every sensor lacks more than 10 %"):
        gather([bad], COLUMNS)
    bad = dataclasses.replace(blocks[0], drift=np.full_like(blocks[0].drift, np.inf))
    with pytest.raises(ArgumentError, match="infinite"):
        gather([bad], COLUMNS)
    with pytest.raises(ArgumentError, match="no displacement q"):
        gather([dataclasses.replace(blocks[0], q=None)], COLUMNS)


@given(st.lists(st.tuples(st.integers(0, 20), st.integers(0, 20)), min_size=1, max_size=30))
def test_the_front_is_what_nothing_beats(points: list[tuple[int, int]]) -> None:
    """A point is off the front exactly if another is as good in both coordinates and better in one."""
    front = set(pareto_front(np.array(points, dtype=float)))
    values = {points[k] for k in front}
    for point in points:
        beaten = any(other != point and other[0] <= point[0] and other[1] <= point[1] for other in points)
        assert (point in values) != beaten


def test_one_sensor_is_chosen_where_one_tells_all(rng: np.random.Generator) -> None:
    """Truth on one sensor: it is chosen, and no pair, although some pair always fits better; the search's own error
    is told. The gain is that of the table of sets; the searches' own is smaller.
    """
    blocks = drawn_leg(rng, runs=6)
    grams = gather(blocks, COLUMNS)
    ranked = rank_sets(blocks, grams)
    choice = choose(ranked, grams)
    assert choice.sensors == ("T07",)
    assert "not more than the spread between runs explains" in choice.reason
    single, double = (ranked.best(size) for size in (1, 2))
    assert choice.gain == pytest.approx(ranked.left_out.rmse[single] - ranked.left_out.rmse[double], abs=1e-12)
    assert choice.nested_gain < choice.gain
    assert choice.nested_rmse < 0.3e-6
    assert len(choice.nested_runs) == 6


def test_two_sensors_are_chosen_where_two_are_needed(rng: np.random.Generator) -> None:
    """Truth on the mean of a lower and an upper sensor: a pair is chosen that joins a lower and an upper one."""
    blocks = drawn_leg(rng, runs=6, true_sensors=(0, 16), landing=0.05e-6, bias=0.01)
    grams = gather(blocks, COLUMNS)
    choice = choose(rank_sets(blocks, grams), grams)
    assert len(choice.sensors) == 2
    low, high = (SENSORS.index(name) for name in choice.sensors)
    assert low < 6 < high


def test_a_common_law_is_kept_or_refused_by_runs_left_out(rng: np.random.Generator) -> None:
    """Legs of one build share a law; a leg with another expansion needs its own."""
    legs: dict[str, Grams] = {f"leg {k}": gather(drawn_leg(rng, runs=4), COLUMNS) for k in range(3)}
    same = fit_common(legs, ("T07",))
    assert same.use_common
    assert same.common == pytest.approx([2.0e-6, 1.1e-6], rel=0.2)
    legs["leg 3"] = gather(drawn_leg(rng, runs=4, A=2.6e-6), COLUMNS)
    other = fit_common(legs, ("T07",))
    assert not other.use_common
    assert other.loss > 3.0 * other.loss_uncertainty
    assert other.by_leg["leg 3"].worse


def test_a_leg_that_is_served_badly_is_not_hidden_by_the_others(rng: np.random.Generator) -> None:
    """Seven like legs with much scatter beside an odd one with little: it is found, and no common law is used."""
    legs = {f"leg {k}": gather(drawn_leg(rng, runs=4, landing=1.5e-6), COLUMNS) for k in range(7)}
    legs["odd"] = gather(drawn_leg(rng, runs=4, A=2.5e-6, landing=0.02e-6, bias=0.01), COLUMNS)
    found = fit_common(legs, ("T07",))
    assert found.by_leg["odd"].worse
    assert not found.use_common
    assert "serves odd clearly worse" in found.reason


def test_legs_are_asked_for_before_a_common_law(rng: np.random.Generator) -> None:
    """One leg is refused."""
    legs = {"leg 0": gather(drawn_leg(rng, runs=2, hours=1.0), COLUMNS)}
    with pytest.raises(ArgumentError, match="at least two legs"):
        fit_common({"one": legs["leg 0"]}, ("T07",))


def test_all_sets_are_made() -> None:
    """17 singles, 136 pairs, 680 triples, 2380 quadruples."""
    assert [len(sets_of(range(17), size)) for size in (1, 2, 3, 4)] == [17, 136, 680, 2380]
    assert [tuple(row) for row in sets_of((0, 2, 5), 2)] == list(combinations((0, 2, 5), 2))
