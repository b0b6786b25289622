"""Refusals: each error carries leg, value and limits, and says what is true."""

from __future__ import annotations

import dataclasses
import pickle

import numpy as np
import pytest

import hexathermal as ht
from hexathermal.errors import (
    ArgumentError,
    HexathermalError,
    JointConeError,
    NotConvergedError,
    OtherBranchError,
    SingularPoseError,
    TemperatureError,
    ThermalModelError,
)
from hexathermal.kinematics.lean import lean_angles
from tests.machines import general_machine, oracle_lengths


@pytest.fixture
def free(reference: ht.Hexapod) -> ht.Hexapod:
    """The reference machine without strokes, with a law."""
    law = ht.ThermalModel(ht.LegLaw("T", [2e-6], [1e-6]))
    return ht.Hexapod(reference.base_joints, reference.platform_joints, 0.5, home=reference.home, thermal=law)


def test_a_singular_pose_names_leg_condition_and_limit(free: ht.Hexapod) -> None:
    """SingularPoseError carries the condition number, its limit and the most dependent leg."""
    turned = ht.pose_from_coordinates([0, 0, 0, 0, 0, 89.9999999])
    with pytest.raises(SingularPoseError, match="condition number") as caught:
        free.forward_kinematics(free.inverse_kinematics(turned), guess=turned)
    assert caught.value.leg in range(1, 7)
    assert caught.value.value > caught.value.upper == 1e7
    result = free.solve_forward(free.inverse_kinematics(turned), guess=turned)
    assert (result.status, result.assembly_mode) == (ht.ForwardStatus.SINGULAR, 0)


def test_a_singular_guess_has_no_branch(free: ht.Hexapod) -> None:
    """From an exactly singular start the answer is singular, whatever the lengths: its sign would be noise."""
    start, near = (ht.pose_from_coordinates([0, 0, 0, 0, 0, turn]) for turn in (90.0, 85.0))
    assert free.solve_forward(free.inverse_kinematics(near), guess=start).status == ht.ForwardStatus.SINGULAR


def test_other_branch_carries_the_determinant(rng: np.random.Generator) -> None:
    """OtherBranchError carries the smallest det J on the way over the start's, at or below its limit 0, and a leg."""
    for _ in range(20):
        machine = general_machine(rng)
        lengths = machine.inverse_kinematics(machine.home) * rng.uniform(0.75, 1.25, (2000, 6))
        found = np.flatnonzero(machine.solve_forward(lengths).status == ht.ForwardStatus.OTHER_BRANCH)
        values = []
        for k in found[:9]:
            with pytest.raises(OtherBranchError, match="of the start's") as caught:
                machine.forward_kinematics(lengths[k])
            assert caught.value.leg in range(1, 7)
            assert caught.value.lower == 0.0
            assert (caught.value.value <= 0.0) == ("passes a singular pose" in str(caught.value))
            values.append(caught.value.value)
        if len(found):
            assert min(values) <= 0.0
            return
    pytest.fail("no machine had another branch")


def test_a_singular_start_is_told_by_its_own_condition(free: ht.Hexapod) -> None:
    """From a singular guess the error carries the guess's condition number, which is above the limit."""
    start, near = (ht.pose_from_coordinates([0, 0, 0, 0, 0, turn]) for turn in (90.0, 85.0))
    with pytest.raises(SingularPoseError) as caught:
        free.forward_kinematics(free.inverse_kinematics(near), guess=start)
    assert caught.value.value > caught.value.upper


def test_lengths_in_millimetres_are_not_called_singular(free: ht.Hexapod) -> None:
    """Lengths a thousand times too long, without strokes, are not reached: the start is no singular pose."""
    with pytest.raises(NotConvergedError):
        free.forward_kinematics(1000.0 * free.inverse_kinematics(free.home))


@pytest.mark.long
def test_the_default_start_and_home_as_a_guess_agree(rng: np.random.Generator) -> None:
    """The fast solver and the careful one from the same start give the same status and pose, far from home too."""
    differ = 0
    for _ in range(4):
        machine = general_machine(rng)
        poses = machine.home @ ht.pose_from_coordinates(rng.uniform(-1, 1, (3000, 6)) * [250, 250, 250, 40, 40, 40])
        lengths = machine.inverse_kinematics(poses)
        fast, careful = machine.solve_forward(lengths), machine.solve_forward(lengths, guess=machine.home)
        both = fast.ok & careful.ok
        assert both.sum() > 500
        assert np.abs(fast.pose - careful.pose)[both].max() < 1e-8
        differ += int((fast.status != careful.status).sum())
    assert differ <= 2, "of 12 000"


@pytest.mark.parametrize("plate_dT", [60.0, -60.0])
def test_cones_are_judged_between_warm_plates(reference: ht.Hexapod, plate_dT: float) -> None:
    """A cone that only the expansion of a plate breaks is reported with an angle above its limit."""
    pose = ht.pose_from_coordinates([60, 0, 0, 0, 0, 0])
    law = ht.ThermalModel(ht.LegLaw("T", [0.0], [0.0]), ht.PlateLaw(2.3e-5, "P"))
    wide = ht.Hexapod(reference.base_joints, reference.platform_joints, 0.6, [-0.3, 0.6], reference.home, law)
    temps, refused = [20.0] * 6 + [20.0 + plate_dT], 0
    for extra in (1e-5, 3e-5, 1e-4):
        narrow = dataclasses.replace(wide, base_cone=lean_angles(wide, pose)[0].max() + extra)
        for call in (
            lambda machine: machine.corrected_leg_lengths(pose, temps),
            lambda machine: machine.predicted_pose(machine.inverse_kinematics(pose), temps),
        ):
            try:
                call(narrow)
            except JointConeError as error:
                refused += 1
                assert error.value > error.upper
    assert refused or plate_dT > 0


def test_nothing_infinite_comes_out(free: ht.Hexapod) -> None:
    """Infinite and absurd poses are refused by every call, with and without strokes."""
    for x in (np.inf, 1e200, 1e3, np.nan):
        pose = np.array(free.home)
        pose[0, 3] = x
        for call in (
            free.inverse_kinematics,
            free.jacobian,
            lambda given: free.corrected_leg_lengths(given, [20.0] * 6),
            lambda given: free.corrected_leg_lengths(np.tile(given, (3, 1, 1)), [20.0] * 6),
            lambda given: free.forward_kinematics(np.full(6, 0.7), given),
        ):
            with pytest.raises(ArgumentError):
                call(pose)


def test_laws_that_could_swallow_a_leg_are_refused() -> None:
    """Coefficients and range that change a part by more than a fifth of itself are unusable."""
    with pytest.raises(ThermalModelError, match="leg 1"):
        ht.ThermalModel(ht.LegLaw("T", [0.0], [-1e-3]), valid_degC=(-100, 2000))


def test_masked_and_labelled_temperatures_are_read_by_what_they_say(reference: ht.Hexapod) -> None:
    """A masked reading is missing; a labelled table counts by its labels, not by its order."""
    masked = np.ma.masked_array([20.0] * 6, mask=[0, 1, 0, 0, 0, 0])
    with pytest.raises(TemperatureError, match="leg2_T1.*NaN"):
        reference.corrected_leg_lengths(reference.home, masked)

    class Table(dict):  # type: ignore[type-arg]
        """Keys and items, but no Mapping by registration."""

    values = {name: 20.0 + k for k, name in enumerate(reference.sensor_names)}
    want = reference.corrected_leg_lengths(reference.home, list(values.values()))
    backwards = Table(reversed(list(values.items())))
    assert np.array_equal(reference.corrected_leg_lengths(reference.home, backwards), want)


def test_unpickled_laws_and_frames_stay_read_only(reference: ht.Hexapod) -> None:
    """No array of a machine, its laws or frames can be written after pickling."""
    again = pickle.loads(pickle.dumps(reference))
    frames = pickle.loads(pickle.dumps(ht.Frames(user=[1, 2, 3, 4, 5, 6])))
    assert frames == ht.Frames(user=[1, 2, 3, 4, 5, 6])
    for array in (again.thermal.legs[0].A, again.thermal.reference_temperature_degC, again.home):
        assert not array.flags.writeable


def test_machines_far_from_their_frames_are_solved(reference: ht.Hexapod, rng: np.random.Generator) -> None:
    """Both frames 100 m off: every pose comes back to what rounding of such coordinates allows, 1e-12 m."""
    away = np.array([100.0, -70.0, 30.0])
    machine = ht.Hexapod(reference.base_joints + away, reference.platform_joints, home=away)
    poses = machine.home @ ht.pose_from_coordinates(rng.uniform(-1, 1, (300, 6)) * [50, 50, 50, 10, 10, 10])
    found = machine.solve_forward(machine.inverse_kinematics(poses))
    assert found.ok.all()
    assert np.abs(found.pose - poses).max() < 1e-12
    assert np.abs(oracle_lengths(machine, found.pose) - machine.inverse_kinematics(poses)).max() < 1e-12


@pytest.mark.long
def test_home_exactly_at_a_limit_is_allowed(rng: np.random.Generator) -> None:
    """A stroke that begins at home's own lengths is a machine, also with a far pivot."""
    for pivot in (0.0, 10.0):
        for _ in range(40):
            free = general_machine(rng, pivot)
            lengths = free.inverse_kinematics(free.home)
            stroke = np.stack([lengths - 0.3, np.full(6, 1.0)], axis=1)
            machine = dataclasses.replace(free, retracted_length=0.3, stroke=stroke)
            assert np.abs(machine.forward_kinematics(lengths) - free.home).max() < 1e-12 * (1 + pivot)


@pytest.mark.parametrize(
    "call",
    [
        lambda: ht.pose_from_coordinates([0] * 6, ["x"]),  # type: ignore[arg-type]
        lambda: ht.Frames(convention=[]),  # type: ignore[arg-type]
        lambda: ht.ThermalModel(ht.LegLaw("T", [1e-6], [1e-6]), valid_degC=np.array([[0, 1], [2, 3.0]])),
        lambda: ht.ThermalModel(ht.LegLaw(["T1", "leg1_T1"], [1e-6, 2e-6], [0, 0])),
        lambda: ht.Hexapod(np.eye(6)[:, :3] * 1e200, np.ones((6, 3))),
    ],
)
def test_odd_arguments_are_refused(call: object) -> None:
    """Unhashable names, nested ranges, double sensors and absurd joints are ArgumentErrors."""
    with pytest.raises(HexathermalError):
        call()  # type: ignore[operator]
