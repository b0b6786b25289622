"""Forces in the legs under a weight, against Pinocchio's closed loop and against virtual work."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import hexathermal as ht
from hexathermal.errors import SingularPoseError
from hexathermal.kinematics.statics import leg_forces, payload_sag
from hexathermal.machine.compliance import Compliance
from hexathermal.machine.pinocchio_model import PinocchioMachine
from tests.machine.mechanisms import FORCE_N, MACHINES, poses


@pytest.mark.parametrize("name", MACHINES)
def test_forces_are_those_of_pinocchio(name: str, rng: np.random.Generator) -> None:
    """What a payload adds to Pinocchio's actuator forces (which hold platform and legs too) is `leg_forces`, 1e-9 N."""
    hexapod = MACHINES[name]()
    for pose in poses(hexapod, 4):
        mass, centre, gravity = rng.uniform(1.0, 80.0), rng.normal(size=3) * 0.1, rng.normal(size=3) * 6.0
        loaded = PinocchioMachine(hexapod, mass, centre, gravity).leg_forces(pose)
        alone = PinocchioMachine(hexapod, gravity=gravity).leg_forces(pose)
        own = leg_forces(hexapod, pose, mass * gravity, centre)
        assert np.abs(loaded - alone - own).max() < FORCE_N * max(1.0, np.abs(loaded).max())
        soft = dataclasses.replace(hexapod, compliance=Compliance(2e-8, mass, centre, gravity))
        assert np.array_equal(payload_sag(soft, pose), -2e-8 * own)


def test_the_sag_does_the_work_of_the_weight(reference: ht.Hexapod, rng: np.random.Generator) -> None:
    """``F . dL`` of a small motion is the work that lifting the weight takes, by positions alone, to 1e-9 of it."""
    weight, centre, h = np.array([30.0, -20.0, -400.0]), np.array([0.05, 0.02, 0.3]), 1e-6
    pose = ht.pose_from_coordinates([5, -8, 12, 2, -3, 4])
    forces = leg_forces(reference, pose, weight, centre)
    for coordinates in rng.normal(size=(5, 6)):
        step = ht.pose_from_coordinates(coordinates * 1e3 * h)
        above, below = pose @ step, pose @ np.linalg.inv(step)
        stretched = reference.inverse_kinematics(above) - reference.inverse_kinematics(below)
        lifted = (above - below)[:3, :3] @ centre + (above - below)[:3, 3]
        assert abs(forces @ stretched + weight @ lifted) < 1e-9 * np.abs(forces * stretched).sum() + 1e-15


def test_forces_are_linear_in_weight_and_moment(reference: ht.Hexapod, rng: np.random.Generator) -> None:
    """Forces of many poses are sums of those of a weight at the origin and of its moments, with leading shapes kept."""
    some = ht.pose_from_coordinates(rng.uniform(-5, 5, (2, 3, 6)))
    weight, centre = rng.normal(size=3) * 100.0, rng.normal(size=3)
    at_origin = leg_forces(reference, some, weight, np.zeros(3))
    moments = [leg_forces(reference, some, weight, axis) - at_origin for axis in np.eye(3)]
    whole = at_origin + np.einsum("k,k...->...", centre, np.array(moments))
    assert whole.shape == (2, 3, 6)
    assert np.abs(leg_forces(reference, some, weight, centre) - whole).max() < 1e-9


def test_a_platform_that_is_not_held_is_refused() -> None:
    """A platform turned by 90 degrees (Fichter's singularity) has no leg forces, said with its place in the batch."""
    hexapod = MACHINES["plain"]()
    turned = hexapod.home @ ht.pose_from_coordinates([0, 0, 0, 0, 0, 90])
    some = np.array([[hexapod.home], [turned]])
    with pytest.raises(SingularPoseError, match=r"at index \(1, 0\).*move away") as caught:
        leg_forces(hexapod, some, np.array([0.0, 0.0, -1.0]), np.zeros(3))
    assert caught.value.index == (1, 0)
    assert caught.value.upper == 1e7
