"""The Pinocchio machine: its loops close, it agrees with geometry worked out here, and forces balance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from hexathermal.errors import (
    ArgumentError,
    JointConeError,
    KinematicsError,
    NotConvergedError,
    OtherBranchError,
    SingularPoseError,
)
from hexathermal.machine.bodies import Bodies
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.pinocchio_collisions import hinged_pairs
from hexathermal.machine.pinocchio_loads import default_bodies, section_lengths
from hexathermal.machine.pinocchio_model import PinocchioMachine

F64 = npt.NDArray[np.float64]

CLOSURE_M = 1e-13
LENGTH_M = 1e-12
POSE = 1e-11
"""Largest error of any entry of a pose, metres or rotation."""
JACOBIAN = 1e-7
FORCE_N = 1e-9
G = 9.80665
HEAVY = Bodies(0.06, 0.04, leg_body_mass=7.0, leg_rod_mass=3.0, platform_mass=40.0, platform_thickness=0.02)
LIGHT = Bodies(0.06, 0.04, platform_mass=40.0, platform_thickness=0.02)


def ring(radius: float, half_deg: float) -> F64:
    """Return six joints in three pairs on a circle about the origin."""
    angles = np.radians([120.0 * k + side * half_deg for k in range(3) for side in (-1.0, 1.0)])
    return np.column_stack([radius * np.cos(angles), radius * np.sin(angles), np.zeros(6)])


def plain() -> Hexapod:
    """Return the usual machine: joints on two circles, legs 0.55 to 0.80 m, 0.63 m at home."""
    return Hexapod(
        ring(0.35, 15.0),
        ring(0.25, 45.0),
        retracted_length=np.array(0.55),
        stroke=np.array([0.0, 0.25]),
        home=np.array([0.0, 0.0, 0.6]),
        base_cone=np.radians(np.full(6, 25.0)),
        platform_cone=np.radians(np.full(6, 30.0)),
        bodies=HEAVY,
    )


def general() -> Hexapod:
    """Return a machine without any symmetry: joints in space, home turned, no stroke, no bodies."""
    random = np.random.default_rng(20240611)
    home = pin.SE3(pin.exp3(np.array([0.3, -0.2, 0.5])), np.array([0.1, -0.2, 0.9])).homogeneous
    spread = 0.1
    base = ring(0.5, 20.0) + random.uniform(-spread, spread, (6, 3)) + [0.3, 0.1, -0.2]
    platform = ring(0.3, 38.0) + random.uniform(-spread, spread, (6, 3)) + [0.05, 0.1, 0.15]
    return Hexapod(base, platform, home=home)


def far_pivot() -> Hexapod:
    """Return the usual machine, its platform frame at a point of interest 5 m above the joints."""
    shift = np.array([0.2, -0.3, 5.0])
    return replace(plain(), platform_joints=ring(0.25, 45.0) - shift, home=shift + np.array([0.0, 0.0, 0.6]))


MACHINES = {"plain": plain, "general": general, "far pivot": far_pivot}


@pytest.fixture(params=MACHINES, scope="module")
def machine(request: pytest.FixtureRequest) -> PinocchioMachine:
    return PinocchioMachine(MACHINES[request.param]())


@pytest.fixture(scope="module")
def plain_machine() -> PinocchioMachine:
    return PinocchioMachine(plain(), payload_mass=25.0, payload_centre=[0.05, -0.02, 0.15])


def moved(hexapod: Hexapod, shift: npt.ArrayLike, turn: npt.ArrayLike) -> F64:
    """Return home, its platform joints turned about their centroid and shifted [m, rad]."""
    centre = pin.SE3(np.eye(3), hexapod.platform_joints.mean(axis=0))
    motion = pin.SE3(pin.exp3(np.asarray(turn, dtype=float)), np.asarray(shift, dtype=float))
    return np.array((pin.SE3(hexapod.home) * centre * motion * centre.inverse()).homogeneous)


def poses(hexapod: Hexapod, count: int, seed: int = 7) -> list[F64]:
    """Return poses within 80 mm and 0.3 rad of home, along and about each axis."""
    random = np.random.default_rng(seed)
    spread = zip(random.uniform(-0.08, 0.08, (count, 3)), random.uniform(-0.3, 0.3, (count, 3)), strict=True)
    return [moved(hexapod, shift, turn) for shift, turn in spread]


def joints_at(hexapod: Hexapod, pose: F64) -> F64:
    return np.asarray(hexapod.platform_joints @ pose[:3, :3].T + pose[:3, 3])


def lengths_at(hexapod: Hexapod, pose: F64) -> F64:
    return np.asarray(np.linalg.norm(joints_at(hexapod, pose) - hexapod.base_joints, axis=1))


def directions_at(hexapod: Hexapod, pose: F64) -> F64:
    legs = joints_at(hexapod, pose) - hexapod.base_joints
    return np.asarray(legs / np.linalg.norm(legs, axis=1, keepdims=True))


def segment_distance(a: F64, b: F64) -> float:
    """Return the distance of two segments, each (2, 3), as a least-squares problem with bounds."""
    matrix = np.column_stack([a[1] - a[0], b[0] - b[1]])
    found = lsq_linear(matrix, b[0] - a[0], bounds=(0.0, 1.0), method="bvls")
    return float(np.linalg.norm(matrix @ found.x - (b[0] - a[0])))


small = st.floats(-1.0, 1.0, allow_subnormal=False)
triples = st.tuples(small, small, small).map(np.array)


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


# --- distances -------------------------------------------------------------------------------------------------------


def capsules_at(machine: PinocchioMachine, pose: F64) -> list[tuple[F64, float]]:
    """Return axis (2, 3) and radius of body and rod of each leg, as `capsule_ends` states them."""
    hexapod, shapes, found = machine.hexapod, machine.shapes, []
    bodies = shapes.bodies
    for leg, (u, end) in enumerate(zip(directions_at(hexapod, pose), joints_at(hexapod, pose), strict=True)):
        gap = min(bodies.leg_body_diameter, shapes.body_lengths[leg] / 4.0)
        start = hexapod.base_joints[leg]
        found.append((np.array([start + gap * u, start + shapes.body_lengths[leg] * u]), bodies.leg_body_diameter / 2))
        gap = min(bodies.leg_rod_diameter, shapes.rod_shown[leg] / 4.0)
        found.append((np.array([end - shapes.rod_shown[leg] * u, end - gap * u]), bodies.leg_rod_diameter / 2))
    return found


def test_distances_are_segment_distances_less_radii(machine: PinocchioMachine) -> None:
    """The distance of two legs is the least of four segment distances less radii, worked out here, within 1e-9 m."""
    for pose in [*poses(machine.hexapod, 8), moved(machine.hexapod, np.zeros(3), [0.0, 0.0, 1.6])]:
        capsules, found = capsules_at(machine, pose), machine.distances(pose)
        for i in range(6):
            for j in range(i + 1, 6):
                pairs = [(capsules[2 * i + a], capsules[2 * j + b]) for a in (0, 1) for b in (0, 1)]
                least = min(segment_distance(a, b) - r - s for (a, r), (b, s) in pairs)
                assert abs(found.between[i, j] - least) <= 1e-9, (i, j)
        i, j = found.legs
        assert found.smallest == found.between.min() == found.between[i - 1, j - 1]
        assert abs(np.linalg.norm(found.points[0] - found.points[1]) - abs(found.smallest)) <= 1e-6


def test_legs_made_to_collide_are_reported(plain_machine: PinocchioMachine) -> None:
    """Lowered by 0.2 m and turned by 150 degrees about z bodies run through each other: it says so, and which."""
    pose = moved(plain_machine.hexapod, [0.0, 0.0, -0.2], [0.0, 0.0, np.radians(150.0)])
    found = plain_machine.distances(pose)
    assert found.collision
    assert plain_machine.margins(pose).collision
    assert not plain_machine.margins(pose).allowed
    assert not plain_machine.distances(plain_machine.hexapod.home).collision
    axes = [axis for axis, _ in capsules_at(plain_machine, pose)]
    i, j = (2 * (leg - 1) + ("body", "rod").index(part) for leg, part in zip(found.legs, found.parts, strict=True))
    assert found.parts == ("body", "body")
    assert segment_distance(axes[i], axes[j]) < 1e-6
    assert found.smallest == pytest.approx(-0.06, abs=1e-6)


def test_legs_on_one_joint_do_not_collide_there() -> None:
    """In a 3-3 machine legs share joints: these pairs are named, left out, and home is free of collisions."""
    hexapod = Hexapod(ring(0.4, 0.0), ring(0.4, 60.0), home=np.array([0.0, 0.0, 0.6]))
    machine = PinocchioMachine(hexapod)
    names = hinged_pairs(hexapod, machine.shapes)
    assert len(names) == 6
    assert sum("body" in pair[0] for pair in names) == 3
    assert machine.distances(hexapod.home).smallest > 0.0
    assert not any("_body" in a and "_body" in b for a, b in hinged_pairs(plain(), machine.shapes))


# --- loads -----------------------------------------------------------------------------------------------------------


def test_forces_of_light_legs_balance_the_wrench() -> None:
    """Without mass in the legs ``J^T f = -wrench`` of platform and payload at the platform's origin, within 1e-9 N."""
    hexapod, payload = replace(far_pivot(), bodies=LIGHT), np.array([0.1, -0.05, 0.3])
    machine = PinocchioMachine(hexapod, payload_mass=30.0, payload_centre=payload)
    plate = hexapod.platform_joints.mean(axis=0)
    for pose in poses(hexapod, 30):
        u, R = directions_at(hexapod, pose), pose[:3, :3]
        lines = np.hstack([u, np.cross(hexapod.platform_joints @ R.T, u)])
        weights = [(40.0, R @ plate), (30.0, R @ payload)]
        fall = np.array([0.0, 0.0, -G])
        wrench = sum(np.concatenate([m * fall, np.cross(arm, m * fall)]) for m, arm in weights)
        assert np.abs(lines.T @ machine.leg_forces(pose) + wrench).max() <= 5.0 * FORCE_N


def test_forces_of_heavy_legs_balance_each_free_body(plain_machine: PinocchioMachine) -> None:
    """Rods, whole legs and platform, cut free one by one, are in balance, within 1e-9 N and N m."""
    hexapod, bodies, fall = plain_machine.hexapod, HEAVY, np.array([0.0, 0.0, -G])
    for pose in poses(hexapod, 30):
        forces, u, ends = plain_machine.leg_forces(pose), directions_at(hexapod, pose), joints_at(hexapod, pose)
        lengths, R, t = lengths_at(hexapod, pose), pose[:3, :3], pose[:3, 3]
        body, rod = 0.5 * plain_machine.shapes.body_lengths, lengths - 0.5 * plain_machine.shapes.rod_lengths
        # Along the leg: the rod hands on the push less its weight. Across: moments of the leg about the base joint.
        along = (forces + bodies.leg_rod_mass * u @ fall)[:, None] * u
        lever = (bodies.leg_body_mass * body + bodies.leg_rod_mass * rod) / lengths
        across = lever[:, None] * (fall - (u @ fall)[:, None] * u)
        on_platform = along + across
        weights = [(bodies.platform_mass, t), (25.0, t + R @ [0.05, -0.02, 0.15])]
        force = on_platform.sum(axis=0) + sum(m * fall for m, _ in weights)
        moment = np.cross(ends, on_platform).sum(axis=0) + sum(np.cross(at, m * fall) for m, at in weights)
        assert np.abs(force).max() <= FORCE_N
        assert np.abs(moment).max() <= FORCE_N


def test_force_is_the_slope_of_energy(plain_machine: PinocchioMachine) -> None:
    """``f_i = + dV / dL_i``: to lengthen a leg by dL costs f dL, by central differences within 1e-4 N."""
    h = 1e-4
    for pose in poses(plain_machine.hexapod, 3):
        lengths, slopes = plain_machine.leg_lengths(pose), np.zeros(6)
        for leg in range(6):
            for sign in (-1.0, 1.0):
                there = plain_machine.forward(lengths + sign * h * np.eye(6)[leg], guess=pose)
                slopes[leg] += sign * plain_machine.potential_energy(there) / (2.0 * h)
        assert np.abs(plain_machine.leg_forces(pose) - slopes).max() <= 1e-4


def test_upright_legs_are_compressed_evenly(plain_machine: PinocchioMachine) -> None:
    """Loaded at its centre, a symmetric machine at home bears the load with six equal positive forces."""
    machine = PinocchioMachine(replace(plain(), bodies=LIGHT), payload_mass=20.0)
    rise = directions_at(machine.hexapod, machine.hexapod.home)[0, 2]
    assert np.allclose(machine.leg_forces(machine.hexapod.home), 60.0 * G / (6.0 * rise), rtol=1e-12)
    hanging = PinocchioMachine(replace(plain(), bodies=LIGHT), payload_mass=20.0, gravity=[0.0, 0.0, G])
    assert (hanging.leg_forces(machine.hexapod.home) < 0.0).all()


def test_forces_at_a_singular_pose_are_refused(plain_machine: PinocchioMachine) -> None:
    """Turned by 90 degrees about z this machine is singular, and no forces are given."""
    with pytest.raises(SingularPoseError, match="do not hold the platform"):
        plain_machine.leg_forces(moved(plain_machine.hexapod, np.zeros(3), [0.0, 0.0, np.pi / 2.0]))


def test_bodies_not_stated_are_steel_by_home_length() -> None:
    """Without bodies: diameter = home length / 12, rod 0.6 of it, and tube plus rod weigh as steel."""
    hexapod = replace(plain(), bodies=None)
    bodies, length = default_bodies(hexapod), section_lengths(hexapod)[0]
    assert bodies.leg_body_diameter == pytest.approx(lengths_at(hexapod, hexapod.home).mean() / 12.0)
    assert bodies.leg_rod_diameter == pytest.approx(0.6 * bodies.leg_body_diameter)
    full = 7850.0 * np.pi / 4.0 * bodies.leg_body_diameter**2 * length
    assert bodies.leg_body_mass + bodies.leg_rod_mass == pytest.approx(full)
    assert PinocchioMachine(hexapod).shapes.bodies == bodies


def test_masses_of_the_model_are_those_stated(plain_machine: PinocchioMachine) -> None:
    """The Pinocchio model weighs six bodies, six rods, platform and payload."""
    assert pin.computeTotalMass(plain_machine.model) == pytest.approx(6 * 7.0 + 6 * 3.0 + 40.0 + 25.0, rel=1e-14)


# --- drawing ---------------------------------------------------------------------------------------------------------


def test_drawing_meets_the_joints(plain_machine: PinocchioMachine) -> None:
    """Bodies start at base joints, rods end at platform joints, balls stand on both, all solids are closed."""
    pose = poses(plain_machine.hexapod, 1)[0]
    solids = {solid.name: solid for solid in plain_machine.geometry(pose)}
    assert len(solids) == 26
    assert all(solid.mesh.is_watertight for solid in solids.values())
    ends, half = joints_at(plain_machine.hexapod, pose), 0.22
    for leg in range(6):
        body, rod = solids[f"leg{leg + 1}_body"].pose, solids[f"leg{leg + 1}_rod"].pose
        base_ball, ball = solids[f"leg{leg + 1}_base_joint"].pose, solids[f"leg{leg + 1}_platform_joint"].pose
        assert np.allclose(body[:3, 3] - half * body[:3, 2], plain_machine.hexapod.base_joints[leg], atol=LENGTH_M)
        assert np.allclose(rod[:3, 3] + half * rod[:3, 2], ends[leg], rtol=0.0, atol=LENGTH_M)
        assert np.allclose(base_ball[:3, 3], plain_machine.hexapod.base_joints[leg], rtol=0.0, atol=LENGTH_M)
        assert np.allclose(ball[:3, 3], ends[leg], rtol=0.0, atol=LENGTH_M)
    assert np.abs(solids["platform"].pose[:3, 3] - ends.mean(axis=0)).max() <= LENGTH_M


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
