"""Errors of the platform before and after correction, on runs that were never fitted."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import hexathermal as ht
from hexathermal.errors import ArgumentError, UnknownNameError
from hexathermal.learn.campaign import Campaign
from hexathermal.learn.campaign_files import load_campaign
from hexathermal.learn.hexapod_data import HexapodRows, hexapod_rows
from hexathermal.learn.hexapod_identification import identify_hexapod
from hexathermal.learn.hexapod_validation import validate_hexapod
from hexathermal.learn.validation import Verdict
from tests.learn.hexapods import EQUAL, NOISE, PLATES, drawn_rows


def law(factor: float = 1.0, plates: bool = True) -> ht.ThermalModel:
    """The true law, or a multiple of it; calibrated at another temperature than the campaign's zero."""
    leg = ht.LegLaw("T1", factor * EQUAL[0, 0], factor * EQUAL[0, 1])
    parts = (ht.PlateLaw(factor * PLATES[0], "T1"), ht.PlateLaw(factor * PLATES[1], "T1")) if plates else ()
    return ht.ThermalModel(leg, *parts, reference_temperature_degC=24.0)


def written(
    folder: Path, rows: HexapodRows, *, zero: str = "run", hexapod: ht.Hexapod | None = None, identified: int = 0
) -> Campaign:
    """Write rows as a campaign of validation runs, the first `identified` of them runs for identification."""
    ht.write_hexapod(dataclasses.replace(rows.hexapod, thermal=None) if hexapod is None else hexapod, folder)
    lines = ['format = "hexathermal-campaign/1"', 'kind = "hexapod"', f'zero = "{zero}"', 'hexapod = "hexapod.toml"']
    six, seen = (ht.coordinates_from_pose(poses, hexapod=rows.hexapod) for poses in (rows.commanded, rows.measured))
    pose = ["x_mm", "y_mm", "z_mm", "rx_deg", "ry_deg", "rz_deg"]
    head = ["time_s", *pose, *(f"leg{k}_q_mm" for k in range(1, 7)), *(f"leg{k}_T1_degC" for k in range(1, 7)),
            "platform_T1_degC", "base_T1_degC", *(f"measured_{name}" for name in pose)]  # fmt: skip
    table = np.column_stack([rows.time, six, rows.q * 1e3, 20.0 + rows.dT[..., 0], 20.0 + rows.plates, seen])
    if rows.air is not None:
        head.append("air_temperature_degC")
        table = np.column_stack([table, 20.0 + rows.air])
    for k, name in enumerate(rows.runs):
        role = "identification" if k < identified else "validation"
        lines += ["[[runs]]", f'name = "{name}"', f'file = "{name}.csv"', f'role = "{role}"']
        part = table[rows.run == k]
        np.savetxt(folder / f"{name}.csv", part, delimiter=",", header=",".join(head), comments="", fmt="%.12g")
    (folder / "campaign.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return load_campaign(folder)


def with_law(rows: HexapodRows, thermal: ht.ThermalModel) -> ht.Hexapod:
    """The machine with a law."""
    return dataclasses.replace(rows.hexapod, thermal=thermal)


def test_the_true_law_leaves_the_noise(rng: np.random.Generator, tmp_path: Path) -> None:
    """What is left after correction is the tracker's noise, axis by axis within 20 %, whatever the machine's reference;
    every axis is better, z by more than 80 %; the predicted drift fits with a factor of 1.
    """
    rows = drawn_rows(rng, runs=4, poses=60, frame=0.0)
    found = validate_hexapod(with_law(rows, law()), written(tmp_path, rows))
    for k, axis in enumerate(("x", "y", "z", "rx", "ry", "rz")):
        assert found.total[axis].after.value == pytest.approx(NOISE[k], rel=0.2)
        assert found.total[axis].after.low <= found.total[axis].after.value <= found.total[axis].after.high
    assert found.total["z"].reduction.low > 0.8
    assert found.verdict == {"translation": Verdict.BETTER, "rotation": Verdict.BETTER}
    assert abs(found.gain.value - 1.0) < 0.02
    assert not any("over-correction" in note for note in found.notes)


def test_figures_are_those_of_the_rows(rng: np.random.Generator, tmp_path: Path) -> None:
    """RMS, largest and reduction agree with plain sums over rotations taken as rotations (scipy), run by run."""
    rows = drawn_rows(rng, runs=2, poses=25)
    found = validate_hexapod(with_law(rows, law()), written(tmp_path, rows))
    told, seen = rows.commanded, rows.measured
    turn = (Rotation.from_matrix(seen[:, :3, :3]) * Rotation.from_matrix(told[:, :3, :3]).inv()).as_rotvec()
    shift = seen[:, :3, 3] - told[:, :3, 3]
    for k, run in enumerate(rows.runs):
        here = rows.run == k
        one = found.runs[run]
        assert one["translation"].before.value == pytest.approx(
            np.sqrt((shift[here] ** 2).sum(axis=1).mean()), rel=1e-5
        )
        assert one["rotation"].largest_before == pytest.approx(np.linalg.norm(turn[here], axis=1).max(), rel=1e-4)
        assert one["rx"].before.value == pytest.approx(np.sqrt((turn[here, 0] ** 2).mean()), rel=1e-4)
        share = one["z"].after.value / one["z"].before.value
        assert one["z"].reduction.value == pytest.approx(1.0 - share, rel=1e-9)


def test_over_correction_is_said(rng: np.random.Generator, tmp_path: Path) -> None:
    """A law 1.3 times too large still helps, and it is said that it over-corrects; one 2.5 times too large makes it
    worse, and that is the verdict; one half as large under-corrects.
    """
    rows = drawn_rows(rng, runs=3, frame=0.0)
    campaign = written(tmp_path, rows)
    more, much, less = (validate_hexapod(with_law(rows, law(factor)), campaign) for factor in (1.3, 2.5, 0.5))
    assert more.verdict["translation"] is Verdict.BETTER
    assert more.gain.value == pytest.approx(1 / 1.3, rel=0.03)
    assert any(note.startswith("over-correction: the predicted drift is too large") for note in more.notes)
    assert much.verdict == {"translation": Verdict.WORSE, "rotation": Verdict.WORSE}
    assert any(note.startswith("over-correction, or a frame") and "run-1" in note for note in much.notes)
    assert any(note.startswith("under-correction") for note in less.notes)


def test_the_frame_of_a_run_is_told_from_heat(rng: np.random.Generator, tmp_path: Path) -> None:
    """A tracker's frame 5 um off adds to what is left; each run's motion is found within 1 um, and without it the noise
    is left.
    """
    rows = drawn_rows(rng, runs=2, poses=80, frame=5e-6)
    found = validate_hexapod(with_law(rows, law()), written(tmp_path, rows))
    assert found.total["translation"].after.value > 3e-6
    assert found.framed[0] == pytest.approx(np.sqrt(3) * 4e-7, rel=0.2)
    assert found.framed[1] == pytest.approx(np.sqrt(3) * 1e-6, rel=0.2)
    assert np.abs(found.frames).max() > 2e-6


def test_poses_in_another_frame_are_noticed(rng: np.random.Generator, tmp_path: Path) -> None:
    """Measured poses that count from the base, not from home, are called that; elsewhere they are far; else nothing is
    said, neither of the tracker's own frame nor of heat. The laws that are found do not change.
    """
    rows = drawn_rows(rng, runs=2, poses=40, frame=20e-6)
    home = rows.hexapod.home[:3, 3]
    laws = []
    for shift, said in ((np.zeros(3), ""), (home, "That is home"), (np.array([0.0, 2e-3, 0.0]), "Another frame")):
        measured = rows.measured.copy()
        measured[:, :3, 3] += shift
        moved = dataclasses.replace(rows, measured=measured)
        found = [*validate_hexapod(with_law(rows, law()), written(tmp_path, moved)).notes]
        notes = [note for note in found if "further than heat" in note]
        assert len(notes) == bool(said)
        assert all(said in note for note in notes)
        identified = identify_hexapod(moved)
        assert [note for note in identified.notes if "further than heat" in note] == notes
        laws.append(identified.fit.theta)
    np.testing.assert_allclose(laws[1:], [laws[0]] * 2, rtol=2e-2, atol=1e-8)


def test_zero_of_the_campaign(rng: np.random.Generator, tmp_path: Path) -> None:
    """Temperatures count from each run's first row, or from the first run's: a run that begins warm tells the two
    apart, and both are what the table says.
    """
    rows = drawn_rows(rng, runs=2, poses=20)
    warm = dataclasses.replace(rows, dT=rows.dT + 3.0 * (rows.run == 1)[:, None, None])
    for zero, rise in (("run", 0.0), ("campaign", 3.0)):
        (tmp_path / zero).mkdir()
        got = hexapod_rows(written(tmp_path / zero, warm, zero=zero), "validation")
        assert got.dT[got.run == 1][0] == pytest.approx(np.full((6, 1), rise), abs=1e-9)


def test_a_correction_that_was_active_is_noticed(rng: np.random.Generator, tmp_path: Path) -> None:
    """Scales that say another pose than was commanded are noticed; before and after count from the scales."""
    rows = drawn_rows(rng, runs=1, poses=30)
    moved = dataclasses.replace(rows, q=rows.q + 5e-6)
    found = validate_hexapod(with_law(rows, law()), written(tmp_path, moved))
    assert any("the scales say another pose" in note for note in found.notes)


def test_rows_without_a_number_are_left_out_and_said(rng: np.random.Generator, tmp_path: Path) -> None:
    """Missing poses and temperatures are left out, counted by reason."""
    rows = drawn_rows(rng, runs=1, poses=30)
    seen, dT = rows.measured.copy(), rows.dT.copy()
    campaign = written(tmp_path, dataclasses.replace(rows, measured=seen, dT=dT))
    table = (tmp_path / "run-1.csv").read_text(encoding="utf-8").splitlines()
    names = table[0].split(",")
    for row, column in ((5, "measured_rx_deg"), (9, "leg3_T1_degC"), (10, "leg3_T1_degC")):
        fields = table[row].split(",")
        fields[names.index(column)] = ""
        table[row] = ",".join(fields)
    (tmp_path / "run-1.csv").write_text("\n".join(table) + "\n", encoding="utf-8")
    got = hexapod_rows(campaign, "validation")
    assert len(got) == 27
    assert got.left_out == {"the measured pose is missing": 1, "a thermometer gave no value": 2}


def test_refusals(rng: np.random.Generator, tmp_path: Path) -> None:
    """No law, a thermometer that was not recorded, a leg's campaign, a role without runs: each said by name."""
    rows = drawn_rows(rng, runs=1, poses=10)
    campaign = written(tmp_path, rows)
    with pytest.raises(ArgumentError, match="no thermal law"):
        validate_hexapod(rows.hexapod, campaign)
    other = ht.ThermalModel(ht.LegLaw("T7", 2e-6, 1e-6))
    with pytest.raises(UnknownNameError, match="leg1_T7"):
        validate_hexapod(with_law(rows, other), campaign)
    with pytest.raises(ArgumentError, match="no identification run"):
        hexapod_rows(campaign, "identification")
    with pytest.raises(ArgumentError, match="measures no poses"):
        hexapod_rows(dataclasses.replace(campaign, kind="leg"), "validation")
    with pytest.raises(UnknownNameError, match="all legs have: T1"):
        hexapod_rows(campaign, "validation", sensors=("T2",))
