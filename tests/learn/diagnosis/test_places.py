"""Places with a common step hide waves of the displacement; what is found there says so, and stays within bounds."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.diagnosing import diagnose
from hexathermal.learn.diagnosis import Diagnosis
from hexathermal.learn.diagnosis.causes import periodic_screw_error
from hexathermal.learn.diagnosis.places import alias_words, common_step
from hexathermal.learn.diagnosis.trials import Workbench
from hexathermal.learn.diagnosis.view import View
from hexathermal.machine.leg_signals import LegSignals
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.effects import named
from hexathermal.simulate.hidden.writing import write_campaign
from tests.learn.diagnosis.campaigns import viewed

STEP = 0.010


def on_a_grid(view: View, step: float, first: float) -> View:
    """The view with the rod at multiples of a step from a first place."""
    runs = []
    for rows in view.runs:
        q = first + step * np.round(rows.signals.q / step)
        runs.append(replace(rows, signals=replace(rows.signals, q=q)))
    return replace(view, runs=tuple(runs))


def diagnosed(folder: Path, pitch: float | None) -> Diagnosis:
    """The diagnosis of a leg that stands at multiples of 10 mm, with a screw's error of 0.1 um."""
    truth, answer = campaign_of("quiet", 12, causes=())
    base = [truth.sensors.index(name) for name in truth.base]
    A, B = np.split(truth.coefficients, 2)
    runs = []
    for run in truth.runs:
        q = STEP * np.round(run.q / STEP)
        warmed = run.temperatures[:, base] - run.temperatures[0, base]
        runs.append(run.changed(q=q, drift=truth.retracted_length * warmed @ A + q * (warmed @ B)))
    truth = truth.changed(runs=tuple(runs))
    if pitch is not None:
        error = {"pitch": pitch, "amplitude": 1e-7, "second": 0.0, "phase": 0.7, "second_phase": 0.0}
        truth = named("periodic-screw-error").hide(truth, error)
    write_campaign(folder, truth, answer)
    return diagnose(load_campaign(folder), answer.base)


@pytest.mark.parametrize(("step", "first"), [(0.010, 0.0), (0.010, 0.0037), (0.025, 0.001)])
def test_the_common_step_of_places_is_found(step: float, first: float) -> None:
    """Whatever the first place is, and however many steps the moves have; no step is found of places anywhere."""
    view, _ = viewed("quiet", 12, (), 1.0)
    assert common_step(view) is None
    assert alias_words(view, 0.004) is None
    found = common_step(on_a_grid(view, step, first))
    assert found is not None
    assert found[0] == pytest.approx(step, rel=1e-6)


def test_a_rare_place_between_the_steps_hides_no_common_step() -> None:
    """A rod that once stood between the steps, for less than a fiftieth of the windows, has their step all the same."""
    view, _ = viewed("quiet", 12, (), 1.0)
    grid = on_a_grid(view, STEP, 0.0037)
    q = grid.runs[0].signals.q.copy()
    q[len(q) // 2 : len(q) // 2 + 12] += 0.0033
    rare = replace(grid.runs[0], signals=replace(grid.runs[0].signals, q=q))
    odd = replace(grid, runs=(rare, *grid.runs[1:]))
    off = np.abs((odd.q - 0.0037) / STEP - np.round((odd.q - 0.0037) / STEP)) > 0.01
    assert 0.0 < off.mean() < 0.02
    found = common_step(odd)
    assert found is not None
    assert found[0] == pytest.approx(STEP, rel=1e-6)
    assert str(alias_words(odd, None)).startswith("all places but rare ones are multiples of 10 mm apart")
    assert str(alias_words(grid, None)).startswith("all places are multiples of 10 mm apart")


def test_trials_differ_at_the_places_that_were_visited() -> None:
    """Of waves that look alike the longest is tried, down to two steps; its columns are no rounding."""
    view, answer = viewed("quiet", 12, (), 1.0)
    grid = on_a_grid(view, STEP, 0.0037)
    trials = list(periodic_screw_error.trials(Workbench(grid, np.ones(2 * len(answer.base)), 1e-7)))
    pitches = [trial.parameters["pitch_m"] for trial in trials]
    assert min(pitches) == pytest.approx(2.0 * STEP)
    assert len(trials) > 10
    for trial in trials:
        assert np.linalg.svd(trial.columns - trial.columns.mean(axis=0), compute_uv=False)[-1] > 0.1


@pytest.mark.long
@pytest.mark.parametrize(("pitch", "said"), [(0.004, 0.020), (0.007, 0.0233)])
def test_a_pitch_that_places_alias_is_named_with_what_looks_alike(tmp_path: Path, pitch: float, said: float) -> None:
    """The longest pitch that looks alike is said, the true one among the others; the law's error stays bounded."""
    found = diagnosed(tmp_path / "leg", pitch)
    assert found.cause == "periodic-screw-error"
    assert found.effects[0].parameters["pitch_m"].value == pytest.approx(said, rel=0.04)
    (note,) = [note for note in found.notes if "multiples of" in note]
    pitches = [float(word) for word in note.split(" may as well be ")[1].split(" mm")[0].split(", ")]
    assert min(abs(one / (1e3 * pitch) - 1.0) for one in pitches) < 0.03
    terms = [one for one in found.extended.terms if one.cause == "periodic-screw-error"]
    between = LegSignals(np.arange(101.0), {}, np.linspace(0.1, 0.2, 101) + 0.00123)
    assert 0.0 < np.abs(sum(term.drift(between) for term in terms)).max() < 3e-7


@pytest.mark.long
def test_a_pitch_that_shows_nowhere_is_told_beside_the_answer(tmp_path: Path) -> None:
    """A pitch of 5 mm on places 10 mm apart leaves nothing to see: nothing is named, and the answer says why."""
    found = diagnosed(tmp_path / "leg", 0.005)
    assert found.verdict == "none"
    assert any("10 mm over a whole number" in note and "does not show here" in note for note in found.notes)
