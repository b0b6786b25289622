"""Machines and lengths that legs do not hold, and singular postures that they do."""

from __future__ import annotations

import numpy as np
import pytest

from hexathermal.kinematics.holding import architecturally_singular
from hexathermal.kinematics.modes import assembly_modes
from tests.kinematics.test_modes import F64, Machine, distance_to, draw, lengths_at, ring, rotation, transform

HEXAGON = ring(1.0, 30.0, 0.0)
SPATIAL = np.random.default_rng(4).normal(size=(6, 3))
MOVABLE = {  # base and platform joints that no six lengths hold
    "point platform": (HEXAGON, 0.0 * HEXAGON),
    "point platform far from its origin": (HEXAGON, 0.0 * HEXAGON + [0.1, 0.2, 0.3]),
    "point base": (0.0 * HEXAGON + [0.1, 0.2, 0.3], HEXAGON),
    "similar hexagons": (HEXAGON, 0.5 * HEXAGON),
    "equal hexagons": (HEXAGON, HEXAGON),
    "similar hexagons, turned and moved": (HEXAGON, 0.5 * HEXAGON @ rotation(np.array([1, 2, 3, 4])).T + [3, 1, 2]),
    "joints rounded to 1e-9": (HEXAGON, np.round(0.37 * HEXAGON, 9)),
    "stretched ring of pairs": (ring(1.0, 12.0, 0.0), ring(1.0, 12.0, 0.0) * [0.5, -0.8, 1.0]),
    "base on a line": (SPATIAL * [1, 0, 0], SPATIAL[::-1]),
    "four legs from one point": (SPATIAL[[0, 0, 0, 0, 1, 2]], SPATIAL[::-1]),
}


@pytest.mark.parametrize("name", MOVABLE)
@pytest.mark.parametrize("height", [0.5, 1.0, 1.3, 2.0])
def test_an_architecturally_singular_machine_has_no_complete_list(name: str, height: float) -> None:
    """Legs that hold the machine at no pose: `complete` is False at every height, and nothing is claimed found."""
    base, platform = MOVABLE[name]
    modes = assembly_modes(base, platform, np.linalg.norm(platform + [0, 0, height] - base + 1e-3, axis=1))
    assert architecturally_singular(base, platform)
    assert not modes.complete
    assert (len(modes.poses), modes.complex_solutions, modes.paths_failed) == (0, 0, 40)


@pytest.mark.parametrize("name", MOVABLE)
def test_architecturally_singular_machines_have_dependent_legs_everywhere(name: str) -> None:
    """At random poses the six rows [d, s x d], worked out here, have rank 5 or less."""
    base, platform = MOVABLE[name]
    random = np.random.default_rng(8)
    for _ in range(20):
        arms = (platform - platform.mean(axis=0)) @ rotation(random.normal(size=4)).T
        legs = arms + random.normal(size=3) - (base - base.mean(axis=0))
        values = np.linalg.svd(np.column_stack([legs, np.cross(arms, legs)]), compute_uv=False)
        assert values[-1] < 1e-8 * values[0]


@pytest.mark.parametrize("kind", ["general", "planar", "ring with tolerances", "small platform", "octahedral"])
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_useful_machines_are_not_architecturally_singular(kind: str, scale: float) -> None:
    """Machines of any size, a far pivot and a platform of a thousandth of the base are not called singular."""
    for seed in range(20):
        base, platform, _, _ = draw(kind, seed)
        assert not architecturally_singular(scale * base, scale * platform)
        assert not architecturally_singular(scale * base, scale * (platform + [0.0, 0.0, 2.2]))
        assert not architecturally_singular(scale * base, 1e-3 * scale * platform)


@pytest.mark.parametrize("seed", range(4))
def test_similar_plates_off_any_conic_are_not_architecturally_singular(seed: int) -> None:
    """It takes more than equal shapes: six joints that lie on no conic hold a machine of similar plates."""
    base = draw("planar", seed)[0]
    assert not architecturally_singular(base, 0.5 * base)


def half_turn_machine(seed: int) -> Machine:
    """Return Bricard's line-symmetric octahedron: equal triangles, one the image of the other in a half turn."""
    random = np.random.default_rng(seed)
    corners = random.normal(size=(3, 3))
    base, platform = corners[[0, 0, 1, 1, 2, 2]], corners[[1, 2, 2, 0, 0, 1]]
    pose = transform(np.concatenate([[0.0], random.normal(size=3)]), np.zeros(3))
    point = 0.5 * random.normal(size=3)
    pose[:3, 3] = point - pose[:3, :3] @ point
    return base, platform, pose, lengths_at(base, platform, pose)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(6))
def test_a_flexible_octahedron_has_no_complete_list(seed: int) -> None:
    """Held by its legs at most lengths, movable at these (Bricard 1897): `complete` is False."""
    base, platform, _, lengths = half_turn_machine(seed)
    assert not architecturally_singular(base, platform)
    modes = assembly_modes(base, platform, lengths)
    assert not modes.complete
    assert modes.paths_failed > 0
    assert assembly_modes(base, platform, lengths * [1.0, 1.01, 1.02, 1.0, 0.99, 0.98]).complete


@pytest.mark.long
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("flat", [False, True])
def test_equal_plates_on_equal_legs_have_no_complete_list(seed: int, flat: bool) -> None:
    """Equal plates translate on equal legs like a parallelogram: `complete` is False."""
    base = draw("general", seed)[0] * [1, 1, 0 if flat else 1]
    assert not assembly_modes(base, base, np.full(6, 1.3)).complete


def fold(kind: str, seed: int) -> Machine | None:
    """Return a machine at a singular pose, where two postures meet; None if the seed has none."""
    base, platform, _, _ = draw(kind, seed)
    random = np.random.default_rng(seed)
    axis, shift = random.normal(size=3), random.normal(size=3)
    axis /= np.linalg.norm(axis)

    def at(angle: float) -> tuple[F64, bool]:
        pose = transform(np.concatenate([[np.cos(angle)], np.sin(angle) * axis]), shift)
        arms = platform @ pose[:3, :3].T
        legs = arms + shift - base
        return pose, bool(np.linalg.det(np.column_stack([legs, np.cross(arms, legs)])) > 0)

    angles = np.linspace(0.0, np.pi, 200)
    signs = np.array([at(angle)[1] for angle in angles])
    changes = np.flatnonzero(signs[1:] != signs[:-1])
    if len(changes) == 0:
        return None
    low, high = angles[changes[0] : changes[0] + 2]
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if at(middle)[1] == signs[changes[0]] else (low, middle)
    pose = at(low)[0]
    return base, platform, pose, lengths_at(base, platform, pose)


@pytest.mark.long
@pytest.mark.parametrize("kind", ["general", "planar", "octahedral"])
def test_a_double_posture_leaves_the_list_complete(kind: str) -> None:
    """At a fold the machine cannot move: complete, the double posture listed once, no more poses than solutions."""
    machines = [machine for seed in range(10) if (machine := fold(kind, seed))]
    assert len(machines) > 5
    for base, platform, pose, lengths in machines:
        modes = assembly_modes(base, platform, lengths)
        assert modes.complete
        assert distance_to(modes, pose) < 1e-6
        assert len(modes.poses) <= modes.complex_solutions
        apart = np.abs(modes.poses[:, None] - modes.poses[None]).max(axis=(2, 3)) + np.eye(len(modes.poses))
        assert apart.min() > 1e-4


@pytest.mark.parametrize("seed", range(3))
def test_a_flattened_machine_is_isolated(seed: int) -> None:
    """Planar plates in one plane: three free motions at first order, yet one posture of multiplicity 8, complete."""
    base, platform, _, _ = draw("planar", seed)
    pose = transform(np.array([1.0, 0, 0, 0.3]), np.array([0.3, 0.2, 0]))
    modes = assembly_modes(base, platform, lengths_at(base, platform, pose))
    assert modes.complete
    assert distance_to(modes, pose) < 1e-6
