"""A diagnosis leaves nothing behind: six legs take no more memory than one."""

from __future__ import annotations

import gc
from pathlib import Path

import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.diagnosing import diagnose
from hexathermal.learn.diagnosis.view import View
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign


def _views() -> int:
    """Campaigns as a diagnosis sees them that are held in memory."""
    return sum(isinstance(item, View) for item in gc.get_objects())


@pytest.mark.long
def test_what_a_diagnosis_made_is_gone_when_it_is_done(tmp_path: Path) -> None:
    """No view of the data is left, although nobody collects what is dead meanwhile."""
    truth, answer = campaign_of("quiet", 4, causes=("backlash",), strength=1.0)
    write_campaign(tmp_path / "leg", truth, answer)
    campaign = load_campaign(tmp_path / "leg")
    gc.collect()
    before = _views()
    gc.disable()
    try:
        found = diagnose(campaign, list(answer.base))
        assert _views() == before
    finally:
        gc.enable()
    assert found.effects
