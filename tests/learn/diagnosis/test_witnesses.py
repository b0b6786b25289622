"""Witnesses beside the drift: other thermometers, the order along the leg, temperatures against motion."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hexathermal.learn.diagnosis import search, witnesses
from hexathermal.learn.diagnosis.along_leg import smooth_along
from hexathermal.learn.diagnosis.causes.clock_offset import OFFSETS_S
from hexathermal.learn.diagnosis.channels import Levels
from hexathermal.learn.diagnosis.evidence import LEAST, Scored
from hexathermal.learn.diagnosis.order import FEIGNED, UNSURE, Order
from hexathermal.learn.diagnosis.ranking import Ranked, most_valued
from hexathermal.learn.diagnosis.sensor_model import FEWEST_OTHERS, SensorModel, Shown, sensor_model
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.timing import Timing
from hexathermal.learn.diagnosis.trials import Trial, Workbench
from hexathermal.learn.diagnosis.view import View
from hexathermal.learn.diagnosis.witnesses import Witnesses
from hexathermal.machine.leg_signals import LegSignals
from hexathermal.poses import FloatArray
from tests.learn.diagnosis.campaigns import altered, nothing_shared, viewed

LEGS = ("modal", "finite_volume")
SEEDS = (3, 4, 5)


@pytest.fixture(scope="module")
def view() -> View:
    return viewed("modal", 3, (), 1.0)[0]


def test_a_sensor_made_of_the_others_is_foretold(view: View) -> None:
    """A thermometer that is a mixture of leading profiles is foretold to a hundredth of its range."""
    name = view.base[0]
    first = SensorModel(view, name)
    weights = first.sensor_weights(first.weights())
    mixed = altered(view, name, lambda _k, s: sum(w * s.dT[other] for other, w in weights.items()))
    model = SensorModel(mixed, name)
    for signals, told in zip(mixed.signals, model.foretold(), strict=True):
        assert np.abs(told - signals.dT[name]).max() < 0.01 * np.ptp(signals.dT[name])


def test_few_sensors_foretell_nothing(view: View) -> None:
    """With fewer than five others there is no model, rather than a bad one."""
    few = replace(view, sensors=view.sensors[:FEWEST_OTHERS])
    assert sensor_model(few, few.sensors[0]) is None
    assert sensor_model(replace(view, sensors=view.sensors[: FEWEST_OTHERS + 1]), view.sensors[0]) is not None


def test_a_drift_shows_in_its_own_parity_only(view: View) -> None:
    """A reading that walks away by 0.3 K an hour raises its parity's evidence by 10; without it, nothing does."""
    name = view.base[0]
    drifted = altered(view, name, lambda _k, s: s.dT[name] + 0.3 * s.time / 3600.0)

    def gain(of: View) -> float:
        model = SensorModel(of, name)
        hours = model.means([signals.time / 3600.0 for signals in of.signals])
        return model.shown(hours[:, None], np.array([0.2])).gain

    assert gain(drifted) > 10.0
    assert gain(drifted) > gain(view) + 10.0


def test_weights_beside_a_drift_are_not_those_of_the_fault(view: View) -> None:
    """Others foretell a reading that walks away as it was before, three times closer than weights that follow it."""
    name = view.base[0]
    drifted = altered(view, name, lambda _k, s: s.dT[name] + 0.3 * s.time / 3600.0)
    model = SensorModel(drifted, name)
    hours = model.means([signals.time / 3600.0 for signals in drifted.signals])[:, None]
    sound = [signals.dT[name] for signals in view.signals]

    def off(weights: FloatArray) -> float:
        pairs = zip(model.profiles, sound, strict=True)
        return float(np.sqrt(np.mean(np.concatenate([profiles @ weights - own for profiles, own in pairs]) ** 2)))

    assert off(model.weights_beside(hours, np.array([0.2]))) < off(model.weights()) / 3.0
    shown = model.shown(hours, np.array([0.2]))
    assert abs(shown.amplitude - 0.3) < 4.0 * shown.uncertainty < 0.15


@pytest.mark.long
def test_drift_and_parity_tell_of_one_error() -> None:
    """A thermometer that drifts errs in its parity as in the law's drift; where the zero drifts it does not."""
    faulty, answer = viewed("finite_volume", 11, ("sensor-drift",), 1.5)
    zero, _ = viewed("finite_volume", 11, ("zero-drift",), 1.5)
    fault = drift_of_a_reading(faulty)
    assert fault.best.trial.target == answer.targets[0]
    assert fault.agreed > 5.0
    assert drift_of_a_reading(zero).agreed < -1.0


def drift_of_a_reading(view: View) -> Ranked:
    """The sensor drift of a ranking."""
    return next(item for item in Stage(view).step.ranking if item.cause == "sensor-drift")


def few_thermometers(view: View) -> View:
    """The view with one thermometer more than foretell another: those of the law, and some outside it."""
    others = [name for name in view.sensors if name not in view.base]
    return replace(view, sensors=(*view.base, *others[: FEWEST_OTHERS + 1 - len(view.base)]))


@pytest.mark.long
@pytest.mark.parametrize(("bench", "seed"), [("finite_volume", 3), ("modal", 7)])
def test_without_bystanders_warmth_alike_in_all_runs_is_no_drift(
    monkeypatch: pytest.MonkeyPatch, bench: str, seed: int
) -> None:
    """Of six thermometers one warms by 0.3 K more in each run than the others tell, as the middle of a part does that
    is warmed from elsewhere: that proves no drift of its reading, where no bystander tells what is usual.
    """
    view, _answer = viewed(bench, seed, (), 1.0)
    name = view.base[0]
    warm = few_thermometers(altered(view, name, lambda _k, s: s.dT[name] - 0.3 * np.expm1(-s.time / 7200.0)))
    assert drift_of_a_reading(warm).agreed < LEAST
    monkeypatch.setattr(witnesses, "FEWEST_BYSTANDERS", 0)
    assert drift_of_a_reading(warm).agreed > 5.0 * LEAST


@pytest.mark.long
def test_a_drift_that_both_show_is_found_without_bystanders() -> None:
    """A thermometer that drifts is found among six, since the law's drift tells of the same error."""
    view, answer = viewed("modal", 13, ("sensor-drift",), 1.5)
    found = drift_of_a_reading(few_thermometers(view))
    assert found.best.trial.target == answer.targets[0]
    assert found.value > 5.0 * LEAST


@pytest.mark.parametrize("bench", LEGS)
def test_a_fault_of_the_law_s_sensor_shows_in_no_bystander(bench: str) -> None:
    """Sensors outside the law are foretold without the law's: what walks away there does not walk in them."""
    view = viewed(bench, 3, (), 1.0)[0]
    name = view.base[0]
    drifted = altered(view, name, lambda _k, s: s.dT[name] + 0.6 * s.time / 3600.0)
    sound, faulty = (Workbench(of, np.ones(4), 1e-7) for of in (view, drifted))
    for other in sound.bystanders(4):
        gains = []
        for bench_ in (sound, faulty):
            model = bench_.model(other)
            assert model is not None
            assert not set(model.others) & set(view.base)
            hours = model.means([signals.time / 3600.0 for signals in model.view.signals])
            gains.append(model.shown(hours[:, None], np.array([0.2])).gain)
        assert gains[1] == pytest.approx(gains[0], abs=1e-6)


@pytest.mark.long
def test_the_parity_alone_makes_a_fault_a_leader() -> None:
    """A thermometer that comes off near the end of the last run leads, although the drift knows nothing of it."""
    view, _ = viewed("rough", 6, (), 1.0)
    name = view.base[0]

    def off(k: int, signals: LegSignals) -> FloatArray:
        assert signals.air is not None  # of every bench
        late = (k == len(view.runs) - 1) & (signals.time > 0.94 * signals.time[-1])
        return np.where(late, 0.2 * signals.dT[name] + 0.8 * signals.air, signals.dT[name])

    step = Stage(altered(view, name, off)).step
    first = next(item for item in step.ranking if item.named)
    assert (first.cause, first.best.trial.target) == ("sensor-detached", name)
    assert first.best.value < 0.0


def test_values_are_less_sure_where_they_jump() -> None:
    """Beside a step, as between two bodies, the spread is ten times that of places on a smooth part, and holds it."""
    x = np.linspace(0.0, 1.0, 17)
    values = (0.3 * x**3 + 0.5 * (x > 0.8))[:, None]
    rest = np.flatnonzero(np.arange(17) % 4 != 1)
    at = np.flatnonzero(np.arange(17) % 4 == 1)
    told, spread = smooth_along(x, values, rest, x[at])
    near = np.abs(x[at] - 0.8) < 0.1
    assert spread[near].min() > 10.0 * spread[~near].min()
    assert (np.abs(told - values[at]) < 3.0 * spread).all()


@pytest.mark.long
@pytest.mark.parametrize("bench", LEGS)
def test_the_order_along_the_leg_tells_a_swap(bench: str) -> None:
    """Of swaps of distant thermometers the order speaks for most, and for none in a leg that is in order."""
    told = alarms = tried = 0
    for seed in SEEDS:
        view, _ = viewed(bench, seed, (), 1.0)
        placed = sorted((name for name in view.sensors if name in view.positions), key=view.positions.__getitem__)
        one, other = placed[1], placed[-2]
        exchanged = [
            {**rows.signals.dT, one: rows.signals.dT[other], other: rows.signals.dT[one]} for rows in view.runs
        ]
        swapped = replace(view, runs=tuple(replace(rows, signals=replace(rows.signals, dT=dT))
                                           for rows, dT in zip(view.runs, exchanged, strict=True)))  # fmt: skip
        tried += 1
        told += Order(swapped).advantage(one, other) > 3.0
        alarms += Order(view).advantage(one, other) > 3.0
        # whatever the drift says for it
        assert Order(view).most(one, other) == 0.0
        assert Order(swapped).most(one, other) == np.inf
    assert told >= tried - 1
    assert alarms == 0


@pytest.mark.long
def test_no_drift_names_an_exchange_that_the_order_denies() -> None:
    """Another thermometer moves the leg: it fits better than the law's own, whose plug nobody exchanged."""
    stage = Stage(viewed("modal", 924, ("missing-sensor",), 1.0)[0])
    for item in stage.search.scored(stage.step.levels, stage.search.trials):
        if item.trial.cause == "swapped-sensors" and item.trial.advantage < -UNSURE:
            assert item.value < 0.0


@pytest.mark.long
def test_an_exchange_needs_more_than_chance(view: View) -> None:
    """Wandering thermometers feign a little of an exchange: that much does not count against nothing."""
    exchanges = [trial for trial in Stage(view).search.trials if trial.cause == "swapped-sensors"]
    for trial in exchanges:
        assert gated(trial, FEIGNED + LEAST - 0.5) < LEAST < gated(trial, FEIGNED + LEAST + 0.5)
    assert exchanges


def gated(trial: Trial, value: float) -> float:
    """The evidence of a trial against nothing."""
    best = Scored(trial, value, 1e-6, 1e-7, np.nan, 0.0, np.zeros(0))
    assert best.gated == Ranked(trial.cause, value, best, Levels(1e-7, 1e-7, 1e-7, 1e-7)).gated
    return best.gated


def test_without_positions_the_order_is_silent(view: View) -> None:
    """Where no places are stated, or too few, the order says nothing for or against a swap."""
    silent = Order(replace(view, positions={}))
    assert silent.advantage(*view.sensors[:2]) == 0.0
    assert silent.most(*view.sensors[:2]) == np.inf


@pytest.mark.parametrize("offset", [-480.0, 300.0, 600.0])
def test_motion_tells_of_a_shifted_clock(view: View, offset: float) -> None:
    """Temperatures logged with another clock speak for the shift that mends them, and against one the other way."""
    shifted = view
    for name in view.sensors:
        shifted = altered(shifted, name, lambda _k, s, name=name: np.interp(s.time - offset, s.time, s.dT[name]))
    timing = Timing(shifted)
    assert timing.advantage(offset) > 3.0
    assert timing.advantage(-offset) < timing.advantage(offset) - 3.0
    assert timing.advantage(0.0) == 0.0


def test_motion_speaks_for_no_clock_where_there_is_none() -> None:
    """In legs with clocks alike no offset of two minutes or more wins 3 log units."""
    for bench in LEGS:
        timing = Timing(viewed(bench, 3, (), 1.0)[0])
        assert max(timing.advantage(sign * size) for sign in (-1.0, 1.0) for size in (120.0, 300.0, 900.0)) < 3.0


@pytest.mark.parametrize("bench", ["quiet", "modal"])
def test_motion_knows_a_clock_to_a_few_rows(bench: str) -> None:
    """Where clocks are alike motion speaks by 4 or more against temperatures read a minute earlier or later."""
    timing = Timing(viewed(bench, 3, (), 1.0)[0])
    assert max(timing.advantage(60.0), timing.advantage(-60.0)) < -4.0


@pytest.mark.long
@pytest.mark.parametrize(("bench", "seed"), [("quiet", 1378150900011671), ("modal", 4394158916904567)])
def test_a_clock_is_looked_for_on_mended_data(bench: str, seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """What the null doubts of a thermometer hides the right shift until it is mended: from the best on, more are."""
    view, answer = viewed(bench, seed, ("clock-offset",), 0.6)
    nothing_shared(monkeypatch)
    best = Stage(replace(view)).step.ranking[0]
    assert best.cause == "clock-offset"
    # the generator reads a clock later by its offset, the repair reads it earlier again
    assert best.best.trial.parameters["offset_s"] == pytest.approx(-answer.parameters[0]["offset"], rel=0.2)


@pytest.mark.long
def test_a_clock_between_two_trials_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """Trials stand a fifth apart; the one that is named is within a thirtieth of the truth."""
    view, answer = viewed("modal", 18, ("clock-offset",), 0.5)
    nothing_shared(monkeypatch)
    best = next(item for item in Stage(replace(view)).step.ranking if item.cause == "clock-offset").best.trial
    assert best.parameters["offset_s"] == pytest.approx(-answer.parameters[0]["offset"], rel=0.033)
    assert min(abs(abs(best.parameters["offset_s"]) / offset - 1.0) for offset in OFFSETS_S) > 0.03


@pytest.mark.long
def test_a_clock_that_helps_some_windows_and_harms_others_is_chance(monkeypatch: pytest.MonkeyPatch) -> None:
    """Temperatures read later fit a clean leg better by 6.7, here for the better and there for the worse: no name.

    It is asked a little more than usual: here the windows tell 2.9 standard deviations.
    """
    monkeypatch.setattr(search, "LEAST_SURE", 1.1 * search.LEAST_SURE)
    nothing_shared(monkeypatch)
    clocks = [item for item in Stage(replace(viewed("rough", 1165592194120917, (), 1.0)[0])).step.ranking
              if item.cause == "clock-offset"]  # fmt: skip
    assert clocks[0].value > 1.4 * LEAST
    assert clocks[0].best.trial.doubt > 0.0
    assert clocks[0].gated < LEAST


@pytest.mark.long
def test_a_clock_that_helps_everywhere_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a true one nothing is doubted, although it is half of the noise and asked a little more than usual."""
    monkeypatch.setattr(search, "LEAST_SURE", 1.1 * search.LEAST_SURE)
    monkeypatch.setattr(search, "SURE", 1.1 * search.SURE)
    best = Stage(viewed("rough", 1666761403684286, ("clock-offset",), 0.5)[0]).step.ranking[0]
    assert best.cause == "clock-offset"
    assert best.best.trial.doubt == 0.0
    assert best.gated > LEAST


@pytest.mark.long
def test_a_clock_between_chance_and_sure_counts_in_part() -> None:
    """A true one of a third of the noise, of which the windows tell 3.2 standard deviations, is named with a doubt."""
    best = Stage(viewed("finite_volume", 3896934736012042, ("clock-offset",), 0.32)[0]).step.ranking[0]
    assert best.cause == "clock-offset"
    assert 0.0 < best.best.trial.doubt < best.value
    assert best.gated > LEAST


@settings(deadline=None)
@given(st.lists(st.tuples(st.floats(-9, 9), st.floats(0, 9)), min_size=1, max_size=12))
def test_the_most_valued_is_found_without_asking_all(pairs: list[tuple[float, float]]) -> None:
    """Of items whose bounds are above their values the first of the largest is found, and none is asked in vain."""
    asked: list[int] = []

    def value(k: int) -> float:
        asked.append(k)
        return pairs[k][0]

    found = most_valued(range(len(pairs)), lambda k: pairs[k][0] + pairs[k][1], value)
    values = [own for own, _more in pairs]
    assert found == values.index(max(values))
    assert all(sum(pairs[k]) >= max(values) for k in asked)


@pytest.mark.long
@pytest.mark.parametrize(("seed", "strength"), [(3, 0.0), (12, 3.0), (14, 2.0)])
def test_what_the_parity_says_at_most_is_a_bound(seed: int, strength: float) -> None:
    """What counts of a late thermometer's parity is never more than that parity gains by it, nor below nothing."""
    stage = Stage(viewed("modal", seed, ("thermal-lag",) if strength else (), strength or 1.0)[0])
    asked = stage.search.witnesses
    late = [trial for trial in stage.search.trials if trial.cause == "thermal-lag" and trial.parity is not None]
    said = [(asked.spoken(item), asked.most_spoken(item)) for item in stage.search.scored(stage.levels, late)]
    assert all(0.0 <= spoken <= most for spoken, most in said)
    assert (max(spoken for spoken, _most in said) > LEAST) == (strength > 0.0)


@pytest.mark.parametrize(
    ("p", "gain", "others", "least", "most"),
    [
        (1.0, 60.0, (0.1, -0.1, 0.2), 20.0, 60.0),
        (1.0, 3.0, (0.1, -0.1, 0.2), 2.9, 3.0),
        (-0.3, 90.0, (0.02, 0.02, 0.02), 0.0, 0.1),
        (1.0, -5.0, (0.1, -0.1, 0.2), 0.0, 0.0),
        (1.0, 60.0, (0.1, -0.1), 0.0, 0.0),
        (0.4, 60.0, (0.3, -0.4, 0.2), 0.0, 0.5),
    ],
)
def test_late_is_what_shows_all_of_it(
    p: float, gain: float, others: tuple[float, ...], least: float, most: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A parity speaks for a thermometer that is late where it shows 1 of lateness, gains by it, and others do not."""
    names = [f"T{k}" for k in range(len(others) + 1)]
    shown = dict(zip(names, [Shown(gain, p, 0.05), *(Shown(1.0, size, 0.05) for size in others)], strict=True))
    bench: Any = SimpleNamespace(
        model=lambda name: SimpleNamespace(shown_of=lambda _parity: shown[name]), bystanders=lambda _most: names[1:]
    )
    nothing: Any = None
    trial = Trial("thermal-lag", np.zeros((2, 1)), "T0", parity=lambda _model: nothing, whole=True)
    monkeypatch.setattr(Witnesses, "_in_drift", lambda _self, _trial: 1.0)
    assert least <= Witnesses(bench, nothing, nothing, nothing).whole(trial) <= most
