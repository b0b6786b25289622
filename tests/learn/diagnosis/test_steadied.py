"""Rates of noisy thermometers as motion explains them, and thermometers that are late."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from hexathermal.learn.diagnosis.causes import thermal_lag
from hexathermal.learn.diagnosis.smoothing import smoothed
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.steadied import motion_of
from hexathermal.learn.diagnosis.trials import Trial
from hexathermal.learn.diagnosis.view import View
from hexathermal.machine.leg_signals import LegSignals, Memory
from hexathermal.poses import FloatArray
from tests.learn.diagnosis.campaigns import altered, viewed

TAU, NOISE_K = 330.0, 0.06


def late_and_noisy(bench: str, seed: int) -> View:
    """A sound leg whose thermometers all are late, and whose readings are noisier than their lateness is large."""
    view, _ = viewed(bench, seed, (), 1.0)
    rng = np.random.default_rng(seed)
    for sensor in view.sensors:

        def change(_k: int, signals: LegSignals, sensor: str = sensor) -> FloatArray:
            late = Memory().low_pass("late", signals.time, signals.dT[sensor], TAU)
            return late + NOISE_K * rng.standard_normal(len(late))

        view = altered(view, sensor, change)
    return view


def values(view: View) -> dict[str, float]:
    """The evidence of each cause."""
    return {item.cause: item.value for item in Stage(view).step.ranking}


@pytest.mark.long
def test_late_thermometers_that_are_noisy_are_no_heat_that_none_of_them_sees(monkeypatch: pytest.MonkeyPatch) -> None:
    """Motion tells of their rates without noise; by their own readings hidden heat would be the likelier."""
    view = late_and_noisy("quiet", 5)
    told = values(view)
    assert told["thermal-lag"] > told["hidden-heat"] + 5.0

    def none(*_given: Any) -> Iterator[Trial]:
        yield from ()

    monkeypatch.setattr(thermal_lag, "_by_motion", none)
    untold = values(late_and_noisy("quiet", 5))
    assert untold["thermal-lag"] < told["thermal-lag"] - 20.0


@pytest.mark.long
@pytest.mark.parametrize(("bench", "seed"), [("quiet", 2), ("modal", 2)])
def test_noise_of_thermometers_is_no_lateness(bench: str, seed: int) -> None:
    """Steadier temperatures explain more of a sound leg whose thermometers are noisy: none of that is lateness."""
    view, _ = viewed(bench, seed, (), 1.0)
    rng = np.random.default_rng(seed)
    for sensor in view.sensors:
        noise = [0.1 * rng.standard_normal(len(rows.drift)) for rows in view.runs]
        view = altered(view, sensor, lambda k, s, sensor=sensor, noise=noise: s.dT[sensor] + noise[k])
    assert values(view)["thermal-lag"] < 5.0


def test_a_steadied_temperature_has_the_rate_of_the_true_one() -> None:
    """Of heat of motion with noise of readings the error of the rate is a third of that of smoothed readings."""
    view, _ = viewed("quiet", 5, (), 1.0)
    rng, errors = np.random.default_rng(2), []
    true, read = [], []
    for rows in view.runs:
        memory = Memory()
        heat = memory.low_pass("heat", rows.signals.time, memory.speed(rows.signals.time, rows.signals.q), 700.0)
        true.append(2.0 * heat / 1e-4)
        read.append((true[-1] + NOISE_K * rng.standard_normal(len(heat)))[:, None])
    for rows, own, reading, steady in zip(view.runs, true, read, motion_of(view).steadied(read), strict=True):
        time = rows.signals.time
        rate, plain, best = (np.gradient(one, time) for one in
                             (own, smoothed(time, reading)[:, 0], steady[:, 0]))  # fmt: skip
        errors.append([((plain - rate) ** 2).mean(), ((best - rate) ** 2).mean()])
    plain_error, best_error = np.sqrt(np.mean(errors, axis=0))
    assert best_error < plain_error / 3.0
