"""Cleaning: spikes are found where they are, heat that leaps or swings is none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.cleaning import used_run
from hexathermal.learn.cleaning_rules import noise_of, spikes_in

from .campaign_folders import Table, cleaned

SHARED = Path(__file__).resolve().parents[3] / "shared"


@pytest.mark.skipif(not (SHARED / "measured").is_dir(), reason="the measured campaigns are not beside the checkout")
@pytest.mark.parametrize("name", ["machine-tool-ch1", "machine-tool-ch2"])
def test_the_spikes_of_a_measured_thermometer_are_found(name: str) -> None:
    """T16's spikes of 1 to 3 K are found, among them the largest; of the other channels 1 row in 500 at most goes."""
    campaign = load_campaign(SHARED / "measured" / name)
    count, largest = 0, 0.0
    others = [sensor for sensor in campaign.sensors if sensor != "T16"]
    for run in campaign.runs:
        block, record = used_run(campaign, run)
        count += record.count("spike", "T16_degC")
        assert record.used >= 0.99 * record.rows
        step = np.abs(np.diff(block.dT[:, campaign.sensors.index("T16")], 2))
        largest = max(largest, float(np.nanmax(step)))
        assert all(record.count("spike", f"{sensor}_degC") <= record.rows / 500 for sensor in others)
    assert count >= 15
    assert largest < 2.5


def test_heat_that_leaps_and_fades_where_the_rod_moves_is_no_spike(tmp_path: Path) -> None:
    """The nut comes to rest beside a thermocouple: a leap of 1 K in one row that fades by half a row is kept; a spike
    of that size at the same place, out and back in one row each, is not.
    """

    def edit(table: Table) -> None:
        fading = np.where(np.arange(600) >= 25, 0.5 ** (np.arange(600) % 25), 0.0)
        table["T02_degC"] = 22.0 + fading + 0.015 * np.random.default_rng(4).standard_normal(600)
        table["T03_degC"][402] += 1.0

    _, record = cleaned(tmp_path, edit)
    assert record.count("spike", "T02_degC") == 0
    assert record.count("spike") == record.count("spike", "T03_degC") == 1


@pytest.mark.parametrize("row", [1, 2, -3, -2, -1])
def test_spikes_of_the_first_and_last_rows_are_found_where_the_rod_moves(row: int) -> None:
    """A spike in one of a run's first or last rows goes, where the rod moves there as elsewhere: of the last row nobody
    sees whether it comes back. Heat that leaps in the last row but two and fades by half a row stays; so does the
    first row, from which all others count, where heat leaps behind it and stays.
    """
    noise = 0.02 * np.random.default_rng(7).standard_normal((200, 1))
    values, moving = 22.0 + noise, np.ones((200, 1), dtype=bool)
    values[row] += 3.0
    assert np.flatnonzero(spikes_in(values, noise_of(values), moving)).tolist() == [row % 200]
    heated = 22.0 + noise
    heated[-3:, 0] += [3.0, 1.5, 0.75]
    heated[1:, 0] += 1.5 * np.exp(-np.arange(199) / 100.0)
    assert not spikes_in(heated, noise_of(heated), moving).any()


def test_a_corner_before_a_steep_slope_is_no_spike() -> None:
    """A slow rise, then a steep fall: the slope behind counts as the one before does."""
    rows = np.arange(60.0)
    bend = np.where(rows < 30.0, 0.01 * rows, 0.3 - 0.3 * (rows - 30.0))[:, None]
    noise = 0.01 * np.random.default_rng(3).standard_normal((60, 1))
    for values in (bend + noise, bend[::-1] + noise):
        assert not spikes_in(values, np.array([0.01])).any()


def test_turning_points_of_a_swinging_channel_are_no_spikes(tmp_path: Path) -> None:
    """A thermocouple that a warm nut passes every 25 rows loses nothing at its turning points; a spike still goes."""

    def edit(table: Table) -> None:
        beside = np.abs((np.arange(600) + 12) % 25 - 12)
        rng = np.random.default_rng(4)
        table["T02_degC"] = 22.0 + 0.6 * np.exp(-beside / 3.0) + 0.015 * rng.standard_normal(600)
        table["T03_degC"][401] += 1.0

    _, record = cleaned(tmp_path, edit)
    assert record.count("spike", "T02_degC") == 0
    assert record.count("spike") == record.count("spike", "T03_degC") == 1
