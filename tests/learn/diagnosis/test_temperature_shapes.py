"""What the temperature does: expansion that bends, a kink that is none, a thermometer that is very late."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hexathermal.learn.diagnosis import witnesses
from hexathermal.learn.diagnosis.deciding import decided
from hexathermal.learn.diagnosis.evidence import LEAST
from hexathermal.learn.diagnosis.rivals import FORETOLD
from hexathermal.learn.diagnosis.spans import beside
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.temperature_shapes import AIRS, products, reached
from hexathermal.simulate.hidden.drawing import campaign_of
from tests.learn.diagnosis.campaigns import altered, nothing_shared, viewed


@pytest.mark.long
def test_runs_that_begin_at_other_temperatures_share_one_curve() -> None:
    """A bend in degC is found although each run counts from its own zero; squares of what runs count see less of it."""
    view, answer = viewed("modal", 733, ("nonlinear-expansion",), 1.2)
    stage = Stage(view)
    best, target = stage.step.ranking[0], answer.targets[0]
    assert (best.cause, best.best.trial.target) == ("nonlinear-expansion", target)
    blind = stage.bench.term("nonlinear-expansion", "square", target, sensor=target, ratio=0.0)
    assert stage.search.scored(stage.step.levels, [blind])[0].value < best.best.value - 3.0


@pytest.mark.long
def test_a_leg_calibrated_at_twenty_degrees_has_no_wrong_scale() -> None:
    """Where the bench's zero is warmer a bend takes the stroke's scale along: neither a bend nor a scale alone does."""
    view, answer = viewed("rough", 32, ("nonlinear-expansion",), 1.5)
    stage = Stage(view)
    ranked = {item.cause: item for item in stage.step.ranking}
    best = stage.step.ranking[0]
    assert (best.cause, best.best.trial.target) == ("nonlinear-expansion", answer.targets[0])
    blind = [trial for trial in stage.search.trials
             if trial.cause == best.cause and "calibration_degC" not in trial.parameters]  # fmt: skip
    scored = stage.search.scored(stage.step.levels, blind)
    assert max(*(item.value for item in scored), ranked["scale-error"].value) < best.value - 10.0


@pytest.mark.long
@pytest.mark.parametrize("seed", [733])
def test_a_kink_in_temperature_has_no_name(seed: int) -> None:
    """What begins at once above a temperature explains more than any bend does: it follows T, and stays nameless."""
    view, _ = viewed("quiet", seed, ("outside: kink",), 1.5)
    decision = decided(Stage(view).step, 6.0)
    assert decision.leader is not None
    assert not decision.named
    assert decision.leader.best.trial.target == "T"


@pytest.mark.long
@pytest.mark.parametrize("seed", [733])
def test_a_very_late_thermometer_is_named_and_the_others_speak_for_it(seed: int) -> None:
    """A lag of a third of an hour or more, of the thermometer, not of the part: neighbours alone explain it less."""
    view, answer = viewed("modal", seed, ("thermal-lag",), 1.4)
    assert answer.parameters[0]["side"] == "sensor"
    leader = decided(Stage(view).step, 6.0).leader
    assert leader is not None
    trial = leader.best.trial
    assert (trial.cause, trial.target) == ("thermal-lag", answer.targets[0])
    assert trial.shape == FORETOLD
    weights = trial.parameters["weights"]
    assert set(weights) == set(view.sensors) - {trial.target}
    assert np.isfinite(list(weights.values())).all()


@pytest.mark.long
@pytest.mark.parametrize(
    ("bench", "seed", "strength"),
    [("modal", 7837254198715841, 0.5), ("rough", 4221017415408888, 0.6)],
)
def test_a_thermometer_that_is_late_with_all_it_reads_neither_drifts_nor_is_exchanged(
    bench: str, seed: int, strength: float
) -> None:
    """Its parity grows with a run's warming as a drift's does, a neighbour fits better; it shows 1 of itself."""
    view, answer = viewed(bench, seed, ("thermal-lag",), strength)
    stage = Stage(view)
    leader = stage.step.ranking[0]
    assert (leader.cause, leader.best.trial.target, leader.best.trial.shape) == (
        "thermal-lag", answer.targets[0], FORETOLD,
    )  # fmt: skip
    assert stage.search.witnesses.whole(leader.best.trial) > LEAST
    after = stage.with_effect(leader.best)
    assert answer.targets[0] not in {trial.target for trial in after.trials_left if trial.fault}
    assert answer.targets[0] in {trial.target for trial in stage.trials_left if trial.fault}


@pytest.mark.long
def test_a_thermometer_that_shows_a_part_of_lateness_is_not_late(monkeypatch: pytest.MonkeyPatch) -> None:
    """Heat of motion that no thermometer sees: one beside the nut is late against the others, by a part of a lag."""
    view, _ = viewed("quiet", 5972132626489281, ("hidden-heat",), 0.35)
    assert Stage(view).step.ranking[0].cause == "hidden-heat"
    monkeypatch.setattr(witnesses, "PARTLY", 1e9)
    monkeypatch.setattr(witnesses, "MOST_LATE", 1e9)
    nothing_shared(monkeypatch)
    assert Stage(replace(view)).step.ranking[0].cause == "thermal-lag"


@pytest.mark.long
@pytest.mark.parametrize(("bench", "seed"), [("modal", 101), ("rough", 106)])
def test_without_bystanders_nobody_knows_a_late_thermometer_by_the_others(bench: str, seed: int) -> None:
    """Of a sound leg with four thermometers beside the law's own, none of them foretold, nothing is named."""
    view, _ = viewed(bench, seed, (), 1.0)
    outside = [name for name in view.sensors if name not in view.base]
    few = replace(view, sensors=tuple(name for name in view.sensors if name in view.base or name in outside[:4]))
    stage = Stage(few)
    late = [trial for trial in stage.search.trials if trial.whole]
    assert late
    assert {stage.search.witnesses.whole(trial) for trial in late} == {0.0}
    assert decided(stage.step, LEAST).leader is None


@pytest.mark.long
@pytest.mark.parametrize("seed", [911528681664114])
def test_a_lag_of_half_a_minute_is_no_clock(seed: int) -> None:
    """What tells a short lag from a shifted clock is as quick as the lag: it is seen in temperatures as recorded."""
    view, answer = viewed("quiet", seed, ("thermal-lag",), 0.6)
    assert answer.parameters[0]["delay"] < 60.0
    best = Stage(view).step.ranking[0]
    assert (best.cause, best.best.trial.target) == ("thermal-lag", answer.targets[0])


def test_smoothing_takes_most_of_what_a_short_lag_does() -> None:
    """Of a lag of 17 s a low pass of recorded temperatures foretells 0.97 and more, of smoothed ones 0.8 and less."""
    view, answer = viewed("quiet", 7610505900638302, ("thermal-lag",), 0.8)
    lag = {"sensor": answer.targets[0], "ratio": 0.0, "time_constant_s": 15.0, "order": 1}
    truth, _ = campaign_of("quiet", 7610505900638302, causes=("thermal-lag",), strength=0.8)
    runs = [run for run in truth.runs if run.role == "identification"]
    told = [np.interp(signals.time, run.time, run.effect) for signals, run in zip(view.signals, runs, strict=True)]
    true = beside(view.windows_zeroed(told), view.base_columns)[:, 0]
    seen = [beside(of.columns("lag", lag), view.base_columns)[:, 0] for of in (view, view.as_recorded)]
    smooth, recorded = (np.corrcoef(one, true)[0, 1] ** 2 for one in seen)
    assert recorded > 0.97
    assert smooth < 0.8


@pytest.mark.long
@pytest.mark.parametrize(
    ("bench", "stranger", "follows"),
    [("quiet", "outside: ratchet", "the highest temperature so far"),
     ("finite_volume", "outside: ratchet", "the highest temperature so far"),
     ("quiet", "outside: clamp", "the product of two temperatures")],
)  # fmt: skip
def test_what_two_temperatures_make_and_what_sets_has_no_name(bench: str, stranger: str, follows: str) -> None:
    """Of three campaigns each, at 0.8 of the noise, none has a name, and two or more are told as what they are."""
    told = []
    for seed in (801, 802, 803):
        decision = decided(Stage(viewed(bench, seed, (stranger,), 0.8)[0]).step, 6.0)
        assert not decision.named
        told.append(decision.leader is not None and decision.leader.cause == f"follows {follows}")
    assert sum(told) >= 2


def test_the_highest_temperature_so_far_stays_when_it_cools() -> None:
    """It never falls within a run, is never below the temperature, nor the lowest above it, and each run begins anew;
    where all runs count from one zero it goes on.
    """
    view, _ = viewed("quiet", 3, (), 1.0)
    sensor, run = view.base[0], view.channel.run
    for own in (view, replace(view, zeroed_by_run=False)):
        now = own.temperatures(sensor) if own is view else own.windows_zeroed([s.dT[sensor] for s in own.signals])[:, 0]
        highest, lowest = (column for _name, column in reached(own, sensor))
        together = [run == k for k in np.unique(run)] if own.zeroed_by_run else [run >= 0]
        assert all((np.diff(highest[part]) >= -1e-12).all() for part in together)
        assert all((np.diff(lowest[part]) <= 1e-12).all() for part in together)
        assert (highest >= now - 1e-9).all()
        assert (lowest <= now + 1e-9).all()
    first = np.flatnonzero(np.diff(run, prepend=-1))
    assert (highest[first[1:]] >= highest[first[1:] - 1] - 1e-12).all()


def test_a_square_is_no_product_of_two_temperatures() -> None:
    """Of places that warm alike the product is the law's square, and not asked for; the air goes its own way."""
    view, _ = viewed("quiet", 3, (), 1.0)
    one = view.base[0]
    alike = altered(view, next(name for name in view.sensors if name != one), lambda k, signals: signals.dT[one])
    twin = next(name for name in view.sensors if name != one)
    asked = [names for names, _column in products(alike)]
    assert (one, twin) not in asked
    assert any(names[1] in AIRS for names in asked)
    for names, column in products(view):
        warm = [view.temperatures(name) for name in names if name not in AIRS]
        if len(warm) == 2:
            assert column == pytest.approx(warm[0] * warm[1])
