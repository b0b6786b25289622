"""Parts with a stroke: missing thermometers as what warms them tells, creep of what was clamped for a run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hexathermal.learn.diagnosis.causes import creep, missing_sensor
from hexathermal.learn.diagnosis.common_error import CommonError
from hexathermal.learn.diagnosis.evidence import LEAST
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.view import View
from hexathermal.machine.leg_signals import LegSignals
from hexathermal.poses import FloatArray
from tests.learn.diagnosis.campaigns import altered, first_name, viewed

PART = "actuator"
WANDERS_K, PERIOD_S = 0.08, 7000.0


def _wandering(sensor: str, run: int, signals: LegSignals) -> FloatArray:
    """Readings that wander slowly besides, in each run with a phase of its own."""
    phase = 2.0 * np.pi * (signals.time / PERIOD_S + 0.37 * run)
    return np.asarray(signals.dT[sensor] + WANDERS_K * (np.sin(phase) - np.sin(phase[0])))


def _value(view: View, cause: str) -> float:
    """The evidence of a cause in the first ranking."""
    return next(item.value for item in Stage(view).step.ranking if item.cause == cause)


@pytest.mark.parametrize("seed", [1, 6, 7])
def test_what_warms_a_part_helps_to_tell_its_thermometers(seed: int) -> None:
    """Of one that wanders, it and what motion and the room foretell, by half each, tell more than it does alone."""
    view, answer = viewed(PART, seed, ("missing-sensor",), 1.5)
    sensor = str(answer.targets[0])
    poor = altered(view, sensor, lambda run, signals: _wandering(sensor, run, signals))
    told = np.concatenate(CommonError(poor, (sensor,)).warmed)[:, 0]
    true, read = (np.concatenate([one.dT[sensor] for one in which.signals]) for which in (view, poor))
    assert np.std(0.5 * (told + read) - true) < 0.95 * np.std(read - true)


@pytest.mark.long
@pytest.mark.parametrize(("seed", "way"), [(1, "_told"), (7, "_warmed")])
def test_a_missing_thermometer_of_a_part_is_tried_as_others_and_what_warms_it_tell(
    monkeypatch: pytest.MonkeyPatch, seed: int, way: str
) -> None:
    """Where its reading wanders by 0.08 K, that brings the cause more evidence; the law reads thermometers still."""
    view, answer = viewed(PART, seed, ("missing-sensor",), 1.5)
    target = str(answer.targets[0])
    poor = altered(view, target, lambda run, signals: _wandering(target, run, signals))
    best = next(item for item in Stage(poor).step.ranking if item.cause == "missing-sensor")
    assert best.best.trial.shape == "temperature"
    monkeypatch.setattr(missing_sensor, way, lambda *_: iter(()))
    assert best.value > _value(replace(poor), "missing-sensor") + LEAST


@pytest.mark.long
@pytest.mark.parametrize(("tau", "size"), [(1000.0, 3.0), (3000.0, 6.0)])
def test_what_was_clamped_for_a_run_relaxes_in_parts_with_a_stroke(
    monkeypatch: pytest.MonkeyPatch, tau: float, size: float
) -> None:
    """Alike from the beginning of each run on, it is creep, not a zero that drifts."""
    view, _ = viewed(PART, 2, (), 1.0)
    height = size * Stage(view).levels.rms
    runs = tuple(replace(rows, drift=rows.drift + height * np.expm1(-rows.signals.time / tau)) for rows in view.runs)
    crept = replace(view, runs=runs)
    assert first_name(crept) == "creep"
    monkeypatch.setattr(creep, "_from_the_beginning", lambda _bench: iter(()))
    assert first_name(replace(crept)) != "creep"


def test_parts_that_never_move_warm_as_they_would_creep() -> None:
    """There nothing from the beginning of runs is tried."""
    still = next(view for view in (viewed("component", seed, (), 1.0)[0] for seed in range(20)) if not view.moves)
    assert not list(creep.trials(Stage(still).bench))
