"""The branch of a forward solution: a pose that is returned can be reached from the start."""

from __future__ import annotations

import numpy as np
import pytest

import hexathermal as ht
from hexathermal.kinematics.workspace import check_path, path_poses
from hexathermal.poses import FloatArray


def scattered(seed: int, which: int = 0) -> tuple[ht.Hexapod, FloatArray]:
    """Return a machine with joints anywhere in space, no strokes and no cones, and poses about its home."""
    rng = np.random.default_rng(seed)
    for _ in range(which + 1):
        base, platform, home = rng.normal(size=(6, 3)), 0.6 * rng.normal(size=(6, 3)), np.eye(4)
        home[:3, 3] = rng.normal(size=3)
        machine = ht.Hexapod(base, platform, home=home)
        coordinates = np.c_[150.0 * rng.normal(size=(200, 3)), rng.uniform(-12.0, 12.0, (200, 3))]
    return machine, ht.pose_from_coordinates(coordinates, hexapod=machine)


def determinants(machine: ht.Hexapod, poses: FloatArray) -> FloatArray:
    """Return the determinants of the Jacobian's rows ``[u, s x u]``."""
    s = np.einsum("nij,kj->nki", poses[:, :3, :3], machine.platform_joints)
    leg = s + poses[:, None, :3, 3] - machine.base_joints
    return np.linalg.det(np.concatenate([leg, np.cross(s, leg)], axis=-1))


@pytest.mark.parametrize("seed", range(20, 32))
def test_an_answer_from_home_is_reached_without_a_singular_pose(seed: int) -> None:
    """What forward kinematics returns as OK on a scattered machine is reached by a straight move from home."""
    machine, poses = scattered(seed)
    result = machine.solve_forward(machine.inverse_kinematics(poses))
    found = result.pose[result.ok]
    assert len(found) > 20
    moves = check_path(machine, machine.home, found)
    assert moves.ok.all(), f"seed {seed}: {np.flatnonzero(~moves.ok)}"


@pytest.mark.parametrize("seed", [11, 24, 28])
def test_an_answer_from_a_guess_is_reached_without_a_singular_pose(seed: int) -> None:
    """The same from a guess: the straight move from the guess to an answer passes no singular pose."""
    machine, poses = scattered(seed)
    starts = poses[::-1]
    result = machine.solve_forward(machine.inverse_kinematics(poses), guess=starts)
    assert result.ok.sum() > 20
    for start, end in zip(starts[result.ok], result.pose[result.ok], strict=True):
        signs = np.sign(determinants(machine, path_poses(start, end, np.linspace(0.0, 1.0, 301))))
        assert (signs == signs[0]).all(), f"seed {seed}"


def test_where_the_lengths_fold_no_far_posture_is_returned() -> None:
    """Lengths whose straight line meets a fold give an error or their own pose, never a posture behind a singular one.

    The pose is 0.38 m and 13 deg from home; Newton from the fold finds one 0.83 m and 120 deg away, behind two
    changes of the determinant's sign.
    """
    rng = np.random.default_rng(11)
    base, platform, home = rng.normal(size=(6, 3)), 0.6 * rng.normal(size=(6, 3)), np.eye(4)
    home[:3, 3] = rng.normal(size=3)
    machine = ht.Hexapod(base, platform, home=home)
    coordinates = np.c_[rng.normal(size=(20, 3)) * 150.0, rng.uniform(-12.0, 12.0, (20, 3))]
    pose = ht.pose_from_coordinates(coordinates, hexapod=machine)[12]
    assert check_path(machine, home, pose).ok
    result = machine.solve_forward(machine.inverse_kinematics(pose))
    assert not result.ok or np.allclose(result.pose, pose, atol=1e-9)
    assert np.allclose(machine.forward_kinematics(machine.inverse_kinematics(pose), guess=pose), pose, atol=1e-12)


def test_a_far_pivot_does_not_hide_a_singular_pose() -> None:
    """With a pivot 30 m aside, and about a home near a singular pose, answers are still reached by a regular move."""
    turns = np.radians([-10.0, 10.0, 110.0, 130.0, 230.0, 250.0])
    base = 0.25 * np.c_[np.cos(turns), np.sin(turns), 0.0 * turns]
    turns = np.radians([-50.0, 50.0, 70.0, 170.0, 190.0, 290.0])
    platform = 0.15 * np.c_[np.cos(turns), np.sin(turns), 0.0 * turns]
    rng = np.random.default_rng(3)
    aside = ht.Hexapod(base, platform + [30.0, 0.0, 0.0], home=[-30.0, 0.0, 0.4])
    for degrees in (40.0, 45.0, 50.0, 55.0):
        pose = ht.pose_from_coordinates([0, 0, 0, 0, degrees, 0])
        pose[:3, 3] = [0.0, 0.0, 0.4] - pose[:3, :3] @ [30.0, 0.0, 0.0]
        result = aside.solve_forward(aside.inverse_kinematics(pose))
        assert not result.ok or check_path(aside, aside.home, result.pose).ok
    for twist in (85.0, 88.0, 89.5):
        home = ht.pose_from_coordinates([0, 0, 400, 0, 0, twist])
        near = ht.Hexapod(base, platform, home=home)
        poses = home @ ht.pose_from_coordinates(rng.uniform(-1, 1, (500, 6)) * [100, 100, 100, 20, 20, 20])
        result = near.solve_forward(near.inverse_kinematics(poses))
        assert result.ok.any()
        assert check_path(near, home, result.pose[result.ok]).ok.all(), twist
