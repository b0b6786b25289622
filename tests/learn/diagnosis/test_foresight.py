"""Runs left out of the fit: what they deny is not named."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from hexathermal.learn.diagnosis import foresight, rivals
from hexathermal.learn.diagnosis.all_trials import all_trials
from hexathermal.learn.diagnosis.chance import LEAST_THRESHOLD
from hexathermal.learn.diagnosis.channels import Levels
from hexathermal.learn.diagnosis.course import _not_denied
from hexathermal.learn.diagnosis.deciding import Decision
from hexathermal.learn.diagnosis.evidence import LEAST, Scored
from hexathermal.learn.diagnosis.foresight import CLEAR_STEP, FAINT, MOST_UNLIKE, worth
from hexathermal.learn.diagnosis.ranking import Ranked, Step
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.trials import Trial
from tests.learn.diagnosis.campaigns import viewed

LEVELS = Levels(1e-7, 1e-7, 1e-7, 1e-7)
FOUR = SimpleNamespace(run=np.array([0, 0, 1, 1]))
"""What stands for a channel of four windows, two of each run."""


def stage_of(*, stroked: bool = True) -> Any:
    """What stands for a stage of a leg or an axis, or of a part whose law reads no displacement."""
    return SimpleNamespace(view=SimpleNamespace(stroked=stroked), channel=FOUR)


@pytest.mark.parametrize(("evidence", "share", "pays"), [
    (LEAST + 1.0, -0.2, False), (LEAST + 1.0, -0.05, True), (FAINT + 1.0, -0.05, True), (FAINT + 1.0, -0.9, False),
])  # fmt: skip
def test_a_faint_name_may_not_add_to_the_squares_of_runs_left_out(
    monkeypatch: pytest.MonkeyPatch, evidence: float, share: float, pays: bool
) -> None:
    """A name that is hardly above chance, and foretells runs clearly worse, is not given; a clear one may be."""

    def saved(*_stages: Any, within: bool = False) -> float:
        return -1.0 if within else share

    monkeypatch.setattr(foresight, "part_saved", saved)
    monkeypatch.setattr(foresight, "part_spread", lambda *_stages: 0.1)
    monkeypatch.setattr(foresight, "foresight", lambda *_stages: 40.0)
    monkeypatch.setattr(foresight, "saved_besides", lambda *_stages: 0.1)
    trial = Trial("frame-expansion", np.zeros((1, 1)))
    best = Scored(trial, evidence, 10.0 * LEVELS.rms, LEVELS.rms, 0.0, 1.0, np.ones(1))
    leader = Ranked("frame-expansion", evidence, best, LEVELS)
    assert worth(stage_of(), stage_of(), leader, later=False)[0] == pays


@pytest.mark.parametrize(("stroked", "later", "share", "besides", "pays"), [
    (True, False, -0.05, 0.1, True), (True, False, -0.05, -0.01, False), (True, False, 0.05, -0.01, True),
    (False, False, -0.05, -0.01, True), (True, True, -0.05, -0.01, True),
])  # fmt: skip
def test_a_first_name_of_a_leg_or_an_axis_takes_something_from_runs_left_out(
    monkeypatch: pytest.MonkeyPatch, stroked: bool, later: bool, share: float, besides: float, pays: bool
) -> None:
    """Besides their zeros and what they began with; the law of a part, which they speak for, is not shrunk."""
    monkeypatch.setattr(foresight, "part_saved", lambda *_stages, within=False: share)
    monkeypatch.setattr(foresight, "part_spread", lambda *_stages: 0.1)
    monkeypatch.setattr(foresight, "foresight", lambda *_stages: 40.0)
    monkeypatch.setattr(foresight, "saved_besides", lambda *_stages: besides)
    best = Scored(Trial("hidden-heat", np.zeros((1, 1))), 40.0, 10.0 * LEVELS.rms, LEVELS.rms, 0.0, 1.0, np.ones(1))
    leader = Ranked("hidden-heat", 40.0, best, LEVELS)
    assert worth(stage_of(stroked=stroked), stage_of(stroked=stroked), leader, later=later) == (pays, pays)


@pytest.mark.parametrize(("evidence", "share", "later", "pays"), [
    (FAINT + 1.0, 0.4, False, True), (FAINT - 1.0, 0.4, False, False), (FAINT + 1.0, 0.15, False, False),
    (FAINT + 1.0, 0.4, True, False),
])  # fmt: skip
def test_a_first_name_whose_squares_fall_pays_though_runs_become_no_likelier(
    monkeypatch: pytest.MonkeyPatch, evidence: float, share: float, later: bool, pays: bool
) -> None:
    """A zero that drifts takes 0.6 of the squares of runs left out, and a law a little moved costs likelihood."""
    monkeypatch.setattr(foresight, "part_saved", lambda *_stages, within=False: share)
    monkeypatch.setattr(foresight, "part_spread", lambda *_stages: 0.1)
    monkeypatch.setattr(foresight, "foresight", lambda *_stages: -10.0)
    monkeypatch.setattr(foresight, "saved_besides", lambda *_stages: share)
    best = Scored(Trial("zero-drift", np.zeros((1, 1))), evidence, 1e-5, LEVELS.rms, 0.0, 1.0, np.ones(1))
    nothing = stage_of()
    assert worth(nothing, nothing, Ranked("zero-drift", evidence, best, LEVELS), later=later) == (pays, pays)


@pytest.mark.parametrize(("starts", "evidence", "sure", "named"), [
    (0, FAINT + 1.0, 5.0, False), (1, FAINT + 1.0, 5.0, True), (1, FAINT - 1.0, 5.0, False),
    (1, FAINT + 1.0, -10.0, True), (1, FAINT + 1.0, -MOST_UNLIKE - 1.0, False),
])  # fmt: skip
def test_runs_left_out_do_not_refuse_what_they_cannot_know(
    monkeypatch: pytest.MonkeyPatch, starts: int, evidence: float, sure: float, named: bool
) -> None:
    """A bench that had not come to rest before a run is named, clear as it is, but joins no law that does worse.

    Nor is it named where they become far less likely by it.
    """
    monkeypatch.setattr(foresight, "part_saved", lambda *_stages, within=False: -0.2)
    monkeypatch.setattr(foresight, "part_spread", lambda *_stages: 0.1)
    monkeypatch.setattr(foresight, "foresight", lambda *_stages: sure)
    trial = Trial("frame-expansion", np.array([[1.0, 0.0], [1.0, 0.0], [1.0, 1.0], [1.0, 1.0]]), starts=starts)
    best = Scored(trial, evidence, 10.0 * LEVELS.rms, LEVELS.rms, 0.0, 1.0, np.ones(2))
    nothing = stage_of()
    leader = Ranked("frame-expansion", evidence, best, LEVELS)
    assert worth(nothing, nothing, leader, later=True) == (named, False)


def test_runs_left_out_may_refuse_what_is_the_same_in_all_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    """The bow of a scale joins no law either, but each run foretells it of the others."""
    monkeypatch.setattr(foresight, "part_saved", lambda *_stages, within=False: -0.4)
    monkeypatch.setattr(foresight, "part_spread", lambda *_stages: 0.1)
    monkeypatch.setattr(foresight, "foresight", lambda *_stages: -30.0)
    trial = Trial("scale-error", np.array([[1.0, 1.0], [0.0, 0.5], [1.0, 1.0], [2.0, -1.0]]), starts=1)
    best = Scored(trial, 40.0, 10.0 * LEVELS.rms, LEVELS.rms, 0.0, 1.0, np.ones(2))
    nothing = stage_of()
    assert worth(nothing, nothing, Ranked("scale-error", 40.0, best, LEVELS), later=False) == (False, False)


@pytest.mark.parametrize(("share", "about_means", "sure", "stands"), [
    (-0.2, -0.2, 30.0, False), (0.01, 0.01, 0.0, True), (-0.2, 0.2, 30.0, True), (-0.2, 0.2, 5.0, False),
])  # fmt: skip
def test_something_faint_without_a_name_is_denied_alike(
    monkeypatch: pytest.MonkeyPatch, share: float, about_means: float, sure: float, stands: bool
) -> None:
    """A rhythm that is hardly above chance, and foretells runs worse, is nothing.

    Unless runs whose first rows are noisy are foretold better about their means, and become far likelier.
    """
    evidence = LEAST + 1.0
    monkeypatch.setattr(foresight, "part_saved", lambda *_stages, within=False: about_means if within else share)
    monkeypatch.setattr(foresight, "part_spread", lambda *_stages: 0.1)
    monkeypatch.setattr(foresight, "foresight", lambda *_stages: sure)
    best = Scored(Trial("follows time", np.ones((4, 1))), evidence, 1.0, LEVELS.rms, 0.0, 1.0, np.ones(1))
    leader = Ranked("follows time", evidence, best, LEVELS)
    stage: Any = SimpleNamespace(with_effect=lambda _best: None, step=Step((leader,), LEVELS, 0.0), channel=FOUR)
    assert (_not_denied(stage, Decision(leader, 0.9, {}, ()), LEAST, ()).leader is leader) == stands


@pytest.mark.parametrize(("columns", "evidence", "stands"), [
    (np.kron(np.eye(2), np.ones((2, 1))), FAINT + 1.0, True), (np.ones((4, 2)), FAINT + 1.0, False),
    (np.kron(np.eye(2), np.ones((2, 1))), FAINT - 1.0, False),
])  # fmt: skip
def test_runs_do_not_deny_what_each_has_its_own_way(
    monkeypatch: pytest.MonkeyPatch, columns: np.ndarray, evidence: float, stands: bool
) -> None:
    """Of a rhythm that has another phase in each run no run foretells another: that they are foretold worse is no
    wonder, and is not held against it, unless little is said for it.
    """
    monkeypatch.setattr(foresight, "part_saved", lambda *_stages, within=False: -0.2)
    monkeypatch.setattr(foresight, "part_spread", lambda *_stages: 0.1)
    best = Scored(Trial("follows time", columns, doubt=2.0), evidence, 1.0, LEVELS.rms, 0.0, 1.0, np.ones(2))
    leader = Ranked("follows time", evidence, best, LEVELS)
    assert leader.gated < FAINT
    stage: Any = SimpleNamespace(with_effect=lambda _best: None, step=Step((leader,), LEVELS, 0.0), channel=FOUR)
    assert (_not_denied(stage, Decision(leader, 0.9, {}, ()), LEAST, ()).leader is leader) == stands


def test_what_stands_behind_something_that_is_denied_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """Faint columns of place and warmth that runs left out deny do not hide a bump at one place, which is plain."""

    def ranked(name: str, evidence: float, visible: float) -> Ranked:
        best = Scored(Trial(name, np.ones((4, 2))), evidence, visible * LEVELS.rms, LEVELS.rms, 0.0, 1.0, np.ones(2))
        return Ranked(name, evidence, best, LEVELS)

    faint, plain = ranked("follows place and warmth", 90.0, 0.2), ranked("follows the displacement", 85.0, 10.0)
    monkeypatch.setattr(foresight, "part_saved", lambda *_stages, within=False: -0.2)
    monkeypatch.setattr(foresight, "part_spread", lambda *_stages: 0.1)
    stage: Any = SimpleNamespace(
        with_effect=lambda _best: None,
        step=Step((faint, plain, ranked("backlash", 0.0, 0.1)), LEVELS, 0.0),
        channel=FOUR,
    )
    assert faint.gated < FAINT
    assert _not_denied(stage, Decision(faint, 0.9, {}, ()), LEAST, ()).leader is plain


@pytest.mark.parametrize(("evidence", "seen", "moment", "given"), [
    (LEAST + 1.0, 10.0, 60.0, False), (CLEAR_STEP - 1.0, 10.0, 60.0, False), (CLEAR_STEP + 1.0, 10.0, 60.0, True),
    (CLEAR_STEP + 1.0, 0.17, 160.0, True), (2.0 * CLEAR_STEP, 10.0, 6000.0, False),
])  # fmt: skip
def test_a_faint_or_blurred_step_of_one_run_is_not_given(
    monkeypatch: pytest.MonkeyPatch, evidence: float, seen: float, moment: float, given: bool
) -> None:
    """No run left out can tell of a step in one run: it must be clear by itself, however small it is over all runs.

    And sharp: what may have begun at any time of a run did not jump.
    """
    monkeypatch.setattr(foresight, "grid_spread", lambda *_stages: moment)
    monkeypatch.setattr(foresight, "part_spread", lambda *_stages: 0.1)
    best = Scored(Trial("zero-jump", np.zeros((1, 1))), evidence, seen * LEVELS.rms, LEVELS.rms, 0.0, 1.0, np.ones(1))
    nothing = stage_of()
    assert worth(nothing, nothing, Ranked("zero-jump", evidence, best, LEVELS), later=False)[0] == given


@pytest.mark.parametrize(("new", "least", "most"), [
    ([0.7, 0.71, 0.69, 0.7, 0.72, 0.7], 9.0, 30.0),  # each run loses three tenths
    ([0.7] * 6, 9.0, 30.0),  # exactly
    ([0.0, 1.1, 0.8, 1.2, 1.0, 0.9], 0.0, 0.0),  # one run loses all, the others nothing
    ([0.95] * 5 + [0.94], 0.0, 0.0),  # all lose little
    ([1.2] * 5 + [1.3], 0.0, 0.0),  # all gain
    ([0.7, 0.71], 0.0, 0.0),  # two runs tell nothing
])  # fmt: skip
@pytest.mark.parametrize("longer", [1, 12])
def test_what_every_run_loses_alike_is_no_wandering_thermometer(
    monkeypatch: pytest.MonkeyPatch, new: list[float], least: float, most: float, longer: int
) -> None:
    """Evidence of runs left out is Student's likelihood ratio where they lose a tenth or more, however long each is."""
    rows = np.array([longer] + [1] * (len(new) - 1)) / (len(new) + longer - 1)
    monkeypatch.setattr(foresight, "_left", lambda *_stages: [rows, rows * np.array(new)])
    before: Any = SimpleNamespace(channel=SimpleNamespace(run=np.arange(len(new)), rows=rows))
    nothing: Any = None
    assert least <= foresight.repeated(before, nothing, nothing) <= most


@pytest.mark.long
def test_a_small_effect_of_all_runs_is_named_where_thermometers_may_feign_as_much(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Another thermometer that matters, no more than those of the law may feign, stands: each run left out shows it."""
    monkeypatch.setattr(rivals, "SELDOM_ELSE", (0.0, 0.0))
    view, answer = viewed("rough", 3259304782937083, ("missing-sensor",), 1.3)
    best = Stage(view).step.ranking[0]
    assert (best.cause, best.best.trial.target) == ("missing-sensor", answer.targets[0])
    assert replace(best, repeated=0.0).gated < LEAST_THRESHOLD < best.gated


@pytest.mark.long
def test_creep_with_the_direction_of_moves_is_feigned_by_no_thermometer() -> None:
    """Heat of motion, read wrong, follows every move alike: relaxation that knows the direction is none of it."""
    view, _ = viewed("quiet", 4069649308442949, ("creep",), 0.5)
    trials = [trial for trial in all_trials(Stage(view).bench) if trial.cause == "creep"]
    assert {trial.feigned > 0.0 for trial in trials if trial.parameters["kick"] == "move"} == {True}
    assert {trial.feigned for trial in trials if trial.parameters["kick"] in ("direction", "step")} == {0.0}
    leader = Stage(view).step.ranking[0]
    assert leader.cause == "creep"
    assert leader.gated > FAINT


def test_creep_of_moves_one_way_may_be_heat() -> None:
    """Where the rod moves one way only, a decay with the direction is the decay after every move, and feigned alike."""
    view, _ = viewed("quiet", 4069649308442949, ("creep",), 0.5)
    way = [np.maximum.accumulate(0.05 * np.arange(len(rows.drift)) // 40) * 1e-3 for rows in view.runs]
    one = replace(view, runs=tuple(replace(rows, signals=replace(rows.signals, q=q))
                                   for rows, q in zip(view.runs, way, strict=True)))  # fmt: skip
    trials = [trial for trial in all_trials(Stage(one).bench) if trial.cause == "creep"]
    assert all(trial.feigned > 0.0 for trial in trials)
