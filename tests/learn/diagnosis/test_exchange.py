"""The first of two names is asked again beside the second."""

from __future__ import annotations

from pathlib import Path

import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.diagnosis import course
from hexathermal.learn.diagnosis.course import Course, base_law, searched
from hexathermal.learn.signals import campaign_rows
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign

PAIRS = [(1027, ("clock-offset", "abbe-tilt")), (2033, ("clock-offset", "abbe-tilt"))]


def diagnosed(folder: Path, seed: int, causes: tuple[str, ...]) -> Course:
    """The course of a diagnosis of two effects of a little more than the noise."""
    truth, answer = campaign_of("finite_volume", seed, causes=causes, strength=1.1)
    write_campaign(folder, truth, answer)
    campaign = load_campaign(folder)
    rows = campaign_rows(campaign, "identification")
    return searched(campaign, base_law(campaign, rows, answer.base, None), rows)


@pytest.mark.parametrize(("seed", "causes"), PAIRS)
def test_a_first_name_that_the_second_effect_feigned_is_exchanged(
    tmp_path: Path, seed: int, causes: tuple[str, ...]
) -> None:
    """Two effects together looked like a third cause: beside the second name the right first one leads, and both stand
    alone at the end.
    """
    found = diagnosed(tmp_path / "campaign", seed, causes)
    assert {one.ranked.cause for one in found.found} == set(causes)
    assert all(one.joined for one in found.found)


def test_without_the_exchange_the_first_name_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Forward steps alone keep the wrong one."""
    monkeypatch.setattr(course, "rival_beside", lambda *_arguments: None)
    seed, causes = PAIRS[0]
    found = diagnosed(tmp_path / "campaign", seed, causes)
    assert found.found[0].ranked.cause not in causes
