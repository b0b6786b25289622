"""A thermocouple in the room's air stands for the station where no column records that."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.diagnosing import diagnose
from hexathermal.learn.diagnosis.extension import gained
from hexathermal.learn.diagnosis.mending import mended
from hexathermal.learn.diagnosis.room_air import in_the_room
from hexathermal.learn.signals import campaign_rows, run_rows
from hexathermal.machine.leg_repairs import SensorRepair
from hexathermal.machine.leg_signals import Memory
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
    assert not [note for note in unseen.notes if "is taken for" in note]


def hall_of(bench: str, seed: int, folder: Path, *causes: str) -> tuple[str, ...]:
    """Write a part whose air is a thermocouple called T90, and no part is stated; return the law's sensors."""
    truth, answer = campaign_of(bench, seed, causes=causes, strength=2.0)
    write_campaign(folder, truth, answer)
    for table in (folder / "runs").glob("*.csv"):
        table.write_text(table.read_text(encoding="utf-8").replace("air_temperature_degC", "T90_degC"), "utf-8")
    file = folder / "campaign.toml"
    file.write_text(re.sub(r"^part = .*\n", "", file.read_text(encoding="utf-8"), flags=re.MULTILINE), "utf-8")
    changed(folder, "[[thermocouples]]", '[[thermocouples]]\nname = "T90"\n\n[[thermocouples]]')
    return answer.base


def told(folder: Path, base: tuple[str, ...]) -> str | None:
    """Return the thermometer that is taken for the room."""
    campaign = load_campaign(folder)
    return in_the_room(campaign, campaign_rows(campaign, "identification"), base)


@pytest.mark.long
@pytest.mark.parametrize(("seed", "causes"), [
    (12, ("frame-expansion",)), (17, ("sensor-detached",)), (12, ("frame-expansion", "clock-offset")),
])  # fmt: skip
def test_a_thermocouple_that_nothing_warms_is_in_the_room(tmp_path: Path, seed: int, causes: tuple[str, ...]) -> None:
    """It is told by what it reads, the cause is named by it, and the law foretells runs that do not say it either.

    Although a clock is put right besides.
    """
    base = hall_of("actuator", seed, tmp_path / "part", *causes)
    campaign = load_campaign(tmp_path / "part")
    found = diagnose(campaign, list(base))
    assert causes[0] in [one.cause for one in found.effects]
    assert [note for note in found.notes if note.startswith("T90 is taken for a thermometer in the room")]
    assert not [note for note in found.notes if "T90 is not trusted" in note]
    reads = [term.parameters.get("sensor") for term in found.extended.terms if term.shape == "room"]
    reads += [one.parameters.get("air_sensor") for one in found.extended.repairs if one.kind == "loose"]
    assert set(reads) == {"T90"}
    gain = gained(found.law, found.extended, campaign)
    assert gain is not None
    assert found.gain is not None
    assert gain.total.rmse_after.value == pytest.approx(found.gain.total.rmse_after.value, rel=1e-9)


@pytest.mark.parametrize(("bench", "seed", "found"), [
    ("actuator", 12, "T90"), ("component", 12, "T90"), ("component", 14, "T90"), ("machine_tool", 12, "T90"),
    ("component", 13, None), ("machine_tool", 13, None),
])  # fmt: skip
def test_the_room_is_told_by_what_warms_all_others(tmp_path: Path, bench: str, seed: int, found: str | None) -> None:
    """With runs or one campaign as the zero; none where others are hardly warmer, and none without that thermometer."""
    base = hall_of(bench, seed, tmp_path / "part", "zero-drift")
    assert told(tmp_path / "part", base) == found
    changed(tmp_path / "part", 'name = "T90"', 'name = "T90"\npart = "cabinet"')
    assert told(tmp_path / "part", base) is None
    changed(tmp_path / "part", '[[thermocouples]]\nname = "T90"\npart = "cabinet"\n\n', "")
    assert told(tmp_path / "part", base) is None


def test_of_what_nothing_warms_the_quick_one_hangs_in_the_room(tmp_path: Path) -> None:
    """A frame follows the room by an hour, and is warmed by nothing else either."""
    base = hall_of("actuator", 12, tmp_path / "part", "zero-drift")
    for table in (tmp_path / "part" / "runs").glob("*.csv"):
        rows = np.genfromtxt(table, delimiter=",", names=True)
        frame = Memory().low_pass("frame", rows["time_s"], rows["T90_degC"], 3600.0)
        lines = table.read_text(encoding="utf-8").splitlines()
        lines = [f"{line},{value}" for line, value in zip(lines, ["T91_degC", *np.round(frame, 3)], strict=True)]
        table.write_text("\n".join(lines) + "\n", encoding="utf-8")
    changed(tmp_path / "part", "[[thermocouples]]", '[[thermocouples]]\nname = "T91"\n\n[[thermocouples]]')
    assert told(tmp_path / "part", base) == "T90"


@pytest.mark.parametrize("stated", ["T01", "station"])
def test_who_says_where_the_air_is_read_is_believed(tmp_path: Path, stated: str) -> None:
    """A thermometer that is said to hang in the room, or a column of the air in some runs: none is sought."""
    base = hall_of("actuator", 12, tmp_path / "part", "zero-drift")
    if stated == "station":
        table = min((tmp_path / "part" / "runs").glob("*.csv"))
        lines = table.read_text(encoding="utf-8").splitlines()
        ends = ["air_temperature_degC", *["20.5"] * (len(lines) - 1)]
        table.write_text("\n".join(f"{a},{b}" for a, b in zip(lines, ends, strict=True)) + "\n", encoding="utf-8")
    else:
        changed(tmp_path / "part", 'name = "T01"', 'name = "T01"\npart = "ambient"')
    assert told(tmp_path / "part", base) is None


def test_an_exchanged_plug_of_the_room_is_put_right_in_the_air_too(tmp_path: Path) -> None:
    """What stands for the air is mended with the thermometer that it is."""
    folder = component_campaign(tmp_path)
    changed(folder, 'name = "T1"', 'name = "T1"\npart = "room"')
    rows = run_rows(load_campaign(folder), "a")
    put = mended(rows, SensorRepair("sensor-drift", "drift", {"sensor": "T1", "rate_K_per_h": 0.5}))
    assert rows.air_sensor == "T1"
    np.testing.assert_array_equal(put.signals.air, put.signals.dT["T1"])  # type: ignore[arg-type]
    assert np.abs(put.signals.air - rows.signals.air).max() > 0.01  # type: ignore[operator]


@pytest.mark.skipif(not (SHARED / "measured").is_dir(), reason="the measured campaigns are not beside the checkout")
@pytest.mark.parametrize("name", ["machine-tool-ch1", "machine-tool-ch2"])
def test_no_thermometer_of_the_measured_machine_tools_is_taken_for_the_room(name: str) -> None:
    """The spindle tells little of most of the sixteen, so that none stands out by it."""
    assert told(SHARED / "measured" / name, ("T08", "T13")) is None
