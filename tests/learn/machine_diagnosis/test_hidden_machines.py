"""Effects hidden in whole hexapods by a generator that shares no code with the diagnosis are found, from files.

Machines, halls, poses, noise, frames and strengths are drawn from fresh entropy at each run of the tests. Bounds follow
from stated rates, so that a diagnosis that has them breaks one at most once in a thousand runs; blind ones break them.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.hidden_effects import CLEAN, ONE, OUTSIDE, TWO
from benchmarks.hidden_machines import CAUSES, MachineOutcome, outcome_of, plan, pulls_of, true_values
from tests.learn.diagnosis.bounds import Bound
from tests.learn.shared_draws import fresh_entropy, shared

DRAWS = 20
VISIBLE = 0.15
"""Strength, with frames of runs put aside, from which an effect counts as plain."""

WIDEST_PULL = 6.0
"""Standard deviations by which the median parameter of the draws may be off its true value at the most."""


@pytest.fixture(scope="module")
def entropy() -> int:
    """A seed nobody has tried; the same in all processes of a run."""
    return fresh_entropy()


@pytest.fixture(autouse=True)
def said(request: pytest.FixtureRequest) -> None:
    """Let every failure tell the seed: `plan(DRAWS, seed)` gives the same draws."""
    if "entropy" in request.fixturenames:
        print(f"seed {request.getfixturevalue('entropy')}")


@pytest.fixture(scope="module")
def outcomes(entropy: int, tmp_path_factory: pytest.TempPathFactory) -> list[MachineOutcome]:
    """What the diagnosis said of fresh draws, all causes in turn."""
    texts = shared(tmp_path_factory, f"machines-{entropy}", plan(DRAWS, entropy),
                   lambda draw: json.dumps(outcome_of(draw).to_dict()))  # fmt: skip
    return [MachineOutcome(**json.loads(text)) for text in texts]


def plain(*kinds: str) -> Callable[[Sequence[MachineOutcome]], list[MachineOutcome]]:
    """The choice of draws of some kinds whose effects are plain."""
    return lambda draws: [one for one in draws if one.kind in kinds and min(one.visible) >= VISIBLE]


def of(*kinds: str) -> Callable[[Sequence[MachineOutcome]], list[MachineOutcome]]:
    """The choice of draws of some kinds."""
    return lambda draws: [one for one in draws if one.kind in kinds]


def rightly_named(draws: Sequence[MachineOutcome]) -> list[MachineOutcome]:
    """The choice of single effects whose name was found."""
    return [one for one in draws if one.kind == ONE and one.right]


BOUNDS = (
    Bound("plain single effect, first name right or stated to be equivalent", 0.80, True, plain(ONE),
          lambda one: one.right_or_equivalent),
    Bound("any single effect, first name right", 0.50, True, of(ONE), lambda one: one.right),
    Bound("single effect, wrong name", 0.15, False, of(ONE), lambda one: one.wrong),
    Bound("name right, on the right leg, plate or joint", 0.85, True, rightly_named, lambda one: one.place_right),
    Bound("nothing hidden, something named", 0.03, False, of(CLEAN), lambda one: bool(one.names)),
    Bound("outside the catalogues, something named", 0.40, False, of(OUTSIDE), lambda one: bool(one.names)),
    Bound("two effects, first name right", 0.50, True, plain(TWO), lambda one: one.right),
)  # fmt: skip


def test_draws_are_of_all_causes_and_machines(outcomes: list[MachineOutcome]) -> None:
    """All eight causes, clean and foreign campaigns, several machines and halls are among the draws."""
    assert {one.causes[0] for one in outcomes if one.kind == ONE} == set(CAUSES)
    assert {one.kind for one in outcomes} >= {CLEAN, ONE, OUTSIDE, TWO}
    assert len({one.machine for one in outcomes}) >= 2
    assert len({one.hall for one in outcomes}) >= 2


def test_no_draw_fails(outcomes: list[MachineOutcome]) -> None:
    """Every folder is read and diagnosed without an error, and the answer is a verdict with a probability."""
    assert not [one.told() for one in outcomes if one.failed]
    assert all(one.verdict in ("effect", "none", "unexplained") for one in outcomes)
    assert all(0.0 <= one.probability <= 1.0 for one in outcomes)


@pytest.mark.parametrize("bound", BOUNDS, ids=lambda bound: bound.claim)
def test_rates_are_as_stated(outcomes: list[MachineOutcome], bound: Bound) -> None:
    """Naming, places, wrong names and false alarms keep their stated rates within chance."""
    assert not bound.broken(outcomes), bound.broken(outcomes)


def test_parameters_are_where_their_intervals_say(outcomes: list[MachineOutcome]) -> None:
    """Half of the parameters of rightly named effects lie well within reach of their stated uncertainties."""
    pulls = [abs(pull) for one in outcomes for pull in one.pulls.values()]
    assert pulls
    assert np.median(pulls) < WIDEST_PULL
    assert np.mean(np.array(pulls) < 3.0) > 0.5


def test_knowing_the_name_pays(outcomes: list[MachineOutcome]) -> None:
    """Where the true machine would gain a twentieth on runs never fitted, the extended one mostly gains half of it."""
    pairs = [(one.gain[kind] or 0.0, best) for one in outcomes if one.kind == ONE
             for kind, best in one.oracle_gain.items() if best is not None and best > 0.05]  # fmt: skip
    if len(pairs) < 6:
        pytest.skip(f"only {len(pairs)} gains to be had")
    assert np.mean([gain > 0.5 * best for gain, best in pairs]) > 0.5


@pytest.mark.parametrize("verdict", ["none", "effect"])
def test_blind_diagnoses_break_the_bounds(outcomes: list[MachineOutcome], verdict: str) -> None:
    """Always saying none, or a random name, breaks a bound on these draws."""
    rng = np.random.default_rng(1)
    guessed = [
        replace(one, verdict=verdict, names=[str(rng.choice(CAUSES))] if verdict == "effect" else [], equivalent=[],
                places=["leg1"] if verdict == "effect" else [])
        for one in outcomes
    ]  # fmt: skip
    assert [bound.claim for bound in BOUNDS if bound.broken(guessed)]


def test_true_values_are_those_that_are_told() -> None:
    """A parameter that is stated exactly has no pull; one off by its std one of 1; wrong places have none."""
    hidden = {"target": "base joint 2", "size": 2e-5, "x": 0.6, "y": 0.0, "z": 0.8}
    answer = {"causes": ["joint-offset"], "targets": ["base joint 2"], "parameters": [hidden]}
    told = {
        name: {"value": value + 0.5 * (name == "offset_z_um"), "std": 0.5}
        for name, value in true_values("joint-offset", hidden).items()
    }
    said = {"cause": "joint-offset", "target": "base joint 2", "parameters": told}
    assert pulls_of(said, answer) == pytest.approx({"offset_x_um": 0.0, "offset_y_um": 0.0, "offset_z_um": 1.0})
    assert true_values("joint-offset", hidden)["offset_x_um"] == pytest.approx(12.0)
    assert not pulls_of({**said, "target": "base joint 3"}, answer)
    assert not pulls_of({**said, "cause": "leg-backlash"}, answer)
