"""Where a campaign sends the machine, and when: poses within a part of what strokes and limits let it reach."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.machines.posture import Posture, legs_of, lengths_of
from hexathermal.simulate.hidden.machines.rotation import from_angles, turned
from hexathermal.simulate.hidden.shapes import log_uniform

MARGIN = 0.02
"""Of the stroke that is left at both ends."""

LEAST_FREE = 0.4
"""Of the determinant of the legs' Jacobian at home that is left everywhere: near 0 loads move the platform far."""

SHARES = (0.12, 0.95)
"""Of the reachable range that poses take up: drawn, uniform in its logarithm."""

WAYS = ("anywhere", "axis by axis", "small steps")
MOST_TRIES, NEARER = 400, 0.9
DECIMALS = 4
"""Of a commanded coordinate, in mm and degrees: a controller's numbers are short."""


@dataclass(frozen=True, eq=False)
class Course:
    """When a campaign measures, and how busy the machine is; a course of even steps holds the rows of the runs.

    Attributes
    ----------
    time : array, shape (m,) [s]
        Even steps from 0 to the campaign's end.
    busy : array, shape (m, 6)
        How hard each leg works, 0 to 1; 0 between runs.
    rows : tuple of array, shape (n,) [s]
        When each run measures.
    """

    time: FloatArray
    busy: FloatArray
    rows: tuple[FloatArray, ...]


def displaced(hexapod: Hexapod, coordinates: FloatArray) -> FloatArray:
    """Return the displacements of the legs at coordinates from home (n, 6) [m, rad], shape (n, 6) [m]."""
    assert hexapod.retracted_length is not None  # checked where machines are drawn
    lengths = lengths_of(_there(hexapod, coordinates), hexapod.base_joints, hexapod.platform_joints)
    return np.asarray(lengths - hexapod.retracted_length)


def _there(hexapod: Hexapod, coordinates: FloatArray) -> Posture:
    """Return the postures of coordinates from home."""
    return Posture(hexapod.home[:3, 3] + coordinates[:, :3], from_angles(coordinates[:, 3:]))


def leaning(hexapod: Hexapod, coordinates: FloatArray) -> FloatArray:
    """Return how far the legs lean from their directions at home, at base and platform joints, (n, 2, 6) [rad]."""
    posture = _there(hexapod, coordinates)
    legs = legs_of(posture, hexapod.base_joints, hexapod.platform_joints)
    back = posture.turn[:, None] * np.array([1.0, -1.0, -1.0, -1.0])
    both = np.stack([legs, turned(back, legs)], axis=1)
    home = hexapod.platform_joints + hexapod.home[:3, 3] - hexapod.base_joints
    both /= np.linalg.norm(both, axis=-1, keepdims=True)
    along = (both * home).sum(-1) / np.linalg.norm(home, axis=1)
    return np.asarray(np.arccos(np.clip(along, -1.0, 1.0)))


def freedom(hexapod: Hexapod, coordinates: FloatArray) -> FloatArray:
    """Return the determinant of the legs' Jacobian over that at home, shape (n,): 0 in a singular posture."""
    found = []
    for there in (coordinates, np.zeros((1, 6))):
        posture = _there(hexapod, there)
        legs = legs_of(posture, hexapod.base_joints, hexapod.platform_joints)
        legs /= np.linalg.norm(legs, axis=-1, keepdims=True)
        arms = turned(posture.turn[:, None], hexapod.platform_joints)
        found.append(np.linalg.det(np.concatenate([legs, np.cross(arms, legs)], axis=-1)))
    return np.asarray(found[0] / found[1])


def reachable(hexapod: Hexapod, coordinates: FloatArray) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Return which coordinates strokes, cones of joints and limits allow, no singular posture near, shape (n,)."""
    assert hexapod.stroke is not None  # checked where machines are drawn
    low, high = hexapod.stroke.T
    edge = MARGIN * (high - low)
    q = displaced(hexapod, coordinates)
    good = ((q >= low + edge) & (q <= high - edge)).all(axis=1) & (freedom(hexapod, coordinates) >= LEAST_FREE)
    for k, cone in enumerate((hexapod.base_cone, hexapod.platform_cone)):
        if cone is not None:
            good &= (leaning(hexapod, coordinates)[:, k] <= (1.0 - MARGIN) * cone).all(axis=1)
    if hexapod.limits is not None:
        limits = hexapod.limits
        least, most = np.array([limits.x, limits.y, limits.z, limits.rx, limits.ry, limits.rz]).T * (1.0 - MARGIN)
        good &= ((coordinates >= least) & (coordinates <= most)).all(axis=1)
    return np.asarray(good)


def ranges(hexapod: Hexapod) -> FloatArray:
    """Return how far each coordinate alone goes from home to either side, shape (6,) [m, rad]."""
    found = np.zeros(6)
    size = np.abs(hexapod.platform_joints - hexapod.platform_joints.mean(axis=0)).max()
    assert hexapod.stroke is not None  # checked where machines are drawn
    span = float(np.ptp(hexapod.stroke, axis=1).max())
    steps = np.linspace(0.0, 1.0, 101)[1:]
    for axis in range(6):
        most = span if axis < 3 else min(span / size, 0.7)
        tried = np.zeros((100, 6))
        tried[:, axis] = most * steps
        good = reachable(hexapod, tried) & reachable(hexapod, -tried)
        found[axis] = most * steps[int(np.argmin(good)) - 1] if not good.all() else most
        if not good[0]:
            found[axis] = 0.5 * most * steps[0]
    return found


def draw_poses(hexapod: Hexapod, count: int, share: float, way: str, generator: np.random.Generator) -> FloatArray:
    """Draw the commanded coordinates of a run, shape (count, 6) [m, rad].

    Parameters
    ----------
    hexapod : Hexapod
    count : int
    share : float
        Of the reachable range.
    way : str
        One of `WAYS`.
    generator : numpy.random.Generator

    Raises
    ------
    ArgumentError
        The machine hardly reaches anything.
    """
    width, unit = share * ranges(hexapod), np.repeat([1e-3, np.pi / 180.0], 3)
    found, left = np.zeros((count, 6)), np.arange(count)
    walk = np.zeros((count, 6))
    for k in range(1, count):
        walk[k] = np.clip(walk[k - 1] + 0.3 * generator.uniform(-1.0, 1.0, 6), -1.0, 1.0)
    for round_ in range(MOST_TRIES):
        there = generator.uniform(-1.0, 1.0, (left.size, 6))
        if way == "axis by axis":
            there = np.where(np.arange(6) == left[:, None] % 6, there, 0.15 * there)
        elif way == "small steps":  # what is out of reach comes nearer to home
            there = NEARER**round_ * walk[left]
        told = np.round(width * there / unit, DECIMALS) * unit
        good = reachable(hexapod, told)
        found[left[good]] = told[good]
        left = left[~good]
        if not left.size:
            return found
    raise ArgumentError(f"machine {hexapod.name!r} reaches hardly anything about home")


def draw_course(runs: int, poses: int, generator: np.random.Generator) -> Course:
    """Draw when runs of so many poses measure, how long the machine rests between them, and how it works meanwhile."""
    interval = log_uniform(40.0, 240.0, generator)
    rest = log_uniform(1800.0, 86400.0, generator)
    rows, now = [], 0.0
    for _run in range(runs):
        gaps = interval * generator.uniform(0.7, 1.3, poses - 1)
        rows.append(np.round(now + np.concatenate([[0.0], np.cumsum(gaps)]), 1))
        now = float(rows[-1][-1]) + rest * float(generator.uniform(0.6, 1.4))
    step = interval / 2.0
    time = np.arange(int(rows[-1][-1] / step) + 2, dtype=np.float64) * step
    return Course(time, _busy(time, rows, generator), tuple(rows))


def _busy(time: FloatArray, rows: list[FloatArray], generator: np.random.Generator) -> FloatArray:
    """Return how hard the legs work: phases of half an hour to two, some of rest, in each run."""
    busy = np.zeros((time.size, 6))
    together = generator.uniform(0.0, 1.0)
    for own in rows:
        now = float(own[0])
        while now < own[-1]:
            end = min(now + float(generator.uniform(1800.0, 7200.0)), float(own[-1]))
            level = together * generator.random() + (1.0 - together) * generator.random(6)
            if generator.random() < 0.3:
                level = 0.0 * level
            busy[(time >= now) & (time < end)] = level
            now = end
    return busy
