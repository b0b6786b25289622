"""Margins to every limit: against independent formulas, Pinocchio, and the forward solver's own refusals."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import numpy.typing as npt
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import hexathermal as ht
from hexathermal.errors import ArgumentError, JointConeError
from hexathermal.kinematics.jacobian import condition_number
from hexathermal.kinematics.lean import lean_angles
from hexathermal.kinematics.limit_functions import limit_functions
from hexathermal.kinematics.limits import Limit, margins, standing
from hexathermal.machine.pinocchio_model import PinocchioMachine

F64 = npt.NDArray[np.float64]

TRAVEL = ht.PoseLimits(
    (-0.05, 0.06), (-0.07, 0.04), (-0.05, 0.08), (-0.2, 0.3), (-0.25, 0.2), (-0.3, 0.35), "fixed-zyx"
)
REFERENCE = ht.load_hexapod("reference")
TURNED = replace(
    REFERENCE,
    home=ht.pose_from_coordinates([10, 20, 5, 5, -8, 12]),
    base_cone=np.radians([14, 15, 16, 17, 18, 19]),
    platform_cone=np.radians(20.0),
    limits=TRAVEL,
)
"""A machine with every kind of limit and a home that is turned."""


def poses_near_home(hexapod: ht.Hexapod, count: int, seed: int, mm: float = 40.0, deg: float = 6.0) -> F64:
    random = np.random.default_rng(seed)
    return ht.pose_from_coordinates(random.normal(size=(count, 6)) * ([mm] * 3 + [deg] * 3), hexapod=hexapod)


def legs_at(hexapod: ht.Hexapod, T: F64) -> F64:
    return np.asarray(T[:3, :3] @ hexapod.platform_joints.T + T[:3, 3:] - hexapod.base_joints.T).T


def lean_of(home: F64, now: F64) -> F64:
    cosine = (home * now).sum(axis=1) / np.linalg.norm(home, axis=1) / np.linalg.norm(now, axis=1)
    return np.asarray(np.arccos(np.clip(cosine, -1.0, 1.0)))


@pytest.mark.parametrize(
    "machine", [REFERENCE, TURNED, ht.load_hexapod("rubin-camera")], ids=["ref", "turned", "rubin"]
)
def test_margins_are_those_of_written_out_formulas(machine: ht.Hexapod) -> None:
    """Stroke, cones and travel agree to 1e-12 m and 1e-7 rad (arccos) with formulas written out for one pose."""
    poses = poses_near_home(machine, 40, seed=1)
    found = margins(machine, poses)
    shortest, longest = machine.length_limits
    for k, T in enumerate(poses):
        legs, home = legs_at(machine, T), legs_at(machine, machine.home)
        L = np.linalg.norm(legs, axis=1)
        assert np.abs(found.stroke[k] - np.minimum(L - shortest, longest - L)).max() < 1e-12
        if machine.base_cone is not None and machine.platform_cone is not None:
            assert np.abs(found.base_cone[k] - machine.base_cone + lean_of(home, legs)).max() < 1e-7
            seen = lean_of(home @ machine.home[:3, :3], legs @ T[:3, :3])
            assert np.abs(found.platform_cone[k] - machine.platform_cone + seen).max() < 1e-7
        else:
            assert np.isinf(found.base_cone[k]).all()
            assert np.isinf(found.platform_cone[k]).all()
        if machine.limits is None:
            assert np.isinf(found.limits[k]).all()
            continue
        six = ht.coordinates_from_pose(T, "fixed-zyx", machine)
        x = np.concatenate([six[:3] / 1e3, np.radians(six[3:])])
        pairs = np.array([getattr(machine.limits, name) for name in ("x", "y", "z", "rx", "ry", "rz")])
        assert np.abs(found.limits[k] - np.minimum(x - pairs[:, 0], pairs[:, 1] - x)).max() < 1e-12


@pytest.mark.parametrize("machine", [REFERENCE, TURNED], ids=["ref", "turned"])
def test_margins_agree_with_pinocchio(machine: ht.Hexapod) -> None:
    """Stroke, cones and distances of the legs are those of the closed-loop Pinocchio model, to 1e-9 m and rad."""
    oracle = PinocchioMachine(machine)
    poses = poses_near_home(machine, 25, seed=2)
    found = margins(machine, poses, collisions=True)
    for k, T in enumerate(poses):
        other = oracle.margins(T)
        assert np.abs(found.stroke[k] - other.stroke.min(axis=1)).max() < 1e-9
        assert np.abs(found.base_cone[k] - other.base_cone).max() < 1e-9
        assert np.abs(found.platform_cone[k] - other.platform_cone).max() < 1e-9
        assert found.clearance[k] == pytest.approx(other.clearance.smallest, abs=1e-12)
        assert tuple(found.clearance_legs[k]) == other.clearance.legs


def test_margins_and_the_forward_solver_refuse_the_same_poses() -> None:
    """Of 3000 poses inside the travel, exactly those are called reachable that the forward solver accepts."""
    machine = replace(TURNED, limits=None)
    poses = poses_near_home(machine, 3000, seed=3)
    found = margins(machine, poses)
    solved = machine.solve_forward(machine.inverse_kinematics(poses), guess=poses)
    assert 0.05 < found.reachable.mean() < 0.95
    assert np.array_equal(found.reachable, solved.ok)


def test_refusal_of_a_cone_names_the_leg_and_angle_of_lean_angles() -> None:
    """The error of a leg that leans too far carries what `lean_angles` gives."""
    machine = replace(REFERENCE, base_cone=np.radians(3.0), platform_cone=None)
    pose = ht.pose_from_coordinates([60, 20, 0, 0, 0, 0], hexapod=machine)
    with pytest.raises(JointConeError) as caught:
        machine.forward_kinematics(machine.inverse_kinematics(pose))
    base, _platform = lean_angles(machine, pose)
    assert caught.value.leg == int(base.argmax()) + 1
    assert caught.value.value == pytest.approx(base.max(), abs=1e-9)


def test_lean_angles_of_a_batch_are_those_of_its_poses() -> None:
    """Any leading shape: the same numbers as one by one; at home all are 0; near 0 nothing is lost."""
    poses = poses_near_home(TURNED, 12, seed=4).reshape(3, 4, 4, 4)
    for side in (0, 1):
        every = lean_angles(TURNED, poses)[side]
        assert every.shape == (3, 4, 6)
        for i in range(3):
            for j in range(4):
                assert np.abs(every[i, j] - lean_angles(TURNED, poses[i, j])[side]).max() < 1e-14
    assert np.abs(lean_angles(TURNED, TURNED.home)).max() < 1e-15
    tiny = ht.pose_from_coordinates([1e-9, 0, 0, 0, 0, 0], hexapod=REFERENCE)
    units = legs_at(REFERENCE, REFERENCE.home)
    across = np.linalg.norm(np.cross(units, [1e-12, 0, 0]), axis=1) / (units**2).sum(axis=1)
    assert np.abs(lean_angles(REFERENCE, tiny)[0] - across).max() < 1e-6 * across.max() + 1e-16


def test_leading_shapes_and_se3() -> None:
    """Every array has the poses' leading shape and cannot be written; a single pose gives plain values."""
    poses = poses_near_home(TURNED, 6, seed=5).reshape(2, 3, 4, 4)
    found, alone = margins(TURNED, poses, collisions=True), margins(TURNED, pin.SE3(poses[1, 2]), collisions=True)
    for item in fields(found):
        every, one = getattr(found, item.name), getattr(alone, item.name)
        assert every.shape == (2, 3, *np.shape(one))
        assert np.array_equal(every[1, 2], one) or np.abs(every[1, 2] - one).max() < 1e-12
        with pytest.raises(ValueError, match="read-only"):
            every[0, 0] = 0
    kinds = (alone.worst, alone.reachable, alone.share, alone.side, alone.worst_leg)
    assert [type(value) for value in kinds] == [Limit, bool, float, int, int]
    assert margins(TURNED, np.empty((0, 4, 4)), collisions=True).stroke.shape == (0, 6)


def test_condition_number_is_the_one_of_the_kinematics() -> None:
    """Margins and `condition_number` name the same number, to 1e-12 of it."""
    poses = poses_near_home(TURNED, 20, seed=6)
    assert margins(TURNED, poses).condition_number == pytest.approx(condition_number(TURNED, poses), rel=1e-12)


@pytest.mark.parametrize(
    ("coordinates", "limit", "machine"),
    [
        ([0, 0, 140, 0, 0, 0], Limit.STROKE, REFERENCE),
        ([65, 0, 0, 0, 0, 0], Limit.TRAVEL, replace(TURNED, base_cone=None, platform_cone=None)),
        ([0, 0, 0, 0, 0, 12], Limit.PLATFORM_CONE, replace(REFERENCE, platform_cone=np.radians(6.0))),
        ([80, 0, 0, 0, 0, 0], Limit.BASE_CONE, replace(REFERENCE, base_cone=np.radians(4.0))),
        ([0, 0, 0, 0, 0, 100], Limit.SINGULAR, replace(REFERENCE, stroke=None, base_cone=None, platform_cone=None)),
    ],
)
def test_the_limit_that_is_broken_is_the_worst(coordinates: list[float], limit: Limit, machine: ht.Hexapod) -> None:
    """A pose beyond one limit is not reachable, and `worst` names that limit with a negative share."""
    found = margins(machine, ht.pose_from_coordinates(coordinates, hexapod=machine))
    assert not found.reachable
    assert found.worst is limit
    assert found.share < 0.0
    assert (found.worst_leg > 0) == (limit not in (Limit.TRAVEL, Limit.SINGULAR))
    assert margins(machine, machine.home).reachable


def test_thick_legs_collide() -> None:
    """Legs of 400 mm touch at home: not reachable once distances are asked for, and the legs are named."""
    bodies = ht.Bodies(0.4, 0.3)
    machine = replace(REFERENCE, bodies=bodies)
    assert margins(machine, machine.home).reachable
    found = margins(machine, machine.home, collisions=True)
    assert found.clearance < 0.0
    assert not found.reachable
    assert found.worst is Limit.COLLISION
    assert found.worst_leg == found.clearance_legs[0] != found.clearance_legs[1]


def test_a_pose_on_its_limit_is_reachable() -> None:
    """A leg at the very end of its stroke, and a platform at the end of its travel, count as inside."""
    lengths = REFERENCE.inverse_kinematics(poses_near_home(REFERENCE, 200, seed=7, mm=10))
    lengths[np.arange(200), np.arange(200) % 6] = REFERENCE.length_limits[1][0]
    lengths = np.clip(lengths, *REFERENCE.length_limits)
    solved = REFERENCE.solve_forward(lengths)
    assert margins(REFERENCE, solved.pose[solved.ok]).reachable.all()
    assert solved.ok.sum() > 100
    wide = replace(TURNED, stroke=[-0.3, 0.6], base_cone=None, platform_cone=None)
    corner = [60, -70, 80, *np.degrees([0.3, -0.25, 0.35])]
    assert margins(wide, ht.pose_from_coordinates(corner, "fixed-zyx", wide)).reachable


def test_a_leg_without_length_is_an_answer_not_an_error() -> None:
    """Where a base joint and its platform joint coincide the pose is singular, out of stroke, and not reachable."""
    T = np.eye(4)
    T[:3, 3] = REFERENCE.base_joints[2] - REFERENCE.platform_joints[2]
    found = margins(REFERENCE, np.stack([T, REFERENCE.home]), collisions=True)
    assert found.reachable.tolist() == [False, True]
    assert np.isinf(found.condition_number[0])
    assert found.side.tolist() == [0, 1]
    assert found.stroke[0, 2] == pytest.approx(-REFERENCE.length_limits[0][2], abs=1e-12)
    assert np.isnan(found.clearance[0])
    assert np.isneginf(found.base_cone[0]).all()


rotations = st.lists(st.floats(-180, 180), min_size=3, max_size=3)
shifts = st.lists(st.floats(-5000, 5000), min_size=3, max_size=3)


@settings(max_examples=25, deadline=None)
@given(shifts, rotations, shifts, rotations, st.integers(0, 2**31))
def test_moving_both_frames_changes_no_margin(
    base: list[float], turn: list[float], platform: list[float], tilt: list[float], seed: int
) -> None:
    """Base and platform frames placed elsewhere on their bodies: the same legs, cones and conditioning, to 1e-9."""
    T_new_base = ht.pose_from_coordinates([*base, *turn])
    T_new_platform = ht.pose_from_coordinates([*platform, *tilt])
    T_platform_new = np.linalg.inv(T_new_platform)
    machine = replace(TURNED, limits=None)

    def placed(T: F64, points: F64) -> F64:
        return np.asarray(points @ T[:3, :3].T + T[:3, 3])

    home = T_new_base @ machine.home @ T_platform_new
    home[:3, :3] = np.linalg.qr(home[:3, :3])[0] * np.sign(np.diag(np.linalg.qr(home[:3, :3])[1]))
    moved = replace(
        machine,
        base_joints=placed(T_new_base, machine.base_joints),
        platform_joints=placed(T_new_platform, machine.platform_joints),
        home=home,
    )
    poses = poses_near_home(machine, 8, seed)
    here, there = margins(machine, poses), margins(moved, T_new_base @ poses @ T_platform_new)
    for name in ("stroke", "base_cone", "platform_cone"):
        assert np.abs(getattr(here, name) - getattr(there, name)).max() < 1e-9
    assert np.array_equal(here.side, there.side)
    assert here.condition_number == pytest.approx(there.condition_number, rel=1e-9)


def test_limit_functions_are_the_margins_in_metres() -> None:
    """``f`` is the stroke's margin, and ``L (cos(lean) - cos(cone))`` for the cones; signs agree everywhere."""
    poses = poses_near_home(TURNED, 200, seed=8)
    functions = limit_functions(TURNED)
    now = standing(TURNED, poses)
    values, found = functions.values(now), margins(TURNED, poses)
    assert values.shape == (200, 24)
    assert np.abs(np.minimum(values[:, :6], values[:, 6:12]) - found.stroke).max() < 1e-14
    for first, cone, margin in (
        (12, TURNED.base_cone, found.base_cone),
        (18, TURNED.platform_cone, found.platform_cone),
    ):
        expected = now.lengths * (np.cos(np.asarray(cone) - margin) - np.cos(np.asarray(cone)))
        assert np.abs(values[:, first : first + 6] - expected).max() < 1e-12
    assert limit_functions(replace(TURNED, stroke=None, base_cone=None, platform_cone=None)).values(now).shape == (
        200,
        0,
    )


def test_unusable_poses_are_refused() -> None:
    """A wrong shape and millimetres raise `ArgumentError`, as in the inverse kinematics."""
    with pytest.raises(ArgumentError, match="shape"):
        margins(REFERENCE, np.eye(3))
    far = np.eye(4)
    far[2, 3] = 663.3e2
    with pytest.raises(ArgumentError, match="millimetres"):
        margins(REFERENCE, np.stack([REFERENCE.home, far]))
