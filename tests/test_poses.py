"""Poses, conventions and frames."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

import hexathermal as ht
from hexathermal.errors import ArgumentError, UnknownNameError

CONVENTIONS = ("fixed-xyz", "fixed-zyx")
coordinates = arrays(
    np.float64,
    6,
    elements=st.one_of(
        st.floats(-179.0, 179.0, allow_subnormal=False),
        st.sampled_from([0.0, 90.0, -90.0, 180.0, 45.0, 89.9999999, -89.9999999, 1e-9]),
    ),
)


@given(coordinates)
def test_conventions_are_those_of_the_controllers(six: np.ndarray) -> None:
    """fixed-xyz is Rz Ry Rx (SYMETRIE), fixed-zyx is Rx Ry Rz (PI, Rubin), in millimetres and degrees."""
    rx, ry, rz = (
        Rotation.from_euler(axis, angle, degrees=True).as_matrix() for axis, angle in zip("xyz", six[3:], strict=True)
    )
    assert np.allclose(ht.pose_from_coordinates(six)[:3, :3], rz @ ry @ rx, atol=1e-14)
    assert np.allclose(ht.pose_from_coordinates(six, "fixed-zyx")[:3, :3], rx @ ry @ rz, atol=1e-14)
    assert np.array_equal(ht.pose_from_coordinates(six)[:3, 3], six[:3] / 1000)


@pytest.mark.parametrize("convention", CONVENTIONS)
@given(coordinates)
def test_coordinates_round_trip_to_the_same_pose_also_in_gimbal_lock(convention: str, six: np.ndarray) -> None:
    """Coordinates of any pose, gimbal cases too, give the same pose back to 1e-12 m and 1e-14 in the rotation."""
    pose = ht.pose_from_coordinates(six, convention)
    back = ht.pose_from_coordinates(ht.coordinates_from_pose(pose, convention), convention)
    assert np.allclose(back[:3, 3], pose[:3, 3], atol=1e-12, rtol=0)
    assert np.abs(back[:3, :3] - pose[:3, :3]).max() < 4e-15


@pytest.mark.parametrize("convention", CONVENTIONS)
@given(arrays(np.float64, 6, elements=st.floats(-80, 80, allow_subnormal=False)))
def test_coordinates_come_back_away_from_gimbal_lock(convention: str, six: np.ndarray) -> None:
    """Six coordinates with |ry| <= 80 degrees come back themselves, to 1e-9 mm and degrees."""
    assert np.allclose(ht.coordinates_from_pose(ht.pose_from_coordinates(six, convention), convention), six, atol=1e-9)


def test_coordinates_count_from_home_where_a_machine_is_given() -> None:
    """All-zero coordinates are the machine's home; without a machine they are the base frame's origin."""
    camera = ht.load_hexapod("rubin-camera")
    assert np.array_equal(ht.pose_from_coordinates(np.zeros(6), "fixed-zyx", camera), camera.home)
    assert np.array_equal(ht.pose_from_coordinates(np.zeros(6)), np.eye(4))
    six = [1.0, -2.0, 3.0, 0.1, -0.2, 0.05]
    pose = ht.pose_from_coordinates(six, "fixed-zyx", camera)
    assert np.allclose(ht.coordinates_from_pose(pose, "fixed-zyx", camera), six, atol=1e-12)


@given(coordinates, coordinates, coordinates, st.sampled_from(CONVENTIONS))
def test_user_and_object_frames_are_symetries(
    user: np.ndarray, tool: np.ndarray, machine: np.ndarray, convention: str
) -> None:
    """user_pose = inv(U) M O and machine_pose is its inverse, checked with Pinocchio's own algebra."""
    frames = ht.Frames(user=user, object=tool, convention=convention)
    U, tool_frame, M = (pin.SE3(ht.pose_from_coordinates(six, convention)) for six in (user, tool, machine))
    seen = frames.user_pose(M)
    assert isinstance(seen, pin.SE3)
    assert np.allclose(seen.homogeneous, (U.inverse() * M * tool_frame).homogeneous, atol=1e-13)
    assert np.allclose(frames.machine_pose(seen.homogeneous), M.homogeneous, atol=1e-13)


@given(coordinates, coordinates)
def test_no_frames_change_nothing_and_equal_frames_cancel(six: np.ndarray, frame: np.ndarray) -> None:
    """Default frames give the machine pose itself; a user frame equal to the pose gives the identity."""
    pose = ht.pose_from_coordinates(six)
    assert np.allclose(ht.Frames().user_pose(pose), pose, atol=1e-15)
    own = ht.Frames(user=frame)
    assert np.allclose(own.user_pose(ht.pose_from_coordinates(frame)), np.eye(4), atol=1e-14)


@pytest.mark.parametrize(
    ("bad", "word"),
    [
        ([1, 2, 3], "shape"),
        ([1, 2, 3, 4, 5, np.nan], "nan"),
        ([1, 2, 3, 4, 5, np.inf], "inf"),
        (["a"] * 6, "real numbers"),
        (None, "real numbers"),
        ([1j] * 6, "real numbers"),
        ([[1, 2], [3]], "real numbers"),
    ],
)
def test_bad_coordinates_are_named(bad: object, word: str) -> None:
    """Wrong shape, NaN, infinity and what is no number is refused with the reason."""
    with pytest.raises(ArgumentError, match=word):
        ht.pose_from_coordinates(bad)  # type: ignore[arg-type]


def test_unknown_convention_lists_those_that_exist() -> None:
    """A misspelled convention names both conventions."""
    with pytest.raises(UnknownNameError, match=r"fixed-xyz.*fixed-zyx") as caught:
        ht.pose_from_coordinates(np.zeros(6), "xyz")
    assert "fixed-zyx" in caught.value.available


@pytest.mark.parametrize(
    ("change", "word"),
    [
        (lambda T: T.T, "transposed"),
        (lambda T: T * [[1.0], [1.0], [-1.0], [1.0]], "mirror"),
        (lambda T: T + 1e-6, "last row|orthonormal"),
        (lambda T: T[:3], "shape"),
        (lambda T: T * np.nan, "nan"),
    ],
)
def test_a_matrix_that_is_no_rigid_motion_is_refused(change: object, word: str) -> None:
    """Transposed, mirrored, deformed and cut matrices are told apart."""
    pose = ht.pose_from_coordinates([100, 20, 30, 10, 20, 30])
    with pytest.raises(ArgumentError, match=word):
        ht.coordinates_from_pose(change(pose))  # type: ignore[operator]


def test_batches_keep_their_leading_shape(rng: np.random.Generator) -> None:
    """Arrays (..., 6) give (..., 4, 4) and back, and each entry equals the single answer."""
    six = rng.uniform(-50, 50, (2, 3, 6))
    poses = ht.pose_from_coordinates(six)
    assert poses.shape == (2, 3, 4, 4)
    assert np.array_equal(poses[1, 2], ht.pose_from_coordinates(six[1, 2]))
    assert ht.coordinates_from_pose(poses).shape == (2, 3, 6)
    assert ht.Frames(user=six[0, 0]).user_pose(poses).shape == (2, 3, 4, 4)
