"""All postures of a hexapod: completeness, invariances, special machines, and what is refused."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hexathermal.errors import ArgumentError
from hexathermal.kinematics import modes_tracker as tracker
from hexathermal.kinematics.modes import AssemblyModes, assembly_modes

F64 = npt.NDArray[np.float64]
Machine = tuple[F64, F64, F64, F64]  # base joints, platform joints, T_base_platform, lengths


def rotation(quaternion: F64) -> F64:
    """Return the rotation matrix of a quaternion, scalar first, of any length."""
    w, x, y, z = quaternion / np.linalg.norm(quaternion)
    skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + 2 * (w * skew + skew @ skew))


def transform(quaternion: F64, shift: F64) -> F64:
    T_base_platform = np.eye(4)
    T_base_platform[:3, :3], T_base_platform[:3, 3] = rotation(quaternion), shift
    return T_base_platform


def lengths_at(base: F64, platform: F64, T_base_platform: F64) -> F64:
    points = T_base_platform[:3, 3] + platform @ T_base_platform[:3, :3].T
    return np.asarray(np.linalg.norm(points - base, axis=1))


def ring(radius: float, half_angle: float, turn: float) -> F64:
    """Return six joints in three pairs on a circle about the origin (angles in degrees)."""
    angles = np.deg2rad(np.repeat([0.0, 120.0, 240.0], 2) + np.tile([-half_angle, half_angle], 3) + turn)
    return np.column_stack([radius * np.cos(angles), radius * np.sin(angles), np.zeros(6)])


def tilted(random: np.random.Generator, height: float) -> F64:
    quaternion = np.concatenate([[1.0], 0.15 * random.normal(size=3)])
    return transform(quaternion, 0.2 * random.normal(size=3) + [0, 0, height])


def draw(kind: str, seed: int) -> Machine:
    """Return a random machine of a kind, a pose of it and the lengths at that pose."""
    random = np.random.default_rng(seed)
    base, platform = random.normal(size=(6, 3)), random.normal(size=(6, 3))
    pose = transform(random.normal(size=4), random.normal(size=3))
    if kind == "planar":
        base, platform, pose = base * [1, 1, 0], platform * [1, 1, 0], tilted(random, 1.0)
    elif kind == "ring with tolerances":
        base = ring(1.0, random.uniform(5, 20), 0.0) + 1e-3 * base
        platform = np.roll(ring(random.uniform(0.3, 0.9), random.uniform(5, 20), 60.0), 1, axis=0) + 1e-3 * platform
        pose = tilted(random, random.uniform(0.5, 1.5))
    elif kind == "small platform":
        base, platform, pose = base * [1, 1, 0.1], 0.1 * platform, tilted(random, 2.0)
    elif kind == "long legs":
        pose = tilted(random, 20.0)
    elif kind == "octahedral":
        base, platform = base[[0, 0, 1, 1, 2, 2]], platform[[0, 1, 1, 2, 2, 0]]
        pose = tilted(random, 1.0)
    elif kind != "general":
        raise ValueError(kind)
    return base, platform, pose, lengths_at(base, platform, pose)


def distance_to(modes: AssemblyModes, T_base_platform: F64) -> float:
    """Return the distance of the nearest posture (largest entry of the difference)."""
    return float(np.abs(modes.poses - T_base_platform).max(axis=(1, 2)).min())


def assert_same_set(first: F64, second: F64, tolerance: float) -> None:
    assert first.shape == second.shape
    apart = np.abs(first[:, None] - second[None]).max(axis=(2, 3))
    assert np.all(apart.min(axis=0) < tolerance)
    assert np.all(apart.min(axis=1) < tolerance)


# 40 real postures: P. Dietmaier, "The Stewart-Gough platform of general geometry can have 40 real postures",
# Advances in Robot Kinematics 1998, doi 10.1007/978-94-015-9064-8_1; numbers as reprinted (6 digits)
# in the CuikSuite documentation (Dietmeier.world) and in Drake's test of global inverse kinematics.
DIETMAIER_BASE = np.array([
    [0, 0, 0], [1.107915, 0, 0], [0.549094, 0.756063, 0],
    [0.735077, -0.223935, 0.525991], [0.514188, -0.526063, -0.368418], [0.590473, 0.094733, -0.205018],
])  # fmt: skip
DIETMAIER_PLATFORM = np.array([
    [0, 0, 0], [0.542805, 0, 0], [0.956919, -0.528915, 0],
    [0.665885, -0.353482, 1.402538], [0.478359, 1.158742, 0.107672], [-0.137087, -0.235121, 0.353913],
])  # fmt: skip
DIETMAIER_LENGTHS = np.array([1.0, 0.645275, 1.086284, 1.503439, 1.281933, 0.771071])


def test_dietmaiers_machine_has_forty_real_postures() -> None:
    """The machine published to show that 40 real postures exist has 40 here, all different."""
    modes = assembly_modes(DIETMAIER_BASE, DIETMAIER_PLATFORM, DIETMAIER_LENGTHS)
    assert modes.complete
    assert modes.poses.shape == (40, 4, 4)
    assert modes.residuals.max() < 1e-14
    apart = np.abs(modes.poses[:, None] - modes.poses[None]).max(axis=(2, 3)) + np.eye(40)
    assert apart.min() > 0.01


@pytest.mark.parametrize("kind", ["general", "planar", "ring with tolerances", "small platform", "long legs"])
@pytest.mark.parametrize("seed", range(6))
def test_generic_machines_are_solved_completely(kind: str, seed: int) -> None:
    """40 complex solutions, the pose that made the lengths among the real ones, their number even."""
    base, platform, pose, lengths = draw(kind, seed)
    modes = assembly_modes(base, platform, lengths)
    size = np.sqrt(np.mean(lengths**2))
    assert modes.complete
    assert modes.paths_failed == 0
    assert modes.complex_solutions == 40
    assert distance_to(modes, pose) < 1e-10 * max(1.0, size)
    assert np.all(modes.residuals < 1e-12 * size)
    assert len(modes.poses) % 2 == 0


def test_residuals_are_those_of_the_poses() -> None:
    """Each pose is a rigid transform, and `residuals` holds its largest length error."""
    base, platform, _, lengths = draw("general", 1)
    modes = assembly_modes(base, platform, lengths)
    for pose, residual in zip(modes.poses, modes.residuals, strict=True):
        assert np.abs(pose[:3, :3] @ pose[:3, :3].T - np.eye(3)).max() < 1e-14
        assert np.linalg.det(pose[:3, :3]) > 0
        assert list(pose[3]) == [0, 0, 0, 1]
        assert np.abs(lengths_at(base, platform, pose) - lengths).max() == pytest.approx(residual, abs=1e-15)


@pytest.mark.parametrize("seed", range(4))
def test_planar_machines_come_in_mirror_images(seed: int) -> None:
    """Joints in z = 0 on both bodies: the mirror image S T S, S = diag(1, 1, -1, 1), is a posture as well."""
    base, platform, _, lengths = draw("planar", seed)
    modes = assembly_modes(base, platform, lengths)
    mirror = np.diag([1.0, 1.0, -1.0, 1.0])
    assert len(modes.poses) >= 2
    assert_same_set(mirror @ modes.poses @ mirror, modes.poses, 1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_octahedral_machines_have_sixteen_solutions(seed: int) -> None:
    """Three joints on either body, each shared by two legs: 16 solutions, the 24 other paths leave."""
    base, platform, pose, lengths = draw("octahedral", seed)
    modes = assembly_modes(base, platform, lengths)
    assert modes.complete
    assert modes.complex_solutions == 16
    assert distance_to(modes, pose) < 1e-10
    assert len(modes.poses) in range(2, 17, 2)


def test_symmetric_ring_at_home_is_complete() -> None:
    """Equal legs between two symmetric rings, the usual hexapod at home: complete, home included."""
    base, platform = ring(1.0, 12.0, 0.0), np.roll(ring(0.7, 8.0, 60.0), 1, axis=0)
    pose = transform(np.array([1.0, 0, 0, 0]), np.array([0, 0, 0.9]))
    modes = assembly_modes(base, platform, lengths_at(base, platform, pose))
    assert modes.complete
    assert distance_to(modes, pose) < 1e-12


def multistart(base: F64, platform: F64, lengths: F64, seed: int, starts: int) -> F64:
    """Return the distinct postures (k, 4, 4) that damped Gauss-Newton finds from random poses."""
    random = np.random.default_rng(seed)
    found: list[F64] = []
    for _ in range(starts):
        turn, shift = rotation(random.normal(size=4)), random.normal(size=3)
        for _ in range(30):
            arms = platform @ turn.T
            legs = arms + shift - base
            size = np.linalg.norm(legs, axis=1)
            error = size - lengths
            if np.abs(error).max() < 1e-11:
                break
            unit = legs / size[:, None]
            jacobian = np.column_stack([unit, np.cross(arms, unit)])
            damping = 0.01 * (error @ error) * np.eye(6)
            step = -np.linalg.solve(jacobian.T @ jacobian + damping + 1e-14 * np.eye(6), jacobian.T @ error)
            step *= min(1.0, 0.7 / float(np.linalg.norm(step)))
            shift = shift + step[:3]
            turn = rotation(np.concatenate([[1.0], 0.5 * step[3:]])) @ turn
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = turn, shift
        if np.abs(error).max() < 1e-11 and all(np.abs(pose - known).max() > 1e-5 for known in found):
            found.append(pose)
    return np.array(found)


@pytest.mark.long
@pytest.mark.parametrize("kind", ["general", "planar", "octahedral"])
def test_random_search_finds_no_further_posture(kind: str) -> None:
    """Newton's method from 400 random poses, which shares no code, ends at listed postures only."""
    base, platform, _, lengths = draw(kind, 3)
    modes = assembly_modes(base, platform, lengths)
    found = multistart(base, platform, lengths, seed=3, starts=400)
    assert len(found) > 0
    for pose in found:
        assert distance_to(modes, pose) < 1e-6


@settings(max_examples=10, deadline=None)
@given(
    st.integers(0, 2**31),
    st.lists(st.floats(-1, 1), min_size=4, max_size=4).filter(lambda q: np.linalg.norm(q) > 0.1),
    st.lists(st.floats(-5, 5), min_size=3, max_size=3),
)
def test_moving_the_base_frame_moves_the_answers(seed: int, turn: list[float], shift: list[float]) -> None:
    """Base joints seen from another frame: T_other_platform = T_other_base @ T_base_platform."""
    base, platform, _, lengths = draw("general", seed)
    T_other_base = transform(np.array(turn), np.array(shift))
    moved = base @ T_other_base[:3, :3].T + T_other_base[:3, 3]
    here = assembly_modes(base, platform, lengths)
    there = assembly_modes(moved, platform, lengths)
    assert_same_set(T_other_base @ here.poses, there.poses, 1e-8)


@pytest.mark.parametrize("seed", range(3))
def test_far_pivot(seed: int) -> None:
    """Platform joints 2.2 m above the platform's origin give the same postures as about their centroid."""
    base, platform, pose, lengths = draw("ring with tolerances", seed)
    T_platform_pivot = transform(np.array([1.0, 0, 0, 0]), np.array([0, 0, -2.2]))
    modes = assembly_modes(base, platform - T_platform_pivot[:3, 3], lengths)
    assert modes.complete
    assert modes.complex_solutions == 40
    assert distance_to(modes, pose @ T_platform_pivot) < 1e-10
    assert modes.residuals.max() < 1e-12
    near = assembly_modes(base, platform, lengths)
    assert_same_set(near.poses @ T_platform_pivot, modes.poses, 1e-9)


@pytest.mark.parametrize("scale", [1e-3, 10.0])
def test_scaling_the_machine_scales_the_translations(scale: float) -> None:
    """A machine of millimetres or of ten metres has the same postures, translations scaled."""
    base, platform, _, lengths = draw("planar", 7)
    unit = assembly_modes(base, platform, lengths).poses.copy()
    unit[:, :3, 3] *= scale
    modes = assembly_modes(scale * base, scale * platform, scale * lengths)
    assert modes.complete
    assert_same_set(modes.poses, unit, 1e-10 * max(scale, 1.0))


def test_infeasible_lengths_give_no_posture() -> None:
    """One leg too short to be reached by the others: no real posture, and the proof is complete."""
    base, platform, _, lengths = draw("ring with tolerances", 0)
    lengths = lengths * [1, 1, 1, 1, 1, 0.05]
    modes = assembly_modes(base, platform, lengths)
    assert modes.complete
    assert modes.poses.shape == (0, 4, 4)
    assert modes.residuals.shape == (0,)


@pytest.mark.parametrize("gap", [1e-3, 1e-5, 3e-6])
def test_close_pairs_of_postures_are_kept_apart(gap: float) -> None:
    """Near a singular pose two real postures are `gap` apart: both are listed."""
    base, platform, _, _ = draw("general", 11)
    random = np.random.default_rng(11)
    axis, shift = random.normal(size=3), random.normal(size=3)
    axis /= np.linalg.norm(axis)

    def jacobian_at(angle: float) -> tuple[F64, F64]:
        pose = transform(np.concatenate([[np.cos(angle)], np.sin(angle) * axis]), shift)
        arms = platform @ pose[:3, :3].T
        unit = arms + shift - base
        unit = unit / np.linalg.norm(unit, axis=1)[:, None]
        return pose, np.column_stack([unit, np.cross(arms, unit)])

    angles = np.linspace(0.0, np.pi, 200)
    positive = np.array([np.linalg.det(jacobian_at(angle)[1]) > 0 for angle in angles])
    change = int(np.flatnonzero(positive[1:] != positive[:-1])[0])
    low, high = angles[change : change + 2]
    for _ in range(60):
        middle = 0.5 * (low + high)
        same = (np.linalg.det(jacobian_at(middle)[1]) > 0) == positive[change]
        low, high = (middle, high) if same else (low, middle)
    pose, jacobian = jacobian_at(low)
    twist = np.linalg.svd(jacobian)[2][-1]  # the motion that leaves the lengths unchanged
    pose[:3, 3] += 0.5 * gap * twist[:3]
    pose[:3, :3] = rotation(np.concatenate([[1.0], 0.25 * gap * twist[3:]])) @ pose[:3, :3]
    modes = assembly_modes(base, platform, lengths_at(base, platform, pose))
    apart = np.sort(np.abs(modes.poses - pose).max(axis=(1, 2)))
    assert modes.complete
    assert len(modes.poses) % 2 == 0
    assert apart[0] < 1e-14 / gap + 1e-12
    assert 0.1 * gap < apart[1] < 3 * gap


def test_answers_repeat_sorted_and_read_only() -> None:
    """The same call gives the same bits, highest platform first, in arrays that cannot be written."""
    base, platform, _, lengths = draw("planar", 2)
    first, second = assembly_modes(base, platform, lengths), assembly_modes(base, platform, lengths)
    assert np.array_equal(first.poses, second.poses)
    assert np.all(np.diff(first.poses[:, 2, 3]) < 1e-9)
    with pytest.raises(ValueError, match="read-only"):
        first.poses[0, 0, 0] = 2.0
    with pytest.raises(ValueError, match="read-only"):
        first.residuals[0] = 2.0


GOOD = draw("general", 0)


@pytest.mark.parametrize(
    ("base", "platform", "lengths", "tolerance", "message"),
    [
        (GOOD[0][:5], GOOD[1], GOOD[3], 1e-12, r"base_joints must have shape \(6, 3\); got \(5, 3\)"),
        (GOOD[0], GOOD[1].T, GOOD[3], 1e-12, "platform_joints must have shape"),
        (GOOD[0], GOOD[1], GOOD[3][:5], 1e-12, "lengths must have shape"),
        (GOOD[0], GOOD[1] * np.nan, GOOD[3], 1e-12, "platform_joints must be finite"),
        (GOOD[0], GOOD[1], GOOD[3] * np.inf, 1e-12, "lengths must be finite"),
        (GOOD[0], GOOD[1], -GOOD[3], 1e-12, "lengths must be positive"),
        (GOOD[0], "joints", GOOD[3], 1e-12, "platform_joints must be an array of real numbers"),
        (GOOD[0], GOOD[1] + 1j, GOOD[3], 1e-12, "platform_joints must be an array of real numbers"),
        (GOOD[0], GOOD[1], GOOD[3], 0.0, "tolerance must lie between"),
        (GOOD[0], GOOD[1], GOOD[3], np.nan, "tolerance must lie between"),
    ],
)
def test_unusable_arguments_are_refused(base: F64, platform: F64, lengths: F64, tolerance: float, message: str) -> None:
    """A wrong shape, a value that is not finite, a length that is not positive: an error that says which."""
    with pytest.raises(ArgumentError, match=message):
        assembly_modes(base, platform, lengths, tolerance=tolerance)


def test_importing_the_module_does_not_import_the_compiler() -> None:
    """`import hexathermal.kinematics.modes` leaves the tracker, which needs numba, for the first call."""
    name = "hexathermal.kinematics.modes"
    code = f"import sys, {name}; print('{name}_tracker' in sys.modules)"
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "False"


def test_polynomials_are_the_squared_lengths() -> None:
    """q_i(x) = N (|t + R p_i - b_i|^2 - L_i^2) for every real x on the Study quadric."""
    random = np.random.default_rng(5)
    base, platform, _, lengths = draw("general", 5)
    squares = (platform**2).sum(axis=1) + (base**2).sum(axis=1) - lengths**2
    legs = np.column_stack([squares, platform, base]).astype(np.complex128)
    e, shift = random.normal(size=4), random.normal(size=3)
    h = np.concatenate([[-shift @ e[1:]], shift * e[0] + np.cross(shift, e[1:])])  # h = t e, h e* = N t
    x = np.concatenate([e, h]).astype(np.complex128)
    rows = np.eye(1, tracker.FEATURES, dtype=np.complex128).repeat(6, axis=0)
    for row, leg in zip(rows, legs, strict=True):
        tracker._add_linear(row, leg)
        tracker._add_products(row, leg[4:7], leg[1:4])
    values, matrix = np.empty(8, np.complex128), np.empty((8, 8), np.complex128)
    tracker._linearize(rows, x, x, matrix, values)
    expected = (e @ e) * (lengths_at(base, platform, transform(e, shift)) ** 2 - lengths**2)
    assert np.abs(values[:6] - expected).max() < 1e-12
    assert abs(values[6]) < 1e-14


def test_jacobian_of_the_polynomials_matches_finite_differences() -> None:
    """The 8 x 8 Jacobian agrees with central differences of the values."""
    random = np.random.default_rng(6)
    rows = random.normal(size=(6, tracker.FEATURES)) + 1j * random.normal(size=(6, tracker.FEATURES))
    x = random.normal(size=8) + 1j * random.normal(size=8)
    matrix, unused = np.empty((8, 8), np.complex128), np.empty((8, 8), np.complex128)
    values, above, below = (np.empty(8, np.complex128) for _ in range(3))
    tracker._linearize(rows, x, x.conj(), matrix, values)
    for k in range(8):
        step = np.zeros(8, np.complex128)
        step[k] = 1e-5
        tracker._linearize(rows, x + step, x, unused, above)
        tracker._linearize(rows, x - step, x, unused, below)
        assert np.abs((above - below)[:7] / 2e-5 - matrix[:7, k]).max() < 1e-8
    features = np.zeros(tracker.FEATURES + 1, np.complex128)
    tracker._add_features(x, x, 1.0, features)
    assert np.abs(rows @ features[:-1] - values[:6]).max() < 1e-13


def test_start_machines_have_forty_distinct_solutions() -> None:
    """Every stored solution solves its machine to rounding and differs from the other 39."""
    from hexathermal.kinematics.modes import _distances, _starts

    machines, solutions = _starts()
    assert solutions.shape == (len(machines), 40, 8)
    for legs, points in zip(machines, solutions, strict=True):
        path = tracker.path_coefficients(legs, legs)
        refined = [tracker.refine(path, x.copy(), 2) for x in points]
        assert max(size for size, _ in refined) < 1e-12
        assert max(sensitivity for _, sensitivity in refined) < 1e6
        assert (_distances(points, points) + np.eye(40)).min() > 1e-3
