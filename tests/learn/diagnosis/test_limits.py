"""Detection limits mean what they say: effects well above are named, well below are not; strangers are seen as such."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from hexathermal.learn.diagnosis.chance import chance_threshold
from hexathermal.learn.diagnosis.course import Course
from hexathermal.learn.diagnosis.deciding import Decision, decided
from hexathermal.learn.diagnosis.evidence import LEAST
from hexathermal.learn.diagnosis.limits import _confused, _shapes_of, at_most_named, limits_of
from hexathermal.learn.diagnosis.next_experiments import next_experiments
from hexathermal.learn.diagnosis.result import Candidate, Confusion, Limit
from hexathermal.learn.diagnosis.spans import visible
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.trials import PREFIX, Workbench
from hexathermal.learn.diagnosis.unexplained import flexible_trials
from hexathermal.learn.diagnosis.view import View
from hexathermal.machine.leg_terms import term_columns
from tests.learn.diagnosis.campaigns import viewed

EFFECTS: dict[str, tuple[str, Mapping[str, Any]]] = {"backlash": ("direction", {}), "zero-drift": ("time", {})}


@cache
def clean() -> Stage:
    return Stage(viewed("quiet", 21, (), 1.0)[0])


@cache
def threshold() -> float:
    stage = clean()
    search = stage.search
    return max(LEAST, chance_threshold(stage.channel, stage.base, stage.step.levels, search.trials, search.largest, 1))


@cache
def told() -> tuple[dict[str, Limit], tuple[Confusion, ...]]:
    limits, confusions = limits_of(clean(), clean().step.levels, threshold())
    return {one.cause: one for one in limits}, confusions


def changed(view: View, shape: str, parameters: Mapping[str, Any], size: float) -> View:
    """The view with a shape added to the drift, its visible RMS as given [m]."""
    shown = float(visible(view.columns(shape, parameters), view.base_columns)[0])
    runs = []
    for rows, piece in zip(view.runs, view.pieces, strict=True):
        column = term_columns(shape, rows.signals, parameters)[:, 0]
        runs.append(replace(rows, drift=rows.drift + size / shown * (column - column[piece.used[0]])))
    return replace(view, runs=tuple(runs))


def said(cause: str, times: float) -> Decision:
    """What the first step says of an effect that many times its limit."""
    shape, parameters = EFFECTS[cause]
    stage = Stage(changed(clean().view, shape, parameters, times * told()[0][cause].visible))
    return decided(stage.step, threshold())


@pytest.mark.long
@pytest.mark.parametrize("cause", sorted(EFFECTS))
def test_an_effect_of_three_limits_is_named_one_of_a_quarter_is_not(cause: str) -> None:
    """In a leg with nothing else in it, an effect of three times its limit has its name, a quarter of it none."""
    above, below = said(cause, 3.0), said(cause, 0.25)
    assert above.leader is not None
    assert cause in (above.leader.cause, *above.equivalent)
    assert below.leader is None or below.leader.cause != cause


def test_nothing_is_said_of_the_clean_leg() -> None:
    """The leg that the limits are told for has no name and nothing nameless in it."""
    assert decided(clean().step, threshold()).leader is None


def test_limits_are_visible_parts_of_whole_effects() -> None:
    """What is visible of an effect is never more than the effect; limits are finite and positive."""
    limits, _ = told()
    assert all(0.0 < one.visible <= one.whole * (1.0 + 1e-9) < np.inf for one in limits.values())


def test_confusions_are_ordered_and_of_different_causes() -> None:
    """Pairs that these data confuse come closest first, each of two causes that have a limit."""
    limits, confusions = told()
    gaps = [one.separation for one in confusions]
    assert gaps == sorted(gaps)
    assert all(one.causes[0] != one.causes[1] and set(one.causes) <= set(limits) for one in confusions)


def test_nameless_shapes_follow_something_and_are_no_cause() -> None:
    """Flexible columns are finite, vary, say what they follow, and bear no name of the catalogue."""
    stage = clean()
    trials = list(flexible_trials(Workbench(stage.view, stage.fit(stage.step.levels)[0], stage.step.levels.rms)))
    assert {"q", "T", "t"} <= {trial.target for trial in trials}
    for trial in trials:
        assert trial.cause.startswith(PREFIX)
        assert np.isfinite(trial.columns).all()
        assert np.ptp(trial.columns, axis=0).max() > 0.0


def course_with(*found: object, refused: tuple[object, ...] = ()) -> Course:
    """A course on the clean leg, as far as experiments ask for it."""
    stage = clean()
    last = SimpleNamespace(levels=stage.step.levels)
    return cast(Course, SimpleNamespace(found=found, refused=refused, first=stage, last=last, threshold=threshold()))


def named_first(cause: str, *alike: str) -> object:
    """What a course found, with what these data cannot tell from it."""
    return SimpleNamespace(ranked=SimpleNamespace(cause=cause), decision=SimpleNamespace(equivalent=alike))


def test_an_experiment_stands_once_and_names_its_thermometers() -> None:
    """What decides the leader is not told again, without its thermometer, for a pair that the campaign confuses."""
    limits = (Limit("missing-sensor", 1e-7, 2e-7), Limit("swapped-sensors", 1e-7, 1e-7))
    leader = Candidate("swapped-sensors", "T06", 20.0, 0.9, 1e-7, {"other": "T08"})
    pair = Confusion(("missing-sensor", "swapped-sensors"), 0.0)
    candidates = (leader, Candidate("missing-sensor", "T03", 5.0, 0.1, 1e-7, {}))
    found = next_experiments(course_with(named_first("swapped-sensors")), limits, (pair,), candidates)
    assert [one.words for one in found] == [
        "Warm T06 or T08 with a finger.",
        "Heat the part near T03 alone.",
    ]
    assert [one.size for one in found] == pytest.approx([1e-7, 4e-7])


def test_what_shows_a_rival_comes_second() -> None:
    """A clock that is off as likely as not is asked by a pulse, before what the ranking or the limits suggest."""
    limits = (Limit("hidden-heat", 1e-7, 2e-7), Limit("creep", 1e-7, 9e-7))
    leader = Candidate("hidden-heat", None, 20.0, 0.5, 1e-7, {})
    candidates = (
        leader,
        Candidate("creep", None, 15.0, 0.1, 1e-7, {}),
        Candidate("clock-offset", None, 9.0, 0.4, 1e-7, {}),
    )
    found = next_experiments(course_with(named_first("hidden-heat", "clock-offset")), limits, (), candidates)
    assert [one.causes for one in found] == [
        ("hidden-heat", "clock-offset", "creep"), ("hidden-heat", "clock-offset"), ("creep",),
    ]  # fmt: skip
    assert "pulse" in found[1].words
    told_before = next_experiments(course_with(named_first("creep", "clock-offset")), limits, (), candidates)
    assert told_before[0].causes == ("hidden-heat", "creep", "clock-offset")
    assert "pulse" not in told_before[1].words


def test_an_experiment_promises_more_for_a_larger_effect_and_more_readings() -> None:
    """Half the readings times the square of the whole effect over the noise of a landing; a finger decides."""
    levels, rows = clean().step.levels, float(np.median(clean().channel.rows))
    noise = np.sqrt(levels.white**2 / rows + levels.landing**2 + levels.slow**2)
    sizes = {"backlash": 0.3 * noise, "zero-drift": 0.3 * noise, "clock-offset": 0.3 * noise}
    limits = tuple(Limit(name, 0.25 * size, 0.5 * size) for name, size in sizes.items())
    told = {one.causes[0]: one.separation for one in next_experiments(course_with(), limits, (), ())}
    assert told["backlash"] == pytest.approx(0.5 * 40 * 0.3**2)
    assert told["zero-drift"] == pytest.approx(0.5 * 12 * 0.3**2)
    assert told["clock-offset"] == 150.0


def test_what_runs_left_out_refused_is_asked_next() -> None:
    """A cause above chance that foretold no better comes before pairs that the campaign confuses."""
    suspect = SimpleNamespace(cause="hidden-heat", best=SimpleNamespace(visible=1e-7))
    limits = (Limit("hidden-heat", 1e-7, 2e-7), Limit("creep", 1e-7, 1e-7), Limit("backlash", 1e-7, 1e-7))
    found = next_experiments(course_with(refused=(suspect,)), limits, (Confusion(("creep", "backlash"), 1.0),), ())
    assert [one.causes[0] for one in found] == ["hidden-heat", "creep", "creep"]
    assert found[0].size == pytest.approx(2e-7)


def test_no_limit_is_larger_than_what_was_named() -> None:
    """What is named at a size is named at that size: the page cannot say that only twice as much would be."""
    limits = (Limit("backlash", 4e-7, 8e-7), Limit("creep", 1e-7, 1e-7), Limit("zero-drift", 2e-7, 3e-7))
    told = at_most_named(limits, {"backlash": 2e-7, "creep": 3e-7})
    assert [one.cause for one in told] == [one.cause for one in limits]
    assert [one.visible for one in told] == pytest.approx([2e-7, 1e-7, 2e-7])
    assert [one.whole for one in told] == pytest.approx([4e-7, 1e-7, 3e-7])


@pytest.mark.long
def test_other_witnesses_than_the_drift_tell_causes_apart() -> None:
    """Of a leg whose thermometers are sound, their parity would tell a drifting one from a drifting zero."""
    stage = Stage(viewed("finite_volume", 21, (), 1.0)[0])
    shapes = _shapes_of(stage, stage.step.levels, LEAST)[1]
    pair = {name: shapes[name] for name in ("sensor-drift", "zero-drift")}
    drift = pair["sensor-drift"]
    alone = pair | {"sensor-drift": replace(drift, witness=0.0 * drift.witness)}
    (weaker,) = _confused(alone)
    assert not _confused(pair) or _confused(pair)[0].separation > weaker.separation + 1.0
