"""A leg's dimensions in campaign.toml: what no leg has is a fault."""

from __future__ import annotations

from pathlib import Path

import pytest

from hexathermal.learn.campaign_files import load_campaign

from .campaign_folders import changed, leg_campaign, messages


@pytest.mark.parametrize(
    ("q0", "stroke", "wanted"),
    [
        ("0.6", "[0.0, 250.0]", "q0_mm is 0.6, less than a tenth of the stroke of 250 mm"),
        ("24.9", "[-5.0, 245.0]", "is q0_mm in metres?"),
        ("0.6", "[0.0, 0.25]", "q0_mm is 0.6, expected 10 or more between the joint centres"),
        ("9.9", "[0.0, 3.0]", "are q0_mm and stroke_mm in metres?"),
        ("80.0", "[0.0, 250.0]", ""),  # a telescope of several stages
        ("12.0", "[0.0, 4.0]", ""),
    ],
)
def test_a_leg_in_metres_is_a_fault(tmp_path: Path, q0: str, stroke: str, wanted: str) -> None:
    """A retracted length that is no length of a leg with such a stroke is told; odd but possible legs pass."""
    folder = leg_campaign(tmp_path)
    changed(folder, "q0_mm = 600.0", f"q0_mm = {q0}")
    changed(folder, "stroke_mm = [0.0, 250.0]", f"stroke_mm = {stroke}")
    if wanted:
        found = messages(folder, scan=False)
        assert len(found) == 1
        assert "campaign.toml:7:1" in found[0]
        assert wanted in found[0]
    else:
        load_campaign(folder, scan=False)
