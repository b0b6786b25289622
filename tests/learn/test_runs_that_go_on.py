"""Runs on the campaign's own clock: what a law with a memory remembers goes on from one to the next."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hexathermal.learn.campaign import Campaign
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.campaign_laws import role_blocks
from hexathermal.learn.diagnosis.stage import view_of
from hexathermal.learn.law import IdentifiedLaw
from hexathermal.learn.signals import campaign_rows, follows_on, run_rows
from hexathermal.learn.validation_rows import RowsPredictor, law_on_rows, memories
from tests.learn.campaign_folders import Table, campaign_text, leg_table, write_table
from tests.learn.extended_laws import law_with, terms_of

REMEMBER = ("lag", "stored-heat", "room", "direction", "relaxation")
"""Shapes whose states need the rows before."""

CUT = 300


def campaign_of(place: Path, tables: dict[str, Table], zero: str) -> Campaign:
    """A campaign of some runs, the last one for validation."""
    roles = dict.fromkeys(tables, "identification") | {list(tables)[-1]: "validation"}
    place.mkdir()
    (place / "campaign.toml").write_text(campaign_text(roles, zero=zero))
    for name, table in tables.items():
        write_table(place / "runs" / f"{name}.csv", table)
    return load_campaign(place)


def law_that_remembers(shape: str, zero: str) -> IdentifiedLaw:
    """A law with terms of one shape on what this bench records."""
    terms = tuple(term for term in terms_of(shape) if "spindle_rpm" not in term.parameters.values())
    return replace(law_with(terms), zero=zero)


@pytest.fixture
def tables() -> tuple[Table, Table, Table]:
    """A whole run in which the room warms, and its two parts."""
    whole = leg_table(noise_K=0.0, noise_um=0.0)
    whole["air_temperature_degC"] = 20.0 + np.linspace(0.0, 3.0, len(whole["time_s"])) ** 2
    first = {name: values[:CUT] for name, values in whole.items()}
    second = {name: values[CUT:] for name, values in whole.items()}
    return whole, first, second


@pytest.mark.parametrize("shape", REMEMBER)
def test_a_run_cut_in_two_is_predicted_as_the_whole(
    shape: str, tables: tuple[Table, Table, Table], tmp_path: Path
) -> None:
    """With the campaign's zero, the second part is what the whole run's end is; forgotten, it would differ."""
    whole, first, second = tables
    law = law_that_remembers(shape, "campaign")
    one = campaign_of(tmp_path / "one", {"a": whole, "b": leg_table(2)}, "campaign")
    two = campaign_of(tmp_path / "two", {"a": first, "b": second}, "campaign")
    wanted = law_on_rows(law, run_rows(one, "a").signals).drift[CUT:]
    signals = run_rows(two, "b").signals
    found = law_on_rows(law, signals, "b", memories(law, two)["b"]).drift
    np.testing.assert_allclose(found, wanted, rtol=0.0, atol=1e-12)
    assert np.abs(law_on_rows(law, signals, "b").drift - wanted).max() > 1e-9
    predictor = RowsPredictor(law, two)
    for block in role_blocks(two, "validation"):
        at = np.searchsorted(whole["time_s"][CUT:] - whole["time_s"][CUT], block.time - 1e-9)
        np.testing.assert_allclose(predictor(block).drift, wanted[at], rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("shape", REMEMBER)
def test_the_diagnosis_sees_the_same_columns_in_both(
    shape: str, tables: tuple[Table, Table, Table], tmp_path: Path
) -> None:
    """Columns of shapes in windows are those of the law's own prediction, run after run."""
    _whole, first, second = tables
    law = law_that_remembers(shape, "campaign")
    campaign = campaign_of(tmp_path / "two", {"a": first, "b": second, "c": leg_table(2)}, "campaign")
    rows = campaign_rows(campaign, "identification")
    assert follows_on(campaign.zero, rows[0].signals, rows[1].signals)
    view = view_of(campaign, rows, law.sensors)
    assert view.goes_on == (False, True)
    past = memories(law, campaign)
    for k, term in enumerate(law.terms):
        own = [term.columns(signals, past[run.run.name].terms[k])
               for signals, run in zip(view.signals, rows, strict=True)]  # fmt: skip
        wanted = view.windows(own)
        found = view.columns(term.shape, term.parameters)
        np.testing.assert_allclose(found, wanted, rtol=0.0, atol=0.02 * np.abs(wanted).max())


def test_runs_that_count_from_their_own_rows_begin_anew(tables: tuple[Table, Table, Table], tmp_path: Path) -> None:
    """With each run's own zero nothing is remembered, even where the clock goes on."""
    _whole, first, second = tables
    campaign = campaign_of(tmp_path / "two", {"a": first, "b": second, "c": leg_table(2)}, "run")
    rows = campaign_rows(campaign, "identification")
    assert not follows_on(campaign.zero, rows[0].signals, rows[1].signals)
    assert view_of(campaign, rows, ("T01",)).goes_on == (False, False)
    law = law_that_remembers("room", "run")
    signals = run_rows(campaign, "b").signals
    assert signals.air is not None
    assert signals.air[0] == 0.0
    alone = law_on_rows(law, signals, "b").drift
    np.testing.assert_array_equal(law_on_rows(law, signals, "b", memories(law, campaign)["b"]).drift, alone)


def test_the_air_counts_from_the_campaigns_first_row(tables: tuple[Table, Table, Table], tmp_path: Path) -> None:
    """The air's rise counts from where temperatures count from: of the campaign, or of each run."""
    _whole, first, second = tables
    campaign = campaign_of(tmp_path / "two", {"a": first, "b": second}, "campaign")
    air = run_rows(campaign, "b").signals.air
    assert air is not None
    np.testing.assert_allclose(air, second["air_temperature_degC"] - first["air_temperature_degC"][0], atol=1e-9)
