"""Thermometers' own failings are not taken for the part's: noise, and neighbours that are none."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.campaign_laws import identify_campaign, validate_campaign
from hexathermal.learn.diagnosing import diagnose
from hexathermal.learn.diagnosis import smoothing_times
from hexathermal.learn.diagnosis import stage as stages
from hexathermal.learn.diagnosis.base_choice import likelier_sensors
from hexathermal.learn.diagnosis.evidence import LEAST
from hexathermal.learn.diagnosis.recorded import noisy_sensors, row_noise
from hexathermal.learn.diagnosis.search import REPEATED
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.view import View
from hexathermal.simulate.hidden.drawing import campaign_of
from tests.learn.diagnosis.campaigns import viewed

MEASURED = Path(__file__).parents[4] / "shared" / "measured"


def with_noise(view: View, sensor: str, noise: float, rng: np.random.Generator) -> View:
    """A view in which one thermometer is noisier [K]."""
    runs = []
    for rows in view.runs:
        dT = dict(rows.signals.dT)
        dT[sensor] = dT[sensor] + noise * rng.standard_normal(len(dT[sensor]))
        runs.append(replace(rows, signals=replace(rows.signals, dT=dT)))
    return replace(view, runs=tuple(runs))


@pytest.mark.long
def test_a_noisy_thermometer_is_not_tried_as_a_missing_one(rng: np.random.Generator) -> None:
    """A thermometer with ten times the usual noise is told apart, and no term is made of it; any other is tried."""
    view, answer = viewed("modal", 5, (), 1.0)
    noisy = next(name for name in view.sensors if name not in answer.base)
    usual = float(np.median([row_noise(view.runs, name) for name in view.sensors]))
    bad = with_noise(view, noisy, 10.0 * usual, rng)
    assert noisy_sensors(view.runs, view.sensors) == {}
    assert noisy_sensors(bad.runs, bad.sensors)[noisy][1] == pytest.approx(10.0, rel=0.1)
    tried = {trial.target for trial in Stage(bad).search.trials if trial.cause == REPEATED}
    assert tried == set(view.sensors) - {noisy, *answer.base}


def test_quick_heat_is_no_noise(rng: np.random.Generator) -> None:
    """A thermometer beside a nut, which jumps by a hundred times its noise in one row of eight, is not noisy."""
    view, answer = viewed("modal", 5, (), 1.0)
    name = next(name for name in view.sensors if name not in answer.base)
    before = row_noise(view.runs, name)
    runs = []
    for rows in view.runs:
        count = len(rows.signals.time)
        jumps = 100.0 * before * rng.standard_normal(count) * (rng.random(count) < 0.125)
        heat = np.cumsum(jumps) - np.linspace(0.0, jumps.sum(), count)
        runs.append(
            replace(rows, signals=replace(rows.signals, dT={**rows.signals.dT, name: rows.signals.dT[name] + heat}))
        )
    quick = replace(view, runs=tuple(runs))
    assert np.std(np.diff(runs[0].signals.dT[name])) > 20.0 * before
    assert noisy_sensors(quick.runs, quick.sensors) == {}


def test_what_smoothing_leaves_of_noise_is_a_parabolas(rng: np.random.Generator) -> None:
    """White noise through the view's smoothing keeps the part of its RMS that is stated."""
    view, _ = viewed("modal", 5, (), 1.0)
    sensor, size = view.sensors[0], 5.0
    once, again = (with_noise(view, sensor, size, np.random.default_rng(k)) for k in (1, 2))
    pairs = zip(once.signals, again.signals, strict=True)
    left = np.concatenate([off - off.mean() for off in (a.dT[sensor] - b.dT[sensor] for a, b in pairs)])
    assert left.std() / np.sqrt(2.0) / size == pytest.approx(view.noise_left(sensor), rel=0.15)


def test_only_thermometers_that_go_alike_are_exchanged() -> None:
    """With every other thermometer gone its own way, the law keeps the one that was chosen, wrong as it is."""
    view, answer = viewed("modal", 5, (), 1.0)
    wrong = next(name for name in view.sensors if name not in answer.base)
    assert likelier_sensors(replace(view, base=(wrong,))) == answer.base
    apart = []
    for rows in view.runs:
        time = rows.signals.time
        dT = {name: (values if name == wrong else values + 50.0 * np.sin(time / (500.0 + 40.0 * k)))
              for k, (name, values) in enumerate(rows.signals.dT.items())}  # fmt: skip
        apart.append(replace(rows, signals=replace(rows.signals, dT=dT)))
    assert likelier_sensors(replace(view, base=(wrong,), runs=tuple(apart))) == (wrong,)


@pytest.mark.long
@pytest.mark.parametrize("name", ["machine-tool-ch1", "machine-tool-ch2"])
def test_on_a_real_machine_the_extended_law_beats_the_best_pair(name: str) -> None:
    """On runs never fitted it leaves 40 % less than the best pair of the paper's search, without the noisy T16.

    The heat of the spindle is stored, not at once there; what nobody trusts or nothing shows is not named.
    """
    if not (MEASURED / name).is_dir():
        pytest.skip("the measured campaigns are not beside the checkout")
    campaign = load_campaign(MEASURED / name)
    found = diagnose(campaign)
    assert found.law.sensors == ("T06",)
    assert {one.cause for one in found.effects} == {REPEATED, "hidden-heat"}
    assert "T16" not in {one.target for one in found.effects}
    # the room's cycle shows at T04, but runs left out do without it: it is no cause
    assert all(one.joined and one.target != "T04" for one in found.effects)
    assert any("missing-sensor (T04)" in note and "not named" in note for note in found.notes)
    assert any("T16 is not trusted" in note for note in found.notes)
    ranked = identify_campaign(campaign, "auto").ranked
    pairs = {ranked.names[ranked.best(2, left_out=left_out)] for left_out in (False, True)}
    laws = [identify_campaign(campaign, pair).law for pair in pairs]
    best = min(float(validate_campaign(law, campaign).total.rmse.value) for law in laws)
    assert found.gain is not None
    assert float(found.gain.total.rmse_after.value) < 0.6 * best


def test_a_noisy_thermometer_does_not_make_the_law_of_a_part_too_small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Weights by the noise lose half of the coefficient to readings that scatter, hardly smoothed; shapes are built
    with the whole.
    """
    monkeypatch.setattr(smoothing_times, "SMOOTHING_S", smoothing_times.SMOOTHING_S[:1])
    seed = 8085561082752997
    truth, _ = campaign_of("component", seed, causes=())
    stage = Stage(replace(viewed("component", seed, (), 1.0)[0]))
    diluted = stage.fit(stage.levels)[0][0]
    assert diluted < 0.5 * truth.coefficients[0]
    assert stage.bench.slopes[truth.base[0]] == pytest.approx(truth.coefficients[0], rel=0.1)


@pytest.mark.long
def test_an_error_is_no_more_than_what_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """Errors of the law's thermometers, none to all of what others deny, leave another cause more of its evidence."""
    view, _answer = viewed("quiet", 1005, ("missing-sensor",), 0.7)
    best = Stage(view).step.ranking[0]
    assert best.cause == "missing-sensor"
    monkeypatch.setattr(stages, "DISBELIEVED", 1.0)
    assert best.value > Stage(view).step.ranking[0].value + LEAST
