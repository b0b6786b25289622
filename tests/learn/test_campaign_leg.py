"""A leg's dimensions in campaign.toml: what no leg has is a fault."""

from __future__ import annotations

from pathlib import Path

import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.check_remarks import of_places

from .campaign_folders import SENSORS, changed, leg_campaign, messages


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


@pytest.mark.parametrize("place", [2640.0, -264.0])
def test_a_thermocouple_far_beside_the_leg_is_a_fault(tmp_path: Path, place: float) -> None:
    """A digit or a sign too many would make it another thermometer for all that is said of places."""
    folder = leg_campaign(tmp_path)
    changed(folder, "position_mm = 50", f"position_mm = {place}")
    (found,) = messages(folder, scan=False)
    assert f"position_mm of {SENSORS[1]} is {place:g}, expected -150 to 1000: along the leg of 600 mm" in found
    assert "leave it out where the thermocouple is not on the leg" in found


def test_places_in_metres_are_asked_for(tmp_path: Path) -> None:
    """Places that are all within a hundredth of the leg are told, and places of a leg are not."""
    folder = leg_campaign(tmp_path)
    assert of_places(load_campaign(folder)) == []
    for k in range(1, len(SENSORS)):
        changed(folder, f"position_mm = {50 * k}\n", f"position_mm = {0.05 * k}\n")
    (said,) = of_places(load_campaign(folder))
    assert said.endswith("is position_mm in metres?")


@pytest.mark.parametrize(
    ("old", "new"),
    [("q0_mm = 600.0", "q0_mm = 1e150"), ("dead_path_mm = 700.0", "dead_path_mm = 1e300")],
)
def test_lengths_of_kilometres_are_faults(tmp_path: Path, old: str, new: str) -> None:
    """No leg and no beam is that long, and no number of them could be trusted."""
    folder = leg_campaign(tmp_path)
    changed(folder, old, new)
    assert "less than a kilometre" in messages(folder, scan=False)[0]


def test_a_title_is_one_line(tmp_path: Path) -> None:
    """A terminal's control characters and lines of their own do not get into what is printed."""
    folder = leg_campaign(tmp_path)
    changed(folder, 'title = "small bench"', 'title = "small\\u001b[31m bench\\n"')
    (found,) = messages(folder, scan=False)
    assert "holds a line's end or another control character" in found


def test_a_table_of_the_other_kind_is_pointed_at(tmp_path: Path) -> None:
    """A Parquet table beside a missing CSV one is named: campaign.toml says which of them it is."""
    folder = leg_campaign(tmp_path)
    (folder / "runs" / "b.csv").rename(folder / "runs" / "b.parquet")
    (found,) = messages(folder, scan=False)
    assert "the table is not there" in found
    assert "b.parquet is there: write file = ... of that name" in found
