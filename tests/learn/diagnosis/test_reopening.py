"""A first cause that has most of a second one leaves it all in another form, and both are named."""

from __future__ import annotations

from pathlib import Path

import pytest

from hexathermal.learn.diagnosis import course
from tests.learn.diagnosis.campaigns import course_of

CAUSES = ("frame-expansion", "zero-drift")


@pytest.mark.long
def test_a_slow_first_cause_hides_no_drift(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A frame of four hours has most of a drift with time: with an hour and a half both explain more, and are named."""
    both = course_of(tmp_path / "both", "finite_volume", 5, CAUSES, 1.5)
    names = [one.ranked.cause for one in both.found]
    times = [item.trial.parameters.get("time_constant_s") for item in both.last.joined]
    assert names == list(CAUSES)
    assert both.found[0].ranked.best in both.last.joined
    assert times[0] == 5400.0
    monkeypatch.setattr(course, "form_beside", lambda *_arguments: None)
    alone = [one.ranked.cause for one in course_of(tmp_path / "alone", "finite_volume", 5, CAUSES, 1.5).found]
    assert alone == [CAUSES[0]]
