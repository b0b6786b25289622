"""Drawn hexapod campaigns with known laws; the true pose comes from a solver of its own, not from the package's."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

import hexathermal as ht
from hexathermal.kinematics.sampled_poses import reachable_coordinates
from hexathermal.learn.hexapod_data import HexapodRows

NOISE = np.array([4e-7, 4e-7, 4e-7, 1e-6, 1e-6, 1e-6])
EQUAL = np.tile([2.0e-6, 1.1e-6], (6, 1))
UNEQUAL = EQUAL * (1.0 + 0.15 * np.array([[1, -1], [-1, 1], [1, 1], [-1, -1], [0.5, 0], [0, -0.5]]))
PLATES = np.array([11e-6, 6e-6])


def machine() -> ht.Hexapod:
    """The reference machine with its base frame in the plane of the base joints, without a law."""
    import dataclasses

    made = ht.load_hexapod("reference")
    home = made.home.copy()
    home[2, 3] += 0.6633
    return dataclasses.replace(made, base_joints=made.base_joints + [0, 0, 0.6633], home=home, thermal=None)


def stood(base: np.ndarray, platform: np.ndarray, lengths: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Return the poses (n, 4, 4) at which legs (n, 6) reach from base to platform joints (n, 6, 3): Newton's method
    with numerical derivatives, written from the definition of a leg.
    """
    t, R = start[:, :3, 3].copy(), Rotation.from_matrix(start[:, :3, :3])

    def miss(shift: np.ndarray, turn: np.ndarray) -> np.ndarray:
        turned = (Rotation.from_rotvec(turn) * R).as_matrix()
        d = (t + shift)[:, None] + np.einsum("nij,nkj->nki", turned, platform) - base
        return np.linalg.norm(d, axis=2) - lengths

    for _step in range(6):
        zero, h = np.zeros_like(t), 1e-5
        J = np.empty((len(t), 6, 6))
        for k in range(6):
            d = np.zeros_like(t)
            d[:, k % 3] = h
            pair = [miss(s * d, zero) if k < 3 else miss(zero, s * d) for s in (1, -1)]
            J[:, :, k] = (pair[0] - pair[1]) / (2 * h)
        step = np.linalg.solve(J, -miss(zero, zero)[..., None])[..., 0]
        t, R = t + step[:, :3], Rotation.from_rotvec(step[:, 3:]) * R
    assert np.abs(miss(np.zeros_like(t), np.zeros_like(t))).max() < 1e-12
    pose = np.tile(np.eye(4), (len(t), 1, 1))
    pose[:, :3, :3], pose[:, :3, 3] = R.as_matrix(), t
    return pose


def temperatures(rng: np.random.Generator, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a run's dT of six legs (n, 6) and of two plates (n, 2): each its own slow course from 0."""
    x = np.linspace(0.0, 1.0, n)[:, None]
    rise = rng.uniform(3.0, 8.0, 8) * [1, 1, 1, 1, 1, 1, 0.4, 0.4]
    both = rise * np.sin(np.pi * x * rng.uniform(0.6, 1.4, 8)) ** 2
    return both[:, :6], both[:, 6:]


def drawn_rows(
    rng: np.random.Generator,
    laws: np.ndarray = EQUAL,
    *,
    runs: int = 4,
    poses: int = 40,
    noise: np.ndarray = NOISE,
    frame: float = 5e-7,
    plates: np.ndarray = PLATES,
    coordinates: np.ndarray | None = None,
    slow: float = 0.0,
) -> HexapodRows:
    """Return a campaign: each leg with its law (6, 2) [1/K], plates that expand, noise, a frame (m, 2 x rad) drawn for
    each run, and `slow`: deviations of the legs [m] that go along with their temperatures, other ones in each run.
    """
    hexapod = machine()
    found = []
    for run in range(runs):
        six = reachable_coordinates(hexapod, poses, rng) if coordinates is None else coordinates
        commanded = ht.pose_from_coordinates(six, hexapod=hexapod)
        q = hexapod.strokes(hexapod.inverse_kinematics(commanded))
        dT, plate = temperatures(rng, len(six))
        lengths = 0.6 + q + (laws[:, 0] * 0.6 + laws[:, 1] * q) * dT
        lengths = lengths + slow * rng.standard_normal(6) * dT / 5.0
        grown = 1.0 + plate * plates
        true = stood(hexapod.base_joints * grown[:, 1, None, None], hexapod.platform_joints * grown[:, 0, None, None],
                     lengths, commanded)  # fmt: skip
        shift, turn = frame * rng.standard_normal(3), 2.0 * frame * rng.standard_normal(3)
        home, F = hexapod.home[:3, 3], Rotation.from_rotvec(turn).as_matrix()
        seen = true.copy()
        seen[:, :3, :3] = F @ true[:, :3, :3]
        seen[:, :3, 3] = home + (true[:, :3, 3] - home) @ F.T + shift
        drawn = noise * rng.standard_normal((len(six), 6)) * np.array([1e3] * 3 + [180 / np.pi] * 3)
        seen = ht.pose_from_coordinates(ht.coordinates_from_pose(seen, hexapod=hexapod) + drawn, hexapod=hexapod)
        found.append((np.full(len(six), run), np.arange(len(six)) * 60.0, commanded, seen, q, dT[..., None], plate))
    return HexapodRows(hexapod, ("T1",), ("T1", "T1"), tuple(f"run-{k + 1}" for k in range(runs)),
                       *(np.concatenate(part) for part in zip(*found, strict=True)),
                       np.full((6, 1), 20.0), np.full(2, 20.0))  # fmt: skip
