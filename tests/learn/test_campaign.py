"""Campaigns read from their files: what is right is read exactly, what is wrong is listed, all of it, with places."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hexathermal.errors import Problem
from hexathermal.learn.campaign_faults import CampaignError
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.campaign_units import MOST_ROWS, Sample
from hexathermal.learn.cleaning import used_run

from .campaign_folders import SENSORS, Table, changed, leg_campaign, leg_table, messages, write_table


def test_a_campaign_is_read_as_written(tmp_path: Path) -> None:
    """Kind, dimensions, beams, runs and thermocouples are those of campaign.toml, in SI units."""
    campaign = load_campaign(leg_campaign(tmp_path))
    assert (campaign.kind, campaign.title, campaign.zero) == ("leg", "small bench", "run")
    assert campaign.leg is not None
    assert campaign.leg.retracted_length == 0.6
    assert campaign.leg.stroke == (0.0, 0.25)
    assert campaign.beams is not None
    assert campaign.beams.dead_path == 0.7
    assert np.allclose(campaign.beams.azimuths, np.radians([0.0, 120.0, 240.0]))
    assert campaign.sensors == SENSORS
    assert campaign.thermocouples[3].position == 0.15
    assert [run.name for run in campaign.runs_of("validation")] == ["c"]
    assert load_campaign(tmp_path / "campaign.toml").sensors == SENSORS


def test_all_faults_of_all_files_come_in_one_error(tmp_path: Path) -> None:
    """Faults of campaign.toml and of every table stand in one message, with file, line and column."""

    def edit(table: Table) -> Table:
        names = {"T02_degC": "T02_K", "beam1_mm": "beam1_um", "q_mm": "q_m"}
        return {names.get(name, name): values for name, values in table.items()}

    leg_campaign(tmp_path, edit=edit)
    (tmp_path / "runs" / "b.csv").unlink()
    lines = (tmp_path / "runs" / "c.csv").read_text().splitlines()
    fields = lines[7].split(",")
    lines[7] = ",".join(["x1", *fields[1:]])
    (tmp_path / "runs" / "c.csv").write_text("\n".join(lines) + "\n")
    changed(tmp_path, "stroke_mm = [0.0, 250.0]", "stroke_mm = [250.0, 0.0]")
    changed(tmp_path, 'role = "validation"', 'role = "validaton"')
    changed(tmp_path, "title", "titel")
    found = messages(tmp_path)
    wanted = [
        "campaign.toml:3:1 unknown key 'titel'",
        "campaign.toml:8:1 leg.stroke_mm must be [low, high] with low < high",
        "did you mean 'validation'?",
        "a.csv:1:2 column q_mm is missing; 'q_m' has another unit",
        "a.csv:1:5 column T02_degC is missing; 'T02_K' has another unit",
        "a.csv:1:8 column beam1_mm is missing; 'beam1_um' has another unit",
        "b.csv:1:1 the table is not there",
        "c.csv:8:1 time_s is 'x1', expected a number",
    ]
    assert len(found) == len(wanted)
    for text in wanted:
        assert any(text in line for line in found), text


def short_rows(table: Table) -> Table | None:
    """Empty a column from the middle to the end."""
    table["T03_degC"][300:] = np.nan
    return None


def lost_block(table: Table) -> Table | None:
    """Empty a block of all columns but the time."""
    for name in table:
        if name != "time_s":
            table[name][100:150] = np.nan
    return None


def backwards(table: Table) -> Table:
    """Turn all rows round."""
    return {name: values[::-1] for name, values in table.items()}


def one_row(table: Table) -> Table:
    """Leave one row."""
    return {name: values[:1] for name, values in table.items()}


def kelvins(table: Table) -> Table | None:
    """Write kelvins under the name of degrees Celsius."""
    table["T01_degC"] += 273.15
    return None


def metres(table: Table) -> Table | None:
    """Write metres under the name of millimetres."""
    table["q_mm"] *= 1e-3
    return None


def micrometres(table: Table) -> Table | None:
    """Write micrometres under the name of millimetres, with one missing code."""
    table["q_mm"] *= 1e3
    table["q_mm"][77] = 9999.0
    return None


def beam_in_micrometres(table: Table) -> Table | None:
    """Write one beam in micrometres."""
    table["beam2_mm"] *= 1e3
    return None


def turned_beam(table: Table) -> Table | None:
    """Turn the sign of a beam."""
    table["beam3_mm"] *= -1.0
    return None


def dead_beam(table: Table) -> Table | None:
    """Cut a beam off."""
    table["beam1_mm"] *= 0.0
    return None


def all_in_micrometres(table: Table) -> Table | None:
    """Write the rod and all beams in micrometres."""
    for name in ("q_mm", "beam1_mm", "beam2_mm", "beam3_mm"):
        table[name] *= 1e3
    return None


def pascals(table: Table) -> Table | None:
    """Write the pressure in pascals."""
    table["air_pressure_hPa"] *= 100.0
    return None


def kilopascals(table: Table) -> Table | None:
    """Write the pressure in kilopascals."""
    table["air_pressure_hPa"] *= 0.1
    return None


def fraction(table: Table) -> Table | None:
    """Write the humidity as a fraction."""
    table["air_humidity_percent"] *= 0.01
    return None


def air_in_kelvins(table: Table) -> Table | None:
    """Write kelvins of the air, and of all thermocouples."""
    for name in table:
        if name.endswith("_degC"):
            table[name] += 273.15
    return None


def no_beam(table: Table) -> Table | None:
    """Empty a beam."""
    table["beam2_mm"][:] = np.nan
    return None


def odd_flag(table: Table) -> Table | None:
    """Write a number that is no flag."""
    table["settled"][33] = 2.0
    return None


@pytest.mark.parametrize(
    ("edit", "wanted"),
    [
        (short_rows, "a.csv:302:6 column T03_degC holds no number from line 302 to the end of the table (300 rows)"),
        (lost_block, "a.csv:102:2 columns q_mm, settled, T01_degC"),
        (backwards, "a.csv:3:1 time_s goes back: 599 of 600 rows"),
        (one_row, "a.csv:2:1 the table has one row"),
        (kelvins, "a.csv:2:4 T01_degC reads 293"),
        (metres, "while q_mm moves over 0.23: one of them is in another unit"),
        (micrometres, "a.csv:2:8 beam1_mm moves over 230.005 while q_mm moves over 230000: one of them is in another"),
        (beam_in_micrometres, "a.csv:2:9 beam2_mm moves over 230005 while q_mm moves over 230: one of them"),
        (turned_beam, "a.csv:2:10 beam3_mm moves against q_mm"),
        (dead_beam, "a.csv:2:8 beam1_mm does not move while q_mm moves over 230 mm"),
        (all_in_micrometres, "a.csv:2:2 q_mm runs from 15000 to 225000, many times beyond stroke_mm [0, 250]"),
        (pascals, "a.csv:2:12 air_pressure_hPa reads 100"),
        (pascals, "pascals? the column is in hPa; convert it"),
        (kilopascals, "kilopascals? the column is in hPa; convert it, or, if it is so"),
        (fraction, "a fraction? the column is in percent; convert it"),
        (air_in_kelvins, "a.csv:2:4 5 columns, T01_degC to air_temperature_degC, read 29"),
        (no_beam, "a.csv:2:9 beam2_mm holds no number in any of 600 rows"),
        (odd_flag, "a.csv:35:3 settled is 2, expected 1 at rest"),
    ],
    ids=lambda item: item.__name__ if callable(item) else "",
)
def test_a_damaged_table_is_refused_with_its_place(
    tmp_path: Path, edit: Callable[[Table], Table | None], wanted: str
) -> None:
    """What no cleaning can make good without guessing is a fault."""
    found = messages(leg_campaign(tmp_path, edit=edit))
    assert any(wanted in line for line in found), found
    assert len(found) == (3 if edit in (metres, micrometres) else 1)


@pytest.mark.parametrize("compensated", [True, False])
@pytest.mark.parametrize("edit", [pascals, fraction], ids=["Pa", "fraction"])
def test_weather_in_another_unit_is_a_fault_of_every_run(
    tmp_path: Path, edit: Callable[[Table], Table | None], compensated: bool
) -> None:
    """One fault a run, whether the beams are corrected by the weather or not, beside all other faults."""
    folder = leg_campaign(tmp_path, compensated=compensated)
    for seed, name in enumerate(("a", "b", "c")):
        table = leg_table(seed)
        edit(table)
        write_table(folder / "runs" / f"{name}.csv", table)
    changed(folder, "title", "titel")
    found = messages(folder)
    assert len(found) == 4
    assert "unknown key 'titel'" in found[0]
    assert "did you mean 'title'?" in found[0]
    assert [line[:5] for line in found[1:]] == ["a.csv", "b.csv", "c.csv"]


def test_unusual_weather_can_be_accepted(tmp_path: Path) -> None:
    """Dry air below 1 %, and a low pressure: faults with a way out, which works."""

    def edit(table: Table) -> None:
        table["air_humidity_percent"] *= 0.01
        table["air_pressure_hPa"] *= 0.11

    folder = leg_campaign(tmp_path, edit=edit)
    assert all('accept = ["unusual-weather"]' in line for line in messages(folder))
    with (folder / "campaign.toml").open("a") as file:
        file.write('[cleaning]\naccept = ["unusual-weather"]\n')
    assert load_campaign(folder).accepted == ("unusual-weather",)


def test_a_text_in_every_row_is_one_fault(tmp_path: Path) -> None:
    """'true' and 'false' for the flag: one fault for each word, counted; the column is not missing besides."""
    folder = leg_campaign(tmp_path)
    file = folder / "runs" / "b.csv"
    head, *rows = file.read_text().splitlines()
    fields = [row.split(",") for row in rows]
    lines = [",".join([*row[:2], "true" if row[2] == "1.0" else "false", *row[3:]]) for row in fields]
    file.write_text("\n".join([head, *lines]) + "\n")
    found = messages(folder)
    assert len(found) == 2
    assert "b.csv:2:3 settled is 'true', expected 1 at rest, 0 otherwise (and 553 more that read the same" in found[0]


@pytest.mark.parametrize("still", [0.0, 1e-5])
def test_sound_campaigns_have_no_unit_fault(tmp_path: Path, still: float) -> None:
    """A rod at rest, a beam that lost count, codes among the weather: nothing of a unit is said."""

    def edit(table: Table) -> None:
        for beam in (1, 2, 3):
            table[f"beam{beam}_mm"] -= table["q_mm"] - table["q_mm"][0]
        table["q_mm"] = 120.0 + still * np.random.default_rng(2).standard_normal(600)
        table["beam2_mm"][300:] += 80.0
        table["air_pressure_hPa"][50:90] = 9999.0
        table["air_humidity_percent"][:] = 100.4

    assert len(load_campaign(leg_campaign(tmp_path, edit=edit)).runs) == 3


@given(st.lists(st.integers(1, 9000), min_size=1, max_size=6))
def test_a_sample_is_even_and_does_not_depend_on_the_blocks(blocks: list[int]) -> None:
    """Every k-th row from the first on, k the smallest power of two that leaves no more than the rows allowed."""
    rows = np.arange(float(sum(blocks)))[:, None]
    sample = Sample(1)
    for part in np.split(rows, np.cumsum(blocks)[:-1]):
        sample.add(part)
    stride = 1
    while len(rows[::stride]) > MOST_ROWS:
        stride *= 2
    assert np.array_equal(sample.rows, rows[::stride])


def test_advice_stands_only_where_it_works(tmp_path: Path) -> None:
    """Some rows out of order may be left out by name; of a table that runs backwards nothing would be left."""

    def edit(table: Table) -> None:
        table["time_s"][100:150] = table["time_s"][100:150][::-1].copy()

    assert 'accept = ["clock-disorder"]' in messages(leg_campaign(tmp_path / "some", edit=edit))[0]
    (found,) = messages(leg_campaign(tmp_path / "all", edit=backwards))
    assert "accept" not in found
    assert "sort the table by time_s" in found


def test_two_names_for_one_column_are_a_fault_and_a_swap_is_none(tmp_path: Path) -> None:
    """[columns] that reads T02's column as T01 too is refused; T01 and T02 exchanged are exchanged."""
    folder = leg_campaign(tmp_path)
    text = (folder / "campaign.toml").read_text()
    (folder / "campaign.toml").write_text(text + '[columns]\nT01_degC = "T02_degC"\n')
    (found,) = messages(folder)
    assert "column 'T02_degC' would be read as T01_degC and as T02_degC" in found
    (folder / "campaign.toml").write_text(text + '[columns]\nT01_degC = "T02_degC"\nT02_degC = "T01_degC"\n')
    swapped, _ = used_run(load_campaign(folder), "a")
    (folder / "campaign.toml").write_text(text)
    plain, _ = used_run(load_campaign(folder), "a")
    assert np.array_equal(swapped.dT[:, [1, 0]], plain.dT[:, :2])


def test_a_mapped_column_that_is_missing_is_named_so(tmp_path: Path) -> None:
    """The name that [columns] gives is the one that is missing, and what may have been meant is said."""
    folder = leg_campaign(tmp_path, validation=False)
    with (folder / "campaign.toml").open("a") as file:
        file.write('[columns]\nbeam1_mm = "laser"\n')
    found = messages(folder)
    assert len(found) == 2
    assert "column 'laser' is missing, which [columns] of campaign.toml gives as the name of beam1_mm" in found[0]
    assert "another unit" not in found[0]


def test_an_empty_table_names_the_header_it_lacks(tmp_path: Path) -> None:
    """A file of no bytes, or of blank lines: the columns that are expected are listed."""
    folder = leg_campaign(tmp_path)
    (folder / "runs" / "a.csv").write_text("")
    (folder / "runs" / "b.csv").write_text("\n\n")
    found = messages(folder)
    assert len(found) == 2
    assert all("expected a header line: time_s,q_mm,settled,T01_degC" in line for line in found)


def test_rows_that_end_early_are_counted_and_located(tmp_path: Path) -> None:
    """A column lost half-way is one fault: where it begins, how many rows, no advice that would not help."""
    leg_campaign(tmp_path)
    file = tmp_path / "runs" / "a.csv"
    lines = file.read_text().splitlines()
    file.write_text("\n".join([*lines[:301], *(line.rpartition(",")[0] for line in lines[301:])]) + "\n")
    found = messages(tmp_path)
    assert any(line.startswith("a.csv:302:13 found 12 fields, expected 13") for line in found)
    assert len(found) == 1
    assert "the row ends before air_humidity_percent" in found[0]
    assert "and 299 more that read the same, the last in line 601" in found[0]
    assert "missing-blocks" not in found[0]


def test_no_validation_run_is_a_fault_only_where_one_is_needed(tmp_path: Path) -> None:
    """A campaign without a validation run can be read, but not where a validation run is asked for."""
    leg_campaign(tmp_path, validation=False)
    assert len(load_campaign(tmp_path).runs) == 2
    assert "there is no validation run" in messages(tmp_path, needed=("validation",))[0]


def test_faults_can_be_accepted_by_name(tmp_path: Path) -> None:
    """[cleaning] accept turns lost blocks and a clock that runs back into rows that are left out and counted."""

    def edit(table: Table) -> Table | None:
        table["T03_degC"][300:] = np.nan
        table["time_s"][100:150] = table["time_s"][100:150][::-1].copy()
        return None

    leg_campaign(tmp_path, edit=edit)
    assert len(messages(tmp_path)) == 2
    with (tmp_path / "campaign.toml").open("a") as file:
        file.write('[cleaning]\naccept = ["missing-blocks", "clock-disorder"]\n')
    block, record = used_run(load_campaign(tmp_path), "a")
    assert record.count("missing", "T03_degC") >= 290
    assert record.count("clock disorder") + record.count("clock jump") == 49
    assert np.isnan(block.dT[-1, 2])


def test_repeated_names_and_files_are_faults(tmp_path: Path) -> None:
    """A name twice, a table used twice, a name of [columns] that is none: each is said."""
    leg_campaign(tmp_path)
    changed(tmp_path, 'name = "T02"', 'name = "T01"')
    changed(tmp_path, 'file = "runs/b.csv"', 'file = "runs/a.csv"')
    with (tmp_path / "campaign.toml").open("a") as file:
        file.write('[columns]\nT03_degc = "temp 3"\n')
    found = "\n".join(messages(tmp_path))
    assert "name 'T01' is there twice in [[thermocouples]]" in found
    assert "is the table of run 'a' already" in found
    assert "did you mean 'T03_degC'?" in found


def test_the_same_fault_of_several_files_is_told_once(tmp_path: Path) -> None:
    """One line with its place, then how many more files have it and which; `faults` holds each of them."""
    folder = leg_campaign(tmp_path / "campaign")
    files = [folder / "runs" / f"{name}.csv" for name in "abc"]
    for file in files:
        file.write_text(file.read_text().replace("time_s", "seconds", 1))
    with pytest.raises(CampaignError) as caught:
        load_campaign(folder)
    first, *others = str(caught.value).splitlines()
    assert first.endswith("3 faults in 3 files")
    assert others[0].startswith(f"  {files[0]}, line 1, column 1: column time_s is missing")
    assert others[1:] == ["    the same in 2 more files: runs/b.csv, runs/c.csv"]
    assert len(caught.value.faults) == 3
    many = CampaignError("x/campaign.toml", tuple((f"x/runs/{k}.csv", Problem(1, 1, "bad")) for k in range(9)))
    assert (
        str(many).splitlines()[2] == "    the same in 8 more files: runs/1.csv, runs/2.csv, runs/3.csv, ..., runs/8.csv"
    )
