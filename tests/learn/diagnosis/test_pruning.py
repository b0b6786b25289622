"""What joined is asked again at the end: what does harm to runs left out leaves the law."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import cast

import numpy as np
import pytest

from hexathermal.learn.diagnosis.evidence import Scored
from hexathermal.learn.diagnosis.pruning import LEAST_HARM, pruned
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.trials import Trial
from tests.learn.diagnosis.campaigns import viewed


def named(name: str) -> Scored:
    """A cause that joined."""
    return Scored(Trial(name, np.zeros((1, 1))), 0.0, 0.0, 1.0, 0.0, 1.0, np.ones(1))


@dataclass(frozen=True)
class Told:
    """A stage of which it is told what runs left out leave, by the names that joined."""

    joined: tuple[Scored, ...]
    squares: Mapping[str, float]

    @property
    def kinder_left(self) -> float:
        """Mean square of runs left out."""
        return self.squares["".join(item.trial.cause for item in self.joined)]


def left_of(squares: dict[str, float], asked: str = "abc") -> tuple[str, str]:
    """What stays of three causes, and what goes, in order."""
    items = {name: named(name) for name in "abc"}
    stage = cast(Stage, Told(tuple(items.values()), squares))
    after, gone = pruned(stage, [items[name] for name in asked])
    return "".join(item.trial.cause for item in after.joined), "".join(item.trial.cause for item in gone)


ALL = ["".join(some) for size in (1, 2, 3) for some in combinations("abc", size)]


def test_the_worst_goes_first_and_one_always_stays() -> None:
    """Of three that all do harm, the two whose leaving helps most go, in that order; the last stays."""
    squares = {"abc": 1.0, "ab": 0.5, "ac": 0.4, "bc": 0.6, "a": 0.2, "c": 0.1, "b": 0.3}
    assert sorted(squares) == sorted(ALL)
    assert left_of(squares) == ("c", "ba")


@pytest.mark.parametrize(("share", "gone"), [(LEAST_HARM + 0.01, "b"), (LEAST_HARM - 0.01, "")])
def test_little_harm_is_borne(share: float, gone: str) -> None:
    """A cause goes where the squares fall by the stated part, and stays where they fall by less."""
    squares = dict.fromkeys(ALL, 1.0) | {"ac": 1.0 - share}
    assert left_of(squares)[1] == gone


def test_only_what_is_asked_may_go() -> None:
    """A step of one run, or one of several shapes of a cause, is not asked, whatever runs left out say."""
    squares = dict.fromkeys(ALL, 1.0) | {"ac": 0.1}
    assert left_of(squares, "ac") == ("abc", "")


@pytest.mark.long
def test_on_a_real_stage_what_is_there_stays() -> None:
    """A plain effect that joined does not leave beside a shape that says nothing."""
    view, _answer = viewed("modal", 5, ("backlash",), 2.0)
    stage = Stage(view)
    there = max((item for item in stage.search.scored(stage.step.levels, stage.trials_left)
                 if item.trial.cause == "backlash"), key=lambda item: item.value)  # fmt: skip
    other = next(item for item in stage.search.scored(stage.step.levels, stage.trials_left)
                 if item.trial.cause == "scale-error")  # fmt: skip
    after, gone = pruned(stage.with_effect(there).with_effect(other), [there, other])
    assert there in after.joined
    assert there not in gone
