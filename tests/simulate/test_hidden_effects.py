"""Effects that a campaign may hide: each changes what it should alone; thermometers go wrong as their physics says."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import pytest

from hexathermal.errors import UnknownNameError
from hexathermal.simulate.hidden.effects import OUTSIDE, found, named
from hexathermal.simulate.hidden.shapes import cascade, diffused, first_order
from hexathermal.simulate.hidden.strength import added, recorded
from hexathermal.simulate.hidden.truth import CampaignTruth
from tests.simulate.hidden_effects import hidden, made_up, with_channel

CATALOGUE = (
    "thermal-lag", "missing-sensor", "hidden-heat", "nonlinear-expansion", "frame-expansion", "air-refraction",
    "abbe-tilt", "backlash", "periodic-screw-error", "scale-error", "creep", "zero-drift", "zero-jump", "clock-offset",
    "sensor-drift", "sensor-detached", "swapped-sensors",
)  # fmt: skip

READINGS = ("clock-offset", "sensor-drift", "sensor-detached", "swapped-sensors")
KEPT = ("time", "q", "settled", "temperatures", "air", "inputs", "drift", "noise")


def test_the_catalogue_is_complete() -> None:
    """There is an effect for every cause of the catalogue, at least six that none explains, and no other."""
    names = found()
    outside = [name for name in names if name.startswith(OUTSIDE)]
    assert sorted(CATALOGUE) == sorted(set(names) - set(outside))
    assert len(outside) >= 6


def test_an_unknown_name_is_refused() -> None:
    """A name that no effect has is told, with those there are."""
    with pytest.raises(UnknownNameError, match="backlash"):
        named("back-lash")


def test_what_hides_does_not_see_what_finds() -> None:
    """Nothing of `hexathermal.learn` is loaded where campaigns with hidden effects are drawn."""
    code = (
        "import sys; from hexathermal.simulate.hidden import drawing, writing, effects, benches;"
        "effects.found(); benches.found();"
        "print([name for name in sys.modules if name.startswith('hexathermal.learn')])"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert said.stdout.strip() == "[]"


@pytest.mark.parametrize("name", [*CATALOGUE, *(name for name in found() if name.startswith(OUTSIDE))])
def test_an_effect_changes_what_it_should_alone(
    name: str, leg: CampaignTruth, component: CampaignTruth, generator: np.random.Generator
) -> None:
    """The truth of heat, motion, law and noise stays; the same parameters hide the same; readings or drift change."""
    effect, possible = named(name), 0
    for truth in (leg, component):
        if not effect.possible(truth):
            continue
        possible += 1
        for _draw in range(4):
            parameters = effect.draw(truth, generator)
            assert json.loads(json.dumps(parameters)) == parameters
            found, again = effect.hide(truth, parameters), effect.hide(truth, parameters)
            changed = {"effect": 0.0, "sensor_errors": 0.0}
            for before, run, same in zip(truth.runs, found.runs, again.runs, strict=True):
                assert all(np.array_equal(getattr(before, key), getattr(run, key)) for key in KEPT)
                np.testing.assert_array_equal(recorded(run), recorded(same))
                np.testing.assert_array_equal(added(run), added(same))
                changed["effect"] += float(np.ptp(added(run)))
                changed["sensor_errors"] += float(np.abs(run.sensor_errors - before.sensor_errors).max())
            read = name in READINGS or parameters.get("side") == "sensor"
            assert (changed["effect"] > 0.0, changed["sensor_errors"] > 0.0) == (not read, read)
            assert ("target" not in parameters) or parameters["target"] in truth.sensors
    assert possible


@pytest.mark.parametrize("form", ["cascade", "diffusion"])
@pytest.mark.parametrize("side", ["sensor", "structure"])
def test_lag_is_the_delay_of_a_ramp(form: str, side: str, leg: CampaignTruth, generator: np.random.Generator) -> None:
    """A ramp of temperature is followed by the stated delay, by the sensor or by the structure; both are smooth."""
    still = made_up(leg, lambda time: np.full(time.size, 0.1))
    sensor, time = still.base[0], still.runs[0].time
    # 1 K/h, flat before
    warm = with_channel(still, sensor, 20.0 + np.clip(time - 1800.0, 0.0, None) / 3600.0)
    truth, _ = hidden("thermal-lag", warm, generator, form=form, side=side, target=sensor, delay=900.0)
    (run,), (before,) = truth.runs, warm.runs
    if side == "sensor":
        behind = (run.sensor_errors - before.sensor_errors)[:, truth.sensors.index(sensor)]
    else:
        count = len(truth.base)
        slope = truth.retracted_length * truth.coefficients[0] + 0.1 * truth.coefficients[count]
        behind = run.effect / slope
    assert behind[-1] * 3600.0 == pytest.approx(-900.0, rel=0.03)
    assert np.abs(behind[time < 1800.0]).max() < 1e-9
    assert np.abs(np.diff(behind)).max() <= 5.0 / 3600.0 + 1e-12


def test_first_order_is_exact_of_straight_pieces() -> None:
    """Of a ramp from equilibrium, ``tau y' = x - y`` gives ``t - tau (1 - exp(-t / tau))``, rows missing or not."""
    time = np.arange(0.0, 3000.0, 20.0)
    exact = time - 300.0 * (1.0 - np.exp(-time / 300.0))
    np.testing.assert_allclose(first_order(time, time, 300.0), exact, atol=1e-9)
    kept = np.delete(np.arange(time.size), [40, 41, 90])
    np.testing.assert_allclose(first_order(time[kept], time[kept], 300.0), exact[kept], atol=1e-9)


def test_slab_and_cascade_differ_in_form_not_in_delay() -> None:
    """A slab answers a step at once and ends late; the cascade begins slowly: more than 5 % apart at the same delay."""
    time = np.arange(0.0, 7200.0, 10.0)
    step = np.where(time > 0.0, 1.0, 0.0)
    slab, stages = diffused(time, step, 600.0), cascade(time, step, (372.0, 168.0, 60.0))
    assert np.abs(slab - stages).max() > 0.05
    for answer in (slab, stages):
        assert (1.0 - answer).sum() * 10.0 == pytest.approx(600.0, rel=0.02)


def test_a_clock_offset_is_found_by_cross_correlation(leg: CampaignTruth, generator: np.random.Generator) -> None:
    """Readings follow the true temperatures shifted by the offset, either sign, within one row; noise stays."""
    for offset in (-300.0, -45.0, 60.0, 600.0):
        truth, _ = hidden("clock-offset", leg, generator, offset=offset)
        j, run = truth.sensors.index(truth.base[0]), truth.runs[0]
        step = float(run.time[1] - run.time[0])
        true, read = np.diff(run.temperatures[:, j]), np.diff(run.temperatures[:, j] + run.sensor_errors[:, j])
        shifts = np.arange(-200, 201)
        inner = slice(250, -250)
        apart = [float(np.square(np.roll(true, -k)[inner] - read[inner]).sum()) for k in shifts]
        assert abs(shifts[int(np.argmin(apart))] * step - offset) <= step
        later = np.interp(run.time + offset, run.time, run.temperatures[:, j])[inner]
        noise = (run.sensor_errors - leg.runs[0].sensor_errors)[inner, j]
        np.testing.assert_allclose(noise, later - run.temperatures[inner, j], atol=1e-9)


@pytest.mark.parametrize("fixed", [False, True])
def test_a_detached_sensor_reads_air_until_it_is_fixed(
    leg: CampaignTruth, generator: np.random.Generator, fixed: bool
) -> None:
    """Before the moment nothing changes; long after it the stated share of air is read, in later runs if it stays."""
    truth, parameters = hidden("sensor-detached", leg, generator, fixed=fixed)
    j = truth.sensors.index(str(parameters["target"]))
    which = [run.name for run in truth.runs].index(str(parameters["run"]))
    share = float(parameters["share"])
    assert truth.runs[which].role == "identification"
    assert 0.7 <= share <= 1.0
    for k, (before, run) in enumerate(zip(leg.runs, truth.runs, strict=True)):
        moved = (run.sensor_errors - before.sensor_errors)[:, j]
        off = run.time - run.time[0] - float(parameters["moment"])
        whole = share * (run.air[:, 0] - run.temperatures[:, j])
        if k < which:
            assert not moved.any()
        elif k > which:
            np.testing.assert_allclose(moved, 0.0 if fixed else whole, atol=1e-12)
        else:
            assert not moved[off < 0.0].any()
            late = off > 10.0 * float(parameters["time"])
            np.testing.assert_allclose(moved[late], whole[late], atol=1e-3)


def test_swapped_sensors_are_exchanged(leg: CampaignTruth, generator: np.random.Generator) -> None:
    """A sensor of the law and another one show each other's readings, errors and all, in every run."""
    truth, parameters = hidden("swapped-sensors", leg, generator)
    a, b = (truth.sensors.index(str(parameters[name])) for name in ("target", "other"))
    assert truth.sensors[a] in truth.base
    assert truth.sensors[b] not in truth.base
    for before, run in zip(leg.runs, truth.runs, strict=True):
        np.testing.assert_allclose(recorded(run)[:, [a, b]], recorded(before)[:, [b, a]], atol=1e-12)


def test_a_sensor_drifts_within_its_bounds(leg: CampaignTruth, generator: np.random.Generator) -> None:
    """The error of one sensor follows the trend over the campaign, the walk never farther from it than stated."""
    truth, parameters = hidden("sensor-drift", leg, generator, alone=-1)
    j, drift = truth.sensors.index(str(parameters["target"])), float(parameters["drift"])
    lengths = [float(run.time[-1] - run.time[0]) for run in leg.runs]
    gone, onset = 0.0, float(parameters["onset"]) * sum(lengths)
    for before, run in zip(leg.runs, truth.runs, strict=True):
        trend = drift * np.maximum(gone + run.time - run.time[0] - onset, 0.0) / np.mean(lengths)
        walk = (run.sensor_errors - before.sensor_errors)[:, j] - trend
        assert np.abs(walk).max() <= abs(drift) * float(parameters["wandering"]) + 1e-12
        assert np.ptp(walk) > 0.0
        gone += float(run.time[-1] - run.time[0])


def test_a_sensor_may_drift_in_one_run_alone(leg: CampaignTruth, generator: np.random.Generator) -> None:
    """Not before its onset there, and not in any other run."""
    truth, parameters = hidden("sensor-drift", leg, generator, alone=1, onset=0.4, wandering=0.0)
    j, drift = truth.sensors.index(str(parameters["target"])), float(parameters["drift"])
    mean = np.mean([run.time[-1] - run.time[0] for run in leg.runs])
    for k, (before, run) in enumerate(zip(leg.runs, truth.runs, strict=True)):
        since = np.maximum(run.time - run.time[0] - 0.4 * (run.time[-1] - run.time[0]), 0.0)
        error = (run.sensor_errors - before.sensor_errors)[:, j]
        np.testing.assert_allclose(error, (k == 1) * drift * since / mean, atol=1e-12)
