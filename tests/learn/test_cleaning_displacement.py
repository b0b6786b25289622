"""A displacement that single rows have and no beam is left out, where the rod moves too; what moves is not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.signals import campaign_rows

from .campaign_folders import Table, cleaned, leg_campaign


def moving_row(table: Table) -> int:
    """Return a row that is not settled, well within the run."""
    return int(np.flatnonzero(table["settled"] == 0.0)[20])


@pytest.mark.parametrize("q_mm", [300.0, 2000.0, -1e6, 99999.0, 1e200, 1e308])
def test_a_wrong_displacement_of_a_row_that_moves_is_left_out(tmp_path: Path, q_mm: float) -> None:
    """Whatever it is, it is counted, and the displacement of that row is what those beside it say."""
    rows: dict[str, int] = {}

    def edit(table: Table) -> None:
        rows["bad"] = moving_row(table)
        table["q_mm"][rows["bad"]] = q_mm

    folder = leg_campaign(tmp_path / "bad", edit=edit)
    got = campaign_rows(load_campaign(folder), "identification")[0]
    sound = campaign_rows(load_campaign(leg_campaign(tmp_path / "sound")), "identification")[0]
    assert got.record.count("spike", "q_mm") + got.record.count("missing code", "q_mm") == 1
    assert np.abs(got.signals.q - sound.signals.q).max() <= np.abs(np.diff(sound.signals.q)).max()
    assert np.array_equal(np.delete(got.signals.q, rows["bad"]), np.delete(sound.signals.q, rows["bad"]))


def test_a_wrong_displacement_of_a_rest_takes_its_row_along(tmp_path: Path) -> None:
    """Its drift is not known."""

    def edit(table: Table) -> None:
        table["q_mm"][330] += 40.0

    block, record = cleaned(tmp_path, edit)
    assert record.count("spike", "q_mm") == 1
    assert 330.0 not in set(block.time / 20.0)


def test_a_rod_that_goes_out_and_back_is_believed(tmp_path: Path) -> None:
    """Where the beams go with it, one row elsewhere is a move."""

    def edit(table: Table) -> None:
        for name in ("q_mm", "beam1_mm", "beam2_mm", "beam3_mm"):
            table[name][330] += 40.0

    _block, record = cleaned(tmp_path, edit)
    assert record.count("spike", "q_mm") == 0


def test_a_slope_is_no_step_of_the_drift(tmp_path: Path) -> None:
    """A rest that cools by 0.08 um a row, which is 0.4 um from five rows to the next five, is not said to step."""

    def edit(table: Table) -> None:
        for beam in (1, 2, 3):
            table[f"beam{beam}_mm"] -= 0.08e-3 * np.arange(len(table["q_mm"]))

    _block, record = cleaned(tmp_path, edit)
    assert record.count("drift step") == 0
