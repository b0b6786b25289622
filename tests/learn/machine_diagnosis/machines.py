"""Drawn campaigns of a machine with one thing wrong; the true pose comes from a solver of the tests' own."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

import hexathermal as ht
from hexathermal.kinematics.sampled_poses import reachable_coordinates
from hexathermal.learn.hexapod_data import HexapodRows
from tests.learn.hexapods import NOISE, machine, stood, temperatures

A, B = 2.0e-6, 1.1e-6
PLATES = (11e-6, 6e-6)
GRAVITY = np.array([0.0, 0.0, -1.0])


@dataclass(frozen=True)
class Fault:
    """What is wrong with the true machine; nothing by default. SI units."""

    legs: tuple[tuple[int, float, float], ...] = ()
    platform: float = 0.0
    base: float = 0.0
    swapped: tuple[int, int] | None = None
    sag: float = 0.0
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0)
    base_joint: tuple[int, tuple[float, float, float]] | None = None
    platform_joint: tuple[int, tuple[float, float, float]] | None = None
    tracker: tuple[float, ...] = (0.0,) * 6
    backlash: tuple[int, float] | None = None
    later: tuple[int, float] | None = None
    """A leg, and by how much it is longer in the second half of each run: no cause of the catalogue."""
    friction: float = 0.0
    """Step of every leg at its reversals, each by its own share: no cause of the catalogue."""
    bent: tuple[int, float] | None = None
    """A leg, and by how much it is longer along a wave of x and y: no cause of the catalogue."""
    loud: tuple[int, float] | None = None
    """A run, and how many times as much its second half scatters."""


def filed(**changes: object) -> ht.Hexapod:
    """The machine as its file has it: one law for all legs, both plates known and measured."""
    thermal = ht.ThermalModel(ht.LegLaw("T1", A, B), ht.PlateLaw(PLATES[0], "T1"), ht.PlateLaw(PLATES[1], "T1"))
    return replace(machine(), thermal=replace(thermal, **changes))


def drawn(
    seed: int, fault: Fault | None = None, *, runs: int = 4, poses: int = 60, noise: np.ndarray = NOISE,
    frame: float = 0.0, tails: float = np.inf, cold: bool = False, share: float = 1.0, apart: float | None = None,
    misread: float = 0.0,
) -> HexapodRows:  # fmt: skip
    """Return rows of a campaign: `frame` draws an offset of the tracker for each run [m, rad], `tails` the degrees of
    freedom of its noise, `cold` leaves all temperatures as they are, `share` is the part of the workspace used,
    `apart` makes all legs as warm but the first two, by waves of that size [K], `misread` is the noise of readings [K].
    """
    fault, rng, hexapod = fault or Fault(), np.random.default_rng(seed), filed()
    found = []
    for run in range(runs):
        six = reachable_coordinates(hexapod, poses, rng) * share
        commanded = ht.pose_from_coordinates(six, hexapod=hexapod)
        q = hexapod.strokes(hexapod.inverse_kinematics(commanded))
        dT, plate = temperatures(rng, poses)
        if apart is not None:
            wave = apart * np.sin(np.arange(poses) / 12.0)
            dT = dT[:, 2:3] + wave[:, None] * np.array([1.0, -1.0, 0.0, 0.0, 0.0, 0.0])
        air = 3.0 * np.sin(np.linspace(0.0, rng.uniform(2.0, 6.0), poses))
        if cold:
            dT, plate, air = 0.0 * dT, 0.0 * plate, 0.0 * air
        seen = _measured(hexapod, fault, commanded, q, dT, plate)
        motion = np.asarray(fault.tracker) * air[:, None] + frame * rng.standard_normal(6)
        seen = _moved(seen, motion, hexapod.home[:3, 3])
        scatter = rng.standard_normal((poses, 6))
        if np.isfinite(tails):
            scatter *= np.sqrt((tails - 2.0) / rng.chisquare(tails, (poses, 1)))
        if fault.loud is not None and fault.loud[0] == run:
            scatter[poses // 2 :] *= fault.loud[1]
        drawn_noise = noise * scatter * np.array([1e3] * 3 + [180.0 / np.pi] * 3)
        six_seen = ht.coordinates_from_pose(seen, hexapod=hexapod) + drawn_noise
        read = dT.copy()
        if fault.swapped is not None:
            read[:, list(fault.swapped)] = dT[:, list(reversed(fault.swapped))]
        if misread:
            read += misread * rng.standard_normal(read.shape)
        found.append((np.full(poses, run), np.arange(poses) * 60.0, commanded,
                      ht.pose_from_coordinates(six_seen, hexapod=hexapod), q, read[..., None], plate, air))  # fmt: skip
    parts = [np.concatenate(part) for part in zip(*found, strict=True)]
    return HexapodRows(hexapod, ("T1",), ("T1", "T1"), tuple(f"run-{k + 1}" for k in range(runs)), *parts[:-1],
                       np.full((6, 1), 20.0), np.full(2, 20.0), air=parts[-1])  # fmt: skip


def _measured(
    hexapod: ht.Hexapod, fault: Fault, commanded: np.ndarray, q: np.ndarray, dT: np.ndarray, plate: np.ndarray
) -> np.ndarray:
    """Return where the true platform stands."""
    lengths = hexapod.retracted_length + q + (A * 0.6 + B * q) * dT
    for leg, dA, dB in fault.legs:
        lengths[:, leg] += (dA * 0.6 + dB * q[:, leg]) * dT[:, leg]
    if fault.backlash is not None:
        leg, step = fault.backlash
        moves = np.sign(np.diff(q[:, leg], prepend=q[0, leg]))
        lengths[:, leg] += 0.5 * step * moves
    if fault.friction:
        share = np.linspace(0.7, 1.3, 6)
        lengths += 0.5 * fault.friction * share * np.sign(np.diff(q, axis=0, prepend=q[:1]))
    if fault.bent is not None:
        x, y = commanded[:, :2, 3].T
        lengths[:, fault.bent[0]] += fault.bent[1] * np.sin(2.0 * x / np.abs(x).max() + y / np.abs(y).max() + 1.0)
    if fault.later is not None:
        lengths[len(q) // 2 :, fault.later[0]] += fault.later[1]
    base, platform = hexapod.base_joints.copy(), hexapod.platform_joints.copy()
    if fault.base_joint is not None:
        base[fault.base_joint[0]] += fault.base_joint[1]
    if fault.platform_joint is not None:
        platform[fault.platform_joint[0]] += fault.platform_joint[1]
    grown = 1.0 + plate * (np.array(PLATES) + [fault.platform, fault.base])
    if fault.sag:
        lengths -= fault.sag * _pushes(base, platform, commanded, np.array(fault.centre))
    return stood(base * grown[:, 1, None, None], platform * grown[:, 0, None, None], lengths, commanded)


def _pushes(base: np.ndarray, platform: np.ndarray, poses: np.ndarray, centre: np.ndarray) -> np.ndarray:
    """Return the pushes of six legs that hold a unit weight at a centre: three forces and three moments balance."""
    found = []
    for T in poses:
        ends = platform @ T[:3, :3].T + T[:3, 3]
        u = ends - base
        u /= np.linalg.norm(u, axis=1)[:, None]
        balance = np.vstack([u.T, np.cross(ends, u).T])
        at = T[:3, :3] @ centre + T[:3, 3]
        found.append(np.linalg.solve(balance, -np.concatenate([GRAVITY, np.cross(at, GRAVITY)])))
    return np.array(found)


def _moved(poses: np.ndarray, motion: np.ndarray, home: np.ndarray) -> np.ndarray:
    """Return poses after a small motion of the measuring frame about home."""
    F, out = Rotation.from_rotvec(motion[:, 3:]).as_matrix(), poses.copy()
    out[:, :3, :3] = F @ poses[:, :3, :3]
    out[:, :3, 3] = home + np.einsum("nij,nj->ni", F, poses[:, :3, 3] - home) + motion[:, :3]
    return out
