"""All postures of a `Hexapod`: a published machine, batches, and lists that cannot be complete."""

from __future__ import annotations

import numpy as np
import pytest

from hexathermal import Hexapod, load_hexapod
from hexathermal.errors import ArgumentError, KinematicsError
from tests.kinematics.test_holding import MOVABLE, half_turn_machine
from tests.kinematics.test_modes import DIETMAIER_BASE, DIETMAIER_LENGTHS, DIETMAIER_PLATFORM


def test_dietmaiers_machine_through_the_hexapod() -> None:
    """40 postures: each has the lengths to 1e-12 sizes, and is found again by forward kinematics started at it."""
    hexapod = Hexapod(DIETMAIER_BASE, DIETMAIER_PLATFORM, home=[0.1, 0.2, 1.0])
    modes = hexapod.assembly_modes(DIETMAIER_LENGTHS)
    size = DIETMAIER_LENGTHS.max()
    assert modes.shape == (40, 4, 4)
    assert np.abs(hexapod.inverse_kinematics(modes) - DIETMAIER_LENGTHS).max() < 1e-12 * size
    for mode in modes:
        assert np.abs(hexapod.forward_kinematics(DIETMAIER_LENGTHS, guess=mode) - mode).max() < 1e-9


def test_one_set_of_lengths_gives_a_list_of_poses() -> None:
    """Lengths (6,) give (k, 4, 4), home among them; lengths that no pose has give k = 0."""
    hexapod = load_hexapod("reference")
    home = hexapod.inverse_kinematics(hexapod.home)
    modes = hexapod.assembly_modes(home)
    assert modes.ndim == 3
    assert np.abs(modes - hexapod.home).max(axis=(1, 2)).min() < 1e-12
    assert hexapod.assembly_modes(home * [1, 1, 1, 1, 1, 5]).shape == (0, 4, 4)


def test_a_batch_is_filled_up_with_nan() -> None:
    """Lengths (2, 1, 6) give (2, 1, k, 4, 4): each list as alone, the shorter one filled up with NaN."""
    hexapod = load_hexapod("reference")
    home = hexapod.inverse_kinematics(hexapod.home)
    alone = hexapod.assembly_modes(home)
    modes = hexapod.assembly_modes(np.stack([home, home * [1, 1, 1, 1, 1, 5]])[:, None])
    assert modes.shape == (2, 1, *alone.shape)
    assert np.array_equal(modes[0, 0], alone)
    assert np.isnan(modes[1, 0]).all()


@pytest.mark.parametrize("lead", [(0,), (0, 3), (2, 0)])
def test_an_empty_batch_gives_an_empty_list(lead: tuple[int, ...]) -> None:
    """Lengths (0, 6) give (0, 0, 4, 4), also on a machine that would be refused."""
    machines = [load_hexapod("reference"), Hexapod(*MOVABLE["similar hexagons"], home=[0, 0, 1])]
    for hexapod in machines:
        assert hexapod.assembly_modes(np.empty((*lead, 6))).shape == (*lead, 0, 4, 4)


@pytest.mark.parametrize("name", MOVABLE)
@pytest.mark.parametrize("height", [0.5, 1.0, 1.3, 2.0])
def test_an_architecturally_singular_machine_is_refused(name: str, height: float) -> None:
    """Legs that hold the machine at no pose: the error says that the machine, not the search, is at fault."""
    hexapod = Hexapod(*MOVABLE[name], home=[1e-3, 2e-3, height])
    lengths = hexapod.inverse_kinematics(hexapod.home)
    with pytest.raises(KinematicsError, match="architecturally singular, its legs do not hold it at any pose"):
        hexapod.assembly_modes(lengths)
    with pytest.raises(KinematicsError, match="postures at index 0 cannot be listed") as caught:
        hexapod.assembly_modes(lengths[None])
    assert caught.value.index == (0,)


def test_lengths_that_let_a_sound_machine_move_are_refused() -> None:
    """A flexible octahedron: the error names the place in the batch and how many paths stayed open."""
    base, platform, pose, lengths = half_turn_machine(1)
    hexapod = Hexapod(base, platform, home=pose)
    fine = lengths * [1.0, 1.01, 1.02, 1.0, 0.99, 0.98]
    hexapod.assembly_modes(fine)
    with pytest.raises(KinematicsError, match=r"at index 1 could not all be found: \d+ of 40 paths") as caught:
        hexapod.assembly_modes([fine, lengths])
    assert caught.value.index == (1,)
    assert caught.value.value is not None
    assert 0 < caught.value.value <= 40


@pytest.mark.parametrize("lengths", [np.ones(5), np.zeros(6), np.full(6, np.nan), np.empty((0, 5))])
def test_unusable_lengths_are_refused(lengths: np.ndarray) -> None:
    """A wrong shape, a length of 0, a value that is not finite."""
    with pytest.raises(ArgumentError):
        load_hexapod("reference").assembly_modes(lengths)
