"""A cause that acts on the law's expansion grows along the leg as the law does, once what bent that has joined."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hexathermal.learn.diagnosis import joining
from hexathermal.learn.diagnosis.channels import Levels
from hexathermal.learn.diagnosis.course import Course
from tests.learn.diagnosis.campaigns import course_of


def off(course: Course) -> float:
    """By how much the ratio of the first cause differs from that of the law that it joined."""
    trial = course.found[0].ranked.best.trial
    return abs(trial.parameters["ratio"] - course.last.bench.ratios[str(trial.target)])


def evidence(course: Course, levels: Levels) -> float:
    """The log evidence of the law with all that joined it, and of nothing else."""
    X, sd = course.last.view.base_columns, course.last.channel.loose(course.last.view.base_columns)
    joined = course.last.joined
    X = np.column_stack([X, *(item.trial.columns for item in joined)])
    sd = np.concatenate([sd, *(4.0 * item.size for item in joined)])
    return course.last.channel.evidences(X, sd, [levels])[0]


@pytest.mark.long
def test_a_lag_has_the_ratio_of_the_law_beside_a_scale(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A scale that is wrong bends B / A, and with it the lag that is named before it; both are put right together."""
    causes = ("thermal-lag", "scale-error")
    course = course_of(tmp_path / "grown", "finite_volume", 1, causes, 1.5)
    names, own, said = [one.ranked.cause for one in course.found], off(course), evidence(course, course.last.levels)
    assert names == list(causes)
    assert own < 0.25
    monkeypatch.setattr(joining, "grown", lambda stage, _levels: stage)
    stiff = course_of(tmp_path / "stiff", "finite_volume", 1, causes, 1.5)
    bent, less = off(stiff), evidence(stiff, stiff.last.levels)
    assert bent > 0.5
    assert said > less + 10.0
