"""A name whose shape is a little bent stays the name; what is no cause is not named for what others leave of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from hexathermal.learn.diagnosis import course, search
from hexathermal.learn.diagnosis.course import APART, LATER_PART, PROVEN, _too_faint, _two_for
from hexathermal.learn.diagnosis.deciding import Decision
from hexathermal.learn.diagnosis.evidence import Scored
from hexathermal.learn.diagnosis.forms import ALIKE, fullest, other_form
from hexathermal.learn.diagnosis.ranking import Ranked
from hexathermal.learn.diagnosis.rivals import SHAPE_ERROR, with_a_misfit
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.trials import Trial
from hexathermal.learn.diagnosis.view import View
from hexathermal.poses import FloatArray
from tests.learn.diagnosis.campaigns import first_name, viewed
from tests.learn.diagnosis.test_evidence import ranked, step
from tests.learn.diagnosis.test_further_forms import THRESHOLD, doubted, with_drift

Made = Callable[[View], list[FloatArray]]


def parts_of_stroke(view: View) -> list[FloatArray]:
    """The place of the rod in each row, 0 to 1 over all that the runs use."""
    q = np.concatenate([rows.signals.q for rows in view.runs])
    return [(rows.signals.q - q.min()) / np.ptp(q) for rows in view.runs]


def bowed(view: View) -> list[FloatArray]:
    """A scale with a bow of a fifth."""
    return [x - 0.2 * 4.0 * x * (1.0 - x) for x in parts_of_stroke(view)]


def deeply_bowed(view: View) -> list[FloatArray]:
    """A scale whose bow, on top of it, is half as high as its slope is over the stroke."""
    return [x + 0.5 * np.sin(np.pi * x) for x in parts_of_stroke(view)]


def arched(view: View) -> list[FloatArray]:
    """A bow without a slope."""
    return [np.sin(np.pi * x) for x in parts_of_stroke(view)]


def in_two_pieces(view: View) -> list[FloatArray]:
    """A scale in two pieces, the second of which is wrong by two thirds as much."""
    return [np.minimum(x, 0.5) + 2.0 / 3.0 * np.maximum(x - 0.5, 0.0) for x in parts_of_stroke(view)]


def cubic(view: View) -> list[FloatArray]:
    """A cube of the place about the middle: its slope goes to nothing there."""
    return [(2.0 * x - 1.0) ** 3 for x in parts_of_stroke(view)]


@pytest.mark.long
@pytest.mark.parametrize("seed", [1, 2])
def test_what_any_misfit_of_a_law_looks_like_is_no_scale_error(seed: int) -> None:
    """A sixth of the noise that goes with the displacement is sure in many rows, and no name: half of it has one."""
    asked = {}
    for strength in (0.15, 0.5):
        stage = Stage(viewed("quiet", seed, ("scale-error",), strength)[0])
        own = [trial for trial in stage.search.trials if trial.cause == "scale-error"]
        asked[strength] = stage.search.step(own).ranking[0]
    assert asked[0.15].gated < THRESHOLD < asked[0.15].value
    assert asked[0.5].gated > THRESHOLD


@pytest.mark.long
@pytest.mark.parametrize(("made", "bench"), [(bowed, "quiet"), (in_two_pieces, "modal"), (deeply_bowed, "rough")])
def test_a_scale_that_is_a_little_bent_is_a_scale_error(made: Made, bench: str) -> None:
    """What bends a scale is small beside it: that flexible columns take it too is no reason not to name it."""
    view, _ = viewed(bench, 2, (), 1.0)
    assert first_name(with_drift(view, made(view), 2.0)) == "scale-error"


@pytest.mark.long
@pytest.mark.parametrize("bench", ["quiet", "rough"])
@pytest.mark.parametrize("made", [cubic, arched])
def test_a_cube_of_the_place_or_an_arch_has_no_name(made: Made, bench: str) -> None:
    """A third of the cube no scale takes, and none of the arch: something real that follows the displacement, and no
    thermometer either.
    """
    view, _ = viewed(bench, 2, (), 1.0)
    name = first_name(with_drift(view, made(view), 1.5))
    assert name is not None
    assert name.startswith("follows")


@pytest.mark.long
def test_names_are_weighed_against_each_other_before_what_has_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """A name that leads another by what it explains beside its misfit does not lead what explains more than both."""
    view, _ = viewed("finite_volume", 2, (), 1.0)
    stage = Stage(with_drift(view, cubic(view), 2.0))

    def raised(*given: Any) -> list[Ranked]:
        return [replace(item, value=470.0) if item.cause == "scale-error" else item for item in with_a_misfit(*given)]

    monkeypatch.setattr(search, "with_a_misfit", raised)
    best, *_others = stage.step.ranking
    assert best.cause == "follows the displacement"
    assert best.value > 470.0


@pytest.mark.long
def test_a_drift_of_the_zero_with_rates_of_its_own_in_each_run_is_named() -> None:
    """Rates that differ by half of the common one are a drift of the zero, not a rhythm."""
    view, _ = viewed("quiet", 2, (), 1.0)
    rates = np.linspace(0.5, 1.5, len(view.runs))[np.argsort(np.sin(np.arange(len(view.runs)) * 5.0))]
    drifts = [rate * rows.signals.time for rate, rows in zip(rates, view.runs, strict=True)]
    assert first_name(with_drift(view, drifts, 2.0)) == "zero-drift"


@pytest.mark.long
def test_what_differs_from_run_to_run_is_looked_at_in_the_noise_that_it_leaves() -> None:
    """In the noise of the null, in which all that wanders is noise, a common rate alone looks best."""
    view, _ = viewed("finite_volume", 1, (), 1.0)
    rates = 1.0 + 0.35 * np.sin(np.arange(len(view.runs)) * 5.0)
    drifts = [rate * rows.signals.time for rate, rows in zip(rates, view.runs, strict=True)]
    best, nameless, *_others = Stage(with_drift(view, drifts, 2.0)).step.ranking
    assert best.cause == "zero-drift"
    assert best.best.trial.starts
    assert nameless.cause == "follows time (a rate of each run's own)"


def test_each_form_of_a_cause_has_the_other_one_beside_it() -> None:
    """With columns of single runs the best one without, of the same cause; without them itself with such columns."""
    plain, with_own = (Trial("zero-drift", np.zeros((3, 1 + k)), None, starts=k) for k in (0, 2))
    later = Trial("zero-drift", np.zeros((3, 3)), None, "relaxation", {"time_constant_s": 100.0}, starts=2)
    other = Trial("creep", np.zeros((3, 3)), None, starts=2)
    said = ((plain, 3.0), (plain, 5.0), (with_own, 2.0), (with_own, 4.0), (later, 8.0), (other, 9.0))
    scored = [Scored(trial, value, 0.0, 0.0, 0.0, 0.0, np.zeros(0)) for trial, value in said]
    assert other_form(scored[1], scored) == [scored[3]]
    assert other_form(scored[3], scored) == [scored[1]]
    assert other_form(scored[4], scored) == [scored[1]]
    assert other_form(scored[5], scored) == []


NAMELESS = ("follows time (a rate of each run's own)", "follows time (a rhythm)")


@pytest.mark.long
@pytest.mark.parametrize(("bench", "common"), [("quiet", 0.0), ("modal", 0.7)])
def test_rates_of_either_sign_are_no_drift_of_the_zero(bench: str, common: float) -> None:
    """Half of the runs drift up, half down: also where they do not cancel, what they have in common says nothing."""
    view, _ = viewed(bench, 2, (), 1.0)
    rates = common + np.where(np.arange(len(view.runs)) % 2 == 0, 1.0, -1.0)
    drifts = [rate * rows.signals.time for rate, rows in zip(rates, view.runs, strict=True)]
    name = first_name(with_drift(view, drifts, 2.0))
    assert name == "follows time (a rate of each run's own)" if bench == "quiet" else name in NAMELESS


def test_a_form_that_explains_more_leads_only_with_something_alike_in_all_runs() -> None:
    """With what each run has of its own a cause explains more; it stands against nothing as it does without."""
    plain, without, alike = doubted("zero-drift", 14.0, 14.0), doubted("zero-drift", 64.0, -2.0), ALIKE + 1.0
    assert fullest([without, plain]) is plain
    whole = fullest([doubted("zero-drift", 64.0, alike), plain])
    assert whole.value == 64.0
    assert whole.gated == pytest.approx(14.0)


@pytest.mark.parametrize(("left", "named"), [
    (SHAPE_ERROR * 200.0 - 1.0, True), (SHAPE_ERROR * 350.0 - 1.0, True), (SHAPE_ERROR * 350.0 + 1.0, False),
])  # fmt: skip
def test_two_names_are_taken_although_a_trifle_is_left(
    monkeypatch: pytest.MonkeyPatch, left: float, named: bool
) -> None:
    """Two names that explain more than something nameless stand in its place where what they leave is an error of
    shapes.
    """
    nameless = ranked("follows the displacement", 250.0, columns=6)
    first, second = ranked("abbe-tilt", 200.0), ranked("creep", 150.0)
    rest = Decision(ranked("follows the displacement", left, columns=6), 0.9, {}, ())
    decisions = iter([Decision(second, 0.9, {}, ()), rest])
    monkeypatch.setattr(course, "decided", lambda *_args, **_more: next(decisions))
    stage: Any = SimpleNamespace(step=step(nameless, first))
    stage.with_effect = lambda _best: stage
    alone = Decision(nameless, 0.9, {}, ())
    assert (_two_for(stage, alone, THRESHOLD).leader is first) is named


def test_the_second_best_name_may_be_the_first_of_two(monkeypatch: pytest.MonkeyPatch) -> None:
    """Beside the best one something nameless leads again, which stands for what the other one and it do together."""
    nameless = ranked("follows displacement and temperature", 337.0)
    best, other = ranked("nonlinear-expansion", 298.0), ranked("scale-error", 240.0)
    found = [ranked("follows displacement and temperature", 157.0), ranked("nonlinear-expansion", 276.0), None]
    decisions = iter([Decision(leader, 0.9, {}, ()) for leader in found])
    monkeypatch.setattr(course, "decided", lambda *_args, **_more: next(decisions))
    stage: Any = SimpleNamespace(step=step(nameless, best, other))
    stage.with_effect = lambda _best: stage
    assert _two_for(stage, Decision(nameless, 0.9, {}, ()), THRESHOLD).leader is other


@pytest.mark.parametrize(
    ("cause", "part", "size", "faint"),
    [
        ("creep", LATER_PART - 0.005, 0.1, True),
        ("creep", LATER_PART + 0.005, 0.1, False),
        ("creep", LATER_PART - 0.005, 0.4, False),
        ("zero-drift", APART - 0.005, 0.1, True),
        ("zero-drift", APART + 0.005, 0.1, False),
        ("zero-drift", APART - 0.005, 0.3, False),
    ],
)
def test_a_later_name_needs_a_part_of_what_the_first_ones_say(
    cause: str, part: float, size: float, faint: bool
) -> None:
    """What is left of a shape that is a sketch has no name, unless a parity proves it, or it is too large for that."""
    before = ranked("backlash", 900.0)
    found = [cast(Any, SimpleNamespace(ranked=before))]
    later = ranked(cause, part * 900.0)
    later = replace(later, best=replace(later.best, visible=size * before.best.visible))
    assert _too_faint(later, found, THRESHOLD) is faint
    assert not _too_faint(replace(later, witness=PROVEN), found, THRESHOLD)
