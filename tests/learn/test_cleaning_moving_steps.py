"""Beams that lose count while the rod moves are put back; tilt, and what turns over at each reversal, is not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hexathermal.learn import cleaning_moving_steps

from .campaign_folders import Table, cleaned

SWEEP = slice(300, 400)


def led(table: Table, rows: slice, place: np.ndarray) -> None:
    """Lead the rod to other places [mm] in some rows; the beams go with it."""
    moved = place - table["q_mm"][rows]
    table["q_mm"][rows] = place
    for k in (1, 2, 3):
        table[f"beam{k}_mm"][rows] += moved


def swept(table: Table) -> None:
    """Let the rod go to and fro for half an hour, as a warming up does."""
    led(table, SWEEP, 5.0 + np.abs((12.0 * np.arange(100)) % 440.0 - 220.0))
    table["settled"][SWEEP] = 0.0


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
    assert not record.beam_steps


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


@pytest.mark.parametrize("share", [0.3, 0.6])
def test_a_part_of_a_step_in_the_last_row_of_a_rest_is_taken_back(tmp_path: Path, share: float) -> None:
    """The count is lost as the rod sets off: the last settled row is a mean that has a part of the step."""

    def edit(table: Table) -> None:
        swept(table)
        table["beam3_mm"][299] += share * 5e-3
        table["beam3_mm"][300:] += 5e-3

    block, record = cleaned(tmp_path, edit)
    clean, _ = cleaned(tmp_path / "clean", swept)
    assert len(record.beam_steps) == 1
    assert np.abs(block.drift - clean.drift).max() < 0.05e-6


@pytest.mark.parametrize("rows", [1, 2, 3, 4, 6, 20])
def test_a_beam_that_is_off_for_some_rows_is_left_as_it_is(tmp_path: Path, rows: int) -> None:
    """What comes back while the rod still moves is in no row that is used: the drift is as without it."""

    def edit(table: Table) -> None:
        swept(table)
        table["beam3_mm"][340 : 340 + rows] += 5e-3

    block, record = cleaned(tmp_path, edit)
    clean, _ = cleaned(tmp_path / "clean", swept)
    assert len(block) == len(clean)
    assert np.abs(block.drift - clean.drift).max() < 0.05e-6
    assert abs(sum(step.size for step in record.beam_steps)) < 0.1e-6


@pytest.mark.long
@pytest.mark.parametrize("rows", [1, 3, 5, 6])
@pytest.mark.parametrize("code", [np.nan, 9999.0])
@pytest.mark.parametrize("first", [300, 340, 396])
def test_a_beam_without_values_for_some_rows_is_no_lost_count(
    tmp_path: Path, rows: int, code: float, first: int
) -> None:
    """Interrupted while the rod moves, and back with the right count: nothing is changed."""

    def edit(table: Table) -> None:
        swept(table)
        table["beam3_mm"][first : first + rows] = code

    block, record = cleaned(tmp_path, edit)
    clean, _ = cleaned(tmp_path / "clean", swept)
    assert not record.beam_steps
    assert len(block) >= len(clean) - rows
    assert np.abs(block.drift[-50:] - clean.drift[-50:]).max() < 1e-9


def test_a_lost_count_is_put_back_beside_rows_with_codes(tmp_path: Path) -> None:
    """Codes elsewhere in the sweep say nothing of what is usual."""

    def edit(table: Table) -> None:
        swept(table)
        table["beam1_mm"][310:314] = 9999.0
        table["beam1_mm"][385:389] = 9999.0
        table["beam3_mm"][350:] += 5e-3

    block, record = cleaned(tmp_path, edit)
    clean, _ = cleaned(tmp_path / "clean", swept)
    assert [step.channel for step in record.beam_steps] == ["beam3_mm"]
    assert np.abs(block.drift - clean.drift).max() < 0.05e-6


@pytest.mark.parametrize("row", [300, 350])
def test_a_pause_of_the_logger_is_no_row(tmp_path: Path, row: int) -> None:
    """Behind an hour without a row a beam is 6 um off: heat tilts a platform by as much."""

    def edit(table: Table) -> None:
        swept(table)
        table["time_s"][row:] += 3600.0
        table["beam1_mm"][row:] += 6e-3

    _block, record = cleaned(tmp_path, edit)
    assert not record.beam_steps


@pytest.mark.parametrize("strokes", [2, 3, 4, 5])
def test_play_that_tilts_at_few_reversals_is_never_taken_back(tmp_path: Path, strokes: int) -> None:
    """Where the rod turns two to five times a joint with play tilts the platform there and back."""

    def edit(table: Table) -> None:
        rows = np.arange(100)
        place = 5.0 + 200.0 * np.abs((strokes * rows / 100.0 + 1.0) % 2.0 - 1.0)
        led(table, SWEEP, place)
        table["settled"][SWEEP] = 0.0
        way = np.sign(np.diff(place, prepend=place[0]))
        way[0] = way[1]
        table["beam1_mm"][SWEEP] += 3e-3 * (way > 0.0)
        table["beam1_mm"][SWEEP.stop :] += 3e-3 * (way[-1] > 0.0)

    _block, record = cleaned(tmp_path, edit)
    assert sum(300 < step.time / 20.0 < 400 for step in record.beam_steps) == 0


def test_tilt_over_the_one_long_move_is_never_taken_back(tmp_path: Path) -> None:
    """Stairs of 10 mm, and once back by 160 mm: tilt goes with the place, and no other move goes as far."""

    def edit(table: Table) -> None:
        led(table, slice(None), 5.0 + 10.0 * ((np.arange(600) // 25) % 17).astype(float))
        table["beam1_mm"] += 3e-3 * (table["q_mm"] - table["q_mm"][0]) / 160.0

    _block, record = cleaned(tmp_path, edit)
    assert not record.beam_steps


@pytest.mark.parametrize(
    ("noise_um", "size_um", "back"),
    [(0.03, 0.9, False), (0.03, 1.1, True), (0.25, 1.2, False), (0.25, 4.0, True), (1.0, 40.0, False)],
)
def test_a_step_stands_out_of_what_beams_do_while_the_rod_moves(
    tmp_path: Path, noise_um: float, size_um: float, back: bool
) -> None:
    """More than 1 um, and more than ten usual jumps; where these are so large that the mean would be no better known
    than 0.1 um, nothing is taken back.
    """

    def edit(table: Table) -> None:
        swept(table)
        table["beam1_mm"][SWEEP] += noise_um * 1e-3 * np.random.default_rng(3).standard_normal(100)
        table["beam3_mm"][341:] += size_um * 1e-3

    _block, record = cleaned(tmp_path, edit)
    assert [(step.channel, step.time) for step in record.beam_steps if not step.at_rest] == (
        [("beam3_mm", 341 * 20.0)] if back else []
    )


@pytest.mark.parametrize("rows", [340, 341, 342, 344, 97])
def test_edges_of_pieces_change_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rows: int) -> None:
    """A step at the edge of a piece of rows, the first row of it with a part, is taken back as within one."""

    def edit(table: Table) -> None:
        swept(table)
        table["beam3_mm"][340] += 2e-3
        table["beam3_mm"][341:] += 5e-3

    whole, record = cleaned(tmp_path / "whole", edit)
    monkeypatch.setattr(cleaning_moving_steps, "PIECE_ROWS", rows)
    pieces, again = cleaned(tmp_path / "pieces", edit)
    assert again.beam_steps == record.beam_steps
    assert np.array_equal(pieces.drift, whole.drift)
