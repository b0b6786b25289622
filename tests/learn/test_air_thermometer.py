"""A thermocouple in the room's air stands for the station where no column records that."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.diagnosing import diagnose
from hexathermal.learn.signals import run_rows
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign
from tests.learn.campaign_folders import changed, component_campaign, leg_campaign


@pytest.mark.parametrize("part", ["room", "Air", "ambient"])
def test_its_part_says_so(tmp_path: Path, part: str) -> None:
    """The air is what it reads, counted as a station's is."""
    folder = component_campaign(tmp_path)
    assert run_rows(load_campaign(folder), "a").signals.air is None
    changed(folder, 'name = "T1"', f'name = "T1"\npart = "{part}"')
    rows = run_rows(load_campaign(folder), "a")
    assert load_campaign(folder).air_thermometer == "T1"
    assert rows.signals.air is not None
    np.testing.assert_allclose(rows.signals.air, rows.signals.dT["T1"], atol=1e-9)


def test_it_counts_from_the_zero_of_the_campaign(tmp_path: Path) -> None:
    """Of a later run it begins where that room was, not at nought; what is left out of it is counted once."""
    folder = component_campaign(tmp_path)
    changed(folder, 'name = "T1"', 'name = "T1"\npart = "room"')
    rows = run_rows(load_campaign(folder), "b")
    assert rows.signals.air is not None
    assert rows.signals.air[0] == pytest.approx(2.0, abs=0.1)
    np.testing.assert_allclose(rows.signals.air, rows.signals.dT["T1"], atol=1e-9)
    table = np.genfromtxt(folder / "runs" / "b.csv", delimiter=",", names=True)
    table["T1_degC"][40] = 60.0
    np.savetxt(folder / "runs" / "b.csv", table, delimiter=",", comments="", header=",".join(table.dtype.names or ()))
    record = run_rows(load_campaign(folder), "b").record
    assert [(step.step, step.channel) for step in record.steps if step.step == "spike"] == [("spike", "T1_degC")]


def test_a_column_of_the_air_goes_first(tmp_path: Path) -> None:
    """Where a station records the air, a thermocouple that hangs in it is one of many."""
    folder = leg_campaign(tmp_path)
    before = run_rows(load_campaign(folder), "a").signals.air
    changed(folder, 'part = "body"', 'part = "room"')
    after = run_rows(load_campaign(folder), "a").signals.air
    assert before is not None
    assert after is not None
    np.testing.assert_array_equal(after, before)


@pytest.mark.long
def test_a_frame_is_named_by_a_thermocouple_in_the_room(tmp_path: Path) -> None:
    """A part with a stroke whose bench follows the room, and whose logger calls the air's column a thermocouple's."""
    truth, answer = campaign_of("actuator", 12, causes=("frame-expansion",), strength=2.0)
    folder = tmp_path / "part"
    write_campaign(folder, truth, answer)
    for table in (folder / "runs").glob("*.csv"):
        table.write_text(table.read_text(encoding="utf-8").replace("air_temperature_degC", "hall_degC"), "utf-8")
    changed(folder, "[[thermocouples]]", '[[thermocouples]]\nname = "hall"\npart = "room"\n\n[[thermocouples]]')
    found = diagnose(load_campaign(folder), list(answer.base))
    assert found.effects[0].cause == "frame-expansion"
    changed(folder, 'part = "room"', 'part = "cabinet"')
    unseen = diagnose(load_campaign(folder), list(answer.base))
    assert "frame-expansion" not in [one.cause for one in unseen.effects]
