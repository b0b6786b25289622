"""Columns that the format has, listed among a campaign's inputs: they are what the format says, and must be there."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.signals import campaign_rows
from tests.learn.campaign_folders import changed, component_campaign, messages

MORE = {"air_temperature_degC": 22.0, "air_pressure_hPa": 1010.0, "air_humidity_percent": 40.0, "q_mm": 120.0,
        "settled": 1.0}  # fmt: skip


def with_columns(folder: Path, columns: dict[str, float]) -> Path:
    """Write a component's campaign whose tables have more columns, which all stand among its inputs."""
    component_campaign(folder)
    for file in (folder / "runs").iterdir():
        rows = list(csv.reader(file.read_text(encoding="utf-8").splitlines()))
        lines = [[*rows[0], *columns]]
        lines += [[*row, *(repr(value + 0.01 * (k % 7) * (name != "settled")) for name, value in columns.items())]
                  for k, row in enumerate(rows[1:])]  # fmt: skip
        file.write_text("\n".join(",".join(line) for line in lines) + "\n", encoding="utf-8")
    more = "".join(f'[[inputs]]\nname = "{name}"\n' for name in columns)
    changed(folder, "[[runs]]", more + "[[runs]]")
    return folder


def test_weather_and_displacement_among_the_inputs_are_weather_and_displacement(tmp_path: Path) -> None:
    """A part's pressure, place and rest may be called causes that were recorded, which they are; others stay inputs."""
    campaign = load_campaign(with_columns(tmp_path / "part", MORE))
    assert [item.name for item in campaign.inputs] == ["spindle_speed_rpm"]
    rows = campaign_rows(campaign, "identification")[0]
    assert rows.weather is not None
    assert rows.weather[0].tolist() == pytest.approx([22.0, 101000.0, 0.4])
    assert rows.usable.q is not None
    assert rows.usable.q[0] == pytest.approx(0.12)
    assert set(rows.signals.inputs) == {"spindle_speed_rpm"}


@pytest.mark.parametrize("name", list(MORE))
def test_what_is_listed_must_be_there(name: str, tmp_path: Path) -> None:
    """A column that the campaign lists and a table lacks is a fault, though the format can do without it."""
    folder = with_columns(tmp_path / "part", MORE)
    file = folder / "runs" / "a.csv"
    file.write_text(file.read_text(encoding="utf-8").replace(name, f"my_{name}", 1), encoding="utf-8")
    assert any("a.csv" in one and name in one for one in messages(folder))


@pytest.mark.parametrize("name", ["time_s", "drift_um", "T1_degC"])
def test_what_is_no_cause_is_no_input(name: str, tmp_path: Path) -> None:
    """Time, drift and the campaign's own thermometers are refused by name."""
    folder = component_campaign(tmp_path / "part")
    changed(folder, 'name = "spindle_speed_rpm"', f'name = "{name}"')
    assert any(f"takes column {name}, which the format has already" in one for one in messages(folder))
