"""Thermometers as they and the others tell, benches of two stages, what follows the last move, and who is denied."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hexathermal.learn.diagnosis import little_errors
from hexathermal.learn.diagnosis.causes import frame_expansion, missing_sensor
from hexathermal.learn.diagnosis.evidence import LEAST
from hexathermal.learn.diagnosis.feigning import feigned_by
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.view import View
from hexathermal.learn.diagnosis.witnesses import Witnesses
from hexathermal.machine.leg_signals import LegSignals, Memory
from hexathermal.poses import FloatArray
from tests.learn.diagnosis.campaigns import altered, first_name, viewed


def _value(view: View, cause: str) -> float:
    """The evidence of a cause in the first ranking."""
    return next(item.value for item in Stage(view).step.ranking if item.cause == cause)


def _drifting(view: View, change: list[FloatArray]) -> View:
    """The view whose drift has something more in each run's rows [m]."""
    runs = tuple(replace(rows, drift=rows.drift + more) for rows, more in zip(view.runs, change, strict=True))
    return replace(view, runs=runs)


@pytest.mark.long
def test_others_help_to_tell_a_thermometer_that_wanders(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the reading of the missing thermometer wanders by 0.06 K, the others bring the cause more evidence."""
    view, answer = viewed("finite_volume", 14, ("missing-sensor",), 1.5)
    target = str(answer.targets[0])

    def wandering(run: int, signals: LegSignals) -> FloatArray:
        phase = 2.0 * np.pi * (signals.time / 7000.0 + 0.37 * run)
        return np.asarray(signals.dT[target] + 0.06 * (np.sin(phase) - np.sin(phase[0])))

    poor = altered(view, target, wandering)
    helped = _value(poor, "missing-sensor")
    assert first_name(poor) == "missing-sensor"
    monkeypatch.setattr(missing_sensor, "TOLD", ())
    assert helped > _value(altered(view, target, wandering), "missing-sensor") + LEAST


@pytest.mark.long
def test_a_bench_of_two_stages_is_told_by_two(monkeypatch: pytest.MonkeyPatch) -> None:
    """A frame that follows the room behind two equal low passes is named, with more evidence than behind one."""
    view, _answer = viewed("quiet", 21, (), 1.0)
    late = []
    for signals in view.signals:
        memory, air = Memory(), signals.recorded("air")
        skin = memory.low_pass("skin", signals.time, air, 2700.0)
        heart = memory.low_pass("heart", signals.time, skin, 2700.0)
        late.append(heart - heart[0])
    size = 2.0 * Stage(view).levels.rms / float(np.concatenate(late).std())
    two = _drifting(view, [size * one for one in late])
    value = _value(two, "frame-expansion")
    assert first_name(two) == "frame-expansion"
    monkeypatch.setattr(frame_expansion, "STAGED_S", np.inf)
    assert value > _value(_drifting(view, [size * one for one in late]), "frame-expansion") + LEAST


@pytest.mark.long
def test_what_follows_the_length_of_the_last_move_has_no_name() -> None:
    """A drift that stays by the length of the last move, either way, is no wave of the screw and no creep."""
    view, _answer = viewed("finite_volume", 12, (), 1.0)
    more = []
    for signals in view.signals:
        lengths = np.abs(Memory().lengths(signals.q))
        last = np.maximum.accumulate(np.where(lengths > 0.0, np.arange(len(lengths)), -1))
        long = np.where(last < 0, 0.0, lengths[last])
        more.append(long / (long + 0.03))
    size = 1.5 * Stage(view).levels.rms / float(np.concatenate(more).std())
    assert first_name(view) is None
    assert first_name(_drifting(view, [size * one for one in more])) == "follows the last move"


@pytest.mark.long
def test_a_loss_of_contact_that_the_drift_denies_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the part itself goes as a thermometer says, that reading fell to the air only for the other sensors."""
    view, answer = viewed("finite_volume", 13, ("sensor-detached",), 2.0)
    assert first_name(view) == "sensor-detached"
    stage = Stage(view)
    best = next(item for item in stage.step.ranking if item.cause == "sensor-detached").best
    others_tell = replace(best, trial=replace(best.trial, lessened=None))
    mended, name = stage.with_effect(others_tell).view, str(answer.targets[0])
    A, B = Stage(mended).law[0][:2]
    more = [(A * one.signals.retracted_length + B * one.signals.q) * (one.signals.dT[name] - two.signals.dT[name])
            for one, two in zip(view.runs, mended.runs, strict=True)]  # fmt: skip
    assert first_name(_drifting(view, more)) is None
    monkeypatch.setattr(Witnesses, "_in_drift", lambda _self, _trial: 1.0)
    assert first_name(_drifting(view, more)) == "sensor-detached"


@pytest.mark.long
def test_thermometers_that_let_in_some_of_the_air_are_no_bench(monkeypatch: pytest.MonkeyPatch) -> None:
    """Four hundredths of the air in every reading of a sound leg make no name; a null that knows no tape has one."""
    view = viewed("quiet", 32, (), 1.0)[0]

    def taped() -> View:
        found = view
        for sensor in view.sensors:
            found = altered(found, sensor, lambda _run, signals, name=sensor: _with_air(signals, name, 0.04))
        return found

    assert first_name(taped()) is None
    monkeypatch.setattr(little_errors, "CONTACT", 1e-9)
    assert first_name(taped()) is not None


def _with_air(signals: LegSignals, name: str, part: float) -> FloatArray:
    """A sensor's temperature with a part of the air in it."""
    return np.asarray((1.0 - part) * signals.dT[name] + part * signals.recorded("air"))


def test_what_all_thermometers_feign_is_what_wanders_beside_all_doubts(monkeypatch: pytest.MonkeyPatch) -> None:
    """What the null's own doubts explain of the drift's wandering, no shared error of the thermometers can feign."""
    view = viewed("modal", 5, (), 1.0)[0]
    bench = Stage(view).bench
    bench.slow = 1e-6
    assert feigned_by(bench, 0.0) < feigned_by(bench, 0.5e-6) <= feigned_by(bench) == feigned_by(bench, 1.0)

    def feigned(slow: float) -> float:
        """What the thermal trials of a stage may feign at most, where so much wanders beside the null's doubts."""
        stage = Stage(view)
        stage.__dict__["bench"] = bench
        stage.__dict__["_null"] = (replace(stage.levels, slow=slow), 0.0)
        return max(trial.feigned for trial in stage.search.trials if trial.cause == "missing-sensor")

    assert feigned(0.0) < feigned(0.5e-6)


def test_noisy_thermometers_are_not_asked_what_another_should_read() -> None:
    """A law that reads row by row would bring their noise into every correction; nor does it read one of no weight."""
    view, answer = viewed("finite_volume", 14, ("missing-sensor",), 1.5)
    other = next(name for name in view.sensors if name not in (*view.base, str(answer.targets[0])))
    scatter = np.random.default_rng(3)
    noisy = altered(view, other, lambda _run, signals: signals.dT[other] + scatter.normal(0.0, 0.3, len(signals)))
    bench = Stage(noisy).bench
    assert other in bench.noisy
    told = [trial.parameters["weights"] for trial in missing_sensor.trials(bench) if "weights" in trial.parameters]
    assert told
    assert all(other not in weights and all(weights.values()) for weights in told)
