"""Moments at which something may begin: none is passed over, and the parity tells the one at which contact is lost."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from threadpoolctl import threadpool_info, threadpool_limits

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.diagnosis import diagnose, diagnosing
from hexathermal.learn.diagnosis.causes import zero_jump
from hexathermal.learn.diagnosis.causes.sensor_detached import _parity
from hexathermal.learn.diagnosis.causes.zero_jump import _moments
from hexathermal.learn.diagnosis.evidence import Scored
from hexathermal.learn.diagnosis.foresight import foresight, part_saved
from hexathermal.learn.diagnosis.onsets import Onset, promising, promising_moments
from hexathermal.learn.diagnosis.sensor_model import SensorModel
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.trials import Trial, Workbench
from hexathermal.learn.diagnosis.view import View
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign
from tests.learn.diagnosis.campaigns import viewed
from tests.learn.diagnosis.test_evidence import ranked


@given(st.integers(3, 300), st.integers(0, 40), st.integers(8, 120), st.integers(0, 2**32 - 1))
def test_steps_are_looked_for_in_long_rests_too(short: int, long: int, most: int, seed: int) -> None:
    """Among many short windows and one long rest, no stretch of time beyond its share of the run is passed over."""
    rng = np.random.default_rng(seed)
    gaps = np.concatenate([rng.uniform(5.0, 40.0, short), np.full(long, 300.0)])
    time = np.cumsum(gaps)
    change = rng.exponential(size=len(time))
    change[-1] = 20.0
    chosen = _moments(time, change, 1, len(time) - 1, most)
    assert chosen.min() >= 1
    assert chosen.max() == len(time) - 1
    assert len(chosen) <= max(most, 1)
    assert np.all(np.diff(chosen) > 0)
    if len(time) - 1 >= most:
        share = (time[-1] - time[1]) / (most // 2 - 1)
        assert np.diff(time[chosen]).max(initial=0.0) <= share + gaps.max() + 1e-9


@pytest.mark.parametrize("bench", ["modal", "finite_volume"])
def test_the_parity_finds_the_moment_of_lost_contact(bench: str) -> None:
    """Of a thermometer of the law that comes off, the most promising moment is within ten minutes of the true one."""
    view, answer = viewed(bench, 5, ("sensor-detached",), 1.0)
    hidden = answer.parameters[0]
    loss = promising_moments(SensorModel(view, str(hidden["target"])), _parity, stays=True)[0]
    assert view.runs[loss.run].run.name == hidden["run"]
    assert abs(loss.moment - float(hidden["moment"])) < 600.0


def lost_for_a_run(seed: int, warmer: float) -> tuple[View, Onset]:
    """A view whose law's sensor reads 0.8 of air from an hour of its second run to that run's end.

    Each run begins with a part that is warmer than the air by so much.
    """
    view = viewed("quiet", seed, (), 1.0)[0]
    name, loss, runs = view.base[0], Onset(1, 3600.0, stays=False), []
    for k, rows in enumerate(view.runs):
        signals, weather = rows.signals, rows.weather
        assert signals.air is not None
        assert weather is not None
        cooler = weather.copy()
        cooler[:, 0] += signals.zero_of(name) - warmer - (weather[0, 0] - signals.air[0])
        off = (k == loss.run) & (signals.time >= loss.moment)
        read = np.where(off, signals.dT[name] + 0.8 * (signals.air - warmer - signals.dT[name]), signals.dT[name])
        runs.append(replace(rows, signals=replace(signals, dT={**signals.dT, name: read}), weather=cooler))
    return replace(view, runs=tuple(runs)), loss


@pytest.mark.long
@pytest.mark.parametrize("warmer", [0.0, 3.0])
def test_a_thermometer_fixed_again_is_found(warmer: float) -> None:
    """Lost for the rest of one run and fixed before the next: named, its moment and kind told, its share about 0.8.

    So where the run begins with a part that is warmer than the room.
    """
    view, loss = lost_for_a_run(21, warmer)
    model = SensorModel(view, view.base[0])
    best = max(promising(model, _parity), key=lambda one: model.shown_of(partial(_parity, one)).gain)
    assert (best.run, best.stays) == (loss.run, loss.stays)
    assert abs(best.moment - loss.moment) < 600.0
    assert model.shown_of(partial(_parity, best)).amplitude == pytest.approx(0.8, abs=0.2)
    leader = Stage(view).step.ranking[0]
    assert leader.cause == "sensor-detached"
    repair = leader.best.trial.repair
    assert repair is not None
    parameters = repair().parameters
    assert list(parameters["from_s"]) == [view.runs[loss.run].run.name]
    assert parameters["again_in"] == view.order[view.order.index(view.runs[loss.run].run.name) + 1 :]


@pytest.mark.long
def test_runs_left_out_deny_chance_and_confirm_what_is_there() -> None:
    """A random shape makes runs left out less likely, in the mean of twenty; the true shape more, and leaves less."""
    stage = Stage(viewed("quiet", 21, ("backlash",), 1.0)[0])
    leader = ranked("backlash", 10.0)
    rng = np.random.default_rng(1)

    def joined(columns: np.ndarray) -> Stage:
        size = np.full(columns.shape[1], 1e-6)
        return stage.with_effect(Scored(Trial("backlash", columns), 1.0, 1.0, 1.0, 1.0, 1.0, size))

    chance = [foresight(stage, joined(rng.standard_normal((len(stage.channel), 1))), leader) for _ in range(20)]
    true = joined(stage.view.columns("direction", {}))
    assert np.mean(chance) < 0.0
    assert foresight(stage, true, leader) > 5.0
    assert part_saved(stage, true, leader) > 0.0


@pytest.mark.long
def test_a_noise_that_forgives_the_effect_does_not_hide_it_from_runs_left_out() -> None:
    """A zero that drifts makes runs left out likelier, though the null's slow noise was fitted with the drift in it."""
    for seed in (21, 7023099979241701):
        stage = Stage(viewed("quiet", seed, ("zero-drift",), 1.3)[0])
        leader = next(item for item in stage.step.ranking if item.cause == "zero-drift")
        after = stage.with_effect(leader.best)
        assert stage.step.levels.slow > leader.levels.slow
        assert foresight(stage, after, leader) > 5.0


def test_a_step_needs_windows_behind_it() -> None:
    """Where each run has its own zero, a last reading that stands off is no step of the zero."""
    view = viewed("rough", 5, ("zero-jump",), 1.0)[0]
    assert view.zeroed_by_run
    for trial in zero_jump.trials(Workbench(view, np.ones(4), 1e-7)):
        own = trial.columns[view.channel.run == [rows.run.name for rows in view.runs].index(trial.target), 0]
        assert zero_jump.LEAST_BEHIND <= own.sum() <= len(own) - zero_jump.LEAST_BEHIND


def test_a_step_is_tried_where_the_drift_changes_most() -> None:
    """Of many short landings the moment of the largest change is among those tried, however few are."""
    rng = np.random.default_rng(7)
    time = np.cumsum(rng.uniform(30.0, 90.0, 700))
    for place in (50, 333, 690):
        change = rng.exponential(size=700)
        change[place] = 20.0
        assert place in _moments(time, change, 3, 697, 40)


@pytest.mark.long
def test_the_share_of_the_air_is_that_of_the_reading(tmp_path: Path) -> None:
    """Of a thermometer that came off the share of the air in its reading is told, not how much of the fault is real."""
    truth, answer = campaign_of("quiet", 8, causes=("sensor-detached",), strength=1.0)
    write_campaign(tmp_path / "campaign", truth, answer)
    effect = diagnose(load_campaign(tmp_path / "campaign"), answer.base).effects[0]
    assert effect.cause == "sensor-detached"
    share = effect.parameters["share"]
    assert share.value == pytest.approx(float(answer.parameters[0]["share"]), abs=4.0 * share.std + 0.03)
    assert 0.0 < share.std < 0.1


def test_a_diagnosis_takes_one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its matrices are small: threads of the linear algebra would wait for each other."""
    seen = []

    def looked(*_arguments: object) -> None:
        seen.extend(one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas")

    monkeypatch.setattr(diagnosing, "_diagnosed", looked)
    with threadpool_limits(limits=2):
        diagnose(SimpleNamespace())  # type: ignore[arg-type]
    assert seen
    assert set(seen) == {1}
