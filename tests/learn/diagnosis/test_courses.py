"""Faults of thermometers that begin, wander or come late in other ways than at one rate, from the first row on."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from hexathermal.learn.diagnosis.causes.sensor_drift import (
    ASKED_AT,
    COURSES,
    STEADY,
    Course,
    _hours,
    _hours_since,
    _lessened,
)
from hexathermal.learn.diagnosis.evidence import LEAST
from hexathermal.learn.diagnosis.onsets import Onset
from hexathermal.learn.diagnosis.ranking import Ranked
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.view import View
from hexathermal.machine.leg_signals import LegSignals, Memory
from hexathermal.poses import FloatArray
from tests.learn.diagnosis.campaigns import altered, first_name, viewed


@pytest.fixture(scope="module")
def sound() -> tuple[View, str]:
    """A sound campaign of a leg whose runs have zeros of their own, and the law's thermometer."""
    view, answer = viewed("modal", 5, (), 1.0)
    return view, answer.base[0]


def leading(view: View) -> Ranked:
    """What leads at first."""
    return Stage(view).step.ranking[0]


def test_courses_begin_at_zero_and_end_at_a_rate_of_one(sound: tuple[View, str]) -> None:
    """Whatever the onset and the power; one that decays begins at it."""
    view, _ = sound
    for course in COURSES:
        rows = _hours(view, course)
        time = [signals.time / 3600.0 for signals in view.signals]
        if course.decay_runs:
            assert np.diff(rows[0])[0] == pytest.approx(np.diff(time[0])[0])
            continue
        assert rows[0][0] == 0.0
        assert np.diff(rows[-1])[-1] == pytest.approx(np.diff(time[-1])[-1], rel=0.02)
        assert all(after[0] == pytest.approx(before[-1]) for before, after in pairwise(rows))


@pytest.mark.long
def test_a_reading_that_drifts_from_an_onset_on_is_named_and_mended(sound: tuple[View, str]) -> None:
    """Nothing for two fifths of the campaign, then 0.25 K/h: runs left out leave less once it is mended."""
    view, sensor = sound
    hours = _hours(view, Course(0.0, 0.4, 1.0))
    drifting = altered(view, sensor, lambda k, s: s.dT[sensor] + 0.25 * (hours[k] - hours[k][0]))
    assert first_name(drifting) == "sensor-drift"
    stage = Stage(drifting)
    best = stage.step.ranking[0].best
    assert {"from_share", "time_s"} & best.trial.parameters.keys()
    assert stage.with_effect(best).kinder_left < 0.7 * stage.kinder_left


@pytest.mark.long
@pytest.mark.parametrize("goes_on", [True, False])
def test_a_drift_that_begins_within_a_run_is_named_with_its_moment(sound: tuple[View, str], goes_on: bool) -> None:
    """At 0.6 K/h from the middle of the third run on, to its end or on and on: told within a quarter of an hour, and
    mended from then on, with the readings before it left as they are. That many moments were looked at costs.
    """
    view, sensor = sound
    moment = float(view.signals[2].time[0] + 0.5 * np.ptp(view.signals[2].time))
    ramp = _hours_since(view, Onset(2, moment, stays=goes_on))
    drifting = altered(view, sensor, lambda k, s: s.dT[sensor] + 0.6 * ramp[k])
    stage = Stage(drifting)
    best = stage.step.ranking[0].best
    told = best.trial.parameters
    assert (stage.step.ranking[0].cause, told["run"]) == ("sensor-drift", view.runs[2].run.name)
    assert abs(told["time_s"] - moment) < 900.0
    assert told.get("ends_with_run", 0) == (not goes_on)
    assert best.trial.advantage < -math.log(ASKED_AT / 20.0)
    rate, std = stage.search.witnesses.told(best, stage.levels)
    assert abs(rate - 0.6) < 3.0 * std < 0.3
    after = stage.with_effect(best)
    assert after.kinder_left < 0.8 * stage.kinder_left
    own = after.view.runs[2].signals
    sound_before = own.time < told["time_s"]
    assert own.dT[sensor][sound_before] == pytest.approx(drifting.runs[2].signals.dT[sensor][sound_before])
    assert np.abs(own.dT[sensor] - view.runs[2].signals.dT[sensor]).max() < 0.5


def test_hours_since_an_onset_go_on_or_end_with_the_run(sound: tuple[View, str]) -> None:
    """None before; then the time since; in later runs the time since each one's begin, or since that of all."""
    view, _ = sound
    moment = float(view.signals[1].time[len(view.signals[1]) // 2])
    for own in (view, replace(view, zeroed_by_run=False)):
        for stays in (True, False):
            rows = _hours_since(own, Onset(1, moment, stays=stays))
            assert not rows[0].any()
            assert rows[1] == pytest.approx(np.maximum(own.signals[1].time - moment, 0.0) / 3600.0)
            later = (own.signals[2].time - own.signals[2].time[0]) / 3600.0
            went_on = 0.0 if own.zeroed_by_run else rows[1][-1]
            assert rows[2] == pytest.approx(stays * (later + went_on))


def test_an_error_is_taken_off_at_each_run_s_rate(sound: tuple[View, str]) -> None:
    """A run that was not looked at drifts as the one before it did; any other as the last one."""
    view, sensor = sound
    names = [rows.run.name for rows in view.runs]
    wider = replace(view, order=(*names[:2], "between", *names[2:], "after"))
    course = Course(0.0, 0.0, 1.6)
    made = _lessened(wider, sensor, course, _hours(wider, course))
    assert made is not None
    repair = made(0.2)
    own = repair.parameters["rates_K_per_h"]
    assert own["between"] == own[names[1]] < own[names[2]] < repair.parameters["rate_K_per_h"] < 0.2
    assert set(own) == {*names[:-1], "between"}
    steady = _lessened(wider, sensor, STEADY, _hours(wider, STEADY))
    assert steady is not None
    assert steady(0.2).parameters == {"sensor": sensor, "rate_K_per_h": pytest.approx(0.2)}


def wandering(size: float, rng: np.random.Generator) -> list[FloatArray]:
    """Two phases for each of up to twenty runs."""
    return [size * rng.standard_normal(2) for _run in range(20)]


@pytest.mark.long
def test_a_reading_that_wanders_is_named(sound: tuple[View, str], rng: np.random.Generator) -> None:
    """It has no shape, but its parity is looser than that of any other, and the drift knows the error's size."""
    view, sensor = sound
    waves = wandering(0.7, rng)

    def change(k: int, signals: LegSignals) -> FloatArray:
        """The reading with waves of two hours."""
        phase = 2.0 * np.pi * signals.time / 7200.0
        wave = np.column_stack([np.sin(phase), np.cos(phase) - 1.0]) @ waves[k]
        return np.asarray(signals.dT[sensor] + wave)

    wandered = altered(view, sensor, change)
    assert first_name(wandered) == "sensor-drift"
    model, before = Stage(wandered).bench.model(sensor), Stage(view).bench
    own, others = before.model(sensor), [before.model(name) for name in before.bystanders(8)]
    assert model is not None
    assert own is not None
    levels = [one.null[0] for one in others if one is not None]
    assert model.beyond(levels) > 20.0 > own.beyond(levels)


@pytest.mark.long
def test_heat_of_its_own_is_no_error_of_a_thermometer(sound: tuple[View, str], rng: np.random.Generator) -> None:
    """Where the drift follows what wanders, the law's thermometer says the truth."""
    view, sensor = sound
    waves = wandering(0.7, rng)
    runs = []
    slope = Stage(view).bench.slopes[sensor]
    for k, rows in enumerate(view.runs):
        phase = 2.0 * np.pi * rows.signals.time / 7200.0
        heat = np.column_stack([np.sin(phase), np.cos(phase) - 1.0]) @ waves[k]
        dT = {**rows.signals.dT, sensor: rows.signals.dT[sensor] + heat}
        span = rows.signals.span(Stage(view).bench.ratios[sensor])
        runs.append(replace(rows, signals=replace(rows.signals, dT=dT), drift=rows.drift + slope * span * heat))
    assert first_name(replace(view, runs=tuple(runs))) is None


@pytest.mark.long
def test_plugs_exchanged_from_a_run_on_are_found_and_put_back_there_alone(sound: tuple[View, str]) -> None:
    """The runs before keep their readings."""
    view, sensor = sound
    other = next(name for name in view.sensors if name not in view.base and name in view.positions)
    first = len(view.runs) // 2

    def exchanged(name: str, with_name: str) -> View:
        """The view with one of the two plugs in the other's place from the middle run on."""
        return altered(view, name, lambda k, s: s.dT[with_name] if k >= first else s.dT[name])

    both = exchanged(sensor, other)
    one_way = exchanged(other, sensor)
    runs = [replace(a, signals=replace(a.signals, dT={**a.signals.dT, other: b.signals.dT[other]}))
            for a, b in zip(both.runs, one_way.runs, strict=True)]  # fmt: skip
    swapped = replace(view, runs=tuple(runs))
    leader = leading(swapped)
    assert leader.cause == "swapped-sensors"
    assert leader.best.trial.repair is not None
    repair = leader.best.trial.repair()
    names = [rows.run.name for rows in view.runs]
    assert set(repair.parameters["not_in"]) & set(names) == set(names[:first])
    mended = Stage(swapped).with_effect(leader.best).view
    for before, after in zip(view.runs, mended.runs, strict=True):
        assert np.array_equal(after.signals.dT[sensor], before.signals.dT[sensor])


def late(view: View, name: str, stages: tuple[float, ...]) -> View:
    """The view with a thermometer behind low passes."""

    def change(_k: int, signals: LegSignals) -> FloatArray:
        """The reading as it comes late."""
        memory, values = Memory(), signals.dT[name]
        for number, tau in enumerate(stages):
            values = memory.low_pass(str(number), signals.time, values, tau)
        return values

    return altered(view, name, change)


@pytest.mark.long
@pytest.mark.parametrize("stages", [(90.0,), (60.0, 30.0), (40.0, 25.0, 25.0)])
def test_a_thermometer_late_by_stages_is_no_clock(stages: tuple[float, ...]) -> None:
    """A minute and a half, in one stage or in three: its shape is an exponential's, or nearly a shift's."""
    view, answer = viewed("quiet", 5, (), 1.0)
    step = Stage(late(view, answer.base[0], stages)).step
    values = {item.cause: item.value for item in step.ranking}
    assert values["thermal-lag"] > max(LEAST, values["clock-offset"])


@pytest.mark.long
def test_a_clock_that_is_off_is_no_lag() -> None:
    """A minute and a half of all thermometers alike."""
    view, _ = viewed("quiet", 5, (), 1.0)
    for name in view.sensors:
        view = altered(view, name, lambda _k, s, name=name: np.interp(s.time - 90.0, s.time, s.dT[name]))
    values = {item.cause: item.value for item in Stage(view).step.ranking}
    assert values["clock-offset"] > max(LEAST, values["thermal-lag"])


@pytest.mark.long
@pytest.mark.parametrize("gains", [-40.0, 60.0])
def test_a_clock_that_gains_or_loses_time_is_told_by_how_much(gains: float) -> None:
    """Right when a run begins, it is off by minutes at its end: neither one offset, nor a lag, nor hidden heat."""
    view, _ = viewed("quiet", 5, (), 1.0)
    for name in view.sensors:
        view = altered(
            view, name, lambda _k, s, name=name: np.interp(s.time * (1.0 - gains / 3600.0), s.time, s.dT[name])
        )
    best = Stage(view).step.ranking[0]
    assert best.cause == "clock-offset"
    assert best.best.trial.parameters["gains_s_per_h"] == pytest.approx(gains, rel=0.25)
    assert best.gated > LEAST


@pytest.mark.long
def test_a_reading_that_wanders_is_told_by_its_size(sound: tuple[View, str]) -> None:
    """No rate is told of what has none."""
    view, _sensor = sound
    trials = [trial for trial in Stage(view).search.trials if trial.wanders]
    assert {trial.target for trial in trials} == set(view.base)
    assert not any(trial.parameters for trial in trials)


@pytest.mark.long
def test_lags_of_a_thermometer_that_stands_still_are_not_tried(sound: tuple[View, str]) -> None:
    """A law may read one that is stuck: neither a term nor the law as a whole has a lag of it."""
    view, sensor = sound
    stuck = altered(view, sensor, lambda _k, s: 0.0 * s.dT[sensor])
    assert not [trial for trial in Stage(stuck).search.trials if trial.delay is not None]


@pytest.mark.parametrize(("agreed", "said", "part"), [(0.5, 0.0, 1.0), (0.5, 2.25, 0.5), (0.5, 4.0, 0.0),
                                                      (-0.5, 0.0, 0.5), (-4.0, 0.0, 0.0)])  # fmt: skip
def test_what_a_parity_could_not_show_counts_unless_it_denies_it(
    monkeypatch: pytest.MonkeyPatch, sound: tuple[View, str], agreed: float, said: float, part: float
) -> None:
    """All of a drift's evidence where the parity would say nothing, none where it would say much, or says no."""
    view, _sensor = sound
    stage = Stage(view)
    witnesses = stage.search.witnesses
    monkeypatch.setattr(type(witnesses), "would_say", lambda *_args: said)
    trial = next(one for one in stage.search.trials if one.cause == "sensor-drift" and one.in_parity)
    item = stage.search.scored(stage.levels, [trial])[0]
    assert witnesses._unseen(Ranked("sensor-drift", 10.0, item, stage.levels), agreed) == pytest.approx(part)
