"""Parts that move by ten times a leg's micrometres for a kelvin: what their thermometers feign is no cause."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.diagnosing import diagnose
from hexathermal.learn.diagnosis import course, witnesses
from hexathermal.learn.diagnosis import stage as stages
from hexathermal.learn.diagnosis.evidence import LEAST
from hexathermal.learn.diagnosis.ranking import Ranked
from hexathermal.learn.diagnosis.sensor_model import SensorModel
from hexathermal.learn.diagnosis.stage import Stage, view_of
from hexathermal.learn.diagnosis.trials import Trial, Workbench
from hexathermal.learn.diagnosis.view import View
from hexathermal.learn.signals import campaign_rows
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.strength import exact_readings
from hexathermal.simulate.hidden.writing import write_campaign
from tests.learn.diagnosis.campaigns import first_name, viewed

PART = "component"


@pytest.mark.long
def test_a_thermometer_that_is_late_against_all_others_is_not_late_where_the_drift_shows_nothing_of_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A sound one deep in a part shows all of lateness in its parity; the part moves with what it reads."""
    view, _ = viewed(PART, 8141239550369383, (), 1.0)
    assert first_name(view) is None
    monkeypatch.setattr(witnesses, "IN_DRIFT", 1e-9)
    assert first_name(view) == "thermal-lag"


def test_the_room_is_no_better_reading_of_a_thermometer_that_the_air_reaches(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a sound part whose law reads such a thermometer the bench does not follow the room."""
    view, _ = viewed(PART, 1848962564601164, (), 1.0)
    assert first_name(view) is None
    monkeypatch.setattr(SensorModel, "_told_beside_air", property(SensorModel.foretold))
    assert first_name(replace(view)) == "frame-expansion"


@pytest.mark.long
def test_thermometers_that_wander_from_run_to_run_are_no_wear(monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs of a sound part count from one zero; its thermometers wander by a tenth of a kelvin."""
    view, _ = viewed(PART, 7873671558253397, (), 1.0)
    assert not view.zeroed_by_run
    assert first_name(view) is None
    monkeypatch.setattr(stages, "FIRST_ROW", 1e-9)  # which would explain a part of it
    assert _wear(replace(view)).gated < LEAST
    monkeypatch.setattr(Workbench, "wandered", 0.0)
    assert _wear(replace(view)).gated > LEAST


def _wear(view: View) -> Ranked:
    """How the way travelled stands in the first ranking."""
    return next(item for item in Stage(view).step.ranking if item.cause == "follows the way travelled")


def test_where_each_run_has_a_zero_nothing_wanders_from_run_to_run() -> None:
    """Thermometers of a leg count anew with each run."""
    assert Stage(viewed("quiet", 3, (), 1.0)[0]).bench.wandered == 0.0


def test_beside_what_may_be_feigned_nothing_says_more() -> None:
    """Two columns together may be a better thermometer: alone they said less, and so they do."""
    stage = Stage(viewed(PART, 7873671558253397, (), 1.0)[0])
    before = {item.cause: item.value for item in stage.step.ranking}
    best = stage.step.ranking[0].best
    freely = {item.cause: item.value for item in stage.tolerating(best).step.ranking}
    assert max(freely[name] - before.get(name, 0.0) for name in freely) > LEAST
    after = stage.tolerating(best, feigned=True)
    assert all(item.value <= before.get(item.cause, 0.0) for item in after.step.ranking)
    values = [item.value for item in after.step.ranking]
    assert values == sorted(values, reverse=True)
    # what joins later, or is named beside, is another matter
    assert after.with_effect(best).most is None
    assert after.beside(best).most is None
    assert best.trial.cause in after.beside(best).refused


@pytest.mark.long
def test_a_second_cause_is_found_where_the_first_one_joins_no_law(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A lag of half a minute, refused by runs left out, hides no tilt of the beams."""
    asked = course.worth
    monkeypatch.setattr(course, "worth", lambda *stages, later: asked(*stages, later=True) if later else (True, False))
    seed = 4878761273465753
    truth, answer = campaign_of("quiet", seed, causes=("abbe-tilt", "thermal-lag"), strength=1.6)
    write_campaign(tmp_path / "campaign", truth, answer)
    found = diagnose(load_campaign(tmp_path / "campaign"), list(answer.base))
    assert [one.cause for one in found.effects] == ["thermal-lag", "abbe-tilt"]
    assert [one.joined for one in found.effects] == [False, True]


@pytest.mark.long
@pytest.mark.parametrize(("bench", "seed", "cause"), [("quiet", 14, "clock-offset"), ("quiet", 16, "swapped-sensors")])
def test_no_second_cause_is_looked_for_in_data_that_the_first_one_would_mend(
    bench: str, seed: int, cause: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A repair that does not join leaves its error in the data, where it would look like something else."""
    truth, answer = campaign_of(bench, seed, causes=(cause,), strength=1.5)
    write_campaign(tmp_path / "campaign", truth, answer)
    monkeypatch.setattr(course, "worth", lambda *_stages, later: (True, later))
    found = diagnose(load_campaign(tmp_path / "campaign"), list(answer.base))
    assert [one.cause for one in found.effects] == [cause]
    assert not found.effects[0].joined


@pytest.mark.parametrize(("share", "counts"), [(1.0, 1.0), (0.075, 0.5), (0.0, 0.0), (-1.0, 0.0)])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_whole_fault_counts_as_far_as_the_drift_shows_it(share: float, counts: float, sign: float) -> None:
    """Of a law of two thermometers, of either sign: from `IN_DRIFT` on all of it, nothing the other way."""
    stage = Stage(viewed("quiet", 3, (), 1.0)[0])
    base, rng = stage.base, np.random.default_rng(1)
    n, A = len(stage.channel), sign * np.array([2e-6, 3e-6])
    X, late = rng.standard_normal((n, 2)), rng.standard_normal(n)
    y = X @ A + share * A[1] * late + 1e-9 * rng.standard_normal(n)
    law = replace(base, X=X, sd=np.full(2, 1e-4), plain=2)
    bench: Any = SimpleNamespace(view=SimpleNamespace(base=("T1", "T2")))
    asked = witnesses.Witnesses(bench, stage.channel.with_y(y), law, lambda _item: law)
    trial = Trial("thermal-lag", late[:, None], "T2")
    assert asked._in_drift(trial) == pytest.approx(counts, abs=0.05)


def test_what_few_profiles_do_not_tell_of_a_part_is_no_bias_of_its_thermometers(tmp_path: Path) -> None:
    """Thermometers of a part of many lumps that read what is there: the parity is 20 mK off, all others foretell 5."""
    truth, answer = campaign_of(PART, 485764582299714, causes=(), strength=1.0)
    write_campaign(tmp_path / "part", exact_readings(truth), answer)
    campaign = load_campaign(tmp_path / "part")
    model = Stage(view_of(campaign, campaign_rows(campaign, "identification"), answer.base)).bench.model(answer.base[0])
    assert model is not None
    assert model.null[0].slow > 0.01
    assert model.bias < 0.005


def test_the_bias_of_a_thermometer_that_wanders_stays() -> None:
    """Of another part, whose readings wander by 20 mK, all others leave no less than half of it."""
    view, _ = viewed(PART, 7250821734823708, (), 1.0)
    model = Stage(view).bench.model(view.base[0])
    assert model is not None
    assert model.bias > 0.01


@pytest.mark.long
def test_landings_of_a_part_with_a_stroke_scatter_as_those_of_a_leg_do() -> None:
    """Their scatter is found, so that it feigns no wave of the displacement."""
    found = []
    for seed in range(4):
        truth, _ = campaign_of("held_out_actuator", seed, causes=())
        stage = Stage(viewed("held_out_actuator", seed, (), 1.0)[0])
        assert stage.channel.has_landings
        found.append(1e6 * stage.levels.landing / float(str(truth.notes["landing_um"])))
        assert first_name(stage.view) is None
    assert np.median(found) == pytest.approx(1.0, rel=0.4)


def test_stretches_of_a_part_without_a_stroke_may_scatter() -> None:
    """A spindle that stands a little elsewhere at each speed: that is found, and feigns no step; alike it has none."""
    still = next(view for view in (viewed(PART, seed, (), 1.0)[0] for seed in range(20)) if not view.moves)
    sound = Stage(still).levels
    size, rng = 4.0 * sound.rms, np.random.default_rng(2)
    runs = []
    for rows in still.runs:
        jumps = size * rng.standard_normal(rows.landing.max() + 1)
        runs.append(replace(rows, drift=rows.drift + np.where(rows.landing >= 0, jumps[rows.landing], np.nan)))
    scattered = replace(still, runs=tuple(runs))
    assert Stage(scattered).levels.landing == pytest.approx(size, rel=0.4)
    assert sound.landing < 0.2 * size
    assert first_name(scattered) is None
