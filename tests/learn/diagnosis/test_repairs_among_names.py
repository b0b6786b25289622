"""Repairs of thermometers beside other causes: what joined before reads mended data, what they hid is found."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.diagnosis.course import base_law, searched
from hexathermal.learn.diagnosis.deciding import Decision
from hexathermal.learn.diagnosis.evidence import Scored
from hexathermal.learn.diagnosis.joining import KIN_SIZE, Found, next_stage
from hexathermal.learn.diagnosis.ranking import Ranked
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.trials import Trial
from hexathermal.learn.signals import campaign_rows
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign
from tests.learn.diagnosis.campaigns import viewed


def scored(trial: Trial) -> Scored:
    """A trial as it stands once it was scored."""
    return Scored(trial, 50.0, 1e-7, 1e-7, 1e-8, 1.0, np.ones(trial.columns.shape[1]))


@pytest.fixture(scope="module")
def stage() -> Stage:
    """A leg with nothing hidden."""
    return Stage(viewed("finite_volume", 17, (), 1.0)[0])


def a_repair(stage: Stage, cause: str) -> Scored:
    """The trial of a repair that concerns the law's first sensor, or all."""
    base = stage.view.base[0]
    return scored(next(trial for trial in stage.search.trials
                       if trial.cause == cause and trial.target in (base, None)))  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize("repair", ["swapped-sensors", "clock-offset", "sensor-drift"])
@pytest.mark.parametrize("shape", ["lag", "square", "temperature"])
def test_a_term_that_joined_before_a_repair_reads_mended_data(stage: Stage, repair: str, shape: str) -> None:
    """Its columns are those of the mended view: of smoothed temperatures, or of those as recorded, as they were."""
    sensor = stage.view.base[0]
    own = {"lag": {"time_constant_s": 120.0, "order": 1}, "square": {}, "temperature": {}}[shape]
    parameters = {"sensor": sensor, "ratio": 0.5, **own}
    for which in (lambda view: view, lambda view: view.as_recorded):
        term = scored(Trial("a cause", which(stage.view).columns(shape, parameters), sensor, shape, parameters))
        after = stage.with_effect(term).with_effect(a_repair(stage, repair))
        found = after.joined[0].trial.columns
        np.testing.assert_array_equal(found, which(after.view).columns(shape, parameters))
        assert np.abs(found - term.trial.columns).max() > 1e-4 * np.abs(found).max()


def test_starts_and_what_reads_no_thermometer_stay(stage: Stage) -> None:
    """A step of the zero, and a frame's own start in each run, are the same in mended data."""
    frame = next(trial for trial in stage.search.trials if trial.cause == "frame-expansion" and trial.starts)
    step = next(trial for trial in stage.search.trials if trial.cause == "zero-jump")
    before = stage.with_effect(scored(frame)).with_effect(scored(step))
    after = before.with_effect(a_repair(stage, "swapped-sensors"))
    for one, other in zip(before.joined, after.joined, strict=True):
        np.testing.assert_array_equal(one.trial.columns, other.trial.columns)
    # with starts beside a term that reads a thermometer only the term is made anew
    sensor = stage.view.base[0]
    parameters = {"sensor": sensor, "ratio": 0.5}
    columns = np.column_stack([stage.view.columns("square", parameters), stage.view.starts(600.0)])
    mixed = scored(replace(frame, columns=columns, shape="square", parameters=parameters, starts=columns.shape[1] - 1))
    found = stage.with_effect(mixed).with_effect(a_repair(stage, "swapped-sensors")).joined[0].trial.columns
    np.testing.assert_array_equal(found[:, 1:], columns[:, 1:])
    assert np.abs(found[:, 0] - columns[:, 0]).max() > 0.0


@pytest.mark.long
@pytest.mark.parametrize(("bench", "seed", "other"), [
    ("quiet", 3211856173960671, "sensor-detached"),
    ("modal", 673151215775648, "swapped-sensors"),
])  # fmt: skip
def test_another_thermometer_is_found_beside_a_mended_one(tmp_path: Path, bench: str, seed: int, other: str) -> None:
    """A detached or exchanged thermometer hid that one outside the law matters: once it is mended that is named too.

    What the others show of the fault leads, however well doubts of thermometers explain the drift.
    """
    assert named(tmp_path, bench, seed, ("missing-sensor", other)) == [other, "missing-sensor"]


def test_errors_of_a_named_shape_stay_tolerated_after_a_repair(stage: Stage) -> None:
    """Stored heat, then a repair: what a sketch of the heat left was creep once data were mended."""
    heat = next(trial for trial in stage.search.trials if trial.cause == "hidden-heat" and trial.shape)
    found = [a_found(scored(heat), stage)]
    before, found = next_stage(stage, stage.with_effect(found[0].ranked.best), found, threshold=np.inf)
    assert [one.trial.cause for one in before.tolerated] == ["hidden-heat"]
    repair = a_repair(before, "sensor-drift")
    after = before.with_effect(repair)
    assert not after.tolerated
    mended, _found = next_stage(before, after, [*found, a_found(repair, before)], threshold=np.inf)
    (shapes,) = mended.tolerated
    assert shapes.trial.cause == "hidden-heat"
    assert shapes.trial.columns.shape[1] > 0
    np.testing.assert_allclose(shapes.size, KIN_SIZE * found[0].ranked.best.visible)
    assert mended.base.X.shape[1] == after.base.X.shape[1] + shapes.trial.columns.shape[1]


def a_found(one: Scored, stage: Stage) -> Found:
    """A trial as it stands once it was named, and joined the law."""
    decision = Decision(None, 0.98, {}, ())
    return Found(Ranked(one.trial.cause, one.value, one, stage.levels), decision, True, np.ones(1), np.ones(1))


def named(folder: Path, bench: str, seed: int, causes: tuple[str, ...]) -> list[str]:
    """The names that a campaign with two causes gets, in their order."""
    truth, answer = campaign_of(bench, seed, causes=causes, strength=1.2)
    write_campaign(folder / "campaign", truth, answer)
    campaign = load_campaign(folder / "campaign")
    rows = campaign_rows(campaign, "identification")
    return [one.ranked.cause for one in searched(campaign, base_law(campaign, rows, answer.base, None), rows).found]


@pytest.mark.long
@pytest.mark.parametrize(("bench", "seed", "strength"), [("modal", 2, 1.07)])
def test_a_step_of_another_run_is_found_beside_a_thermometer_that_came_off(
    bench: str, seed: int, strength: float, tmp_path: Path
) -> None:
    """What the repair leaves looks like a step in its own run, where none is asked any more."""
    truth, answer = campaign_of(bench, seed, causes=("zero-jump", "sensor-detached"), strength=strength)
    write_campaign(tmp_path / "campaign", truth, answer)
    campaign = load_campaign(tmp_path / "campaign")
    rows = campaign_rows(campaign, "identification")
    course = searched(campaign, base_law(campaign, rows, list(answer.base), None), rows)
    assert sorted(one.ranked.cause for one in course.found) == ["sensor-detached", "zero-jump"]
    after = next(stage for stage in (*course.stages, course.last) if stage.repairs)
    first = next(iter(after.repairs[0].parameters["from_s"]))
    steps = [[trial.target for trial in trials if trial.cause == "zero-jump"]
             for trials in (after.search.trials, after.trials_left)]  # fmt: skip
    assert first in steps[0]
    assert set(steps[1]) == set(steps[0]) - {first}
