"""Corrected leg lengths, corrected pose and predicted pose."""

from __future__ import annotations

import dataclasses

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hexathermal as ht
from hexathermal.errors import (
    ArgumentError,
    HexathermalError,
    OutOfStrokeError,
    TemperatureError,
    ThermalModelError,
)
from tests.machines import oracle_lengths, random_poses

A, B = 1.99e-6, 1.09e-6
EXACT_M = 4e-16


def paper_drift_um(q0_mm: np.ndarray, q_mm: np.ndarray, dT: np.ndarray) -> np.ndarray:
    """Eq. (8) as printed: millimetres in, micrometres out."""
    return 1.99e-3 * q0_mm * dT + 1.09e-3 * q_mm * dT


def test_drift_is_eq_8_of_the_paper(reference: ht.Hexapod, rng: np.random.Generator) -> None:
    """The reference machine's drift is eq. (8) as printed, to 1e-9 um."""
    lengths = rng.uniform(0.6, 0.85, (50, 6))
    temps = rng.uniform(5, 45, (50, 6))
    drift = reference.leg_drift(lengths, temps)
    assert np.abs(drift * 1e6 - paper_drift_um(600.0, (lengths - 0.6) * 1e3, temps - 20.0)).max() < 1e-9


def test_the_papers_largest_drift_needs_5_3_kelvin(reference: ht.Hexapod) -> None:
    """At q0 = 600 mm, q = 250 mm the paper's largest drift, 7.81 um, is reached 5.33 K above the reference."""
    drift = reference.leg_drift(np.full(6, 0.85), np.full(6, 20.0 + 7.81 / (1.99 * 0.6 + 1.09 * 0.25)))
    assert np.allclose(drift, 7.81e-6, atol=1e-15)
    assert 7.81 / (1.99 * 0.6 + 1.09 * 0.25) == pytest.approx(5.33, abs=0.01)


def test_correction_is_exact(reference: ht.Hexapod, rng: np.random.Generator) -> None:
    """corrected + drift(corrected) equals the nominal length to 4e-16 m at every temperature."""
    poses = random_poses(reference, 500, rng)
    temps = rng.uniform(5, 45, (500, 6))
    corrected = reference.corrected_leg_lengths(poses, temps)
    q = corrected - 0.6
    true = corrected + (A * 0.6 + B * q) * (temps - 20.0)
    assert np.abs(true - oracle_lengths(reference, poses)).max() < EXACT_M


def test_reference_temperature_changes_nothing(reference: ht.Hexapod, rng: np.random.Generator) -> None:
    """dT = 0: corrected lengths are the nominal ones, corrected and predicted poses the wanted ones."""
    poses = random_poses(reference, 100, rng)
    temps = np.full(6, 20.0)
    nominal = reference.inverse_kinematics(poses)
    assert np.abs(reference.corrected_leg_lengths(poses, temps) - nominal).max() < EXACT_M
    assert np.abs(reference.corrected_pose(poses, temps) - poses).max() < 1e-14
    assert np.abs(reference.predicted_pose(nominal, temps) - poses).max() < 1e-14


@pytest.mark.parametrize("machine", ["reference", "two_plates"])
def test_a_corrected_machine_stands_where_it_should(
    machine: str, request: pytest.FixtureRequest, rng: np.random.Generator
) -> None:
    """predicted_pose(corrected_leg_lengths(pose, T), T) = pose to 1e-13 m, plates and several sensors included."""
    hexapod = request.getfixturevalue(machine)
    poses = random_poses(ht.load_hexapod("reference"), 300, rng)
    temps = rng.uniform(5, 45, (300, len(hexapod.sensor_names)))
    stands = hexapod.predicted_pose(hexapod.corrected_leg_lengths(poses, temps), temps)
    assert np.abs(stands - poses).max() < 1e-13
    uncorrected = hexapod.predicted_pose(hexapod.inverse_kinematics(poses), temps)
    assert np.abs(uncorrected - poses)[:, :3, 3].max() > 5e-6


def test_corrected_pose_makes_a_nominal_controller_command_the_corrected_lengths(
    reference: ht.Hexapod, rng: np.random.Generator
) -> None:
    """Nominal inverse kinematics of the corrected pose gives the corrected lengths to 1e-14 m."""
    poses = random_poses(reference, 200, rng)
    temps = rng.uniform(15, 30, (200, 6))
    lengths = reference.corrected_leg_lengths(poses, temps)
    sent = reference.corrected_pose(poses, temps)
    assert np.abs(reference.inverse_kinematics(sent) - lengths).max() < 1e-14
    assert isinstance(reference.corrected_pose(pin.SE3(poses[0]), temps[0]), pin.SE3)


@given(st.floats(1.0, 49.0), st.floats(-2e-5, 2e-5))
def test_uniform_expansion_of_everything_scales_the_machine(temperature: float, alpha: float) -> None:
    """Legs and plates of one material at one temperature: the platform moves out from the base's origin by alpha dT."""
    law = ht.LegLaw(("T1",), np.array([alpha]), np.array([alpha]))
    plate = ht.PlateLaw(alpha, "T1")
    reference = ht.load_hexapod("reference")
    hexapod = dataclasses.replace(reference, thermal=ht.ThermalModel(law, plate, plate, 20.0, (0.0, 50.0)))
    pose = ht.pose_from_coordinates([20, -10, 15, 2, -3, 4])
    warm = hexapod.predicted_pose(hexapod.inverse_kinematics(pose), np.full(8, temperature))
    scale = 1.0 + alpha * (temperature - 20.0)
    assert np.abs(warm[:3, :3] - pose[:3, :3]).max() < 1e-13
    assert np.abs(warm[:3, 3] - scale * pose[:3, 3]).max() < 1e-13


def test_plates_expand_by_their_own_temperature(two_plates: ht.Hexapod) -> None:
    """The closure |t + R p (1 + ap) - b (1 + ab)| = command + drift holds at the predicted pose."""
    pose = ht.pose_from_coordinates([10, 5, -8, 1, 2, 3])
    temps = dict(zip(two_plates.sensor_names, np.linspace(18, 27, 14), strict=True))
    command = two_plates.inverse_kinematics(pose)
    stands = two_plates.predicted_pose(command, temps)
    p = two_plates.platform_joints * (1 + 11.5e-6 * (temps["platform_T1"] - 20))
    b = two_plates.base_joints * (1 + 11.5e-6 * (temps["base_T1"] - 20))
    closed = np.linalg.norm(p @ stands[:3, :3].T + stands[:3, 3] - b, axis=1)
    for i in range(6):
        d7, d15 = temps[f"leg{i + 1}_T7"] - 20, temps[f"leg{i + 1}_T15"] - 20
        drift = (1.2e-6 * d7 + 0.8e-6 * d15) * 0.6 + (0.5e-6 * d7 + 0.6e-6 * d15) * (command[i] - 0.6)
        assert closed[i] == pytest.approx(command[i] + drift, abs=1e-14)


def test_sensors_are_in_the_order_of_the_model(two_plates: ht.Hexapod, rng: np.random.Generator) -> None:
    """An array in the order of sensor_names and a mapping in any order mean the same."""
    assert two_plates.sensor_names[:3] == ("leg1_T7", "leg1_T15", "leg2_T7")
    assert two_plates.sensor_names[-2:] == ("platform_T1", "base_T1")
    values = rng.uniform(15, 30, (4, 14))
    mapping = {name: values[:, k] for k, name in reversed(list(enumerate(two_plates.sensor_names)))}
    pose = two_plates.home
    assert np.array_equal(
        two_plates.corrected_leg_lengths(pose, mapping), two_plates.corrected_leg_lengths(pose, values)
    )


def test_poses_and_temperatures_broadcast(reference: ht.Hexapod, rng: np.random.Generator) -> None:
    """Every pair of shapes that broadcasts gives what single calls give, to 2e-16 m."""
    poses, temps = random_poses(reference, 6, rng), rng.uniform(15, 30, (5, 6))
    for T, t in (
        (poses[0], temps), (poses, temps[0]), (poses[:5], temps), (poses[:, None], temps),
        (poses[None, :, None], temps), (poses[:1], temps), (poses.reshape(3, 2, 4, 4)[:, :, None], temps[:, :]),
    ):  # fmt: skip
        lead = np.broadcast_shapes(T.shape[:-2], t.shape[:-1])
        got = reference.corrected_leg_lengths(T, t)
        assert got.shape == (*lead, 6)
        all_poses, all_temps = np.broadcast_to(T, (*lead, 4, 4)), np.broadcast_to(t, (*lead, 6))
        want = [reference.corrected_leg_lengths(all_poses[k], all_temps[k]) for k in np.ndindex(lead)]
        assert np.abs(got.reshape(-1, 6) - want).max() < EXACT_M
        stands = reference.predicted_pose(got, t)
        assert np.abs(stands - all_poses).max() < 1e-13
    with pytest.raises(ArgumentError, match="broadcast"):
        reference.corrected_leg_lengths(poses, temps)


def test_module_level_call(reference: ht.Hexapod) -> None:
    """hexathermal.corrected_leg_lengths takes a machine, a name or a path, and is the method's answer."""
    pose, temps = ht.pose_from_coordinates([5, 0, 12, 0, 1.5, 0]), [21.0, 22, 23, 24, 25, 26]
    want = reference.corrected_leg_lengths(pose, temps)
    assert np.array_equal(ht.corrected_leg_lengths(pose, temps), want)
    assert np.array_equal(ht.corrected_leg_lengths(pose, temps, hexapod=reference), want)
    from hexathermal.machine.library import models_folder

    assert np.array_equal(ht.corrected_leg_lengths(pose, temps, hexapod=models_folder() / "reference"), want)


@pytest.mark.parametrize(
    ("value", "word"),
    [
        (np.nan, "leg3_T1.*NaN"),
        (np.inf, "leg3_T1.*impossible"),
        (-300.0, "leg3_T1.*impossible"),
        (60.0, r"leg3_T1.*outside the law's range of validity \[0, 50\]"),
        (294.15, "leg3_T1.*kelvin"),
    ],
)
def test_a_bad_temperature_names_its_sensor(reference: ht.Hexapod, value: float, word: str) -> None:
    """NaN, infinite, impossible, out-of-range and kelvin values name the sensor, alone and inside a batch."""
    temps = np.full((40, 6), 21.0)
    temps[17, 2] = value
    home = reference.home
    lengths = reference.inverse_kinematics(home)
    for call in (
        lambda: reference.corrected_leg_lengths(home, temps[17]),
        lambda: reference.corrected_leg_lengths(home, temps),
        lambda: reference.predicted_pose(lengths, temps),
        lambda: reference.leg_drift(lengths, temps[17]),
        lambda: reference.corrected_pose(home, temps),
    ):
        with pytest.raises(TemperatureError, match=word) as caught:
            call()
        assert caught.value.sensor == "leg3_T1"


def test_missing_and_unknown_sensors_are_named(reference: ht.Hexapod) -> None:
    """A mapping without a sensor, or with one that the machine does not have, names it and those that exist."""
    temps = dict.fromkeys(reference.sensor_names, 21.0)
    del temps["leg4_T1"]
    with pytest.raises(TemperatureError, match=r"leg4_T1 is missing.*leg1_T1, leg2_T1"):
        reference.corrected_leg_lengths(reference.home, temps)
    with pytest.raises(TemperatureError, match="leg7_T1 is not one of"):
        reference.corrected_leg_lengths(reference.home, temps | {"leg4_T1": 21.0, "leg7_T1": 20.0})


def test_compensation_that_is_not_active_says_so() -> None:
    """A machine without a thermal law refuses to correct and says why; its repr says so too."""
    camera = ht.load_hexapod("rubin-camera")
    assert "not active" in repr(camera)
    for call in (
        lambda: camera.corrected_leg_lengths(camera.home, [20.0] * 6),
        lambda: camera.predicted_pose(camera.inverse_kinematics(camera.home), [20.0] * 6),
        lambda: camera.corrected_pose(camera.home, {}),
    ):
        with pytest.raises(ThermalModelError, match="not active"):
            call()


@pytest.mark.parametrize(
    ("pose", "temps", "word"),
    [
        (np.eye(4), np.full(5, 20.0), r"expected \(\.\.\., 6\)"),
        (np.eye(4), 20.0, r"expected \(\.\.\., 6\)"),
        (np.eye(4), "warm", "real numbers"),
        (np.eye(4), None, "real numbers"),
        (np.eye(3), np.full(6, 20.0), "shape"),
        (np.eye(4) * np.nan, np.full(6, 20.0), "nan"),
        (None, np.full(6, 20.0), "real numbers"),
        (ht.pose_from_coordinates([5, 0, 12, 0, 1.5, 0]) * [[1, 1, 1, 1e3]] * 1.0, np.full(6, 20.0), "last row"),
    ],
)
def test_bad_arguments_are_named(reference: ht.Hexapod, pose: object, temps: object, word: str) -> None:
    """Wrong shapes and types are refused with what was expected."""
    with pytest.raises(HexathermalError, match=word):
        reference.corrected_leg_lengths(pose, temps)  # type: ignore[arg-type]


def test_poses_out_of_stroke_and_in_millimetres_are_refused(reference: ht.Hexapod) -> None:
    """A pose beyond the stroke names the leg; one given in millimetres is refused as such."""
    with pytest.raises(OutOfStrokeError, match=r"leg \d out of stroke") as caught:
        reference.corrected_leg_lengths(ht.pose_from_coordinates([0, 0, 150, 0, 0, 0]), np.full(6, 20.0))
    assert caught.value.value > caught.value.upper
    wrong = np.eye(4)
    wrong[:3, 3] = [5, 0, 120]
    with pytest.raises(HexathermalError, match="millimetres"):
        reference.corrected_leg_lengths(wrong, np.full(6, 20.0))


def test_inputs_are_not_written_to(reference: ht.Hexapod) -> None:
    """Read-only poses and temperatures work, and writable ones come back unchanged."""
    pose, temps = ht.pose_from_coordinates([5, 0, 12, 0, 1.5, 0]), np.full(6, 25.0)
    before = pose.copy(), temps.copy()
    writable = reference.corrected_leg_lengths(pose, temps)
    assert np.array_equal(pose, before[0])
    assert np.array_equal(temps, before[1])
    pose.setflags(write=False)
    temps.setflags(write=False)
    assert np.array_equal(reference.corrected_leg_lengths(pose, temps), writable)
