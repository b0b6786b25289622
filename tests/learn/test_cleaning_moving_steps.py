"""Beams that lose count while the rod moves are put back; tilt, and what turns over at each reversal, is not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from .campaign_folders import Table, cleaned

SWEEP = slice(300, 400)


def swept(table: Table) -> None:
    """Let the rod go to and fro for half an hour, as a warming up does."""
    place = 5.0 + np.abs((12.0 * np.arange(100)) % 440.0 - 220.0)
    moved = place - table["q_mm"][SWEEP]
    table["q_mm"][SWEEP] = place
    table["settled"][SWEEP] = 0.0
    for k in (1, 2, 3):
        table[f"beam{k}_mm"][SWEEP] += moved


def turned(table: Table) -> np.ndarray:
    """Return the rows behind which the rod goes the other way."""
    way = np.sign(np.diff(table["q_mm"][SWEEP]))
    return SWEEP.start + 1 + np.flatnonzero(np.diff(way) != 0.0)


@pytest.mark.parametrize("share", [0.0, 0.4])
@pytest.mark.parametrize("size_um", [1.5, -6.0, 400.0])
def test_a_count_lost_while_the_rod_moves_is_put_back(tmp_path: Path, size_um: float, share: float) -> None:
    """A beam steps within one row of a sweep, or within two of which the first is a mean: the drift is right behind."""

    def edit(table: Table) -> None:
        swept(table)
        table["beam3_mm"][340] += share * size_um * 1e-3
        table["beam3_mm"][341:] += size_um * 1e-3

    block, record = cleaned(tmp_path, edit)
    clean, _ = cleaned(tmp_path / "clean", swept)
    assert record.count("beam step", "beam3_mm") == 1
    assert [(step.at_rest, step.time) for step in record.beam_steps] == [(False, 341 * 20.0)]
    assert np.abs(block.drift - clean.drift).max() < 0.05e-6


def test_both_counts_lost_in_a_sweep_are_put_back(tmp_path: Path) -> None:
    """Two beams lose count in one sweep, at different moments."""

    def edit(table: Table) -> None:
        swept(table)
        table["beam3_mm"][330:] += 5e-3
        table["beam1_mm"][372:] -= 3e-3

    block, record = cleaned(tmp_path, edit)
    clean, _ = cleaned(tmp_path / "clean", swept)
    assert [step.channel for step in record.beam_steps] == ["beam3_mm", "beam1_mm"]
    assert np.abs(block.drift - clean.drift).max() < 0.05e-6


@pytest.mark.parametrize("lever", [(85.0, -5.0, -5.0), (5.0, 59.0, -25.0)])
def test_tilt_of_a_moving_rod_is_never_taken_back(tmp_path: Path, lever: tuple[float, ...]) -> None:
    """Tilt that goes with the place, and turns over by 4 um of a beam at each reversal: nothing is changed."""

    def edit(table: Table) -> None:
        swept(table)
        turn = np.sin(table["q_mm"] / 40.0)
        for row in turned(table):
            turn[row:] = -turn[row:] + 2.0 * turn[row - 1]
        for k in range(3):
            table[f"beam{k + 1}_mm"] += 40e-6 * lever[k] * (turn - turn[0])

    _block, record = cleaned(tmp_path, edit)
    assert not [step for step in record.beam_steps if SWEEP.start < step.time / 20.0 < SWEEP.stop]


def test_play_that_tilts_at_each_reversal_is_never_taken_back(tmp_path: Path) -> None:
    """A joint with play tilts the platform by 3 um of one beam within one row wherever the rod turns."""

    def edit(table: Table) -> None:
        swept(table)
        way = np.sign(np.diff(table["q_mm"], prepend=table["q_mm"][0]))
        held = np.maximum.accumulate(np.where(way != 0.0, np.arange(len(way)), 0))
        table["beam1_mm"] += 3e-3 * (way[held] > 0.0)

    _block, record = cleaned(tmp_path, edit)
    assert not record.beam_steps


def test_two_beams_that_step_together_are_left_as_they_are(tmp_path: Path) -> None:
    """Two beams jump in one row: nothing tells which of them lost count, or whether all tilt."""

    def edit(table: Table) -> None:
        swept(table)
        table["beam1_mm"][341:] += 5e-3
        table["beam2_mm"][341:] -= 5e-3

    _block, record = cleaned(tmp_path, edit)
    assert not record.beam_steps


def test_a_beam_that_creeps_away_in_a_sweep_is_left_as_it_is(tmp_path: Path) -> None:
    """Over six rows one beam goes 4 um away from the others, once: that may be the target."""

    def edit(table: Table) -> None:
        swept(table)
        table["beam1_mm"] += 4e-3 * np.clip((np.arange(600) - 340) / 6.0, 0.0, 1.0)

    _block, record = cleaned(tmp_path, edit)
    assert not record.beam_steps
