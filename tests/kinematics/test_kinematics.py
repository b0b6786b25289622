"""Inverse and forward kinematics, Jacobians: round trips, oracles, refusals."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import hexathermal as ht
from hexathermal.errors import (
    ArgumentError,
    HexathermalError,
    JointConeError,
    NotConvergedError,
    OtherBranchError,
    OutOfStrokeError,
    SingularPoseError,
)
from hexathermal.kinematics.jacobian import condition_number
from tests.machines import general_machine, oracle_lengths, random_poses, rotation

ROUND_TRIP_M = 1e-12
ONE_BY_ONE_M = 2e-14


def test_round_trip_over_100_000_poses(hexapod: ht.Hexapod, rng: np.random.Generator) -> None:
    """pose -> lengths -> pose comes back to 1e-12 m over 1e5 random poses of each bundled machine."""
    poses = random_poses(hexapod, 100_000, rng)
    back = hexapod.forward_kinematics(hexapod.inverse_kinematics(poses))
    assert np.abs(back - poses).max() < ROUND_TRIP_M


def test_lengths_equal_extended_precision(hexapod: ht.Hexapod, rng: np.random.Generator) -> None:
    """Leg lengths agree with the definition evaluated in extended precision to 1e-15 m times the coordinates' size."""
    poses = random_poses(hexapod, 5_000, rng)
    scale = 1.0 + np.abs(hexapod.home).max()
    assert np.abs(hexapod.inverse_kinematics(poses) - oracle_lengths(hexapod, poses)).max() < 1e-15 * scale


@pytest.mark.parametrize("pivot", [0.0, -3.0, 10.0])
def test_general_joints_and_far_pivots_round_trip(pivot: float, rng: np.random.Generator) -> None:
    """Machines with scattered joints, also metres away from the platform's origin, round-trip to 1e-12 m per metre."""
    for _ in range(5):
        machine = general_machine(rng, pivot)
        turn = np.eye(4)[None].repeat(500, axis=0)
        turn[:, :3, :3] = rotation(rng.uniform(-0.08, 0.08, (500, 3)))
        centre, back = np.eye(4), np.eye(4)
        centre[2, 3], back[2, 3] = pivot, -pivot
        turn[:, :3, 3] = rng.uniform(-0.03, 0.03, (500, 3))
        poses = machine.home @ centre @ turn @ back
        found = machine.solve_forward(machine.inverse_kinematics(poses))
        assert np.all(found.ok)
        assert np.abs(found.pose - poses).max() < ROUND_TRIP_M * (1.0 + abs(pivot))


def test_batch_equals_one_by_one(hexapod: ht.Hexapod, rng: np.random.Generator) -> None:
    """A batch gives what single calls give: lengths and poses within 2e-14 m, with any leading shape."""
    poses = random_poses(hexapod, 6 * 33, rng).reshape(6, 33, 4, 4)
    lengths = hexapod.inverse_kinematics(poses)
    assert lengths.shape == (6, 33, 6)
    singles = np.array([[hexapod.inverse_kinematics(pose) for pose in row] for row in poses])
    assert np.abs(lengths - singles).max() < ONE_BY_ONE_M
    back = hexapod.forward_kinematics(lengths)
    assert back.shape == (6, 33, 4, 4)
    assert np.abs(back - [[hexapod.forward_kinematics(row) for row in rows] for rows in lengths]).max() < ONE_BY_ONE_M
    assert hexapod.jacobian(poses).shape == (6, 33, 6, 6)
    for empty in (poses[:0], poses[:, :0]):
        assert hexapod.inverse_kinematics(empty).shape == (*empty.shape[:2], 6)
        assert hexapod.forward_kinematics(hexapod.inverse_kinematics(empty)).shape == empty.shape


def test_se3_in_se3_out_and_other_layouts(reference: ht.Hexapod) -> None:
    """SE3, read-only, Fortran-ordered, sliced and single-precision-safe inputs give the same lengths."""
    pose = ht.pose_from_coordinates([5, -4, 12, 1, 1.5, -2])
    lengths = reference.inverse_kinematics(pose)
    sliced = np.zeros((8, 8))
    sliced[::2, ::2] = pose
    frozen = pose.copy()
    frozen.setflags(write=False)
    for other in (pin.SE3(pose), np.asfortranarray(pose), sliced[::2, ::2], frozen, pose.tolist()):
        assert np.abs(reference.inverse_kinematics(other) - lengths).max() < 1e-15
    back = reference.forward_kinematics(lengths, guess=pin.SE3(pose))
    assert isinstance(back, pin.SE3)
    assert np.abs(back.homogeneous - pose).max() < ROUND_TRIP_M
    assert isinstance(reference.forward_kinematics(lengths), np.ndarray)


def test_jacobian_against_finite_differences(hexapod: ht.Hexapod, rng: np.random.Generator) -> None:
    """dL/dx agrees with central differences of extended-precision lengths to 1e-9."""
    step = 1e-6
    for pose in random_poses(hexapod, 20, rng):
        J = hexapod.jacobian(pose)
        for k in range(6):
            moved = []
            for sign in (1.0, -1.0):
                other = pose.copy()
                if k < 3:
                    other[k, 3] += sign * step
                else:
                    turn = np.zeros(3)
                    turn[k - 3] = sign * step
                    other[:3, :3] = rotation(turn) @ pose[:3, :3]
                moved.append(oracle_lengths(hexapod, other))
            assert np.abs(J[:, k] - (moved[0] - moved[1]) / (2 * step)).max() < 1e-8


def test_moving_the_base_frame_moves_the_answer_with_it(reference: ht.Hexapod, rng: np.random.Generator) -> None:
    """The same machine described in another base frame has the same lengths and the moved pose."""
    shift = np.eye(4)
    shift[:3, :3], shift[:3, 3] = rotation(np.array([0.3, -0.2, 1.0])), [1.0, -2.0, 0.5]
    base = reference.base_joints @ shift[:3, :3].T + shift[:3, 3]
    moved = ht.Hexapod(base, reference.platform_joints, home=shift @ reference.home)
    poses = random_poses(reference, 200, rng)
    lengths = reference.inverse_kinematics(poses)
    assert np.abs(moved.inverse_kinematics(shift @ poses) - lengths).max() < 1e-14
    assert np.abs(moved.forward_kinematics(lengths) - shift @ poses).max() < ROUND_TRIP_M


def test_condition_number_does_not_depend_on_the_platform_origin(rng: np.random.Generator) -> None:
    """Moving the platform's origin 3 m away leaves the condition number as it is."""
    near = general_machine(rng)
    far = ht.Hexapod(near.base_joints, near.platform_joints + [0, 0, 3.0], home=[0, 0, -2.5])
    a, b = condition_number(near, near.home), condition_number(far, far.home)
    assert abs(a / b - 1) < 1e-12


def test_out_of_stroke_names_leg_value_and_limits(reference: ht.Hexapod) -> None:
    """A length beyond the stroke is refused with leg, value and limits, also inside a batch."""
    lengths = np.tile(reference.inverse_kinematics(reference.home), (5, 1))
    lengths[3, 4] = 0.8501
    for given, index in ((lengths[3], ()), (lengths, (3,))):
        with pytest.raises(OutOfStrokeError, match=r"leg 5 out of stroke.*850\.1.*600\.0.*850\.0") as caught:
            reference.forward_kinematics(given)
        assert (caught.value.leg, caught.value.value, caught.value.index) == (5, 0.8501, index)
        assert (caught.value.lower, caught.value.upper) == (0.6, 0.85)


def test_a_pose_on_the_limit_of_the_stroke_is_allowed(reference: ht.Hexapod) -> None:
    """Lengths exactly at both ends of the stroke are inside."""
    lengths = np.full(6, 0.6)
    assert np.abs(reference.inverse_kinematics(reference.forward_kinematics(lengths)) - lengths).max() < 1e-14


def test_out_of_cone_names_the_joint(reference: ht.Hexapod) -> None:
    """A leg that leans further than a joint's cone is refused with leg, joint, angle and limit."""
    import dataclasses

    narrow = dataclasses.replace(reference, base_cone=np.radians(2.0))
    lengths = reference.inverse_kinematics(ht.pose_from_coordinates([60, 0, 0, 0, 0, 0]))
    for given in (lengths, np.tile(lengths, (3, 1))):
        with pytest.raises(
            JointConeError, match=r"leg \d leans .* deg at its base joint.*allowed 2\.0000 deg"
        ) as caught:
            narrow.forward_kinematics(given)
        assert caught.value.value > caught.value.upper == pytest.approx(np.radians(2.0))
    with pytest.raises(JointConeError):
        narrow.corrected_leg_lengths(ht.pose_from_coordinates([60, 0, 0, 0, 0, 0]), [20.0] * 6)


def test_lengths_that_close_no_posture_do_not_converge(reference: ht.Hexapod) -> None:
    """Five legs at one end and one at the other close no platform: an error with the leg and what is left."""
    free = ht.Hexapod(reference.base_joints, reference.platform_joints, home=reference.home)
    with pytest.raises(NotConvergedError, match="no pose with these leg lengths was found") as caught:
        free.forward_kinematics(np.array([0.1, 2.0, 0.1, 2.0, 0.1, 2.0]))
    assert caught.value.leg in range(1, 7)
    assert caught.value.value > 1e-6


def test_every_answer_without_error_is_a_true_answer(rng: np.random.Generator) -> None:
    """Random lengths, most of them impossible: what is not refused closes to 2e-14 and keeps home's assembly mode."""
    machine = general_machine(rng)
    result = machine.solve_forward(machine.inverse_kinematics(machine.home) * rng.uniform(0.6, 1.4, (3000, 6)))
    ok = result.ok
    assert 100 < ok.sum() < 2900
    assert np.abs(oracle_lengths(machine, result.pose[ok]) - machine.inverse_kinematics(result.pose[ok])).max() < 1e-14
    assert result.residual[ok].max() < 2e-14
    assert (result.assembly_mode[ok] == 1).all()


def test_singular_pose_is_refused() -> None:
    """A platform similar to its base, not turned against it, is singular at home: no answer, but an error."""
    angles = np.radians([0, 50, 120, 170, 240, 290])
    base = np.stack([0.5 * np.cos(angles), 0.5 * np.sin(angles), 0 * angles], axis=1)
    machine = ht.Hexapod(base, 0.6 * base, home=[0, 0, 0.4])
    with pytest.raises((SingularPoseError, NotConvergedError)):
        machine.forward_kinematics(machine.inverse_kinematics(machine.home))
    assert machine.solve_forward(machine.inverse_kinematics(machine.home)).status == ht.ForwardStatus.SINGULAR


@pytest.mark.parametrize(("turn", "singular"), [(89.9, False), (89.999, False), (89.999999, True), (90.0, True)])
def test_near_singular_poses_are_solved_or_called_singular(reference: ht.Hexapod, turn: float, singular: bool) -> None:
    """Up to a condition number of 1e7 poses come back with the error that it allows; beyond it they are refused."""
    free = ht.Hexapod(reference.base_joints, reference.platform_joints, home=reference.home)
    pose = ht.pose_from_coordinates([1, 2, -30, 0, 0, turn])
    lengths = free.inverse_kinematics(pose)
    for guess in (None, pose):
        if singular:
            with pytest.raises(SingularPoseError):
                free.forward_kinematics(lengths, guess)
            assert free.solve_forward(lengths, guess).status == ht.ForwardStatus.SINGULAR
        else:
            allowed = 1e-14 * condition_number(free, pose)
            assert np.abs(free.forward_kinematics(lengths, guess) - pose).max() < allowed


def test_another_assembly_mode_is_never_returned_silently(reference: ht.Hexapod) -> None:
    """Lengths taken from another assembly mode give home's posture, or an error, never the other posture."""
    free = ht.Hexapod(reference.base_joints, reference.platform_joints, home=reference.home)
    lengths = free.inverse_kinematics(ht.pose_from_coordinates([20, 10, -15, 2, -3, 4]))
    modes = free.assembly_modes(lengths)
    assert len(modes) > 1
    found = free.forward_kinematics(lengths)
    assert np.abs(found - ht.pose_from_coordinates([20, 10, -15, 2, -3, 4])).max() < ROUND_TRIP_M
    for mode in modes:
        near = free.forward_kinematics(lengths, guess=mode)
        assert np.abs(near - mode).max() < 1e-10


def test_other_branch_is_an_error_of_its_own(rng: np.random.Generator) -> None:
    """Where Newton ends beyond a singular pose and home's own branch has no posture, the status says other branch."""
    seen = set()
    for _ in range(12):
        machine = general_machine(rng)
        lengths = machine.inverse_kinematics(machine.home) * rng.uniform(0.75, 1.25, (2000, 6))
        result = machine.solve_forward(lengths)
        seen |= set(np.unique(result.status).tolist())
        other = np.flatnonzero(result.status == ht.ForwardStatus.OTHER_BRANCH)
        if len(other):
            with pytest.raises(OtherBranchError, match="assembly_modes"):
                machine.forward_kinematics(lengths[other[0]])
            break
    assert ht.ForwardStatus.OTHER_BRANCH in seen
    assert ht.ForwardStatus.NOT_CONVERGED in seen


@pytest.mark.parametrize(
    ("lengths", "word"),
    [
        (np.full(5, 0.7), "shape"),
        (np.full((6, 5), 0.7), "shape"),
        ([0.7, 0.7, np.nan, 0.7, 0.7, 0.7], "nan"),
        ([0.7, 0.7, np.inf, 0.7, 0.7, 0.7], "inf"),
        ([0.7, 0.7, -0.7, 0.7, 0.7, 0.7], "strokes"),
        (np.full(6, 725.0), "millimetres"),
        (np.full(6, 0.125), "too short"),
        ("lengths", "real numbers"),
        (0.7, "shape"),
    ],
)
def test_bad_lengths_are_refused(reference: ht.Hexapod, lengths: object, word: str) -> None:
    """Wrong shape, NaN, infinite, negative, millimetres and strokes for lengths each get a clear error."""
    with pytest.raises(HexathermalError, match=word):
        reference.forward_kinematics(lengths)  # type: ignore[arg-type]


@pytest.mark.parametrize("machine", ["reference", "free"])
def test_bad_values_inside_a_batch_are_refused(machine: str, reference: ht.Hexapod) -> None:
    """One bad entry among many is found, with and without strokes."""
    hexapod = reference if machine == "reference" else ht.Hexapod(reference.base_joints, reference.platform_joints)
    lengths = np.tile(reference.inverse_kinematics(reference.home), (1000, 1))
    for bad in (np.nan, np.inf, -0.7, 0.0):
        wrong = lengths.copy()
        wrong[777, 2] = bad
        with pytest.raises(ArgumentError, match="777|leg 3"):
            hexapod.forward_kinematics(wrong)


def test_poses_in_millimetres_and_bad_poses_are_refused(reference: ht.Hexapod) -> None:
    """A pose in millimetres, a NaN and a sheared rotation inside a batch are refused with their place."""
    good = np.tile(ht.pose_from_coordinates([5, 0, 12, 0, 1.5, 0]), (100, 1, 1))
    for change, word in ((lambda T: T.__setitem__((0, 3), 500.0), "millimetres"),
                         (lambda T: T.__setitem__((0, 3), np.nan), "nan"),
                         (lambda T: T.__setitem__((0, 1), 1e-3), "orthonormal"),
                         (lambda T: T.__setitem__((3, 3), 2.0), "last row")):  # fmt: skip
        poses = good.copy()
        change(poses[42])
        with pytest.raises(ArgumentError, match=word) as caught:
            reference.inverse_kinematics(poses)
        assert "42" in str(caught.value)
        with pytest.raises(HexathermalError):
            reference.inverse_kinematics(poses[42]) if word != "nan" else reference.jacobian(poses)


def test_compiled_cache_is_stale_when_a_formula_changes(tmp_path: object) -> None:
    """The stamp of a compiled loop depends on the text of the formulas that end up inside it."""
    from pathlib import Path

    from hexathermal.kinematics import compiled

    folder = Path(str(tmp_path))
    for file in Path(compiled.__file__).parent.glob("*.py"):
        (folder / file.name).write_bytes(file.read_bytes())
    before = compiled.sources_digest(folder)
    assert before == compiled.sources_digest()
    for name in ("formulas.py", "elimination.py", "layout.py", "lengths_loops.py"):
        original = (folder / name).read_bytes()
        (folder / name).write_bytes(original + b"# edited\n")
        assert compiled.sources_digest(folder) != before, name
        (folder / name).write_bytes(original)
