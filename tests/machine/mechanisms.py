"""Machines, poses and independent geometry for the tests of the mechanism."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pinocchio as pin
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from hexathermal.machine.bodies import Bodies
from hexathermal.machine.hexapod import Hexapod

F64 = npt.NDArray[np.float64]

CLOSURE_M = 1e-13
LENGTH_M = 1e-12
POSE = 1e-11
"""Largest error of any entry of a pose, metres or rotation."""
JACOBIAN = 1e-7
FORCE_N = 1e-9
G = 9.80665
HEAVY = Bodies(0.06, 0.04, leg_body_mass=7.0, leg_rod_mass=3.0, platform_mass=40.0, platform_thickness=0.02)
LIGHT = Bodies(0.06, 0.04, platform_mass=40.0, platform_thickness=0.02)


def ring(radius: float, half_deg: float) -> F64:
    """Return six joints in three pairs on a circle about the origin."""
    angles = np.radians([120.0 * k + side * half_deg for k in range(3) for side in (-1.0, 1.0)])
    return np.column_stack([radius * np.cos(angles), radius * np.sin(angles), np.zeros(6)])


def plain() -> Hexapod:
    """Return the usual machine: joints on two circles, legs 0.55 to 0.80 m, 0.63 m at home."""
    return Hexapod(
        ring(0.35, 15.0),
        ring(0.25, 45.0),
        retracted_length=np.array(0.55),
        stroke=np.array([0.0, 0.25]),
        home=np.array([0.0, 0.0, 0.6]),
        base_cone=np.radians(np.full(6, 25.0)),
        platform_cone=np.radians(np.full(6, 30.0)),
        bodies=HEAVY,
    )


def general() -> Hexapod:
    """Return a machine without any symmetry: joints in space, home turned, no stroke, no bodies."""
    random = np.random.default_rng(20240611)
    home = pin.SE3(pin.exp3(np.array([0.3, -0.2, 0.5])), np.array([0.1, -0.2, 0.9])).homogeneous
    spread = 0.1
    base = ring(0.5, 20.0) + random.uniform(-spread, spread, (6, 3)) + [0.3, 0.1, -0.2]
    platform = ring(0.3, 38.0) + random.uniform(-spread, spread, (6, 3)) + [0.05, 0.1, 0.15]
    return Hexapod(base, platform, home=home)


def far_pivot() -> Hexapod:
    """Return the usual machine, its platform frame at a point of interest 5 m above the joints."""
    shift = np.array([0.2, -0.3, 5.0])
    return replace(plain(), platform_joints=ring(0.25, 45.0) - shift, home=shift + np.array([0.0, 0.0, 0.6]))


MACHINES = {"plain": plain, "general": general, "far pivot": far_pivot}


def moved(hexapod: Hexapod, shift: npt.ArrayLike, turn: npt.ArrayLike) -> F64:
    """Return home, its platform joints turned about their centroid and shifted [m, rad]."""
    centre = pin.SE3(np.eye(3), hexapod.platform_joints.mean(axis=0))
    motion = pin.SE3(pin.exp3(np.asarray(turn, dtype=float)), np.asarray(shift, dtype=float))
    return np.array((pin.SE3(hexapod.home) * centre * motion * centre.inverse()).homogeneous)


def poses(hexapod: Hexapod, count: int, seed: int = 7) -> list[F64]:
    """Return poses within 80 mm and 0.3 rad of home, along and about each axis."""
    random = np.random.default_rng(seed)
    spread = zip(random.uniform(-0.08, 0.08, (count, 3)), random.uniform(-0.3, 0.3, (count, 3)), strict=True)
    return [moved(hexapod, shift, turn) for shift, turn in spread]


def joints_at(hexapod: Hexapod, pose: F64) -> F64:
    return np.asarray(hexapod.platform_joints @ pose[:3, :3].T + pose[:3, 3])


def lengths_at(hexapod: Hexapod, pose: F64) -> F64:
    return np.asarray(np.linalg.norm(joints_at(hexapod, pose) - hexapod.base_joints, axis=1))


def directions_at(hexapod: Hexapod, pose: F64) -> F64:
    legs = joints_at(hexapod, pose) - hexapod.base_joints
    return np.asarray(legs / np.linalg.norm(legs, axis=1, keepdims=True))


def segment_distance(a: F64, b: F64) -> float:
    """Return the distance of two segments, each (2, 3), as a least-squares problem with bounds."""
    matrix = np.column_stack([a[1] - a[0], b[0] - b[1]])
    found = lsq_linear(matrix, b[0] - a[0], bounds=(0.0, 1.0), method="bvls")
    return float(np.linalg.norm(matrix @ found.x - (b[0] - a[0])))


small = st.floats(-1.0, 1.0, allow_subnormal=False)
triples = st.tuples(small, small, small).map(np.array)
