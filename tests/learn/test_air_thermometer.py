"""A thermocouple in the room's air stands for the station where no column records that."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.diagnosing import diagnose
from hexathermal.learn.diagnosis.extension import gained
from hexathermal.learn.diagnosis.room_air import in_the_room
from hexathermal.learn.diagnosis.stage import view_of
from hexathermal.learn.signals import campaign_rows, run_rows
from hexathermal.simulate.hidden.drawing import campaign_of
from hexathermal.simulate.hidden.writing import write_campaign
from tests.learn.campaign_folders import changed, component_campaign, leg_campaign

SHARED = Path(__file__).resolve().parents[3] / "shared"


@pytest.mark.parametrize("part", ["room", "Air", "ambient", "room air", "air in the laboratory"])
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
    assert not [note for note in unseen.notes if "in the room" in note]


def hall_of(bench: str, seed: int, folder: Path, cause: str) -> tuple[str, ...]:
    """Write a part whose air is a thermocouple called T90, of which nothing says where it hangs; return the sensors."""
    truth, answer = campaign_of(bench, seed, causes=(cause,), strength=2.0)
    write_campaign(folder, truth, answer)
    for table in (folder / "runs").glob("*.csv"):
        table.write_text(table.read_text(encoding="utf-8").replace("air_temperature_degC", "T90_degC"), "utf-8")
    changed(folder, "[[thermocouples]]", '[[thermocouples]]\nname = "T90"\n\n[[thermocouples]]')
    return answer.base


@pytest.mark.long
@pytest.mark.parametrize("cause", ["frame-expansion", "sensor-detached"])
def test_a_thermocouple_that_nothing_warms_is_in_the_room(tmp_path: Path, cause: str) -> None:
    """It is told by what it reads, the cause is named by it, and the law foretells runs that do not say it either."""
    base = hall_of("actuator", 12, tmp_path / "part", cause)
    campaign = load_campaign(tmp_path / "part")
    found = diagnose(campaign, list(base))
    assert found.effects[0].cause == cause
    assert [note for note in found.notes if note.startswith("T90 is taken for a thermometer in the room")]
    assert "T90" in found.extended.read_sensors
    gain = gained(found.law, found.extended, campaign)
    assert gain is not None
    assert gain.total.rmse_after.value == pytest.approx(found.gain.total.rmse_after.value, rel=1e-9)  # type: ignore[union-attr]


@pytest.mark.parametrize("kept", [True, False])
def test_thermometers_that_all_warm_alike_hang_in_no_room(tmp_path: Path, kept: bool) -> None:
    """Without the one in the room none of the others is taken for it; with it, that one."""
    base = hall_of("actuator", 12, tmp_path / "part", "frame-expansion")
    if not kept:
        changed(tmp_path / "part", '[[thermocouples]]\nname = "T90"\n\n', "")
    campaign = load_campaign(tmp_path / "part")
    view = view_of(campaign, campaign_rows(campaign, "identification"), tuple(base))
    assert in_the_room(campaign, view) == ("T90" if kept else None)


@pytest.mark.skipif(not (SHARED / "measured").is_dir(), reason="the measured campaigns are not beside the checkout")
@pytest.mark.parametrize("name", ["machine-tool-ch1", "machine-tool-ch2"])
def test_no_thermometer_of_the_measured_machine_tools_is_taken_for_the_room(name: str) -> None:
    """None of the sixteen answers clearly less than the others."""
    campaign = load_campaign(SHARED / "measured" / name)
    view = view_of(campaign, campaign_rows(campaign, "identification"), ("T08", "T13"))
    assert in_the_room(campaign, view) is None
