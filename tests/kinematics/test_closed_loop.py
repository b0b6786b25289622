"""The formula and the mechanism: the compiled equations against Pinocchio's closed loops, for every bundled machine."""

from __future__ import annotations

import numpy as np

import hexathermal as ht
from hexathermal.machine.pinocchio_model import PinocchioMachine
from tests.machines import random_poses


def test_lengths_jacobians_and_poses_agree_with_the_closed_loop(hexapod: ht.Hexapod, rng: np.random.Generator) -> None:
    """Lengths and Jacobians agree to 1e-12 with Pinocchio's closed loop, forward kinematics to 1e-12 m."""
    mechanism = PinocchioMachine(hexapod)
    for pose in random_poses(hexapod, 40, rng):
        lengths = hexapod.inverse_kinematics(pose)
        assert np.abs(mechanism.leg_lengths(pose) - lengths).max() < 1e-12
        assert np.abs(mechanism.jacobian(pose) - hexapod.jacobian(pose)).max() < 1e-12
        assert np.abs(mechanism.forward(lengths) - hexapod.forward_kinematics(lengths)).max() < 1e-12
