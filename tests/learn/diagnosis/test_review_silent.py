"""Thermometers, inputs and weather that a run lacks: left out and told, never a fault inside."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from hexathermal.errors import ArgumentError
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.diagnosis import diagnose
from hexathermal.learn.diagnosis.recorded import judged_runs, refuse_silent
from hexathermal.learn.signals import campaign_rows
from tests.learn.campaign_folders import Table, leg_campaign, write_table
from tests.show.drawn_diagnoses import plain_law


def without(name: str) -> Callable[[Table], Table]:
    """Return what empties a column of a table."""

    def edit(table: Table) -> Table:
        return {key: np.full_like(values, np.nan) if key == name else values for key, values in table.items()}

    return edit


def test_a_thermometer_without_values_is_left_out_and_told(tmp_path: Path) -> None:
    """One run has no value of T03: the diagnosis goes on with the others, and says so."""
    campaign = load_campaign(leg_campaign(tmp_path, edit=without("T03_degC")))
    found = diagnose(campaign, ("T01",))
    assert "not looked at, without values in a run: T03" in found.notes
    assert not any(one.target == "T03" for one in found.candidates)


def test_a_silent_thermometer_of_the_law_is_refused(tmp_path: Path) -> None:
    """The law's own sensor without values is an error that names sensor and run."""
    campaign = load_campaign(leg_campaign(tmp_path, edit=without("T01_degC")))
    rows = campaign_rows(campaign, "identification")
    with pytest.raises(ArgumentError, match=r"sensor T01 of the law has no values in run a"):
        refuse_silent(rows, ("T01",))


def test_runs_that_the_law_cannot_read_are_not_judged(tmp_path: Path) -> None:
    """A run for validation without the law's sensor drops out by name; the others stay."""
    folder = leg_campaign(tmp_path)
    campaign = load_campaign(folder)
    (rows,) = campaign_rows(campaign, "validation")
    law = plain_law()
    assert judged_runs([rows], [law]) == ([], ["c"])


def test_causes_that_could_not_be_looked_for_are_told(tmp_path: Path) -> None:
    """Without the weather nothing can follow the pressure: air-refraction is said not to be looked for."""
    folder = leg_campaign(tmp_path)
    for file in (folder / "runs").glob("*.csv"):
        table = np.genfromtxt(file, delimiter=",", names=True)
        kept = [name for name in table.dtype.names or () if not name.startswith("air_")]
        write_table(file, {name: table[name] for name in kept})
    (note,) = [one for one in diagnose(load_campaign(folder), ("T01",)).notes if one.startswith("not looked for")]
    assert "air-refraction" in note
    assert "backlash" not in note


def test_degrees_fahrenheit_are_told(tmp_path: Path) -> None:
    """Tables in degrees Fahrenheit are not diagnosed without a word: a room of 68 degC is none."""
    folder = leg_campaign(tmp_path)
    assert not any("Fahrenheit" in note for note in diagnose(load_campaign(folder), ("T01",)).notes)
    for file in (folder / "runs").glob("*.csv"):
        table = np.genfromtxt(file, delimiter=",", names=True)
        warm = [name for name in table.dtype.names or () if name.startswith("T") and name.endswith("_degC")]
        columns = {name: table[name] * (1.8 if name in warm else 1.0) for name in table.dtype.names or ()}
        write_table(file, {name: values + 32.0 * (name in warm) for name, values in columns.items()})
    (note,) = [one for one in diagnose(load_campaign(folder), ("T01",)).notes if "Fahrenheit" in one]
    assert note.startswith("all sensors: never below")
