"""The Pinocchio machine: its loops close, it agrees with geometry worked out here, and forces balance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings

from hexathermal.errors import (
    ArgumentError,
    JointConeError,
    KinematicsError,
    NotConvergedError,
    OtherBranchError,
    SingularPoseError,
)
from hexathermal.machine.pinocchio_model import PinocchioMachine
from tests.machine.mechanisms import (
    CLOSURE_M,
    F64,
    JACOBIAN,
    LENGTH_M,
    POSE,
    G,
    directions_at,
    general,
    joints_at,
    lengths_at,
    moved,
    plain,
    poses,
    triples,
)

# --- the mechanism ---------------------------------------------------------------------------------------------------


def test_neutral_is_home(machine: PinocchioMachine) -> None:
    """Pinocchio's neutral configuration is home, and there all joint angles are 0."""
    q_pin = machine.configuration(machine.hexapod.home)
    assert np.abs(q_pin - pin.neutral(machine.model)).max() < 1e-14
    angles = machine.joint_angles(machine.hexapod.home)
    for name in ("universal", "travel", "spherical", "base_cone", "platform_cone"):
        assert np.abs(getattr(angles, name)).max() < 1e-14, name


def test_loops_close(machine: PinocchioMachine) -> None:
    """At 200 poses Pinocchio's forward kinematics of each leg ends at its platform joint within 1e-13 m."""
    data = machine.model.createData()
    for pose in poses(machine.hexapod, 200):
        pin.forwardKinematics(machine.model, data, machine.configuration(pose))
        ends = [data.oMi[machine.model.getJointId(f"leg{i + 1}_spherical")].translation for i in range(6)]
        assert np.linalg.norm(ends - joints_at(machine.hexapod, pose), axis=1).max() <= CLOSURE_M
        assert np.abs(data.oMi[machine.model.getJointId("platform")].homogeneous - pose).max() <= CLOSURE_M


def test_mechanism_moves_with_six_freedoms(machine: PinocchioMachine) -> None:
    """42 joint velocities less 36 independent closures leave six, which the six lengths take."""
    data, found = machine.model.createData(), pin.StdVec_RigidConstraintData()
    for closure in machine.closures:
        found.append(closure.createData())
    pin.computeJointJacobians(machine.model, data, machine.configuration(poses(machine.hexapod, 1)[0]))
    for closure, place in zip(machine.closures, found, strict=True):
        closure.calc(machine.model, data, place)
    jacobian = pin.getConstraintsJacobian(machine.model, data, machine.closures, found)
    travel = np.eye(42)[[6 * leg + 2 for leg in range(6)]]
    assert np.linalg.matrix_rank(jacobian) == 36
    assert np.linalg.matrix_rank(np.vstack([jacobian, travel])) == 42


def test_lengths_are_distances_of_joints(machine: PinocchioMachine) -> None:
    """The prismatic joints give |t + R p - b| within 1e-12 m at 200 poses."""
    for pose in poses(machine.hexapod, 200):
        assert np.abs(machine.leg_lengths(pose) - lengths_at(machine.hexapod, pose)).max() <= LENGTH_M


def test_forward_inverts_lengths(machine: PinocchioMachine) -> None:
    """Forward finds the pose whose lengths it was given, from home, within 1e-11, at 60 poses."""
    for pose in poses(machine.hexapod, 60):
        assert np.abs(machine.forward(lengths_at(machine.hexapod, pose)) - pose).max() <= POSE


def test_forward_follows_its_guess() -> None:
    """Above and below the base are two postures with the same legs: the guess chooses."""
    machine = PinocchioMachine(replace(plain(), stroke=None))
    above = moved(machine.hexapod, [0.02, 0.0, 0.01], [0.0, 0.0, 0.1])
    below = above.copy()
    below[2, 3] *= -1.0
    lengths = lengths_at(machine.hexapod, above)
    near = below.copy()
    near[:3, 3] += [0.01, -0.01, 0.02]
    assert np.abs(machine.forward(lengths) - above).max() <= POSE
    assert np.abs(machine.forward(lengths, guess=near) - below).max() <= POSE
    assert np.abs(machine.forward(lengths, guess=pin.SE3(near)) - below).max() <= POSE


def test_forward_answers_on_the_branch_of_home_or_not_at_all() -> None:
    """Far from home, forward gives a pose with these lengths and home's sign of det J, or raises which it is not."""
    hexapod, random = general(), np.random.default_rng(4)
    machine, refused, found = PinocchioMachine(hexapod), set(), 0
    side = np.sign(np.linalg.det(machine.jacobian(hexapod.home)))
    for _ in range(60):
        pose = moved(hexapod, random.uniform(-0.25, 0.25, 3), random.uniform(-1.5, 1.5, 3))
        try:
            answer = machine.forward(lengths_at(hexapod, pose))
        except (NotConvergedError, OtherBranchError, SingularPoseError) as error:
            refused.add(type(error))
            continue
        found += 1
        assert np.abs(lengths_at(hexapod, answer) - lengths_at(hexapod, pose)).max() <= LENGTH_M
        assert np.sign(np.linalg.det(machine.jacobian(answer))) == side
    assert {NotConvergedError, OtherBranchError} <= refused
    assert found >= 45


def test_jacobian_is_the_slope_of_lengths(machine: PinocchioMachine) -> None:
    """dL/dx agrees with central differences of |t + R p - b| within 1e-7, twist in base axes."""
    h = 1e-5
    for pose in poses(machine.hexapod, 40):
        slopes = np.zeros((6, 6))
        for k in range(6):
            for sign in (-1.0, 1.0):
                near, step = pose.copy(), sign * h * np.eye(6)[k]
                near[:3, 3] += step[:3]
                near[:3, :3] = pin.exp3(step[3:]) @ pose[:3, :3]
                slopes[:, k] += sign * lengths_at(machine.hexapod, near) / (2.0 * h)
        assert np.abs(machine.jacobian(pose) - slopes).max() <= JACOBIAN


def test_jacobian_rows_are_leg_lines(machine: PinocchioMachine) -> None:
    """The row of a leg is [u, (R p) x u] within 1e-12."""
    for pose in poses(machine.hexapod, 20):
        u = directions_at(machine.hexapod, pose)
        rows = np.hstack([u, np.cross(machine.hexapod.platform_joints @ pose[:3, :3].T, u)])
        assert np.abs(machine.jacobian(pose) - rows).max() <= 1e-12


def test_compiled_kinematics_agree(machine: PinocchioMachine) -> None:
    """The compiled formulas, which share no code with the mechanism, agree: lengths and Jacobian 1e-12, pose 1e-11."""
    hexapod = replace(machine.hexapod, stroke=None, base_cone=None, platform_cone=None)
    for pose in poses(hexapod, 50, seed=11):
        lengths = hexapod.inverse_kinematics(pose)
        assert np.abs(machine.leg_lengths(pose) - lengths).max() <= LENGTH_M
        assert np.abs(machine.jacobian(pose) - hexapod.jacobian(pose)).max() <= 1e-12
        assert np.abs(machine.forward(lengths) - hexapod.forward_kinematics(lengths)).max() <= POSE


@settings(max_examples=15, deadline=None)
@given(shift=triples, turn=triples, pose_shift=triples, pose_turn=triples)
def test_moving_the_base_frame_changes_nothing(shift: F64, turn: F64, pose_shift: F64, pose_turn: F64) -> None:
    """Lengths, angles of the cones, distances and forces do not depend on where the base frame stands."""
    hexapod = plain()
    T_world_base = pin.SE3(pin.exp3(turn), shift)
    joints = np.array([T_world_base.act(joint) for joint in hexapod.base_joints])
    pose = moved(hexapod, 0.05 * pose_shift, 0.2 * pose_turn)
    here = PinocchioMachine(hexapod, payload_mass=10.0)
    gravity = T_world_base.rotation @ [0.0, 0.0, -G]
    home = T_world_base.homogeneous @ hexapod.home
    there = PinocchioMachine(replace(hexapod, base_joints=joints, home=home), payload_mass=10.0, gravity=gravity)
    seen = T_world_base.homogeneous @ pose
    assert np.allclose(there.leg_lengths(seen), here.leg_lengths(pose), rtol=0.0, atol=1e-13)
    assert np.allclose(there.leg_forces(seen), here.leg_forces(pose), rtol=0.0, atol=1e-8)
    assert np.allclose(there.distances(seen).between, here.distances(pose).between, rtol=0.0, atol=1e-9)
    for name in ("base_cone", "platform_cone"):
        far, near = getattr(there.joint_angles(seen), name), getattr(here.joint_angles(pose), name)
        assert np.allclose(far, near, rtol=0.0, atol=1e-12)


# --- joint angles and margins ----------------------------------------------------------------------------------------


def test_cones_are_angles_to_the_home_direction(machine: PinocchioMachine) -> None:
    """Cone angles are those between leg and home direction, seen from base and from platform, within 1e-12 rad."""
    hexapod = machine.hexapod
    at_home = directions_at(hexapod, hexapod.home)
    for pose in poses(hexapod, 30):
        u, angles = directions_at(hexapod, pose), machine.joint_angles(pose)
        seen_home, seen = at_home @ hexapod.home[:3, :3], u @ pose[:3, :3]
        for found, a, b in ((angles.base_cone, at_home, u), (angles.platform_cone, seen_home, seen)):
            wanted = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1))
            assert np.abs(found - wanted).max() <= 1e-12


def test_joint_angles_rebuild_the_platform(plain_machine: PinocchioMachine) -> None:
    """Universal turns, then the ball's rotation vector, turn home's rotation into the platform's."""
    home = plain_machine.hexapod.home
    for pose in poses(plain_machine.hexapod, 10):
        angles = plain_machine.joint_angles(pose)
        for leg in range(6):
            frame = plain_machine.model.jointPlacements[plain_machine.model.getJointId(f"leg{leg + 1}_universal")]
            first, second = angles.universal[leg]
            turns = pin.exp3(np.array([first, 0.0, 0.0])) @ pin.exp3(np.array([0.0, second, 0.0]))
            whole = frame.rotation @ turns @ pin.exp3(angles.spherical[leg]) @ frame.rotation.T @ home[:3, :3]
            assert np.abs(whole - pose[:3, :3]).max() <= 1e-12


def test_stroke_is_written_into_the_model(plain_machine: PinocchioMachine) -> None:
    """Pinocchio's limits of the prismatic joints are the stroke, counted from home; unbounded without one."""
    travel = [7 * leg + 2 for leg in range(6)]
    model, home = plain_machine.model, lengths_at(plain_machine.hexapod, plain_machine.hexapod.home)
    assert np.allclose(model.lowerPositionLimit[travel], 0.55 - home, rtol=0.0, atol=LENGTH_M)
    assert np.allclose(model.upperPositionLimit[travel], 0.80 - home, rtol=0.0, atol=LENGTH_M)
    assert np.isposinf(PinocchioMachine(general()).model.upperPositionLimit[travel]).all()


def test_margins_count_to_each_limit(plain_machine: PinocchioMachine) -> None:
    """Margins are limit less value; at home all are met, 0.2 m higher the stroke is not."""
    home, high = plain_machine.hexapod.home, moved(plain_machine.hexapod, [0.0, 0.0, 0.2], np.zeros(3))
    found, lengths = plain_machine.margins(home), lengths_at(plain_machine.hexapod, home)
    assert found.allowed
    assert np.allclose(found.stroke, np.column_stack([lengths - 0.55, 0.80 - lengths]), rtol=0.0, atol=LENGTH_M)
    assert np.allclose(found.base_cone, np.radians(25.0), rtol=0.0, atol=1e-12)
    assert np.allclose(found.platform_cone, np.radians(30.0), rtol=0.0, atol=1e-12)
    assert np.allclose(found.rod_overlap, 2.0 * 0.44 - lengths, rtol=0.0, atol=LENGTH_M)
    beyond = plain_machine.margins(high)
    assert beyond.stroke[:, 1].max() < 0.0
    assert not beyond.allowed
    assert not beyond.collision


def test_margins_without_limits_are_infinite() -> None:
    """A machine without stroke and cones has infinite margins there, never a made-up limit."""
    machine = PinocchioMachine(general())
    found = machine.margins(machine.hexapod.home)
    for margin in (found.stroke, found.base_cone, found.platform_cone):
        assert np.isposinf(margin).all()
    assert found.allowed


# --- what is refused -------------------------------------------------------------------------------------------------


def test_an_se3_is_a_pose(plain_machine: PinocchioMachine) -> None:
    """An SE3 and its 4 x 4 array give the same answers."""
    pose = poses(plain_machine.hexapod, 1)[0]
    for ask in (plain_machine.configuration, plain_machine.leg_lengths, plain_machine.leg_forces):
        assert np.array_equal(ask(pin.SE3(pose)), ask(pose))


def test_wrong_arguments_are_refused(plain_machine: PinocchioMachine) -> None:
    """Batches, wrong shapes, negative masses and things that are no Hexapod raise ArgumentError."""
    home = plain_machine.hexapod.home
    for pose in (np.stack([home, home]), np.eye(3), home.T, home * np.nan):
        with pytest.raises(ArgumentError):
            plain_machine.leg_lengths(pose)
    with pytest.raises(ArgumentError, match=r"expected \(6,\)"):
        plain_machine.forward(np.full((2, 6), 0.6))
    with pytest.raises(ArgumentError, match="Hexapod"):
        PinocchioMachine("reference")  # type: ignore[arg-type]
    for wrong in ({"payload_mass": -1.0}, {"payload_centre": [0.0, 0.0]}, {"gravity": [0.0, 0.0, np.inf]}):
        with pytest.raises(ArgumentError, match=next(iter(wrong))):
            PinocchioMachine(plain(), **wrong)


def test_poses_without_a_configuration_are_refused(plain_machine: PinocchioMachine) -> None:
    """A leg of no length, and a leg along its universal joint's first axis, are named in the error."""
    home, hexapod = plain_machine.hexapod.home, plain_machine.hexapod
    pose = home.copy()
    pose[:3, 3] = hexapod.base_joints[2] - home[:3, :3] @ hexapod.platform_joints[2]
    with pytest.raises(KinematicsError, match="length 0") as caught:
        plain_machine.leg_lengths(pose)
    assert caught.value.leg == 3
    frame = plain_machine.model.jointPlacements[plain_machine.model.getJointId("leg3_universal")]
    pose[:3, 3] += 0.6 * frame.rotation[:, 0]
    with pytest.raises(JointConeError, match="first axis") as caught:
        plain_machine.leg_lengths(pose)
    assert caught.value.leg == 3


def test_lengths_that_do_not_meet_are_refused(plain_machine: PinocchioMachine) -> None:
    """Legs that cannot meet raise NotConvergedError with what is missing; lengths of 0 m are named."""
    with pytest.raises(NotConvergedError, match="do not close") as caught:
        plain_machine.forward([2.0, 0.3, 0.6, 0.6, 0.6, 0.6])
    assert caught.value.value is not None
    assert caught.value.upper == CLOSURE_M
    assert caught.value.value > CLOSURE_M
    with pytest.raises(KinematicsError, match="strokes"):
        plain_machine.forward([0.6, 0.6, 0.0, 0.6, 0.6, 0.6])
