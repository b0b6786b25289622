"""Six legs: laws from 6-D measurements of the platform alone, with uncertainties that hold."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

import hexathermal as ht
from hexathermal.errors import ArgumentError
from hexathermal.learn.hexapod_doubts import weak_coefficients
from hexathermal.learn.hexapod_identification import HexapodIdentification, identify_hexapod
from hexathermal.learn.hexapod_model import columns, frame_columns, measured_lengths, turn_axes
from hexathermal.learn.hexapod_spread import leg_spread
from hexathermal.predict.pose_errors import moved_poses
from tests.learn.hexapods import EQUAL, NOISE, PLATES, UNEQUAL, drawn_rows, machine


def laws_of(found: HexapodIdentification, name: str = "leg-specific") -> np.ndarray:
    """A and B of each leg."""
    return found.fits[name].b[:12].reshape(6, 2)


def test_without_noise_the_truth_comes_back(rng: np.random.Generator) -> None:
    """Twelve coefficients of unequal legs and two plates come back to 1e-4 of themselves from the platform's poses
    alone, although the tracker's frame lies 0.2 mm and 0.4 mrad off, another way in each run.
    """
    rows = drawn_rows(rng, UNEQUAL, noise=np.zeros(6), frame=2e-4)
    found = identify_hexapod(rows)
    assert found.chosen == "leg-specific"
    assert np.abs(laws_of(found) / UNEQUAL - 1.0).max() < 1e-4
    assert np.abs(found.fit.b[12:14] / PLATES - 1.0).max() < 1e-4
    assert found.fit_rmse["leg-specific"][0] < 1e-10


@pytest.mark.long
def test_intervals_cover(rng: np.random.Generator) -> None:
    """Of 560 intervals of 95 % (40 campaigns, 12 + 2 coefficients) 93 to 99.5 % hold the truth: the larger of two
    uncertainties is taken, so they are rather wide.
    """
    truth = np.concatenate([UNEQUAL.ravel(), PLATES])
    inside = []
    for _campaign in range(40):
        fit = identify_hexapod(drawn_rows(rng, UNEQUAL, runs=5, poses=30)).fits["leg-specific"]
        inside.append(np.abs(fit.theta - truth) < 1.96 * np.sqrt(np.diagonal(fit.covariance)))
    assert 0.93 < np.mean(inside) < 0.995


def test_the_noise_is_found_and_given_noise_is_propagated(rng: np.random.Generator) -> None:
    """Coordinates' noise comes out within 15 %, tilted poses or not; given as it is, the legs add nothing and the
    uncertainties agree within 15 %; given half as large, what is missing is found in the legs.
    """
    noise = NOISE * [1.0, 2.0, 0.5, 1.0, 3.0, 0.7]
    rows = drawn_rows(rng, runs=4, poses=100, noise=noise)
    found, told = identify_hexapod(rows), identify_hexapod(rows, noise=noise)
    assert np.abs(found.noise / noise - 1.0).max() < 0.15
    assert told.noise_given
    assert told.leg_noise == 0.0
    assert identify_hexapod(rows, noise=0.5 * noise).leg_noise > 3e-7
    ratio = told.fits["leg-specific"].by_rows / found.fits["leg-specific"].by_rows
    assert np.abs(ratio - 1.0).max() < 0.15


@pytest.mark.long
def test_equal_legs_share_a_law_and_unequal_ones_do_not(rng: np.random.Generator) -> None:
    """Of ten campaigns with equal legs at least nine take one law; legs that differ by 15 % get their own in all."""
    equal = [identify_hexapod(drawn_rows(rng, EQUAL, runs=5)).chosen for _k in range(10)]
    unequal = [identify_hexapod(drawn_rows(rng, UNEQUAL, runs=5)).chosen for _k in range(10)]
    assert equal.count("common") >= 9
    assert unequal.count("leg-specific") == 10


def test_laws_of_a_bench_are_judged_by_the_platform(rng: np.random.Generator) -> None:
    """True laws from a bench are taken, six of them for unequal legs; laws that are 20 % off are not."""
    rows = drawn_rows(rng, UNEQUAL, runs=5)
    right = identify_hexapod(rows, legs={"bench": UNEQUAL[..., None]})
    wrong = identify_hexapod(rows, legs={"bench": 1.2 * UNEQUAL[..., None]})
    assert right.chosen == "bench"
    assert np.array_equal(laws_of(right, "bench"), UNEQUAL)
    assert wrong.chosen == "leg-specific"
    assert right.left_out_rmse["bench"][0] < wrong.left_out_rmse["bench"][0]


@pytest.mark.long
def test_slow_deviations_widen_the_uncertainty(rng: np.random.Generator) -> None:
    """Deviations that rows of a run share (0.6 um at 5 K) are not taken for independent: intervals of 95 % still hold
    the truth in more than 88 %, where those of independent rows hold it in less than 75 %.
    """
    wide, narrow = [], []
    for _campaign in range(12):
        fit = identify_hexapod(drawn_rows(rng, EQUAL, runs=8, poses=60, slow=6e-7)).fits["leg-specific"]
        off = np.abs(fit.theta[:12] - EQUAL.ravel())
        wide.append(off < 1.96 * np.sqrt(np.diagonal(fit.covariance))[:12])
        narrow.append(off < 1.96 * fit.by_rows[:12])
    assert np.mean(wide) > 0.88
    assert np.mean(narrow) < 0.75


def test_misses_of_the_tracker_are_left_out_and_said(rng: np.random.Generator) -> None:
    """Five poses that are 0.1 mm off are left out, counted and said, and no others; the law is that of the rest."""
    rows = drawn_rows(rng)
    spoilt = rows.measured.copy()
    bad = np.array([3, 50, 51, 90, 150])
    spoilt[bad, :3, 3] += 1e-4
    found = identify_hexapod(dataclasses.replace(rows, measured=spoilt))
    rest = identify_hexapod(rows.rows(~np.isin(np.arange(len(rows)), bad)))
    assert sum(found.rows.left_out.values()) == 5
    assert len(found.rows) == len(rows) - 5
    assert any("5 rows were left out" in note for note in found.notes)
    assert np.allclose(laws_of(found), laws_of(rest), rtol=1e-3)


@pytest.mark.parametrize("frame", ["run", "campaign", "none"])
def test_the_frame_is_a_choice(rng: np.random.Generator, frame: str) -> None:
    """Without any frame error all three choices find the truth within their uncertainties; the fewer unknowns, the
    smaller the uncertainty.
    """
    rows = drawn_rows(rng, frame=0.0)
    fit = identify_hexapod(rows, frame=frame).fits["common"]
    off = np.abs(fit.theta[:2] - EQUAL[0]) / np.sqrt(np.diagonal(fit.covariance))[:2]
    assert off.max() < 4.0
    free = identify_hexapod(rows, frame="run").fits["common"]
    assert (fit.by_rows[:4] <= 1.05 * free.by_rows[:4]).all()


def test_plates_are_a_choice(rng: np.random.Generator) -> None:
    """Plates taken from the machine, or left out, are not fitted; left out, the fit is worse where they expand."""
    rows = drawn_rows(rng, noise=0.1 * NOISE)
    law = ht.LegLaw("T1", 2e-6, 1e-6)
    thermal = ht.ThermalModel(law, ht.PlateLaw(PLATES[0], "T1"), ht.PlateLaw(PLATES[1], "T1"))
    rows = dataclasses.replace(rows, hexapod=dataclasses.replace(rows.hexapod, thermal=thermal))
    known, none = identify_hexapod(rows, plates="known"), identify_hexapod(rows, plates="none")
    assert known.fit.model.words == ("A T1", "B T1")
    assert np.array_equal(known.fit.b[12:], PLATES)
    assert none.fit_rmse["common"][0] > 2.0 * known.fit_rmse["common"][0]


def test_the_machine_is_written_and_predicts(rng: np.random.Generator, tmp_path: Path) -> None:
    """The identified machine survives its file, and predicts what the platform did: distances as small as the fit's."""
    rows = drawn_rows(rng, UNEQUAL, frame=0.0)
    found = identify_hexapod(rows, frame="none")
    made = found.hexapod("a campaign")
    ht.write_hexapod(made, tmp_path)
    assert ht.load_hexapod(tmp_path) == made
    assert made.thermal is not None
    assert made.thermal.legs[0].covariance is not None
    assert made.grade == "A"
    temps = np.column_stack([rows.dT[..., 0], rows.plates]) + 20.0
    warm = made.predicted_pose(0.6 + rows.q, temps)
    apart = np.linalg.norm((warm - rows.measured)[:, :3, 3], axis=1)
    assert np.sqrt((apart**2).mean()) == pytest.approx(found.fit_rmse["leg-specific"][0], rel=1e-3)


def test_columns_are_derivatives(rng: np.random.Generator) -> None:
    """Columns of plates and frame are the derivatives of leg lengths: central differences agree to 1e-6 of them."""
    rows = drawn_rows(rng, runs=1, poses=20)
    X = columns(rows.hexapod, rows.measured, rows.q, rows.dT, rows.plates)
    F = frame_columns(rows.hexapod, rows.measured)

    def lengths(scale: np.ndarray, motion: np.ndarray) -> np.ndarray:
        poses = moved_poses(rows.measured, motion, rows.hexapod.home[:3, 3])
        p = rows.hexapod.platform_joints * (1 + scale[0] * rows.plates[:, 0, None, None])
        b = rows.hexapod.base_joints * (1 + scale[1] * rows.plates[:, 1, None, None])
        return np.linalg.norm(np.einsum("nij,nkj->nki", poses[:, :3, :3], p) + poses[:, None, :3, 3] - b, axis=2)

    for k in range(2):
        d = 1e-5 * np.eye(2)[k]
        slope = (lengths(d, np.zeros(6)) - lengths(-d, np.zeros(6))) / 2e-5
        # an expanded plate makes the leg longer than the nominal joints say, or shorter: the law's column has that sign
        assert np.allclose(-slope, X[:, :, 12 + k], atol=1e-6)
    for k in range(6):
        d = 1e-5 * np.eye(6)[k]
        slope = (lengths(np.zeros(2), d) - lengths(np.zeros(2), -d)) / 2e-5
        assert np.allclose(slope, F[:, :, k], atol=1e-6)
    assert np.abs(measured_lengths(rows, rows.measured)).max() < 1e-4


def test_axes_of_the_coordinates_are_derivatives(rng: np.random.Generator) -> None:
    """rx, ry, rz turn the platform about the axes that are said, tilted or not."""
    hexapod = machine()
    six = np.array([[0, 0, 0, 0, 0, 0], [5, -3, 2, 20, -15, 30.0], [0, 0, 0, -10, 25, -40]])
    poses = ht.pose_from_coordinates(six, hexapod=hexapod)
    axes = turn_axes(poses, hexapod.home)
    for k in range(3):
        d = np.zeros(6)
        d[3 + k] = 1e-3
        pair = [ht.pose_from_coordinates(six + s * d, hexapod=hexapod)[:, :3, :3] for s in (1, -1)]
        turn = (pair[0] - pair[1]) / (2.0 * np.radians(1e-3)) @ np.swapaxes(poses[:, :3, :3], 1, 2)
        found = np.stack([turn[:, 2, 1], turn[:, 0, 2], turn[:, 1, 0]], axis=-1)
        assert np.allclose(found, axes[:, :, k], atol=1e-6)


def test_refusals_name_what_is_missing(rng: np.random.Generator) -> None:
    """Too few poses, a thermometer that never leaves its zero, plates not stated: each says what and what to try."""
    rows = drawn_rows(rng, runs=1)
    cold = dataclasses.replace(rows, dT=np.zeros_like(rows.dT))
    cases = [
        (rows.rows(np.arange(len(rows)) < 4), {}, "poses cannot tell"),
        (cold, {}, "never leaves its zero"),
        (rows, {"plates": "known"}, "states no expansion"),
        (rows, {"plates": "maybe"}, "plates is 'maybe'"),
        (rows, {"frame": "sometimes"}, "frame is 'sometimes'"),
    ]
    for one, options, words in cases:
        with pytest.raises(ArgumentError, match=words):
            identify_hexapod(one, **options)  # type: ignore[arg-type]


def test_one_run_is_said(rng: np.random.Generator) -> None:
    """One run is enough for laws, but nothing is judged on runs left out, and that is said."""
    found = identify_hexapod(drawn_rows(rng, runs=1, poses=80))
    assert any("one run only" in note for note in found.notes)
    assert np.isnan(found.left_out_rmse["common"][0])


def test_stated_plates_are_taken_and_contradicted(rng: np.random.Generator) -> None:
    """Plates that the machine states are taken as they are; a statement that is 8 um/m/K off is contradicted in words,
    a true one is not.
    """
    rows = drawn_rows(rng)
    law = ht.LegLaw("T1", 2e-6, 1e-6)
    said = []
    for off in (0.0, 8e-6):
        plates = (ht.PlateLaw(PLATES[0] - off, "T1"), ht.PlateLaw(PLATES[1], "T1"))
        hexapod = dataclasses.replace(rows.hexapod, thermal=ht.ThermalModel(law, *plates))
        found = identify_hexapod(dataclasses.replace(rows, hexapod=hexapod))
        assert np.array_equal(found.fit.b[12:], PLATES - [off, 0.0])
        said.append([note for note in found.notes if "found freely" in note])
    assert not said[0]
    assert len(said[1]) == 1
    assert said[1][0].startswith("the platform is taken to expand by 3.00 um/m/K")


def test_one_law_for_legs_that_differ_says_so_in_its_covariance() -> None:
    """Legs that differ by 5 % hardly prove it in six runs: where one law is taken for all, the 95 % intervals that are
    written hold the legs' own coefficients A in 90 % at least, and would in less than 70 % without the spread.
    """
    rng = np.random.default_rng(3)
    wide, narrow = [], []
    for _machine in range(10):
        laws = EQUAL * (1.0 + 0.05 * rng.standard_normal((6, 2)))
        found = identify_hexapod(drawn_rows(rng, laws, runs=6, poses=30, slow=3e-7))
        made = dataclasses.replace(found, chosen="common").laws()
        covariance = found.fits["common"].full_covariance
        for leg, law in enumerate(made):
            assert law.covariance is not None
            assert law.spread is not None
            own = covariance[2 * leg : 2 * leg + 2, 2 * leg : 2 * leg + 2]
            assert np.allclose(law.covariance - np.diag(law.spread**2), own, rtol=1e-9, atol=1e-22)
            off = abs(law.A[0] - laws[leg, 0])
            wide.append(off < 1.96 * np.sqrt(law.covariance[0, 0]))
            narrow.append(off < 1.96 * np.sqrt(covariance[2 * leg, 2 * leg]))
    assert np.mean(wide) >= 0.9
    assert np.mean(narrow) < 0.7


def test_the_spread_between_legs_is_that_of_the_legs(rng: np.random.Generator) -> None:
    """Over 200 draws of six legs the spread found is 0.7 to 1.3 of the true one on average, known exactly or with
    uncertainties half as large; equal legs get less than half of their uncertainty.
    """
    for known in (1e-6, 0.5):
        found = [leg_spread(rng.standard_normal(6) * np.hypot(1.0, known), known**2 * np.eye(6)) for _k in range(200)]
        assert 0.7 < np.mean(found) < 1.3
    assert leg_spread(np.zeros(6), np.eye(6)) < 0.5
    assert leg_spread(np.zeros(6), np.zeros((6, 6))) == 0.0


def test_coefficients_that_rows_do_not_tell_are_warned_of(rng: np.random.Generator) -> None:
    """Poses near home with legs of one length do not tell B: one warning names it with its uncertainty and says to use
    more of the stroke; poses over the whole stroke give none.
    """
    near = np.array([[0.2, 0, 0, 0, 0, 0], [0, 0.2, 0, 0, 0, 0], [0, 0, 0.4, 0, 0, 0], [0, 0, -0.4, 0.02, 0, 0.02]] * 8)
    weak = weak_coefficients(identify_hexapod(drawn_rows(rng, coordinates=near, frame=0.0), frame="none"))
    assert any(text.startswith("B T1") and "over more of the 250 mm" in text for text in weak), weak
    assert not weak_coefficients(identify_hexapod(drawn_rows(rng, poses=60)))


@pytest.mark.parametrize("laws", [EQUAL, UNEQUAL], ids=["equal legs", "unequal legs"])
@pytest.mark.parametrize("bench", [False, True], ids=["fitted", "and from a bench"])
def test_a_run_of_one_row_changes_nothing(rng: np.random.Generator, laws: np.ndarray, bench: bool) -> None:
    """Its own frame takes all that one row tells: the same kind of laws is chosen as without it, on the same runs left
    out, with the same coefficients and uncertainties.
    """
    rows = drawn_rows(rng, laws, runs=4)
    three = rows.run < 3
    single = three | (np.arange(len(rows)) == np.argmax(rows.run == 3))
    legs = {"bench": laws[:, :, None]} if bench else None
    with_it, without = (identify_hexapod(rows.rows(keep), legs=legs, noise=NOISE) for keep in (single, three))
    assert len(with_it.rows) == len(without.rows) + 1
    assert (with_it.chosen, with_it.reason) == (without.chosen, without.reason)
    assert without.chosen == ("bench" if bench else "common" if laws is EQUAL else "leg-specific")
    np.testing.assert_allclose(with_it.fit.b, without.fit.b, rtol=1e-3, atol=1e-12)
    np.testing.assert_allclose(with_it.fit.by_runs, without.fit.by_runs, rtol=1e-2)
    assert np.isnan(with_it.fit.left_out).tolist() == [False, False, False, True]
