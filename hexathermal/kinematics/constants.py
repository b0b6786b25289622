"""The arrays of numbers that the compiled loops read, made once for each machine."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations

import numpy as np

from hexathermal.kinematics import layout as at
from hexathermal.kinematics.region import regular_region
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.thermal import PlateLaw, ThermalModel
from hexathermal.poses import FloatArray

SWAPPED_UNITS = 10.0
"""A pose with a leg this many times longer than the longest allowed (else at home) is refused: metres not meant."""

LARGEST_CONDITION = 1e7
"""Condition number (lengths over the machine's size) above which a pose is called singular."""


@dataclass(frozen=True, eq=False)
class Constants:
    """One machine's numbers for the loops; see `layout` for their places.

    `both_forward` joins machine and forward constants; `both_law` has the machine's constants as its first row, filled
    up, and the rows of the law below.

    `unlimited` is `machine` without strokes; `radius` is the platform joints' about `centre`, their centroid; `origin`
    is the base joints' centroid.
    """

    machine: FloatArray
    unlimited: FloatArray
    forward: FloatArray
    both_forward: FloatArray
    both_law: FloatArray
    centre: FloatArray
    origin: FloatArray
    size: float
    radius: float


def constants(hexapod: Hexapod) -> Constants:
    """Return the machine's constants, made on first use."""
    try:
        made: Constants = hexapod._prepared["constants"]
    except KeyError:
        made = hexapod._prepared["constants"] = _made(hexapod)
    return made


def reach(hexapod: Hexapod) -> float:
    """Return the leg length [m] beyond which a pose is taken for one in millimetres."""
    longest = hexapod.length_limits[1]
    return SWAPPED_UNITS * float(longest.max() if np.isfinite(longest).all() else hexapod.home_lengths.max())


def dimensionless(J: FloatArray, radius: float) -> FloatArray:
    """Return Jacobians with rotations counted as motions of the joints: last three columns over their radius."""
    return np.asarray(J / np.array([1.0, 1.0, 1.0, radius, radius, radius]))


def _made(hexapod: Hexapod) -> Constants:
    """Return fresh constants."""
    p, b, home = hexapod.platform_joints, hexapod.base_joints, hexapod.home
    centre = p.mean(axis=0)
    radius = float(np.sqrt(((p - centre) ** 2).sum(axis=1).mean())) or 1.0
    lengths = hexapod.home_lengths
    size = float(max(lengths.max(), np.linalg.norm(p - centre, axis=1).max()))
    law = thermal_rows(hexapod.thermal)
    machine = _machine(hexapod, lengths, size)
    unlimited = machine.copy()
    unlimited[at.SHORTEST : at.SHORTEST + 6], unlimited[at.LONGEST : at.LONGEST + 6] = 0.0, np.inf
    origin = b.mean(axis=0)
    shifted = home.copy()
    shifted[:3, 3] -= origin
    forward = _forward(p - centre, b - origin, shifted, centre, size)
    forward[at.F_ORIGIN : at.F_ORIGIN + 3] = origin
    order = forward[at.F_ORDER : at.F_ORDER + 6].astype(int)
    for own, place, width in (
        (at.BASE_AXES, at.F_BASE_AXES, 3), (at.BASE_COSINES, at.F_BASE_COSINES, 1),
        (at.PLATFORM_AXES, at.F_PLATFORM_AXES, 3), (at.PLATFORM_COSINES, at.F_PLATFORM_COSINES, 1),
    ):  # fmt: skip
        rows = machine[own : own + 6 * width].reshape(6, width)
        forward[place : place + 6 * width] = rows[order].ravel()
    columns = max(at.MACHINE_LENGTH, law.shape[1])
    both_law = np.zeros((1 + at.LAW_ROWS, columns))
    both_law[0, : at.MACHINE_LENGTH], both_law[1:, : law.shape[1]] = machine, law
    both_forward = np.concatenate([machine, forward])
    return Constants(machine, unlimited, forward, both_forward, both_law, centre, origin, size, radius)


def _machine(hexapod: Hexapod, lengths: FloatArray, size: float) -> FloatArray:
    """Return the machine constants."""
    p, b, home = hexapod.platform_joints, hexapod.base_joints, hexapod.home
    c = np.zeros(at.MACHINE_LENGTH)
    c[at.PLATFORM : at.PLATFORM + 18], c[at.BASE : at.BASE + 18] = p.ravel(), b.ravel()
    c[at.Q0 : at.Q0 + 6] = 0.0 if hexapod.retracted_length is None else hexapod.retracted_length
    shortest, longest = hexapod.length_limits
    slack = hexapod.length_slack
    c[at.SHORTEST : at.SHORTEST + 6], c[at.LONGEST : at.LONGEST + 6] = shortest - slack, longest + slack
    u = (p @ home[:3, :3].T + home[:3, 3] - b) / lengths[:, None]
    c[at.BASE_AXES : at.BASE_AXES + 18] = u.ravel()
    c[at.PLATFORM_AXES : at.PLATFORM_AXES + 18] = (u @ home[:3, :3]).ravel()
    for first, cone in ((at.BASE_COSINES, hexapod.base_cone), (at.PLATFORM_COSINES, hexapod.platform_cone)):
        c[first : first + 6] = -2.0 if cone is None else np.cos(cone) - 1e-15
        c[at.HAS_CONES] = max(c[at.HAS_CONES], float(cone is not None))
    columns = _columns(hexapod.thermal)
    c[at.FIRST_SENSOR : at.FIRST_SENSOR + 8] = [own.start for own in columns]
    c[at.LAST_SENSOR : at.LAST_SENSOR + 8] = [own.stop for own in columns]
    c[at.SENSORS] = max(own.stop for own in columns)
    c[at.SIZE] = size
    c[at.LARGEST_LENGTH] = reach(hexapod)
    return c


def _newton_matrix(p: FloatArray, b: FloatArray, R: FloatArray, t: FloatArray) -> FloatArray:
    """Return Newton's matrix, rows ``[d, s x d]``, of six squared lengths."""
    s = p @ R.T
    d = s + t - b
    return np.hstack([d, np.cross(s, d)])


def _smallest_pivot(A: FloatArray, best: float) -> float:
    """Return the smallest pivot of an elimination in the given order; stops early below `best`."""
    A = A.copy()
    smallest = np.inf
    for k in range(6):
        smallest = min(smallest, abs(A[k, k]))
        if smallest <= best:
            return 0.0
        A[k + 1 :] -= np.outer(A[k + 1 :, k] / A[k, k], A[k])
    return float(smallest)


def _forward(p: FloatArray, b: FloatArray, home: FloatArray, centre: FloatArray, size: float) -> FloatArray:
    """Return the forward constants; the determinant is 0 where home itself is singular."""
    R, t = home[:3, :3], home[:3, 3] + home[:3, :3] @ centre
    A = _newton_matrix(p, b, R, t)
    scaled = A / np.array([1, 1, 1, size, size, size]) / size
    best, order = 0.0, tuple(range(6))
    for candidate in permutations(range(6)):
        pivot = _smallest_pivot(scaled[list(candidate)], best)
        if pivot > best:
            best, order = pivot, candidate
    o = list(order)
    f = np.zeros(at.FORWARD_LENGTH)
    f[at.F_PLATFORM : at.F_PLATFORM + 18], f[at.F_BASE : at.F_BASE + 18] = p[o].ravel(), b[o].ravel()
    f[at.F_T : at.F_T + 3] = t
    f[at.F_Q : at.F_Q + 4] = quaternion(R)
    f[at.F_INVERSE_SIZE] = 1.0 / size
    f[at.F_ORDER : at.F_ORDER + 6] = o
    f[at.F_CENTRE : at.F_CENTRE + 3] = centre
    if best > 0.0 and np.linalg.cond(scaled) < LARGEST_CONDITION:
        f[at.F_INVERSE : at.F_INVERSE + 36] = np.linalg.inv(A[o]).ravel()
        f[at.F_DETERMINANT] = np.linalg.det(A[o])
        f[at.F_SHIFT], f[at.F_COSINE] = regular_region(p, b, R, t, size, float(np.linalg.norm(centre)))
    else:
        f[at.F_INVERSE : at.F_INVERSE + 36] = np.nan
        f[at.F_DETERMINANT] = np.nan
    return f


def quaternion(R: FloatArray) -> FloatArray:
    """Return the unit quaternion (x, y, z, w) of a rotation: the eigenvector of Bar-Itzhack's matrix."""
    K = np.array(
        [
            [R[0, 0] - R[1, 1] - R[2, 2], R[0, 1] + R[1, 0], R[0, 2] + R[2, 0], R[2, 1] - R[1, 2]],
            [R[0, 1] + R[1, 0], R[1, 1] - R[0, 0] - R[2, 2], R[1, 2] + R[2, 1], R[0, 2] - R[2, 0]],
            [R[0, 2] + R[2, 0], R[1, 2] + R[2, 1], R[2, 2] - R[0, 0] - R[1, 1], R[1, 0] - R[0, 1]],
            [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], R[0, 0] + R[1, 1] + R[2, 2]],
        ]
    )
    q = np.linalg.eigh(K)[1][:, 3]
    return np.asarray(q if q[3] >= 0.0 else -q)


def thermal_rows(thermal: ThermalModel | None) -> FloatArray:
    """Return the law as rows of `layout`, one column a sensor."""
    law = np.zeros((at.LAW_ROWS, 0 if thermal is None else len(thermal.sensor_names)))
    if thermal is None:
        return law
    for leg, own in zip(thermal.legs, thermal.columns_of_leg, strict=True):
        law[at.LAW_A, own], law[at.LAW_B, own] = leg.A, leg.B
    plates = [plate.expansion for plate in _measured(thermal)]
    law[at.LAW_A, law.shape[1] - len(plates) :] = plates
    law[at.LAW_REFERENCE] = thermal.reference_temperature_degC
    law[at.LAW_LOWEST], law[at.LAW_HIGHEST] = thermal.valid_degC
    return law


def _measured(thermal: ThermalModel) -> list[PlateLaw]:
    """Return the plates that have a thermometer, platform first."""
    return [plate for plate in (thermal.platform, thermal.base) if plate is not None and plate.sensor is not None]


def _columns(thermal: ThermalModel | None) -> list[slice]:
    """Return the columns of each part's sensors: six legs, platform, base."""
    if thermal is None:
        return [slice(0, 0)] * 8
    found = list(thermal.columns_of_leg)
    for plate in (thermal.platform, thermal.base):
        first = max(own.stop for own in found)
        found.append(slice(first, first + int(plate is not None and plate.sensor is not None)))
    return found
