"""A first cause that has most of a second one leaves it all in another form, and both are named."""

from __future__ import annotations

from pathlib import Path

import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.diagnosis import course
from hexathermal.learn.diagnosis.course import Course, base_law, searched
from hexathermal.learn.signals import campaign_rows
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign

CAUSES = ("frame-expansion", "zero-drift")


def searched_for(folder: Path, bench: str, seed: int) -> Course:
    """The course of a diagnosis of a bench that follows the room beside a zero that drifts."""
    truth, answer = campaign_of(bench, seed, causes=CAUSES, strength=1.5)
    write_campaign(folder, truth, answer)
    campaign = load_campaign(folder)
    rows = campaign_rows(campaign, "identification")
    return searched(campaign, base_law(campaign, rows, answer.base, None), rows)


def test_a_slow_first_cause_hides_no_drift(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A frame of four hours has most of a drift with time: with an hour and a half both explain more, and are named."""
    both = searched_for(tmp_path / "both", "finite_volume", 4)
    names = [one.ranked.cause for one in both.found]
    times = [item.trial.parameters.get("time_constant_s") for item in both.last.joined]
    assert names == list(CAUSES)
    assert both.found[0].ranked.best in both.last.joined
    assert times[0] == 5400.0
    monkeypatch.setattr(course, "form_beside", lambda *_arguments: None)
    alone = [one.ranked.cause for one in searched_for(tmp_path / "alone", "finite_volume", 4).found]
    assert alone == [CAUSES[0]]
