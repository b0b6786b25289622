"""Straight-line moves: against dense sampling, known geometry, and the bounds that the proof rests on."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import numpy.typing as npt
import pinocchio as pin
import pytest
from scipy.optimize import minimize_scalar

import hexathermal as ht
from hexathermal.errors import ArgumentError
from hexathermal.kinematics.limits import Limit, margins, standing
from hexathermal.kinematics.path import check_path, path_poses
from hexathermal.kinematics.path_search import Moves, Search
from hexathermal.poses import inverse_pose

F64 = npt.NDArray[np.float64]

REFERENCE = ht.load_hexapod("reference")
TRAVEL = ht.PoseLimits(
    (-0.07, 0.08), (-0.09, 0.06), (-0.05, 0.09), (-0.2, 0.3), (-0.25, 0.2), (-0.3, 0.35), "fixed-zyx"
)
MACHINES = {
    "strokes": replace(REFERENCE, base_cone=None, platform_cone=None),
    "cones": replace(REFERENCE, base_cone=np.radians(12.0), platform_cone=np.radians(15.0)),
    "travel": replace(REFERENCE, limits=TRAVEL, base_cone=None),
    "turned home": replace(
        REFERENCE, limits=TRAVEL, home=ht.pose_from_coordinates([10, 20, 5, 5, -8, 12]), base_cone=np.radians(100.0)
    ),
}
FREE = replace(REFERENCE, stroke=None, base_cone=None, platform_cone=None)


def from_home(*coordinates: float, machine: ht.Hexapod = REFERENCE) -> F64:
    return ht.pose_from_coordinates(list(coordinates), hexapod=machine)


def drawn(machine: ht.Hexapod, count: int, seed: int) -> tuple[F64, F64]:
    """Return starts near home and ends further out."""
    random = np.random.default_rng(seed)
    near, far = random.normal(size=(2, count, 6))
    return (
        ht.pose_from_coordinates(near * [30, 30, 30, 6, 6, 6], hexapod=machine),
        ht.pose_from_coordinates(far * [60, 60, 60, 12, 12, 12], hexapod=machine),
    )


@pytest.mark.long
@pytest.mark.parametrize("name", MACHINES)
def test_moves_fail_where_dense_sampling_says(name: str) -> None:
    """200 moves against 501 samples each: the same verdict, and the same first place to one step of the samples."""
    machine = MACHINES[name]
    start, end = drawn(machine, 200, seed=1)
    found = check_path(machine, start, end)
    s = np.linspace(0.0, 1.0, 501)
    bad = ~margins(machine, path_poses(start[:, None], end[:, None], s)).reachable
    sampled = np.where(bad.any(axis=1), s[bad.argmax(axis=1)], np.inf)
    first = np.where(found.ok, np.inf, found.first)
    assert 10 < found.ok.sum() < 190
    assert (first <= sampled + 1e-9).all()
    assert (sampled[~found.ok] < first[~found.ok] + 2.001e-3).all()


@pytest.mark.parametrize("name", MACHINES)
def test_the_first_failing_pose_is_just_beyond_the_limit_that_is_named(name: str) -> None:
    """At `first` the named limit is passed, by less than 1e-6; 2e-9 of the way before, by less than 1e-8 if at all."""
    machine = MACHINES[name]
    start, end = drawn(machine, 300, seed=2)
    found = check_path(machine, start, end)
    bad = ~found.ok & (found.first > 0.0)
    start, end, first = start[bad], end[bad], found.first[bad]
    there = margins(machine, path_poses(start, end, first))
    before = margins(machine, path_poses(start, end, np.maximum(first - 2e-9, 0.0)))
    names = {Limit.STROKE: "stroke", Limit.BASE_CONE: "base_cone", Limit.PLATFORM_CONE: "platform_cone"}
    assert bad.sum() > 50
    for n, k in enumerate(np.flatnonzero(bad)):
        limit = Limit(int(found.limit[k]))
        index = found.axis[k] if limit is Limit.TRAVEL else found.leg[k] - 1
        field = names.get(limit, "limits")
        assert -1e-6 < getattr(there, field)[n, index] < 0.0
        assert getattr(before, field)[n, index] > -1e-8
        excess = abs(found.value[k] - found.bound[k])
        assert excess == pytest.approx(-getattr(there, field)[n, index], abs=1e-12)


def test_what_is_named_without_a_failure() -> None:
    """An allowed move names no limit, leg or value; its smallest margins are those of the samples; ends may agree."""
    end = from_home(10, 20, 30, 5, 3, 10)
    found = check_path(REFERENCE, REFERENCE.home, end, samples=5)
    assert found.ok
    assert (found.limit, found.leg, found.axis) == (Limit.NONE, 0, -1)
    assert np.isnan([found.first, found.value, found.bound]).all()
    every = margins(REFERENCE, path_poses(REFERENCE.home, end, np.linspace(0, 1, 5)))
    assert found.samples == 5
    assert np.array_equal(found.smallest.stroke, every.stroke.min(axis=0))
    assert np.array_equal(found.smallest.base_cone, every.base_cone.min(axis=0))
    assert found.smallest.condition_number == every.condition_number.max()
    assert check_path(REFERENCE, end, end).ok


@pytest.mark.parametrize(("depth", "ok"), [(5e-9, False), (2e-9, False), (-1e-9, True), (-1e-6, True)])
def test_a_dip_between_samples_is_not_missed(depth: float, ok: bool) -> None:
    """A leg that dips 2 nm below its stroke between two samples is found; one that stays 1 nm above it is allowed."""
    across = np.cross(REFERENCE.jacobian(REFERENCE.home)[2, :3], [0.0, 0.0, 1.0])
    start, end = (from_home(*(100.0 * side * across - [0, 0, 5]), 0, 0, 0) for side in (-1.0, 0.8))

    def length(s: float) -> float:
        return float(REFERENCE.inverse_kinematics(path_poses(start, end, s))[2])

    dip = minimize_scalar(length, bounds=(0.0, 1.0), method="bounded", options={"xatol": 1e-12})
    assert 0.05 < dip.x < 0.95
    stroke = np.tile([-0.3, 0.6], (6, 1))
    stroke[2, 0] = dip.fun + depth - 0.6
    machine = replace(REFERENCE, stroke=stroke, base_cone=None, platform_cone=None)
    found = check_path(machine, start, end, samples=2)
    assert found.ok is ok
    if not ok:
        assert (found.limit, found.leg) == (Limit.STROKE, 3)
        assert found.first < dip.x


def test_a_move_along_its_limit_is_allowed() -> None:
    """Riding on a travel limit, by height and by angle, and turning in place at the end of the travel: allowed."""
    machine = replace(REFERENCE, limits=TRAVEL, stroke=[-0.3, 0.6], base_cone=None, platform_cone=None)
    x, z = 80.0, 90.0
    rx, ry = np.degrees([0.3, -0.25])
    for one, two in (
        ([-x + 10, 0, z, 0, 0, 0], [x, 10, z, 0, 0, 0]),
        ([0, 0, 0, rx, 0, 0], [x, -90, 0, rx, 0, 0]),
        ([0, 0, 0, 0, ry, 0], [x, -90, 0, 0, ry, 0]),
        ([x, 60, z, -5, 0, 0], [x, 60, z, rx, 0, 0]),
    ):
        start, end = (ht.pose_from_coordinates(six, "fixed-zyx", machine) for six in (one, two))
        assert check_path(machine, start, end).ok


def test_a_turn_through_a_singular_pose_fails_there() -> None:
    """A hexapod of two symmetric rings is singular when turned by 90 degrees about z: a turn by 170 fails at 90/170."""
    found = check_path(FREE, FREE.home, from_home(0, 0, 0, 0, 0, 170))
    assert not found.ok
    assert found.limit is Limit.SINGULAR
    assert found.first == pytest.approx(90.0 / 170.0, abs=1e-6)
    assert found.value > 1e6
    assert check_path(FREE, FREE.home, from_home(0, 0, 0, 0, 0, 89)).ok
    assert check_path(FREE, from_home(0, 0, 0, 0, 0, 120), from_home(0, 0, 0, 0, 0, 130)).first == 0.0


def test_a_turn_that_only_touches_a_singular_pose_fails() -> None:
    """Up to 90 degrees and back over two moves: the first ends in the singular pose, and is refused at its end."""
    found = check_path(FREE, FREE.home, from_home(0, 0, 0, 0, 0, 90))
    assert not found.ok
    assert found.first == pytest.approx(1.0, abs=1e-6)


def test_collisions_on_the_way() -> None:
    """Thick legs that come together on a turn: found between samples, where dense sampling finds them."""
    machine = replace(REFERENCE, stroke=[-0.3, 0.6], bodies=ht.Bodies(0.15, 0.15), base_cone=None, platform_cone=None)
    start, end = from_home(0, 0, -20, 0, 0, -40), from_home(0, 0, 60, 0, 0, 80)
    found = check_path(machine, start, end, collisions=True, samples=3)
    s = np.linspace(0.0, 1.0, 201)
    every = margins(machine, path_poses(start, end, s), collisions=True)
    touching = every.clearance <= 0.0
    assert touching.any()
    assert not touching[0]
    assert not found.ok
    assert found.limit is Limit.COLLISION
    assert abs(found.first - s[touching.argmax()]) < 5.1e-3
    assert found.leg in found.smallest.clearance_legs
    assert -1e-6 < found.value <= 0.0
    assert check_path(machine, start, end).ok
    slim = replace(machine, bodies=None)
    apart = check_path(slim, start, end, collisions=True)
    assert apart.ok
    assert apart.smallest.clearance >= margins(slim, path_poses(start, end, s), collisions=True).clearance.min() - 1e-12


def test_legs_that_pass_through_each_other_between_samples_collide() -> None:
    """Legs in crossed pairs, side by side at both ends of a turn and through each other on the way: not missed."""
    base, platform = [], []
    for third in (0, 120, 240):
        for side, radius in ((-1, 0.47), (1, 0.43)):
            a, b = np.radians([third + 25 * side, third - 25 * side])
            base.append([radius * np.cos(a), radius * np.sin(a), 0.0])
            platform.append([(radius - 0.05) * np.cos(b), (radius - 0.05) * np.sin(b), 0.0])
    machine = ht.Hexapod(base, platform, home=[0, 0, 0.6], bodies=ht.Bodies(0.002, 0.002))
    start, end = from_home(0, 0, 0, 0, 0, -30, machine=machine), from_home(0, 0, 0, 0, 0, 45, machine=machine)
    ends = margins(machine, np.stack([start, end]), collisions=True)
    assert ends.clearance.min() > 0.005
    found = check_path(machine, start, end, samples=2, collisions=True)
    assert found.limit is Limit.COLLISION
    assert 0.1 < found.first < 0.9
    assert check_path(machine, start, end, samples=2).ok


def test_a_visit_to_the_other_side_between_samples_is_not_missed() -> None:
    """Moves whose ends are on home's side of the singular poses, and whose middle is not, are refused."""
    random = np.random.default_rng(7)
    start, end = ht.pose_from_coordinates(random.normal(size=(2, 3000, 6)) * [120, 120, 120, 35, 35, 35], hexapod=FREE)
    side = margins(FREE, path_poses(start[:, None], end[:, None], np.linspace(0.0, 1.0, 21))).side
    visits = (side[:, 0] == 1) & (side[:, -1] == 1) & (side == -1).any(axis=1)
    assert visits.sum() >= 5
    found = check_path(FREE, start[visits], end[visits], samples=2)
    assert not found.ok.any()
    assert (found.limit == Limit.SINGULAR).all()


def test_the_way_back_is_as_good_as_the_way_there() -> None:
    """Reversed moves get the same verdict."""
    machine = MACHINES["cones"]
    start, end = drawn(machine, 200, seed=3)
    assert np.array_equal(check_path(machine, start, end).ok, check_path(machine, end, start).ok)


def test_leading_shapes() -> None:
    """Starts and ends broadcast; a batch says what its moves say alone; an SE3 is one pose; none is none."""
    machine = MACHINES["turned home"]
    start, end = drawn(machine, 6, seed=4)
    many = check_path(machine, start[:2, None], end[None, :3])
    assert many.ok.shape == (2, 3)
    one = check_path(machine, pin.SE3(start[1]), end[2])
    for item in fields(many):
        if item.name != "smallest":
            assert np.array_equal(getattr(many, item.name)[1, 2], getattr(one, item.name), equal_nan=True), item.name
    assert many.smallest.stroke.shape == (2, 3, 6)
    assert np.allclose(many.smallest.stroke[1, 2], one.smallest.stroke)
    assert check_path(machine, np.empty((0, 4, 4)), machine.home).ok.shape == (0,)


def test_moves_are_straight_and_turn_evenly() -> None:
    """The origin moves in proportion to s, the turn from the start is s times the whole, and both ends are met."""
    start, end = drawn(REFERENCE, 20, seed=5)
    s = np.linspace(0.0, 1.0, 11)
    poses = path_poses(start[:, None], end[:, None], s)
    line = start[:, None, :3, 3] + s[:, None] * (end - start)[:, None, :3, 3]
    assert np.abs(poses[..., :3, 3] - line).max() < 1e-15
    for k in range(20):
        whole = pin.log3((inverse_pose(start[k]) @ end[k])[:3, :3])
        for n in range(11):
            assert np.abs(pin.log3((inverse_pose(start[k]) @ poses[k, n])[:3, :3]) - s[n] * whole).max() < 1e-12
    assert np.array_equal(poses[:, 0], start)
    assert np.array_equal(poses[:, -1], end)


@pytest.mark.parametrize("name", ["cones", "turned home"])
def test_second_derivatives_stay_below_their_bounds(name: str) -> None:
    """The curvature that the proof allows for is never exceeded: second differences of 200 moves, at three places."""
    machine, step = MACHINES[name], 1e-3
    start, end = drawn(machine, 200, seed=6)
    moves, path = Moves(start, end), np.arange(200)
    search = Search(machine, moves, collisions=False)
    for s in (0.1, 0.5, 0.9):
        now = [standing(machine, moves.poses(path, np.full(200, s + e))) for e in (-step, 0.0, step)]
        low, middle, high = (search.values(state)[0] for state in now)
        rate = search.speed / now[1].lengths
        bound = search._bends(path, rate)
        assert (np.abs(low - 2.0 * middle + high) / step**2 <= 1.01 * bound + 1e-8).all()
        change = np.abs(now[2].singular_values[:, 5] - now[0].singular_values[:, 5]) / (2.0 * step)
        assert (change <= search._matrix_rate(path, rate)).all()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: check_path(REFERENCE, np.eye(3), REFERENCE.home), "start has shape"),
        (lambda: check_path(REFERENCE, REFERENCE.home, 2 * np.eye(4)), "end: the last row"),
        (lambda: check_path(REFERENCE, REFERENCE.home, REFERENCE.home, samples=1), "at least 2"),
        (lambda: check_path(REFERENCE, np.stack([np.eye(4)] * 2), np.stack([np.eye(4)] * 3)), "do not broadcast"),
        (lambda: path_poses(REFERENCE.home, REFERENCE.home, 1.5), r"s must lie in \[0, 1\]"),
    ],
)
def test_unusable_arguments_are_refused(call: object, message: str) -> None:
    """Wrong shapes, no rigid motion, too few samples, a place off the way: an error that says which."""
    with pytest.raises(ArgumentError, match=message):
        call()  # type: ignore[operator]
