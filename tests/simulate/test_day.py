"""A simulated working day: its temperatures obey their equation, and correction does what it can and no more."""

from __future__ import annotations

import csv
import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import hexathermal as ht
from hexathermal.errors import ArgumentError, KinematicsError, TemperatureError, ThermalModelError
from hexathermal.simulate.day import HOUR_S, WorkingDay, day_temperatures, lagged, readings, sensor_truth
from hexathermal.simulate.demonstration import (
    demonstrate,
    held_at_its_base,
    largest,
    pose_errors,
    save,
    summary,
    table,
    with_plate_sensors,
    with_true_law,
    work_poses,
)
from tests.machines import rotation

EXACT = WorkingDay(law_uncertainty=0.0)
QUIET = WorkingDay(sensor_noise_K=0.0, sensor_gain=0.0, law_uncertainty=0.0)


def temperatures(day: WorkingDay, seed: int = 1, reference: float = 20.0):
    return day_temperatures(day, reference, np.random.default_rng(seed))


@given(tau=st.floats(10.0, 1e5), step=st.floats(1.0, 600.0), height=st.floats(-50.0, 50.0))
def test_a_lump_answers_a_step_exactly(tau: float, step: float, height: float) -> None:
    """``T = T_end + (T_0 - T_end) exp(-t/tau)`` after a step of the surroundings, for any step of time."""
    around = np.full((40, 2), 20.0 + height)
    around[0] = 20.0
    found = lagged(around, step, np.array([tau, 2.0 * tau]))
    elapsed = np.maximum(np.arange(40) - 1, 0)[:, None] * step
    wanted = 20.0 + height * (1.0 - np.exp(-elapsed / np.array([tau, 2.0 * tau])))
    assert np.abs(found - wanted).max() < 1e-9


def test_legs_follow_the_differential_equation() -> None:
    """``tau dT/dt = T_room - T + rise`` integrated by another method gives the same legs to 5 mK."""
    day = WorkingDay(heat_spread=0.0, leg_spread=0.0)
    truth = temperatures(day)

    def room(time: float) -> float:
        return float(np.interp(time, truth.time, truth.room))

    def rate(time: float, T: np.ndarray) -> np.ndarray:
        works = truth.working[min(int(time // day.step_s), len(truth.working) - 1)]
        return (room(time) + works * day.heat_W * day.rise_K_per_W - T) / day.leg_time_constant_s

    stops = truth.time[::30]
    found = solve_ivp(rate, (0.0, truth.time[-1]), truth.legs[0, :1], t_eval=stops, rtol=1e-7, max_step=day.step_s)
    assert np.abs(found.y[0] - truth.legs[::30, 0]).max() < 5e-3


@given(seed=st.integers(0, 1000))
def test_the_day_keeps_its_promises(seed: int) -> None:
    """The room stays within 2 K and below 1 K/h, legs rise by about 5 K above it, plates lag behind the legs."""
    truth = temperatures(WorkingDay(), seed)
    assert np.abs(truth.room - 20.0).max() <= 2.0
    assert np.abs(np.diff(truth.room)).max() * 60.0 < 1.0
    end = int(np.flatnonzero(truth.working)[-1])
    above = truth.legs[end] - truth.room[end]
    assert 4.0 < above.mean() < 6.0
    assert 0.05 < np.ptp(above) < 2.5
    assert truth.legs[end].min() > truth.platform[end] > truth.base[end]
    assert truth.working.sum() == 7.5 * 60
    assert truth.time[-1] == 12 * HOUR_S


def test_nothing_drives_nothing() -> None:
    """Without heat and swing every part stays at the reference temperature."""
    truth = temperatures(WorkingDay(heat_W=0.0, room_swing_K=0.0), reference=17.25)
    for part in (truth.room, truth.legs, truth.platform, truth.base):
        assert np.array_equal(part, np.full_like(part, 17.25))


def test_a_seed_is_a_day() -> None:
    """The same seed gives the same legs to the last bit, another one others."""
    assert np.array_equal(temperatures(WorkingDay(), 5).legs, temperatures(WorkingDay(), 5).legs)
    assert np.abs(temperatures(WorkingDay(), 5).legs - temperatures(WorkingDay(), 6).legs).max() > 0.01


def test_thermometers_err_as_stated(reference: ht.Hexapod) -> None:
    """Noise has the stated standard deviation, gain errors too, and both vanish when set to 0."""
    truth = np.full((20_000, 6), 30.0)
    rng = np.random.default_rng(3)
    day = WorkingDay()
    draws = [readings(reference, truth, day, rng) for _ in range(60)]
    noise = np.concatenate([draw - draw.mean(axis=0) for draw in draws])
    gains = np.concatenate([(draw.mean(axis=0) - 30.0) / 10.0 for draw in draws])
    assert noise.std() == pytest.approx(day.sensor_noise_K, rel=0.01)
    assert gains.std() == pytest.approx(day.sensor_gain, rel=0.15)
    assert np.array_equal(readings(reference, truth, QUIET, rng), truth)


def test_sensors_stand_on_their_parts(two_plates: ht.Hexapod) -> None:
    """Both thermometers of a leg read that leg, those of the plates the plates."""
    truth = temperatures(WorkingDay())
    found = dict(zip(two_plates.sensor_names, sensor_truth(two_plates, truth).T, strict=True))
    assert np.array_equal(found["leg3_T15"], truth.legs[:, 2])
    assert np.array_equal(found["leg3_T7"], truth.legs[:, 2])
    assert np.array_equal(found["platform_T1"], truth.platform)
    assert np.array_equal(found["base_T1"], truth.base)


def test_the_truth_has_the_same_laws_and_more_eyes(reference: ht.Hexapod, two_plates: ht.Hexapod) -> None:
    """Plates without a thermometer get one, nothing else changes; a machine with all of them stays as it is."""
    whole = with_plate_sensors(reference)
    assert whole.sensor_names == (*reference.sensor_names, "platform_true", "base_true")
    even = np.full(8, 20.0)
    hot = even + [1, 2, 3, 4, 5, 6, 0, 0]
    assert np.array_equal(
        whole.corrected_leg_lengths(reference.home, hot), reference.corrected_leg_lengths(reference.home, hot[:6])
    )
    assert with_plate_sensors(two_plates) is two_plates


def test_each_sensor_keeps_its_reference_temperature(reference: ht.Hexapod) -> None:
    """References of the legs stay with their sensors; a plate without one counts from their mean."""
    model = dataclasses.replace(reference.thermal, reference_temperature_degC=np.arange(18.0, 24.0))
    whole = with_plate_sensors(dataclasses.replace(reference, thermal=model))
    assert whole.thermal is not None
    assert np.array_equal(whole.thermal.reference_temperature_degC, [*np.arange(18.0, 24.0), 20.5, 20.5])


@given(shift=st.tuples(*[st.floats(-1e-3, 1e-3)] * 3), turn=st.tuples(*[st.floats(-1e-3, 1e-3)] * 3))
def test_errors_are_shift_and_turn_in_base_axes(shift: tuple[float, ...], turn: tuple[float, ...]) -> None:
    """``t = t_w + shift`` and ``R = exp(turn) R_w`` give back shift and turn."""
    wanted = ht.pose_from_coordinates([10, 20, 30, 5, -7, 80])
    reached = wanted.copy()
    reached[:3, 3] += shift
    reached[:3, :3] = rotation(np.array(turn)) @ wanted[:3, :3]
    assert np.abs(pose_errors(wanted, reached) - [*shift, *turn]).max() < 1e-15


def test_what_is_known_is_corrected_completely(two_plates: ht.Hexapod) -> None:
    """With perfect thermometers on legs and plates no error is left (1 pm), where micrometres stand without."""
    result = demonstrate(two_plates, day=QUIET)
    assert np.abs(result.errors_with).max() < 1e-12
    assert largest(result.errors_without)[0].max() > 5.0


@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_correction_helps_also_with_real_thermometers(reference: ht.Hexapod, seed: int) -> None:
    """With unwatched plates, erring thermometers and a law 3 % off, the shift shrinks by 80 %; the turn still shrinks.

    Turns come from small differences of the legs; with an exact law they shrink by more than half.
    """
    numbers = summary(demonstrate(reference, seed=seed))
    assert numbers["largest_shift_um"]["reduction_percent"] > 80.0
    assert numbers["largest_turn_urad"]["reduction_percent"] > 0.0
    exact = summary(demonstrate(reference, day=EXACT, seed=seed))
    assert exact["largest_turn_urad"]["reduction_percent"] > 50.0


def test_what_is_left_comes_from_plates_and_thermometers(reference: ht.Hexapod) -> None:
    """Perfect thermometers leave the plates' part; plates that do not expand leave nothing (1 pm)."""
    left = demonstrate(reference, day=QUIET)
    assert largest(left.errors_with)[0].max() > 0.2
    model = dataclasses.replace(reference.thermal, platform=ht.PlateLaw(0.0), base=ht.PlateLaw(0.0))
    stiff = demonstrate(dataclasses.replace(reference, thermal=model), day=QUIET)
    assert np.abs(stiff.errors_with).max() < 1e-12


def test_every_number_is_the_librarys(reference: ht.Hexapod) -> None:
    """Lengths, readings and errors belong together: picked rows are recomputed one by one."""
    result = demonstrate(reference, day=EXACT, seed=9)
    held, centre = held_at_its_base(reference)
    assert np.allclose(centre, [0, 0, -0.6633], atol=1e-12)
    whole = with_plate_sensors(held)
    for n, m in ((0, 0), (333, 5), (720, 7)):
        pose, told = result.poses[m], result.corrected[n, m]
        assert np.array_equal(told, reference.corrected_leg_lengths(pose, result.readings[n]))
        stands = whole.predicted_pose(told, sensor_truth(whole, result.truth)[n])
        wanted = ht.pose_from_coordinates([0, 0, 663.3, 0, 0, 0]) @ pose
        assert np.abs(pose_errors(wanted, stands) - result.errors_with[n, m]).max() < 1e-14


def test_work_poses_suit_the_machine(reference: ht.Hexapod) -> None:
    """They close about home, stay inside stroke and travel limits, and shrink where the machine allows less."""
    heat = np.full((1, 6), 22.0)
    wide = ht.coordinates_from_pose(work_poses(reference, heat), hexapod=reference)
    assert np.abs(wide[:, :3]).max() > 20.0
    assert np.abs(wide.mean(axis=0)).max() < 0.1
    ranges = [(-0.004, 0.004)] * 3 + [(-0.002, 0.002)] * 3
    limited = dataclasses.replace(reference, limits=ht.PoseLimits(*ranges))
    narrow = ht.coordinates_from_pose(work_poses(limited, heat), hexapod=reference)
    assert 1.0 < np.abs(narrow[:, :3]).max() <= 4.0
    assert np.abs(np.radians(narrow[:, 3:])).max() <= 0.002
    tight = dataclasses.replace(reference, platform_cone=np.radians(1.0), base_cone=np.radians(1.0))
    shrunk = ht.coordinates_from_pose(work_poses(tight, heat), hexapod=reference)
    assert 0.0 < np.abs(shrunk[:, :3]).max() < 0.5 * np.abs(wide[:, :3]).max()
    free = dataclasses.replace(reference, stroke=None)
    assert np.abs(ht.coordinates_from_pose(work_poses(free, heat), hexapod=reference)).max() > 20.0


def test_the_true_law_differs_as_stated(reference: ht.Hexapod) -> None:
    """Each true A and B is drawn about the law's with the stated deviation; 0 changes nothing; what is left grows."""
    day, rng = WorkingDay(law_uncertainty=0.05), np.random.default_rng(2)
    machines = [with_true_law(reference, day, rng) for _ in range(300)]
    for name in ("A", "B"):
        true = np.array([[getattr(law, name) for law in machine.thermal.legs] for machine in machines])
        ratio = true / [getattr(law, name) for law in reference.thermal.legs]
        assert ratio.std() == pytest.approx(0.05, rel=0.1)
        assert ratio.mean() == pytest.approx(1.0, abs=0.005)
    same = with_true_law(reference, EXACT, rng)
    for law, known in zip(same.thermal.legs, reference.thermal.legs, strict=True):
        assert np.array_equal(law.A, known.A)
        assert np.array_equal(law.B, known.B)
    wrong = dataclasses.replace(QUIET, law_uncertainty=0.2)
    known, drawn = (demonstrate(reference, day=day, seed=2) for day in (QUIET, wrong))
    assert largest(drawn.errors_with)[0].max() > largest(known.errors_with)[0].max() + 0.1
    assert np.array_equal(drawn.readings, known.readings)
    assert np.array_equal(drawn.corrected, known.corrected)


def test_files_of_a_day_appear_together_or_not_at_all(reference: ht.Hexapod, tmp_path: Path) -> None:
    """An interrupt while the last file is written leaves the earlier day as it was, and no parts."""
    (tmp_path / "day.csv").write_text("yesterday")

    def interrupted(_part: Path) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        save(demonstrate(reference), tmp_path, {"day.png": interrupted})
    assert [file.name for file in tmp_path.iterdir()] == ["day.csv"]
    assert (tmp_path / "day.csv").read_text() == "yesterday"


def test_days_that_cannot_be_are_refused(reference: ht.Hexapod) -> None:
    """No law, a day outside the law's range, a machine that cannot move, and numbers that make no sense."""
    with pytest.raises(ThermalModelError, match="not active"):
        demonstrate(ht.load_hexapod("rubin-camera"))
    with pytest.raises(TemperatureError, match="outside the law's range"):
        demonstrate(reference, day=WorkingDay(room_above_K=40.0))
    cone = np.radians(1e-9)
    with pytest.raises(KinematicsError, match="hardly leave its home"):
        demonstrate(dataclasses.replace(reference, base_cone=cone, platform_cone=cone))
    for bad in (
        {"step_s": 0.0},
        {"shift_h": float("nan")},
        {"heat_W": -1.0},
        {"leg_spread": 1.0},
        {"law_uncertainty": 1.0},
    ):
        with pytest.raises(ArgumentError):
            WorkingDay(**bad)


def test_what_is_saved_is_what_was_computed(reference: ht.Hexapod, tmp_path: Path) -> None:
    """``day.csv`` has a row for each minute and work pose, to 0.1 nm; ``summary.json`` has the largest errors."""
    result = demonstrate(reference, seed=4)
    days, numbers = save(result, tmp_path)
    with days.open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    names, values = rows[0], np.array(rows[1:], dtype=float)
    assert names == table(result)[0]
    n, m = result.corrected.shape[:2]
    assert values.shape == (n * m, len(names))
    by = {name: values[:, k].reshape(n, m) for k, name in enumerate(names)}
    assert np.abs(by["leg4_length_mm"] / 1e3 - result.corrected[:, :, 3]).max() < 1e-10
    assert np.abs(by["with_z_um"] / 1e6 - result.errors_with[:, :, 2]).max() < 1e-10
    assert np.abs(by["without_ry_urad"] / 1e6 - result.errors_without[:, :, 4]).max() < 1e-10
    assert np.abs(by["leg2_T1_degC"][:, 0] - result.readings[:, 1]).max() < 1e-4
    found = json.loads(numbers.read_text())
    shift = np.sqrt(by["with_x_um"] ** 2 + by["with_y_um"] ** 2 + by["with_z_um"] ** 2).max()
    assert found["largest_shift_um"]["with"] == pytest.approx(shift, abs=1e-3)
    assert found["day"] == dataclasses.asdict(WorkingDay())
    assert (found["seed"], found["machine"]) == (4, "reference")


def test_exchanged_plugs_stand_in_the_columns_of_the_record(two_plates: ht.Hexapod) -> None:
    """Where the plugs of legs 2 and 5 are exchanged, each leg's temperature stands under the other's name, and
    correction is as good as with plugs in their places.
    """
    assert two_plates.thermal is not None
    model = dataclasses.replace(two_plates.thermal, thermometers_of_leg=(1, 5, 3, 4, 2, 6))
    swapped = dataclasses.replace(two_plates, thermal=model)
    day = temperatures(QUIET)
    truth = dict(zip(model.sensor_names, sensor_truth(swapped, day).T, strict=True))
    for recorded, leg in ((1, 1), (2, 5), (5, 2), (6, 6)):
        assert np.array_equal(truth[f"leg{recorded}_T15"], day.legs[:, leg - 1])
    assert np.array_equal(truth["platform_T1"], day.platform)
    assert np.array_equal(truth["base_T1"], day.base)
    left = [largest(demonstrate(one, day=QUIET, seed=3).errors_with)[0].max() for one in (two_plates, swapped)]
    assert left[1] == pytest.approx(left[0], abs=1e-6)
