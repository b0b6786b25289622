"""Noise of the law's thermometers: no drift is surer than they read; steps that noise makes up for."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hexathermal.learn.diagnosis import evidence, rivals
from hexathermal.learn.diagnosis.evidence import Scored, less_feigned
from hexathermal.learn.diagnosis.reading_noise import with_reading_noise
from hexathermal.learn.diagnosis.recorded import reading
from hexathermal.learn.diagnosis.sensor_model import SensorModel
from hexathermal.learn.diagnosis.smoothing import SMOOTHED_S
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.trials import Trial, Workbench
from hexathermal.learn.diagnosis.view import View
from tests.learn.diagnosis.campaigns import first_name, viewed

NOISE_K = 0.03


def _read_with_noise(view: View) -> View:
    """A view whose thermometers read with noise from row to row, and whose drift follows what was there exactly.

    What was there is as slow as smoothed readings are.
    """
    rng, runs = np.random.default_rng(4), []
    for rows, slow in zip(view.runs, view.signals, strict=True):
        drift = 4e-6 * np.sum([slow.dT[name] for name in view.base], axis=0)
        noise = {name: NOISE_K * rng.standard_normal(len(rows)) for name in view.sensors}
        dT = {name: values + noise[name] - noise[name][0] for name, values in slow.dT.items()}
        runs.append(replace(rows, drift=drift - drift[0], signals=replace(rows.signals, dT=dT)))
    return replace(view, runs=tuple(runs))


def _told_and_seen(found: View) -> tuple[float, float]:
    """The least noise of windows apart from each other, RMS, and what the law's residual scatters by between them."""
    assert found.floor is not None
    X, y = found.base_columns, found.channel.y
    left = y - X @ np.linalg.lstsq(X, y, rcond=None)[0]
    alone = found.channel.step > 0.5 * SMOOTHED_S
    quick = (left - np.roll(left, 1))[alone] / np.sqrt(2.0)
    return float(np.sqrt(np.mean(found.floor[alone] ** 2))), float(quick.std())


@pytest.mark.parametrize("seed", [2, 5])
def test_a_drift_is_no_surer_than_its_thermometers_read(seed: int) -> None:
    """The least noise is what the law's residual scatters by where the drift itself is exact, to the half of it."""
    found = with_reading_noise(_read_with_noise(viewed("actuator", seed, (), 1.0)[0]))
    told, scatter = _told_and_seen(found)
    assert told == pytest.approx(scatter, rel=0.5)
    assert found.channel.floor is found.floor


def _thinned(view: View, every: int) -> View:
    """A view that was recorded every so many rows."""
    runs = []
    for rows in view.runs:
        kept = slice(None, None, every)
        signals = rows.signals
        dT = {name: values[kept] for name, values in signals.dT.items()}
        air = None if signals.air is None else signals.air[kept]
        inputs = {name: values[kept] for name, values in signals.inputs.items()}
        fewer = replace(signals, time=signals.time[kept], dT=dT, q=signals.q[kept], air=air, inputs=inputs, index=None,
                        pressure_index=None, tilt=None)  # fmt: skip
        runs.append(replace(rows, signals=fewer, drift=rows.drift[kept], landing=rows.landing[kept],
                            settled=rows.settled[kept], weather=None))  # fmt: skip
    return replace(view, runs=tuple(runs))


def test_windows_of_one_parabola_tell_no_more_than_one() -> None:
    """Windows that follow each other within seconds err alike: the variances of all within half a parabola add up."""
    found = with_reading_noise(viewed("actuator", 5, (), 1.0)[0])
    assert found.floor is not None
    step, floor = found.channel.step, found.floor
    close = ~found.channel.start & (step < 0.4 * SMOOTHED_S)
    rest = step > 0.5 * SMOOTHED_S
    assert close.any()
    least = floor[rest].max()
    few = found.channel.rows < 4.0
    np.testing.assert_allclose((floor[close & few] / least) ** 2 * step[close & few], 0.5 * SMOOTHED_S)


def test_of_a_leg_whose_beams_scatter_more_little_changes() -> None:
    """An interferometer's noise is larger than what thermometers of a leg leave: the same levels, to a tenth."""
    view, _ = viewed("rough", 5, (), 1.0)
    found = with_reading_noise(view)
    assert found.floor is not None
    before, after = Stage(view).levels, Stage(found).levels
    assert 0.03 * before.rms < float(np.sqrt(np.mean(found.floor**2))) < before.rms
    assert after.rms == pytest.approx(before.rms, rel=0.1)


@pytest.mark.parametrize("every", [1, 4, 12])
def test_the_least_noise_is_what_means_of_readings_scatter_by(every: int) -> None:
    """Whether rows are smoothed or too far apart for that: drift exact, as it is read with noise, to the half of it."""
    view = _read_with_noise(_thinned(viewed("actuator", 2, (), 1.0)[0], every))
    told, scatter = _told_and_seen(with_reading_noise(view))
    assert told == pytest.approx(scatter, rel=0.6)


def test_least_squares_beside_a_least_noise_are_what_they_are_said_to_be() -> None:
    """The estimate by least squares is a sum of the data by the weights whose covariance is told."""
    stage = Stage(with_reading_noise(_read_with_noise(viewed("actuator", 2, (), 1.0)[0])))
    X, _sd = stage._plain
    mean, inverse = stage.fit(stage.plain)
    G = (X / stage.channel.alone(stage.plain)[:, None]) @ inverse
    np.testing.assert_allclose(G.T @ stage.channel.y, mean, rtol=0.02)


@pytest.mark.parametrize("share", [0.1, 0.2, 0.3, 0.32, 0.34, 0.36, 0.4, 0.8])
def test_noise_makes_up_for_steps(share: float) -> None:
    """What steps hide of a mean is as said, to the half of it, or a fortieth of a step, which chance shows.

    A temperature creeps through three steps; its readings are averaged where it stands.
    """
    step, rng = 0.05, np.random.default_rng(8)
    true = np.linspace(20.0, 20.0 + 3.0 * step, 60)
    readings = np.round((np.repeat(true, 20000) + share * step * rng.standard_normal(60 * 20000)) / step) * step
    hidden = float(np.std(readings.reshape(60, -1).mean(axis=1) - true)) * np.sqrt(12.0)
    rows: Any = SimpleNamespace(signals=SimpleNamespace(dT={"T": readings}))
    assert reading([rows], "T")[0] == pytest.approx(hidden, rel=0.7, abs=0.045 * step)


@pytest.mark.long
@pytest.mark.parametrize(("bench", "seed", "cause"), [("quiet", 3, "hidden-heat")])
def test_what_leaves_nothing_that_wanders_is_no_error_of_thermometers(
    monkeypatch: pytest.MonkeyPatch, bench: str, seed: int, cause: str
) -> None:
    """Thermometers that might err by half a kelvin, and feign three tenths of that, would wander beside any one shape.

    Strong causes are named, therefore.
    A part of many lumps is more than few profiles tell, so that what the others leave says as much of sound ones.
    """
    view, _ = viewed(bench, seed, (cause,), 1.5)
    monkeypatch.setattr(SensorModel, "bias", 0.5)
    monkeypatch.setattr(Workbench, "usual_bias", 0.5)
    monkeypatch.setattr(rivals, "SELDOM", {})
    monkeypatch.setattr(rivals, "SELDOM_ELSE", (0.0, 0.0))
    assert first_name(view) == cause
    monkeypatch.setattr(evidence, "WANDERING", 1e-12)
    assert first_name(replace(view)) is None


@pytest.mark.parametrize(("left", "part"), [(1.0, 1.0), (0.5, 1.0), (0.25, 0.5), (0.0, 0.0)])
def test_thermometers_feign_less_where_less_wanders_beside_a_trial(left: float, part: float) -> None:
    """Down to half of what wanders in the null all of it counts; from there on as much less as there is less."""
    scored = Scored(Trial("creep", np.ones((3, 1)), feigned=2e-7), 9.0, 1.0, 1.0, 1e-7, 1e-7, np.ones(1))
    assert less_feigned(scored, left * 3e-7, 3e-7, 4e-7).trial.feigned == pytest.approx(part * 2e-7)
    # where hardly anything wanders, what is left of that tells nothing
    assert less_feigned(scored, 0.0, 3e-7, 4e-6).trial.feigned == 2e-7
    assert less_feigned(scored, 0.0, 0.0, 0.0).trial.feigned == 2e-7
