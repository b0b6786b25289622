"""Stretches of a part without a stroke: from one change of its inputs to the next, however noisy these are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.cleaning import used_run
from tests.learn.campaign_folders import component_campaign, write_table

SPEEDS = np.repeat([0.0, 3000.0, 1500.0, 1500.0, 6000.0, 0.0], 60)


@pytest.mark.parametrize("first", [0, 60], ids=["stands still at first", "runs at first"])
@pytest.mark.parametrize("noise", [0.0, 0.002, 0.01], ids=["commanded", "read", "noisy"])
def test_a_stretch_begins_where_an_input_changes(first: int, noise: float, tmp_path: Path) -> None:
    """Not where its noise, a part of its size, makes it differ from row to row; a motor at rest has none."""
    folder = component_campaign(tmp_path / "part")
    speeds = SPEEDS[first:]
    rng, time = np.random.default_rng(5), 15.0 * np.arange(len(speeds))
    table = {"time_s": time, "spindle_speed_rpm": speeds * (1.0 + noise * rng.standard_normal(len(speeds))),
             "T1_degC": 21.0 + 1e-4 * time, "drift_um": 1e-4 * time}  # fmt: skip
    write_table(folder / "runs" / "a.csv", table)
    block, _record = used_run(load_campaign(folder), "a")
    begins = np.flatnonzero(np.diff(block.landing)) + 1
    assert begins.tolist() == (np.flatnonzero(np.diff(speeds)) + 1).tolist()


def test_blocks_make_no_difference(tmp_path: Path) -> None:
    """What a block knows of an input's span it hands on: small blocks find the same stretches."""
    from hexathermal.learn.cleaning import usable_blocks

    folder = component_campaign(tmp_path / "part")
    rng, time = np.random.default_rng(5), 15.0 * np.arange(len(SPEEDS))
    table = {"time_s": time, "spindle_speed_rpm": SPEEDS * (1.0 + 0.01 * rng.standard_normal(len(SPEEDS))),
             "T1_degC": 21.0 + 1e-4 * time, "drift_um": 1e-4 * time}  # fmt: skip
    write_table(folder / "runs" / "a.csv", table)
    campaign = load_campaign(folder)
    found = [
        np.concatenate([block.landing for block in usable_blocks(campaign, "a", rows=rows)]) for rows in (40, 16384)
    ]
    assert np.array_equal(*found)
