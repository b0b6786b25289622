"""ISO 9283: hand examples, the traps of public scripts, rotations that cross 180 degrees, and invariances."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hexathermal.errors import ArgumentError
from hexathermal.poses import FloatArray, pose_from_coordinates
from hexathermal.predict.acceptance import PoseAccuracy, pose_accuracy, pose_drift
from hexathermal.predict.acceptance.pose_accuracy import accuracies_of_poses

CROSS = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]], dtype=float)


def poses(positions: FloatArray, turns: FloatArray | None = None, about: FloatArray | None = None) -> FloatArray:
    """Poses at positions [m], turned by rotation vectors [rad] about the base's axes after `about`."""
    out = np.broadcast_to(np.eye(4), (len(positions), 4, 4)).copy()
    out[:, :3, 3] = positions
    if turns is not None:
        out[:, :3, :3] = Rotation.from_rotvec(turns).as_matrix()
    if about is not None:
        out[:, :3, :3] = out[:, :3, :3] @ about
    return out


def scattered(seed: int, count: int, turn: float = 1e-3) -> FloatArray:
    """Visits scattered about a pose far from the identity."""
    rng = np.random.default_rng(seed)
    shifts, turns = rng.normal(0.0, 1e-5, (count, 3)), rng.normal(0.0, turn, (count, 3))
    return poses(shifts + [0.1, -0.2, 0.3], turns, Rotation.from_rotvec([1.0, -2.0, 0.5]).as_matrix())


def test_hand_example() -> None:
    """Points at +-1 on two axes: mean distance 1, no scatter of it, RP = 1; commanded (3, 4, 0): AP = 5."""
    found = pose_accuracy(poses(CROSS), poses(np.array([[3.0, 4.0, 0.0]]))[0])
    assert (found.AP, found.RP, found.count) == (5.0, 1.0, 4)
    assert found.position.tolist() == [-3.0, -4.0, 0.0]
    assert (found.AP_rotation, found.RP_rotation) == (0.0, 0.0)


def test_repeatability_divides_by_the_visits() -> None:
    """Two visits 2 apart: mean distance 1. Divided by the larger side of the table (3 columns) it would be 2/3."""
    assert pose_accuracy(poses(CROSS[:2]), np.eye(4)).RP == pytest.approx(1.0, abs=1e-15)


def test_scatter_of_distances_has_n_minus_one() -> None:
    """On a line at -2, 0, 0, 2: distances 2, 0, 0, 2, mean 1, S = sqrt(4/3), RP = 1 + 3 S."""
    line = np.array([[-2.0, 0, 0], [0, 0, 0], [0, 0, 0], [2.0, 0, 0]])
    assert pose_accuracy(poses(line), np.eye(4)).RP == pytest.approx(1.0 + 3.0 * np.sqrt(4.0 / 3.0), rel=1e-14)


def test_turns_about_one_axis_are_differences_of_that_angle() -> None:
    """rz of 10, 20, 30 urad commanded 0: AP_rz = 20 urad, RP_rz = 3 S = 30 urad, nothing about x and y."""
    angles = np.array([10e-6, 20e-6, 30e-6])
    found = pose_accuracy(poses(np.zeros((3, 3)), np.outer(angles, [0, 0, 1])), np.eye(4))
    np.testing.assert_allclose(found.rotation, [0, 0, 20e-6], atol=1e-15)
    np.testing.assert_allclose(found.RP_axes, [0, 0, 30e-6], atol=1e-15)
    assert found.AP_rotation == pytest.approx(20e-6, abs=1e-15)


def test_angles_are_averaged_across_180_degrees() -> None:
    """rz = 179.999 and -179.999 commanded 180: no error, and a spread of 0.001 degrees; their numbers' mean is 0."""
    visits = pose_from_coordinates([[0, 0, 0, 0, 0, 179.999], [0, 0, 0, 0, 0, -179.999]])
    found = pose_accuracy(visits, pose_from_coordinates([0, 0, 0, 0, 0, 180]))
    assert found.AP_rotation < 1e-14
    assert found.RP_axes[2] == pytest.approx(3.0 * np.radians(0.001) * np.sqrt(2.0), rel=1e-9)


def test_gimbal_lock_is_no_error() -> None:
    """At ry = 90 degrees, where rx and rz jump for the same rotation, equal rotations have no error and no spread."""
    visits = pose_from_coordinates([[0, 0, 0, 0, 90, 0], [0, 0, 0, 40, 90, 40], [0, 0, 0, -70, 90, -70]])
    found = pose_accuracy(visits, pose_from_coordinates([0, 0, 0, 10, 90, 10]))
    assert found.AP_rotation < 1e-14
    assert found.RP_rotation < 1e-14


def test_mean_is_the_geodesic_one_where_it_matters() -> None:
    """The chordal mean has mean log(R_j R_mean^T) = 0: within 1e-7 rad for a scatter of 5 mrad, 1e-12 for 0.1 mrad."""
    for turn, allowed in ((5e-3, 1e-7), (1e-4, 1e-12)):
        visits = scattered(3, 30, turn=turn)
        mean = Rotation.from_rotvec(pose_accuracy(visits, np.eye(4)).rotation.copy())
        logs = (Rotation.from_matrix(visits[:, :3, :3]) * mean.inv()).as_rotvec()
        assert np.abs(logs.mean(axis=0)).max() < allowed


@given(st.integers(0, 10_000), st.integers(2, 12))
def test_moving_the_base_frame_moves_the_errors_with_it(seed: int, count: int) -> None:
    """Seen from another frame, sizes stay and components turn with the frame."""
    rng = np.random.default_rng(seed)
    visits, command = scattered(seed, count), scattered(seed + 1, 2)[0]
    frame = poses(rng.normal(size=(1, 3)), rng.normal(size=(1, 3)))[0]
    here, there = pose_accuracy(visits, command), pose_accuracy(frame @ visits, frame @ command)
    for name in ("AP", "AP_rotation", "RP", "RP_rotation"):
        assert getattr(here, name) == pytest.approx(getattr(there, name), abs=1e-12)
    np.testing.assert_allclose(frame[:3, :3] @ here.position, there.position, atol=1e-14)
    np.testing.assert_allclose(frame[:3, :3] @ here.rotation, there.rotation, atol=1e-12)


@given(st.integers(0, 10_000), st.integers(2, 12))
def test_order_of_visits_does_not_matter(seed: int, count: int) -> None:
    """Shuffled visits have the same accuracy and repeatability."""
    visits = scattered(seed, count)
    one, other = (pose_accuracy(given, visits[0]) for given in (visits, visits[::-1]))
    assert one.AP == pytest.approx(other.AP, abs=1e-15)
    assert one.RP == pytest.approx(other.RP, abs=1e-15)
    np.testing.assert_allclose(one.RP_axes, other.RP_axes, atol=1e-14)


def test_se3_and_arrays_are_the_same() -> None:
    """Poses may be Pinocchio's."""
    visits = scattered(1, 5)
    one = pose_accuracy(visits, visits[0])
    other = pose_accuracy([pin.SE3(visit) for visit in visits], pin.SE3(visits[0]))
    assert (one.AP, one.RP) == (other.AP, other.RP)
    assert not one.position.flags.writeable


@pytest.mark.parametrize(
    ("visits", "command", "words"),
    [
        (np.eye(4)[None], np.eye(4), "found 1 measured visit of a pose; expected at least 2"),
        (np.zeros((0, 4, 4)), np.eye(4), "found 0 measured visits"),
        ([], np.eye(4), "found 0 measured visits"),
        (np.eye(4), np.eye(4), r"expected \(n, 4, 4\)"),
        (poses(CROSS), poses(CROSS), "expected one pose"),
        (poses(CROSS), np.diag([2.0, 1, 1, 1]), "not orthonormal"),
        (poses(CROSS[:2], np.array([[0, 0, 0], [0, 0, 3.1]])), np.eye(4), "not visits of one pose"),
    ],
)
def test_what_is_no_test_of_a_pose_is_refused(visits: FloatArray, command: FloatArray, words: str) -> None:
    """A single visit, no visit, other shapes, and visits that have no mean are errors that say so."""
    with pytest.raises(ArgumentError, match=words):
        pose_accuracy(visits, command)


def group(shift: float, spread: float) -> PoseAccuracy:
    """A group of visits about (shift, 0, 0) with RP = spread."""
    return pose_accuracy(poses(spread * CROSS + [shift, 0.0, 0.0]), np.eye(4))


def test_drift_is_the_largest_change_from_the_first_group() -> None:
    """AP of 1, 4, 3 and RP of 1, 1, 3: dAP = 3 in group 1, dRP = 2 in group 2."""
    drift = pose_drift([group(1.0, 1.0), group(4.0, 1.0), group(3.0, 3.0)])
    assert (drift.dAP, drift.dRP, drift.shift) == (3.0, 2.0, 3.0)
    assert drift.worst == {"dAP": 1, "dRP": 2, "shift": 1}
    assert drift.dAP_axes.tolist() == [3.0, 0.0, 0.0]


def test_drift_to_the_other_side_is_seen_by_the_shift() -> None:
    """From +5 to -5 the standard's dAP is 0; the mean position moved by 10."""
    drift = pose_drift([group(5.0, 1.0), group(-5.0, 1.0)])
    assert (drift.dAP, drift.shift) == (0.0, 10.0)
    assert drift.dAP_axes[0] == 10.0


def test_drift_needs_two_groups() -> None:
    """One group has no drift, and that is said."""
    with pytest.raises(ArgumentError, match="at least two"):
        pose_drift([group(0.0, 1.0)])


def test_many_poses_at_once_are_each_by_itself(rng: np.random.Generator) -> None:
    """Poses of 2 to 9 visits, worked on together, have the values of each alone, written out with SciPy's mean."""
    counts = rng.integers(2, 10, 40)
    starts = np.cumsum([0, *counts[:-1]])
    commands = poses(rng.normal(size=(40, 3)), rng.normal(size=(40, 3)))
    visits = np.repeat(commands, counts, axis=0)
    visits[:, :3, 3] += 1e-5 * rng.normal(size=(len(visits), 3))
    visits[:, :3, :3] = Rotation.from_rotvec(1e-4 * rng.normal(size=(len(visits), 3))).as_matrix() @ visits[:, :3, :3]
    found = accuracies_of_poses(visits, commands, starts, "fixed-xyz")
    for k, (first, count) in enumerate(zip(starts, counts, strict=True)):
        own, command = visits[first : first + count], commands[k]
        turned = Rotation.from_matrix(own[:, :3, :3] @ command[:3, :3].T)
        mean = turned.mean()
        away = np.linalg.norm((turned * mean.inv()).as_rotvec(), axis=1)
        lengths = np.linalg.norm(own[:, :3, 3] - own[:, :3, 3].mean(axis=0), axis=1)
        assert found[k].count == count
        assert found[k].position == pytest.approx(own[:, :3, 3].mean(axis=0) - command[:3, 3], abs=1e-15)
        assert found[k].rotation == pytest.approx(mean.as_rotvec(), abs=1e-14)
        assert found[k].RP == pytest.approx(lengths.mean() + 3.0 * lengths.std(ddof=1), rel=1e-9)
        assert found[k].RP_rotation == pytest.approx(away.mean() + 3.0 * away.std(ddof=1), rel=1e-9)
        alone = pose_accuracy(own, command)
        for name in ("RP_axes", "angles", "RP_angles"):
            assert getattr(found[k], name) == pytest.approx(getattr(alone, name), rel=1e-9, abs=1e-14, nan_ok=True)
    visits[starts[7] + 1, :3, :3] = Rotation.from_rotvec([0, 0, 2.0]).as_matrix() @ visits[starts[7] + 1, :3, :3]
    with pytest.raises(ArgumentError, match=r"G: visit \d is turned"):
        accuracies_of_poses(visits, commands, starts, "fixed-xyz", [chr(ord("@") + k) for k in range(40)])
