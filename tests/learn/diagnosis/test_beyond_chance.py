"""What is said for a name counts in part whatever thermometers feign; a beam that drifts is no tilt; index and air."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hexathermal.learn.diagnosis.channels import Levels
from hexathermal.learn.diagnosis.evidence import TOLERATED, Base, Scored
from hexathermal.learn.diagnosis.ranking import Ranked
from hexathermal.learn.diagnosis.rivals import (
    MOST_INDEX,
    NAMELESS_PART,
    SELDOM,
    SELDOM_ELSE,
    UNLIKELY,
    beyond_chance,
    drifting,
    nothing_like_it,
    refracted,
    tilted,
)
from hexathermal.learn.diagnosis.trials import PREFIX, Trial
from tests.learn.diagnosis.noises import channel_like

LEVELS = Levels(0.1, 0.0, 0.0, 0.0)


def item(cause: str, value: float, columns: np.ndarray | None = None, feigned: float = 0.0) -> Ranked:
    """A cause of some evidence, of which thermometers may feign a part."""
    made = np.zeros((3, 0)) if columns is None else columns
    scored = Scored(Trial(cause, made, feigned=feigned), value, 0.1, 0.1, 0.0, 1.0, np.full(made.shape[1], 10.0))
    return Ranked(cause, value, scored, LEVELS)


@pytest.mark.parametrize("cause", ["swapped-sensors", "nonlinear-expansion", "missing-sensor", "creep"])
def test_a_part_of_what_is_said_counts_in_any_case(cause: str) -> None:
    """However much thermometers feign; never more than is said, and what stands anyway is left as it is."""
    doubted = item(cause, 90.0, feigned=1.0)
    assert doubted.gated < 1.0
    (after,) = beyond_chance([doubted])
    assert after.gated == pytest.approx(SELDOM.get(cause, SELDOM_ELSE)[0] * 90.0)
    assert after.value == 90.0
    sure = replace(doubted, best=replace(doubted.best, visible=5.0, trial=Trial(cause, np.zeros((3, 0)))))
    assert beyond_chance([sure]) == [sure]


@pytest.mark.parametrize("cause", ["swapped-sensors", "creep"])
def test_what_is_far_smaller_than_the_noise_does_not_count_so(cause: str) -> None:
    """No thermometer feigns it, but no model is exact to a twentieth of the noise either."""
    tiny = item(cause, 90.0, feigned=1.0)
    tiny = replace(tiny, best=replace(tiny.best, visible=0.01))
    (after,) = beyond_chance([tiny])
    assert after.gated == pytest.approx(0.5 * (0.01 / 0.1 / TOLERATED) ** 2)


def test_what_hardly_shows_in_the_drift_is_no_error_of_the_law() -> None:
    """However much the other thermometers say for a fault: a twentieth of the noise is the least."""
    told = replace(item("sensor-detached", 90.0), witness=90.0, both=40.0, repeated=20.0, borne=20.0)
    tiny, small = (replace(told, best=replace(told.best, visible=part * LEVELS.rms * TOLERATED)) for part in (0.9, 1.1))
    assert tiny.gated < 0.5
    assert small.gated == 90.0


def test_a_clock_and_a_lag_do_not_count_so() -> None:
    """Loggers are off by seconds everywhere: what moves little stays small."""
    given = [item("clock-offset", 90.0, feigned=1.0), item("thermal-lag", 80.0, feigned=1.0)]
    assert beyond_chance(given) == given


@pytest.mark.parametrize(
    ("cause", "nameless", "counts"),
    [("creep", 60.0, True), ("creep", 80.0, False), ("nonlinear-expansion", 85.0, True),
     ("nonlinear-expansion", 95.0, False), ("swapped-sensors", 95.0, True)],
)  # fmt: skip
def test_beside_something_without_a_name_little_counts(cause: str, nameless: float, counts: bool) -> None:
    """Flexible columns that say as much, or nearly, hold a name back that thermometers feign, but no exchange."""
    given = [item(cause, 90.0, feigned=1.0), item(f"{PREFIX}the temperature", nameless)]
    after = beyond_chance(given)
    assert (after[0].gated > 10.0) == counts
    assert after[1] == given[1]


@pytest.mark.parametrize(("name", "counts"), [(10.0, True), (70.0, True), (75.0, False)])
def test_what_is_like_no_name_counts_in_part_too(name: float, counts: bool) -> None:
    """Nothing without a name says much by chance: a part of it is real, unless a name says nearly as much."""
    given = [item(f"{PREFIX}the humidity", 90.0, feigned=1.0), item("creep", name, feigned=1.0)]
    after = nothing_like_it(given)
    assert given[0].gated < 1.0
    assert after[0].gated == pytest.approx(NAMELESS_PART * 90.0 if counts else given[0].gated)
    assert after[1] == given[1]


@pytest.mark.parametrize(
    ("straight", "drift", "leads"), [(True, 90.0, True), (True, 50.0, False), (False, 90.0, False)]
)
def test_a_beam_that_drifts_is_no_tilt(straight: bool, drift: float, leads: bool, rng: np.random.Generator) -> None:
    """What tilt explains goes as time in each run, and the drift says nearly as much: it is the drift of the zero."""
    channel = channel_like(rng, runs=4, windows=50)
    time = np.tile(np.linspace(0.0, 1.0, 50), 4)
    tilt = (time if straight else np.sin(40.0 * time))[:, None]
    data = channel.with_y(tilt[:, 0] + 0.05 * rng.standard_normal(len(time)))
    base = Base(rng.standard_normal((len(time), 1)), np.ones(1), 1)
    given = [item("abbe-tilt", 100.0, tilt), item("zero-drift", drift, time[:, None])]
    given = [replace(one, best=replace(one.best, visible=5.0)) for one in given]
    after = drifting(data, lambda scored: base.extended(scored.trial.columns, scored.size), given)
    first = max(tilted(after), key=lambda one: one.value).cause
    assert first == ("zero-drift" if leads else "abbe-tilt")
    assert sorted(one.value for one in after) == sorted(one.value for one in given)


@pytest.mark.parametrize(("share", "likely"), [(0.9, True), (MOST_INDEX + 0.5, False), (-MOST_INDEX - 0.5, False)])
def test_no_path_lacks_far_more_than_its_index(share: float, likely: bool, rng: np.random.Generator) -> None:
    """A thermometer in the air leaves what goes with it, by any amount: as an index it counts for less."""
    channel = channel_like(rng, runs=4, windows=50)
    column = rng.standard_normal((len(channel), 1))
    data = channel.with_y(share * column[:, 0] + 0.02 * rng.standard_normal(len(channel)))
    base = Base(rng.standard_normal((len(channel), 1)), np.ones(1), 1)
    (after,) = refracted(
        data, lambda scored: base.extended(scored.trial.columns, scored.size), [item("air-refraction", 50.0, column)]
    )
    assert after.unlikely != likely
    assert after.value == pytest.approx(50.0 if likely else UNLIKELY * 50.0)


@pytest.mark.parametrize(("share", "weather", "counts"), [
    (0.9, {"weather": "pressure"}, True), (-0.9, {"weather": "pressure"}, False), (-0.9, {}, True),
    (-0.003, {"weather": "pressure"}, True),
])  # fmt: skip
def test_a_pressure_that_acts_the_wrong_way_round_was_left_out_of_no_index(
    share: float, weather: dict[str, str], counts: bool, rng: np.random.Generator
) -> None:
    """Alone it presses, and is nameless; the whole index may have been taken off twice."""
    channel = channel_like(rng, runs=4, windows=50)
    column = rng.standard_normal((len(channel), 1))
    data = channel.with_y(share * column[:, 0] + 0.02 * rng.standard_normal(len(channel)))
    base = Base(rng.standard_normal((len(channel), 1)), np.ones(1), 1)
    air = item("air-refraction", 50.0, column)
    air = replace(air, best=replace(air.best, trial=replace(air.best.trial, parameters=weather)))
    (after,) = refracted(data, lambda scored: base.extended(scored.trial.columns, scored.size), [air])
    assert after.value == pytest.approx(50.0 if counts else 0.0)
