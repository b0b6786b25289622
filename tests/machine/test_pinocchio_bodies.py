"""Distances between legs, leg forces and the drawing: against independent geometry, statics and energy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from hexathermal.errors import (
    SingularPoseError,
)
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.pinocchio_collisions import hinged_pairs
from hexathermal.machine.pinocchio_loads import default_bodies, section_lengths
from hexathermal.machine.pinocchio_model import PinocchioMachine
from tests.machine.mechanisms import (
    F64,
    FORCE_N,
    HEAVY,
    LENGTH_M,
    LIGHT,
    G,
    directions_at,
    far_pivot,
    joints_at,
    lengths_at,
    moved,
    plain,
    poses,
    ring,
    segment_distance,
)

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
