"""Beams: lost counts are put back, tilt and jumps of the zero never; bad rows go."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from .campaign_folders import Table, cleaned


@pytest.mark.parametrize("size_um", [2.0, 30.0, 1000.0, -7.0])
@pytest.mark.parametrize("row", [110, 330, 402])
def test_a_beam_that_loses_count_is_put_back(tmp_path: Path, size_um: float, row: int) -> None:
    """A step of one beam, at rest or during a movement, is found once and the drift is right behind it."""

    def edit(table: Table) -> None:
        table["beam2_mm"][row:] += size_um * 1e-3

    block, record = cleaned(tmp_path, edit)
    clean, _ = cleaned(tmp_path / "clean")
    assert record.count("beam step", "beam2_mm") == 1
    assert record.used == 554
    assert np.abs(block.drift - clean.drift).max() < 0.05e-6


@pytest.mark.parametrize("share", [0.25, 0.4, 0.7])
@pytest.mark.parametrize("size_um", [2.0, -30.0])
def test_a_step_within_a_row_that_is_a_mean_is_put_back(tmp_path: Path, share: float, size_um: float) -> None:
    """Where a row is the mean of its interval it may have a part of a step: that part is taken back as the step is."""

    def edit(table: Table) -> None:
        table["beam2_mm"][330] += share * size_um * 1e-3
        table["beam2_mm"][331:] += size_um * 1e-3

    block, record = cleaned(tmp_path, edit)
    clean, _ = cleaned(tmp_path / "clean")
    assert record.count("beam step", "beam2_mm") == 1
    assert record.used == 554
    assert np.abs(block.drift - clean.drift).max() < 0.05e-6


def test_a_beam_that_creeps_at_rest_is_only_noted(tmp_path: Path) -> None:
    """Over three rows one beam moves away from the others: that may be the target, and the drift is as measured."""

    def edit(table: Table) -> None:
        table["beam2_mm"][330:] += 4e-3 * np.clip(np.arange(1, 271) / 3.0, 0.0, 1.0)

    block, record = cleaned(tmp_path, edit)
    clean, _ = cleaned(tmp_path / "clean")
    assert record.count("beam step") == 0
    assert record.count("tilt or step") == 1
    assert abs((block.drift - clean.drift)[-1] - 4e-6 / 3.0) < 1e-9


def test_a_tilt_is_no_step_of_a_beam(tmp_path: Path) -> None:
    """A lasting tilt moves one beam one way and the others the other: it is noted, not taken back."""

    def edit(table: Table) -> None:
        table["beam1_mm"][330:] += 0.004
        table["beam2_mm"][330:] -= 0.002
        table["beam3_mm"][330:] -= 0.002

    block, record = cleaned(tmp_path, edit)
    clean, _ = cleaned(tmp_path / "clean")
    assert record.count("beam step") == 0
    assert record.count("tilt or step") == 1
    assert np.allclose(block.drift, clean.drift, atol=1e-12)


@pytest.mark.parametrize("source", ["place", "heat"])
@pytest.mark.parametrize("single", [True, False])
def test_tilt_that_goes_with_the_rod_or_with_heat_is_never_taken_back(
    tmp_path: Path, source: str, single: bool
) -> None:
    """Tilt of 40 urad with the place of the rod or with a temperature, beams 25 mm off centre: it moves one beam nearly
    alone at every move, and shifts the mean; no step is taken back, no row left out, and the drift is as measured.
    """

    def edit(table: Table) -> None:
        turn = np.sin(table["q_mm"] / 40.0) if source == "place" else (table["T01_degC"] - 20.0) / 5.0
        lever = np.array([85.0, -5.0, -5.0]) if single else np.array([5.0, 59.0, -25.0])
        for k in range(3):
            table[f"beam{k + 1}_mm"] += 40e-6 * lever[k] * (turn - turn[0])

    kept: dict[str, Table] = {}
    block, record = cleaned(tmp_path, lambda table: kept.setdefault("table", (edit(table), table)[1]))
    table = kept["table"]
    settled = table["settled"] == 1.0
    assert {step.step for step in record.steps} <= {"not settled", "tilt or step"}
    beams = np.mean([table[f"beam{k}_mm"] for k in (1, 2, 3)], axis=0)
    assert np.allclose(block.drift, 1e-3 * (beams - (table["q_mm"] - table["q_mm"][0]))[settled], atol=1e-15)


def test_tilt_at_a_place_that_is_visited_seldom_is_no_lost_count(tmp_path: Path) -> None:
    """At the far end one beam alone parts by 3 um, which no other movement does: it is gone when the rod is back."""

    def far(table: Table) -> None:
        away = np.zeros(600, dtype=bool)
        away[360:372] = away[400:420] = True
        for name in ("q_mm", "beam1_mm", "beam2_mm", "beam3_mm"):
            table[name] = np.where(away, table[name] + 150.0, table[name])
        table["beam3_mm"] += 3e-3 * away

    kept: dict[str, Table] = {}
    block, record = cleaned(tmp_path, lambda table: kept.setdefault("table", (far(table), table)[1]))
    table = kept["table"]
    beams = np.mean([table[f"beam{k}_mm"] for k in (1, 2, 3)], axis=0)
    measured = 1e-3 * (beams - (table["q_mm"] - table["q_mm"][0]))[table["settled"] == 1.0]
    assert record.count("beam step") == 0
    assert np.allclose(block.drift, measured, atol=1e-15)


def test_a_count_that_is_lost_on_the_way_stays_lost_where_the_rod_is_back(tmp_path: Path) -> None:
    """At a movement to a place where the rod stood before, and is again: that is a lost count, and it is put back."""

    def edit(table: Table) -> None:
        table["beam3_mm"][402:] += 3e-3

    block, record = cleaned(tmp_path, edit)
    clean, _ = cleaned(tmp_path / "clean")
    assert record.count("beam step", "beam3_mm") == 1
    assert np.abs(block.drift - clean.drift).max() < 0.05e-6


@pytest.mark.parametrize(("beams", "rows"), [((2, 2), (352, 376)), ((2, 3), (352, 376)), ((3, 3), (351, 401))])
def test_two_counts_that_are_lost_one_after_the_other_are_put_back(
    tmp_path: Path, beams: tuple[int, int], rows: tuple[int, int]
) -> None:
    """At movements a rest or two apart, of one beam or of two: neither is held against the other."""

    def there_and_back(table: Table) -> None:
        place = np.where(np.arange(600) // 25 % 2 == 0, 10.0, 80.0)
        for name in ("beam1_mm", "beam2_mm", "beam3_mm"):
            table[name] += place - place[0] - (table["q_mm"] - table["q_mm"][0])
        table["q_mm"] = place

    def edit(table: Table) -> None:
        there_and_back(table)
        for beam, row in zip(beams, rows, strict=True):
            table[f"beam{beam}_mm"][row:] += 4e-3

    block, record = cleaned(tmp_path, edit)
    clean, _ = cleaned(tmp_path / "clean", there_and_back)
    assert record.count("beam step") == 2
    assert np.abs(block.drift - clean.drift).max() < 0.1e-6


def test_a_count_that_a_creeping_beam_loses_is_put_back(tmp_path: Path) -> None:
    """Ten nanometres a row are a third of the step until the rod is back: that is no part of it."""

    def creeping(table: Table) -> None:
        table["beam3_mm"] += 1e-5 * np.arange(600)

    def edit(table: Table) -> None:
        creeping(table)
        table["beam3_mm"][402:] += 2e-3

    block, record = cleaned(tmp_path, edit)
    clean, _ = cleaned(tmp_path / "clean", creeping)
    assert record.count("beam step", "beam3_mm") == 1
    assert np.abs(block.drift - clean.drift).max() < 0.1e-6


def test_two_beams_that_turn_about_the_third_lost_no_count(tmp_path: Path) -> None:
    """Heat tilts the target about the line through one beam, within two rows: the mean stays, however noisy it is."""

    def shaken(table: Table) -> None:
        noise = 0.3e-3 * np.random.default_rng(7).standard_normal(600)
        for k in (1, 2, 3):
            table[f"beam{k}_mm"] += noise

    def edit(table: Table) -> None:
        shaken(table)
        turn = np.clip((np.arange(600) - 329) / 2.0, 0.0, 1.0)
        table["beam2_mm"] -= 0.35e-3 * turn
        table["beam3_mm"] += 0.35e-3 * turn

    block, record = cleaned(tmp_path, edit)
    clean, _ = cleaned(tmp_path / "clean", shaken)
    assert record.count("beam step") == 0
    assert record.count("tilt or step") == 1
    assert np.allclose(block.drift, clean.drift, atol=1e-12)


def test_a_lost_count_is_found_beside_tilt(tmp_path: Path) -> None:
    """Within a rest a beam that loses count is put back though tilt moves the beams by twice as much at every move."""

    def tilt(table: Table) -> None:
        turn = np.sin(table["q_mm"] / 40.0)
        for k, lever in enumerate((85.0, -5.0, -5.0)):
            table[f"beam{k + 1}_mm"] += 40e-6 * lever * (turn - turn[0])

    def edit(table: Table) -> None:
        tilt(table)
        table["beam1_mm"][310:] += 1.5e-3

    block, record = cleaned(tmp_path, edit)
    clean, _ = cleaned(tmp_path / "clean", tilt)
    assert [step.count for step in record.steps if step.step == "beam step"] == [1]
    assert np.abs(block.drift - clean.drift).max() < 0.05e-6


def test_what_beams_part_by_while_nothing_rests_is_not_held_against_single_moves(tmp_path: Path) -> None:
    """Over half an hour of sweeps one beam parts by 6 um, as heat tilts a platform: no other movement lasts as long, so
    nothing tells of a lost count, and the drift is as measured.
    """

    def still(table: Table) -> None:
        table["settled"][300:400] = 0.0

    def edit(table: Table) -> None:
        still(table)
        table["beam1_mm"] += 6e-3 * np.clip((np.arange(600) - 300) / 100.0, 0.0, 1.0)

    block, record = cleaned(tmp_path, edit)
    clean, _ = cleaned(tmp_path / "clean", still)
    assert record.count("beam step") == 0
    assert record.count("tilt or step", "beam1_mm") == 1
    assert abs((block.drift - clean.drift)[-1] - 2e-6) < 1e-9


def test_a_jump_of_the_zero_is_never_taken_back(tmp_path: Path) -> None:
    """A step of all beams within some minutes, of any height up to 20 um, is in the drift as it was measured."""
    for height in (0.5, 3.0, 20.0):

        def edit(table: Table, height: float = height) -> None:
            ramp = np.clip((np.arange(600) - 260) / 6.0, 0.0, 1.0)
            for beam in (1, 2, 3):
                table[f"beam{beam}_mm"] += 1e-3 * height * ramp

        block, record = cleaned(tmp_path / f"{height}", edit)
        clean, _ = cleaned(tmp_path / "clean")
        assert {step.step for step in record.steps} <= {"not settled", "drift step"}
        assert abs((block.drift - clean.drift)[-1] - 1e-6 * height) < 1e-9


def test_a_leg_that_warmed_up_while_it_moved_lost_no_count(tmp_path: Path) -> None:
    """No row is settled for half an hour, in which steel grows by 150 um; within one row that is a lost count."""
    warmed = 1e-3 * 150.0 * np.clip((np.arange(600) - 300) / 100.0, 0.0, 1.0)

    def edit(table: Table) -> None:
        table["settled"][300:400] = 0.0
        for beam in (1, 2, 3):
            table[f"beam{beam}_mm"] += warmed

    def still(table: Table) -> None:
        table["settled"][300:400] = 0.0

    block, record = cleaned(tmp_path, edit)
    clean, quiet = cleaned(tmp_path / "clean", still)
    assert record.count("beams lost") == 0
    assert block.drift[-1] - clean.drift[-1] == pytest.approx(150e-6)
    assert record.count("drift step") == quiet.count("drift step") + 1  # it is noted

    for height, unsettled in ((0.15, 0), (0.6, 100), (1.1, 280)):  # mm; the last is too much for any time

        def lost(table: Table, height: float = height, unsettled: int = unsettled) -> None:
            table["settled"][300 : 300 + unsettled] = 0.0
            for beam in (1, 2, 3):
                table[f"beam{beam}_mm"][300:] += height

        _, record = cleaned(tmp_path / f"lost {height}", lost)
        assert record.count("beams lost") > 0.8 * (300 - unsettled)


def test_bad_rows_of_the_beams_are_left_out(tmp_path: Path) -> None:
    """A spike of one beam, of all, a missing reading: that row goes, the others stay; all beams lost end the run."""

    def edit(table: Table) -> None:
        table["beam1_mm"][111] += 0.003
        for beam in (1, 2, 3):
            table[f"beam{beam}_mm"][212] += 0.004
            table[f"beam{beam}_mm"][510:] += 1.0
        table["beam2_mm"][313] = np.nan

    block, record = cleaned(tmp_path, edit)
    assert record.count("beam spike", "beam1_mm") == 1
    assert record.count("drift spike") == 1
    assert record.count("no drift") == 1
    assert record.count("beams lost") > 50
    assert block.time[-1] == 20.0 * 509
    assert not {111.0, 212.0, 313.0} & set(block.time / 20.0)
