"""Of causes that explain alike, the one leads that has no amplitude, was measured, or is a step; clocks ask motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from hexathermal.learn.diagnosis.channels import Levels
from hexathermal.learn.diagnosis.deciding import EVEN, SOUND, decided
from hexathermal.learn.diagnosis.evidence import LEAST, Base, Scored
from hexathermal.learn.diagnosis.feigning import ERRING, FEIGNED, erring
from hexathermal.learn.diagnosis.ranking import Ranked, Step
from hexathermal.learn.diagnosis.rivals import UNLIKELY, exchanged, lagging, late_or_off, stepping, steps_with, tilted
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.trials import STOOD, WORN, Trial
from hexathermal.machine.leg_signals import Memory
from tests.learn.diagnosis.campaigns import viewed
from tests.learn.diagnosis.noises import channel_like

LEVELS = Levels(0.1, 0.0, 0.0, 0.0)


def named(cause: str, value: float, columns: np.ndarray | None = None, advantage: float = 0.0) -> Ranked:
    """A cause that is surely there."""
    made = np.zeros((3, 0)) if columns is None else columns
    trial = Trial(cause, made, advantage=advantage)
    return Ranked(cause, value, Scored(trial, value, 20.0, 1.0, 0.0, 1.0, np.ones(made.shape[1])), LEVELS)


def first(ranked: list[Ranked]) -> str:
    """The cause of the largest evidence."""
    return max(ranked, key=lambda item: item.value).cause


@pytest.mark.parametrize("rival", ["missing-sensor", "thermal-lag"])
@pytest.mark.parametrize(("plugs", "leads"), [(90.0, True), (80.0, False), (130.0, True)])
def test_exchanged_plugs_lead_what_imitates_them(rival: str, plugs: float, leads: bool) -> None:
    """An exchange with nine tenths of the evidence of what has an amplitude leads it; with eight tenths it does not."""
    given = [named(rival, 100.0), named("swapped-sensors", plugs), named("creep", 5.0)]
    after = exchanged(given)
    assert first(after) == ("swapped-sensors" if leads else rival)
    assert sorted(item.value for item in after) == sorted(item.value for item in given)


def test_an_exchange_behind_two_rivals_leads_both() -> None:
    """It takes the place of the first of them, and both stand where it stood."""
    after = exchanged([named("missing-sensor", 100.0), named("thermal-lag", 98.0), named("swapped-sensors", 95.0)])
    assert {item.cause: item.value for item in after} == {
        "swapped-sensors": 100.0, "missing-sensor": 95.0, "thermal-lag": 95.0,
    }  # fmt: skip


def test_what_stands_for_its_rival_stands_for_an_exchange() -> None:
    """Thermometers may feign a late exchange; where a rival stands that explains no more, there is something."""
    plugs = named("swapped-sensors", 50.0)
    doubted = replace(plugs, best=replace(plugs.best, visible=0.006, trial=replace(plugs.best.trial, doubt=45.0)))
    after = {item.cause: item for item in exchanged([named("missing-sensor", 30.0), doubted])}
    assert doubted.gated < LEAST < after["swapped-sensors"].gated
    assert (after["swapped-sensors"].value, after["missing-sensor"].value) == (50.0, 30.0)
    faint = named("missing-sensor", 30.0)
    faint = replace(faint, best=replace(faint.best, visible=0.005))
    assert exchanged([faint, doubted]) == [faint, doubted]


@pytest.mark.parametrize(("tilt", "other", "leads"), [(90.0, "missing-sensor", True), (80.0, "missing-sensor", False),
                                                      (95.0, "follows the displacement", True),
                                                      (95.0, "zero-jump", False)])  # fmt: skip
def test_tilt_that_was_measured_leads_what_goes_with_it(tilt: float, other: str, leads: bool) -> None:
    """Nine tenths of the evidence are enough, also against what is nameless; a step is not handed over."""
    after = tilted([named(other, 100.0), named("abbe-tilt", tilt), named("creep", 97.0)])
    assert first(after) == ("abbe-tilt" if leads else other)


@pytest.mark.parametrize(("off", "motion", "leads"), [
    (102.0, 0.0, "thermal-lag"), (102.0, 2.0, "clock-offset"), (102.0, -2.0, "thermal-lag"),
    (112.0, -2.0, "clock-offset"), (98.0, 2.0, "thermal-lag"),
])  # fmt: skip
def test_a_clock_a_little_ahead_leads_where_motion_speaks_for_it(off: float, motion: float, leads: str) -> None:
    """Motion silent or against it: then a lag with an error of its sketch is what a shift mends."""
    ranked = [named("thermal-lag", 100.0), named("clock-offset", off, advantage=motion)]
    assert first(late_or_off(ranked, timed=False)) == leads


def late(columns: np.ndarray, shape: str, target: str = "T02") -> Ranked:
    """A lag of a thermometer that is surely there."""
    item = named("thermal-lag", 100.0, columns)
    return replace(item, best=replace(item.best, trial=replace(item.best.trial, target=target, shape=shape)))


def beside_law(law: np.ndarray) -> Callable[[Scored], Base]:
    """The law, and a trial beside it."""
    return lambda scored: Base(np.column_stack([law, scored.trial.columns]),
                               np.full(law.shape[1] + scored.trial.columns.shape[1], 10.0), law.shape[1])  # fmt: skip


@pytest.mark.parametrize("A", [2.0, -0.5])
@pytest.mark.parametrize("shape", ["lag", "foretold"])
@pytest.mark.parametrize(("part", "likely"), [
    (1.0, True), (0.4, True), (2.0, True), (0.1, False), (4.0, False), (-1.0, False),
])  # fmt: skip
def test_a_lag_acts_by_the_laws_own_coefficient(
    A: float, shape: str, part: float, likely: bool, rng: np.random.Generator
) -> None:
    """What is late is the part, or its thermometer: other amplitudes than its A, and other signs, are imitations."""
    channel = channel_like(rng, runs=4, windows=50)
    law, column = rng.standard_normal((len(channel), 2)), rng.standard_normal((len(channel), 1))
    data = channel.with_y(law @ [0.3, A] + A * part * column[:, 0] + 0.02 * rng.standard_normal(len(channel)))
    given = [late(column, shape), named("missing-sensor", 90.0)]
    after = lagging(data, beside_law(law), ("T01", "T02"), given)
    assert after[0].value == (100.0 if likely else UNLIKELY * 100.0)
    assert after[0].unlikely == (not likely)
    assert after[1] is given[1]


@pytest.mark.parametrize("grid", [30.0, 60.0, 150.0, 400.0])
@pytest.mark.parametrize(("true", "likely"), [(60.0, True), (200.0, True), (-100.0, False)])
def test_a_late_thermometer_is_likely_whatever_the_time_that_stands_for_it(
    grid: float, true: float, likely: bool, rng: np.random.Generator
) -> None:
    """By its rates behind low passes of another time: amplitudes are any, but it shows what is yet to come."""
    channel, A = channel_like(rng, runs=4, windows=50), 2.0
    time = np.arange(len(channel)) * 300.0
    reads = np.cumsum(rng.standard_normal(len(time))) / 5.0
    reads = Memory().low_pass("smooth", time, reads, 900.0)
    part = reads + true * np.gradient(reads, time)
    once = Memory().low_pass("once", time, reads, grid)
    rates = np.column_stack([reads - once, reads - Memory().low_pass("twice", time, once, grid)])
    data = channel.with_y(A * part + 1e-3 * rng.standard_normal(len(time)))
    after = lagging(data, beside_law(reads[:, None]), ("T02",), [late(rates, "lead")])
    assert after[0].unlikely == (not likely)


def test_a_lag_whose_amplitude_is_not_sure_may_act_by_the_laws_own(rng: np.random.Generator) -> None:
    """Two standard deviations are left to it; and one that reads all late, with no amplitude, is as it is."""
    channel = channel_like(rng, runs=4, windows=50)
    law = rng.standard_normal((len(channel), 1))
    data = channel.with_y(law[:, 0])
    item = late(0.004 * rng.standard_normal((len(channel), 1)), "lag", "T01")
    assert lagging(data, beside_law(law), ("T01",), [item]) == [item]
    whole = named("thermal-lag", 9.0)
    assert lagging(data, beside_law(law), ("T01",), [whole]) == [whole]


@pytest.mark.parametrize("unlikely", [True, False])
def test_an_unlikely_name_is_not_chosen_for_its_gate(unlikely: bool) -> None:
    """Of names that fit alike the one that may least be a misfit is given, unless it acts by an unlikely amplitude."""
    lag = replace(named("thermal-lag", 60.0), unlikely=unlikely)
    heat = named("hidden-heat", 61.0)
    heat = replace(heat, best=replace(heat.best, visible=0.2, trial=replace(heat.best.trial, feigned=0.05)))
    assert LEAST < heat.gated < lag.gated
    leader = decided(Step((heat, lag), LEVELS, 0.0), LEAST).leader
    assert leader is not None
    assert leader.cause == ("hidden-heat" if unlikely else "thermal-lag")


def test_time_at_each_displacement_imitates_time() -> None:
    """A name may be a little behind it, as behind what is flexible; of wear, one column as well, it must be ahead."""
    drift = named("zero-drift", 50.0)

    def nameless(cause: str, target: str) -> Ranked:
        """One column a little ahead."""
        item = named(f"follows {cause}", 51.0, np.ones((3, 1)))
        return replace(item, best=replace(item.best, trial=replace(item.best.trial, target=target)))

    stood, worn = nameless("the time at each displacement", STOOD), nameless("the way travelled", WORN)
    kink = nameless("the temperature beyond a kink", "T")
    assert decided(Step((stood, drift), LEVELS, 0.0), LEAST).named
    assert not decided(Step((worn, drift), LEVELS, 0.0), LEAST).named
    assert decided(Step((named("zero-drift", 53.0), worn), LEVELS, 0.0), LEAST).named
    assert not decided(Step((named("zero-drift", 53.0), kink), LEVELS, 0.0), LEAST).named
    assert decided(Step((named("zero-drift", 54.5), kink), LEVELS, 0.0), LEAST).named


def test_tilt_that_only_steps_is_a_step_of_the_zero(rng: np.random.Generator) -> None:
    """A beam that jumps tilts the target once; tilt that wanders beside a step of the zero stays tilt."""
    channel = channel_like(rng, runs=4, windows=50)
    step = ((channel.run == 2) & (np.arange(len(channel)) >= 120)).astype(float)
    wander = np.sin(np.arange(len(channel)) / 7.0)
    for shape, leads in ((step + 0.05 * wander, "zero-jump"), (wander + 0.1 * step, "abbe-tilt")):
        columns = np.column_stack([shape, 0.3 * shape + 0.01 * wander])
        data = channel.with_y(columns[:, 0] + 0.01 * rng.standard_normal(len(channel)))
        ranked = [named("abbe-tilt", 100.0, columns), named("zero-jump", 60.0, step[:, None])]

        def system(scored: Scored) -> Base:
            """The trial alone."""
            return Base(scored.trial.columns, np.ones(scored.trial.columns.shape[1]), 0)

        assert first(stepping(data, system, ranked)) == leads
    assert steps_with(channel, step, 3.0 - 2.0 * step)
    assert not steps_with(channel, np.zeros(len(channel)), step)
    assert not steps_with(channel, step, np.zeros(len(channel)))


def test_what_consists_of_thermometers_errors_may_be_feigned_by_half_of_them() -> None:
    """An exchange in some of the runs, and what others foretell of a reading, count beside the whole slow biases."""
    view, _ = viewed("quiet", 2, (), 1.0)
    stage = Stage(view)
    bench, trials = stage.bench, stage.search.trials
    some = next(one for one in trials if one.cause == "swapped-sensors" and "from_run" in one.parameters)
    told = next(one for one in trials if one.cause == "sensor-drift" and one.wanders)
    whole = next(one for one in trials if one.cause == "swapped-sensors" and "from_run" not in one.parameters)
    assert some.errors == (some.target, some.parameters["other"])
    assert told.errors == (told.target,)
    assert not whole.errors
    assert erring(bench, whole) == 0.0
    assert whole.feigned < told.feigned < some.feigned
    assert some.feigned == pytest.approx(np.hypot(whole.feigned, erring(bench, some)))
    assert erring(bench, told) > ERRING / FEIGNED * 0.5 * whole.feigned


def test_what_wanders_is_no_error_of_a_rate() -> None:
    """Of what the others foretell of a drifting reading counts unseen only the part that goes with time."""
    view, _ = viewed("quiet", 2, (), 1.0)
    stage = Stage(view)
    told = next(one for one in stage.search.trials if one.cause == "sensor-drift" and "rate_K_per_h" in one.parameters)
    lost, hours = told.columns[:, 0] / stage.bench.slopes_span(str(told.target)), view.time / 3600.0
    assert told.alike == pytest.approx((lost @ hours) ** 2 / (lost @ lost) / (hours @ hours))
    assert 0.0 <= told.alike <= 1.0
    witnesses, scored = stage.search.witnesses, stage.search.scored(stage._null[0], [told])[0]
    item = Ranked("sensor-drift", 50.0, scored, stage._null[0])
    part = witnesses._unseen(item, 0.0)
    straight = replace(item, best=replace(scored, trial=replace(told, alike=1.0)))
    assert part == pytest.approx(told.alike * witnesses._unseen(straight, 0.0))


@pytest.mark.parametrize("name", [101.0, 99.0])
def test_what_has_no_name_and_is_said_is_as_likely_as_not(name: float) -> None:
    """Behind a name that is hardly ahead of it, or ahead of all names: table and verdict say the same, one in all."""
    bent = named("follows the temperature beyond a kink", 100.0, np.ones((3, 1)))
    found = decided(Step((named("nonlinear-expansion", name, np.ones((3, 1))), bent), LEVELS, 0.0), LEAST)
    assert not found.named
    assert found.probability == pytest.approx(EVEN)
    assert found.probabilities[bent.cause] == pytest.approx(EVEN)
    assert sum(found.probabilities.values()) == pytest.approx(SOUND)
