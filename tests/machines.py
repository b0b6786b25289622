"""Random machines and poses for tests."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

import hexathermal as ht

TRAVEL = {
    "reference": (50.0, 50.0, 50.0, 10.0, 10.0, 10.0),
    "rubin-camera": (11.4, 11.4, 13.1, 0.36, 0.36, 0.1),
    "rubin-m2": (10.5, 10.5, 8.9, 0.175, 0.175, 0.05),
}


def random_poses(hexapod: ht.Hexapod, count: int, rng: np.random.Generator) -> np.ndarray:
    """Return poses within the machine's travel whose legs are all inside their strokes."""
    travel = np.array(TRAVEL[hexapod.name])
    poses = []
    while sum(map(len, poses)) < count:
        some = ht.pose_from_coordinates(rng.uniform(-1, 1, (2 * count, 6)) * travel, hexapod=hexapod)
        poses.append(some[inside(hexapod, oracle_lengths(hexapod, some))])
    return np.concatenate(poses)[:count].copy()


def inside(hexapod: ht.Hexapod, lengths: np.ndarray) -> np.ndarray:
    """Return which sets of lengths are inside the strokes."""
    low, high = hexapod.length_limits
    return ((lengths >= low) & (lengths <= high)).all(axis=-1)


def oracle_lengths(hexapod: ht.Hexapod, poses: np.ndarray) -> np.ndarray:
    """Return leg lengths by a second path: extended precision, written from the definition."""
    T = np.asarray(poses, dtype=np.longdouble)
    p, b = hexapod.platform_joints.astype(np.longdouble), hexapod.base_joints.astype(np.longdouble)
    d = np.einsum("...ij,kj->...ki", T[..., :3, :3], p) + T[..., None, :3, 3] - b
    return np.sqrt((d * d).sum(axis=-1))


def general_machine(rng: np.random.Generator, pivot: float = 0.0) -> ht.Hexapod:
    """Return a well-conditioned machine with scattered joints; the platform's origin lies `pivot` metres below."""
    while True:
        angles = np.sort(rng.uniform(0, 2 * np.pi, (2, 6)), axis=1)
        base = np.stack([0.4 * np.cos(angles[0]), 0.4 * np.sin(angles[0]), rng.uniform(-0.08, 0.08, 6)], axis=1)
        top = np.stack([0.3 * np.cos(angles[1] + 0.5), 0.3 * np.sin(angles[1] + 0.5), rng.uniform(-0.05, 0.05, 6)], 1)
        machine = ht.Hexapod(base, top + [0, 0, pivot], home=[0.0, 0.0, 0.5 - pivot], name="general")
        if (
            machine.solve_forward(oracle_lengths(machine, machine.home).astype(float), machine.home).condition_number
            < 25
        ):
            return machine


def rotation(vector: np.ndarray) -> np.ndarray:
    """Return the rotation of a rotation vector."""
    return Rotation.from_rotvec(vector).as_matrix()
