"""Two names in the place of something nameless: both stand, or neither does."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from hexathermal.learn.diagnosis import course
from hexathermal.learn.diagnosis.course import Course
from hexathermal.learn.diagnosis.deciding import Decision
from hexathermal.learn.diagnosis.stage import Stage
from tests.learn.diagnosis.campaigns import course_of


def diagnosed(folder: Path) -> Course:
    """The course of a diagnosis of two effects, a kink and a play."""
    return course_of(folder, "quiet", 733, ("outside: kink", "backlash"), 1.5)


def for_two(stage: Stage, decision: Decision, threshold: float) -> Decision:
    """The best name, as though a second one stood behind it."""
    name = next(item for item in stage.step.ranking if item.named and item.gated >= threshold)
    return replace(decision, leader=name, probability=0.9)


@pytest.mark.long
@pytest.mark.parametrize("second", [True, False])
def test_a_name_given_for_two_falls_with_the_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, second: bool
) -> None:
    """Where the second does not pay on runs left out, what has no name, and led, is the verdict."""
    monkeypatch.setattr(course, "_two_for", for_two)
    paid = course.worth
    monkeypatch.setattr(
        course, "worth", lambda stage, after, leader, *, later: paid(stage, after, leader, later=later)
        if second or not later else (False, False)
    )  # fmt: skip
    found = diagnosed(tmp_path / "campaign")
    if second:
        assert len(found.found) > 1
    else:
        assert not found.found
        assert found.last.joined == ()
        assert found.end.leader is not None
        assert not found.end.named
