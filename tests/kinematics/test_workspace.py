"""The reachable volume against exact volumes and random points; the cut of a box; grids about home."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hexathermal as ht
from hexathermal.errors import ArgumentError, SingularPoseError
from hexathermal.kinematics.cells import connected, cut_bounds, neighbours, root
from hexathermal.kinematics.singular_surface import nodes, singular_surface
from hexathermal.kinematics.volume import poses_from_home
from hexathermal.kinematics.workspace import Limit, check_path, margins, reachable_volume, workspace_grid
from tests.machines import general_machine

F64 = npt.NDArray[np.float64]

REFERENCE = ht.load_hexapod("reference")
WIDE = replace(REFERENCE, stroke=[-0.5, 2.0], base_cone=None, platform_cone=None)
CM3 = 1e-6


def turned(*angles_deg: float) -> F64:
    return ht.pose_from_coordinates([0, 0, 0, *angles_deg])[:3, :3]


def sampled(machine: ht.Hexapod, rotation: F64, half: F64, count: int, seed: int) -> tuple[float, float]:
    """Return the allowed volume in a box about home and its standard uncertainty, by points and written-out limits."""
    random = np.random.default_rng(seed)
    x = random.uniform(-1.0, 1.0, (count, 3)) * half
    R = machine.home[:3, :3] @ rotation
    legs = (
        (machine.home[:3, 3] + x @ machine.home[:3, :3].T)[:, None]
        + machine.platform_joints @ R.T
        - machine.base_joints
    )
    L = np.sqrt((legs**2).sum(axis=2))
    inside = ((machine.length_limits[0] <= L) & (machine.length_limits[1] >= L)).all(axis=1)
    home = machine.platform_joints @ machine.home[:3, :3].T + machine.home[:3, 3] - machine.base_joints
    home /= np.linalg.norm(home, axis=1)[:, None]
    unit = legs / L[..., None]
    if machine.base_cone is not None:
        inside &= ((unit * home).sum(axis=2) >= np.cos(machine.base_cone)).all(axis=1)
    if machine.platform_cone is not None:
        seen = (unit @ R) * (home @ machine.home[:3, :3])
        inside &= (seen.sum(axis=2) >= np.cos(machine.platform_cone)).all(axis=1)
    part, box = inside.mean(), 8.0 * half.prod()
    return box * part, box * np.sqrt(part * (1.0 - part) / count)


CONES = replace(
    REFERENCE,
    home=ht.pose_from_coordinates([5, -10, 20, 3, -4, 6]),
    base_cone=np.radians([15, 16, 17, 18, 19, 20]),
    platform_cone=np.radians(18.0),
)


@pytest.mark.long
@pytest.mark.parametrize(
    ("machine", "angles"),
    [(REFERENCE, (0, 0, 0)), (REFERENCE, (10, -4, 15)), (CONES, (0, 0, 0)), (CONES, (3, 4, 5))],
    ids=["reference", "reference turned", "cones", "cones turned"],
)
def test_volume_agrees_with_random_points(machine: ht.Hexapod, angles: tuple[float, float, float]) -> None:
    """400 000 random points give the same volume within 4 standard deviations; bounds are as close as asked."""
    volume = reachable_volume(machine, turned(*angles), resolution=0.002)
    lower, upper = volume.bounds
    found, deviation = sampled(machine, turned(*angles), np.array([0.36, 0.36, 0.3]), 400_000, seed=1)
    assert lower - 4.0 * deviation < found < upper + 4.0 * deviation
    assert 0.0 < upper - lower <= 0.004 * volume.value * (1.0 + 1e-9)
    assert volume.value == pytest.approx(0.5 * (lower + upper))
    assert volume.uncertainty == pytest.approx((upper - lower) / np.sqrt(12.0))
    assert volume.reached


def test_the_reference_machine_is_of_the_papers_class() -> None:
    """Its translational workspace at home is 31 000 cm3 to 1 %; the paper's machine has 30 000 cm3; found in 2 s."""
    reachable_volume(REFERENCE)
    start = time.perf_counter()
    volume = reachable_volume(REFERENCE)
    assert time.perf_counter() - start < 2.0
    assert volume.value == pytest.approx(31_000 * CM3, rel=0.01)
    assert volume.uncertainty < 0.01 * volume.value


def test_a_travel_box_is_measured_exactly() -> None:
    """Where only the maker's travel limits a turned machine, both bounds are the volume of that box."""
    travel = ht.PoseLimits((-0.01, 0.02), (-0.03, 0.01), (-0.02, 0.02), (-0.1, 0.1), (-0.1, 0.1), (-0.1, 0.1))
    machine = replace(WIDE, limits=travel, home=ht.pose_from_coordinates([5, -10, 20, 3, -4, 6]))
    assert reachable_volume(machine).bounds == pytest.approx([0.03 * 0.04 * 0.04] * 2, rel=1e-12)
    assert reachable_volume(machine, turned(7, 0, 0)).bounds.tolist() == [0.0, 0.0]


def test_a_cap_of_a_sphere_is_measured() -> None:
    """One leg's longest length cuts a cap off a box, ``pi h^2 (3 r - h) / 3``: inside the bounds, to 0.1 %.

    The platform's x axis is laid along that leg, so that the box ends at a plane across it.
    """
    along = WIDE.jacobian(WIDE.home)[0, :3]
    other = np.cross(along, [0.0, 0.0, 1.0]) / np.linalg.norm(np.cross(along, [0.0, 0.0, 1.0]))
    home = np.eye(4)
    home[:3, :3] = np.column_stack([along, other, np.cross(along, other)])
    length, height = float(WIDE.inverse_kinematics(WIDE.home)[0]), 0.02
    stroke = np.tile([-0.5, 2.0], (6, 1))
    stroke[0, 1] = length + height - 0.6
    travel = ht.PoseLimits((0.0, 0.1), (-0.2, 0.2), (-0.2, 0.2), (-1, 1), (-1, 1), (-1, 1))
    machine = replace(
        WIDE, platform_joints=WIDE.platform_joints @ home[:3, :3], home=home, stroke=stroke, limits=travel
    )
    volume = reachable_volume(machine, resolution=0.001)
    exact = np.pi * height**2 * (3.0 * (length + height) - height) / 3.0
    assert volume.bounds[0] < exact < volume.bounds[1]
    assert volume.value == pytest.approx(exact, rel=0.001)


def test_bounds_of_finer_resolution_agree() -> None:
    """Every pair of bounds holds the truth, so all overlap, and finer ones are closer."""
    found = [reachable_volume(REFERENCE, turned(5, 5, 10), resolution=r).bounds for r in (0.2, 0.05, 0.01, 0.002)]
    assert max(low for low, _high in found) < min(high for _low, high in found)
    widths = [high - low for low, high in found]
    assert widths == sorted(widths, reverse=True)


def test_a_machine_twice_as_large_has_eight_times_the_volume() -> None:
    """All lengths doubled: eight times the volume, to the last bits."""
    assert REFERENCE.stroke is not None
    assert REFERENCE.retracted_length is not None
    home = np.array(REFERENCE.home)
    home[:3, 3] *= 2.0
    large = replace(
        REFERENCE, base_joints=2 * REFERENCE.base_joints, platform_joints=2 * REFERENCE.platform_joints, home=home,
        retracted_length=2 * REFERENCE.retracted_length, stroke=2 * REFERENCE.stroke,
    )  # fmt: skip
    assert reachable_volume(large).value == pytest.approx(8.0 * reachable_volume(REFERENCE).value, rel=1e-12)


def test_what_is_not_connected_with_home_does_not_count() -> None:
    """Below the base the same lengths are met in the mirror image, twice the volume in all: only home's half counts."""
    machine = replace(REFERENCE, base_cone=None, platform_cone=None)
    height = machine.home[2, 3] - machine.base_joints[0, 2]
    mirrored = np.array(machine.home)
    mirrored[2, 3] -= 2.0 * height
    assert np.abs(machine.inverse_kinematics(mirrored) - machine.inverse_kinematics(machine.home)).max() < 1e-12
    assert not margins(machine, mirrored).reachable
    assert reachable_volume(machine).value == pytest.approx(reachable_volume(REFERENCE).value, rel=0.02)


def test_a_part_behind_a_wall_does_not_count() -> None:
    """A leg's shortest length cuts a narrow travel in two, both parts on home's side of det J: home's counts."""
    unit = WIDE.jacobian(WIDE.home)[2, :3]
    across = np.cross(unit, [0.0, 0.0, 1.0]) / np.linalg.norm(np.cross(unit, [0.0, 0.0, 1.0]))
    home = np.eye(4)
    home[:3, :3] = np.column_stack([across, np.cross(unit, across), unit])
    home[:3, 3] = 0.08 * across
    stroke = np.tile([-0.5, 2.0], (6, 1))
    stroke[2, 0] = float(WIDE.inverse_kinematics(WIDE.home)[2]) + 0.002 - 0.6
    travel = ht.PoseLimits((-0.2, 0.04), (-0.001, 0.001), (-0.001, 0.001), (-1, 1), (-1, 1), (-1, 1))
    machine = replace(
        WIDE, platform_joints=WIDE.platform_joints @ home[:3, :3], home=home, stroke=stroke, limits=travel
    )
    x = np.linspace(-0.2, 0.04, 2401)
    _poses, found = workspace_grid(machine, x, np.linspace(-0.001, 0.001, 5), np.linspace(-0.001, 0.001, 5))
    assert not found.reachable[np.abs(x + 0.08) < 0.01].any()
    here, there = (found.reachable[part].sum() * 1e-4 * 4e-6 / 25 for part in (x > -0.08, x < -0.08))
    assert there > 0.2 * here
    assert reachable_volume(machine, resolution=0.001).value == pytest.approx(here, rel=0.01)


def test_the_other_side_of_a_singular_pose_does_not_count() -> None:
    """Turned by 120 degrees about z, two symmetric rings are beyond their singular pose at 90: nothing is reachable."""
    travel = ht.PoseLimits((-0.3, 0.3), (-0.3, 0.3), (-0.3, 0.3), (-1, 1), (-1, 1), (-3, 3))
    machine = replace(WIDE, limits=travel)
    volume = reachable_volume(machine, turned(0, 0, 120))
    assert volume.bounds.tolist() == [0.0, 0.0]
    assert not volume.reached
    assert reachable_volume(machine, turned(0, 0, 60)).bounds == pytest.approx([0.6**3] * 2, rel=1e-12)


def test_the_singular_surface_is_cubic(rng: np.random.Generator) -> None:
    """The polynomial from 125 points meets the determinant at 300 others, to 1e-12; its planes hold it over boxes."""
    low, size = np.array([-1.0, -1.2, -0.8]), np.array([2.0, 2.3, 1.9])
    for machine in (REFERENCE, ht.load_hexapod("rubin-m2"), general_machine(rng), general_machine(rng, pivot=3.0)):
        turn = turned(*rng.uniform(-40, 40, 3))

        def determinant(x: F64, machine: ht.Hexapod = machine, turn: F64 = turn) -> F64:
            arms = machine.platform_joints @ (machine.home[:3, :3] @ turn).T
            legs = (machine.home[:3, 3] + x @ machine.home[:3, :3].T)[:, None] + arms - machine.base_joints
            return np.asarray(
                np.linalg.det(np.concatenate([legs, np.cross(np.broadcast_to(arms, legs.shape), legs)], -1))
            )

        points = low + size * nodes()
        surface = singular_surface(machine, points, poses_from_home(machine, points, turn), low, size)
        x = low + size * rng.uniform(0.1, 0.9, (300, 3))
        expected = determinant(x)
        below, above, _slopes = surface.over_boxes(x, np.zeros((300, 3)))
        scale = (0.5 * (below + above) @ expected) / (expected @ expected)
        assert np.abs(0.5 * (below + above) / scale - expected).max() < 1e-12 * np.abs(expected).max()
        half = np.tile([0.1, 0.05, 0.07], (300, 1))
        below, above, slopes = surface.over_boxes(x, half)
        moved = scale * determinant(x + half * rng.uniform(-1.0, 1.0, (300, 3)))
        assert (below - slopes.sum(axis=1) <= moved).all()
        assert (moved <= above + slopes.sum(axis=1)).all()


def test_volumes_of_a_batch_of_orientations() -> None:
    """Leading shapes go through; each entry is what it is alone; a volume that no straight move reaches says so."""
    turns = np.array([[np.eye(3), turned(5, 0, 0)], [turned(0, 0, 120), turned(0, 0, 20)]])
    machine = replace(WIDE, stroke=[-0.2, 0.4])
    many = reachable_volume(machine, turns, resolution=0.1)
    assert many.value.shape == many.uncertainty.shape == many.reached.shape == (2, 2)
    assert many.bounds.shape == (2, 2, 2)
    for i in range(2):
        for j in range(2):
            one = reachable_volume(machine, turns[i, j], resolution=0.1)
            assert one.value == many.value[i, j]
            assert one.reached == many.reached[i, j]
    assert many.reached.tolist() == [[True, True], [False, True]]


def test_positions_of_a_volume_are_reached_by_straight_moves() -> None:
    """Points at another orientation are reachable exactly where a straight move from the middle is not refused."""
    poses, found = workspace_grid(
        REFERENCE, np.linspace(-0.2, 0.2, 9), 0.0, np.linspace(-0.15, 0.15, 9), turned(0, 8, 0)
    )
    moves = check_path(REFERENCE, poses[4, 0, 4], poses)
    assert 10 < found.reachable.sum() < 70
    assert np.array_equal(found.reachable, moves.ok)


@pytest.mark.parametrize(
    ("machine", "options", "message"),
    [
        (replace(REFERENCE, stroke=None), {}, "has no stroke"),
        (REFERENCE, {"rotation": np.eye(4)}, "rotation has shape"),
        (REFERENCE, {"rotation": 2 * np.eye(3)}, "no rotation matrix"),
        (REFERENCE, {"rotation": np.diag([1.0, 1.0, -1.0])}, "determinant must be 1"),
        (REFERENCE, {"resolution": 0.0}, "resolution must lie"),
        (REFERENCE, {"resolution": np.nan}, "resolution must lie"),
        (REFERENCE, {"resolution": "fine"}, "resolution must lie"),
    ],
)
def test_unusable_arguments_are_refused(machine: ht.Hexapod, options: dict[str, object], message: str) -> None:
    """No stroke, no rotation, a resolution that is no part: an error that says which."""
    with pytest.raises(ArgumentError, match=message):
        reachable_volume(machine, **options)  # type: ignore[arg-type]


def test_a_singular_home_has_no_side() -> None:
    """Six parallel legs do not hold the platform: the volume is refused, and no pose is called reachable."""
    machine = ht.Hexapod(
        REFERENCE.base_joints, REFERENCE.base_joints, home=[0, 0, 0.7], retracted_length=0.6, stroke=[0.0, 0.25]
    )
    with pytest.raises(SingularPoseError, match="is singular"):
        reachable_volume(machine)
    found = margins(machine, machine.home)
    assert not found.reachable
    assert found.worst is Limit.SINGULAR


slopes = st.one_of(st.just(0.0), st.floats(1e-6, 10.0))


@given(st.floats(-12.0, 12.0), st.tuples(slopes, slopes, slopes).filter(any))
def test_cut_of_a_box_is_bounded(a: float, w: tuple[float, float, float]) -> None:
    """Bounds of a cut hold what 40^3 cells of the box give, are close, and the two sides of a plane fill the box."""
    t = (np.arange(40) + 0.5) / 20.0 - 1.0
    height = a + w[0] * t[:, None, None] + w[1] * t[:, None] + w[2] * t
    cells = sum(w) / 40.0
    low, high = (height > cells).mean(), (height > -cells).mean()
    value, slope = np.array([a]), np.array([w])
    least, most = cut_bounds(value, value, slope)
    assert low - 1e-9 <= most[0]
    assert least[0] <= high + 1e-9
    assert 0.0 <= least[0] <= most[0] <= 1.0
    assert most[0] - least[0] < 0.01
    other_least, other_most = cut_bounds(-value, -value, slope)
    assert least[0] + other_most[0] == pytest.approx(1.0, abs=1e-9)
    assert most[0] + other_least[0] == pytest.approx(1.0, abs=1e-9)


def test_boxes_that_share_a_face() -> None:
    """64 boxes, one halved again: every pair found shares a face, none is left out, and a wall of holes parts them."""
    cells = root().halved().halved()
    one = np.arange(len(cells)) == 21
    cells = cells[~one].joined(cells[one].halved())
    centre, half = cells.boxes(np.zeros(3), np.ones(3))
    gap = np.abs(centre[:, None] - centre[None]) - half[:, None] - half[None]
    touching = (np.abs(gap) < 1e-12).sum(axis=2) == 1
    touching &= (gap < 1e-12).all(axis=2)
    a, b = neighbours(cells)
    found = np.zeros_like(touching)
    found[a, b] = found[b, a] = True
    assert np.array_equal(found, touching)
    left = centre[:, 0] < 0.5
    wall = (centre[:, 0] > 0.25) & left
    assert np.array_equal(connected(cells, (a, b), ~wall, int(np.flatnonzero(left & ~wall)[0])), left & ~wall)
    assert connected(cells, (a, b), np.ones(len(cells), np.bool_), 0).all()


def test_grid_counts_from_home() -> None:
    """Entry (i, j, k) is the pose that a controller's coordinates mean, turns come first in the shape."""
    machine = CONES
    x, y, z = [-0.02, 0.0, 0.03], [0.01], [-0.05, 0.04]
    turns = np.stack([np.eye(3), turned(2, 3, 4)])
    poses, found = workspace_grid(machine, x, y, z, turns)
    assert poses.shape == (2, 3, 1, 2, 4, 4)
    assert found.stroke.shape == (2, 3, 1, 2, 6)
    for i, k in ((0, 1), (2, 0)):
        expected = ht.pose_from_coordinates([1e3 * x[i], 10.0, 1e3 * z[k], 2, 3, 4], hexapod=machine)
        assert np.abs(poses[1, i, 0, k] - expected).max() < 1e-15
    assert np.array_equal(found.base_cone, margins(machine, poses).base_cone)
    asked = workspace_grid(machine, 0.0, 0.0, [-0.01, 0.01], collisions=True)[1]
    assert (asked.clearance > 0.0).all()
    with pytest.raises(ArgumentError, match="y has shape"):
        workspace_grid(machine, x, [[0.0]], z)
