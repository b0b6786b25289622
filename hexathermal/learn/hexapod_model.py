"""From measured poses to leg lengths: the linear model of a warm hexapod, and its normal equations run by run.

For each row, with the measured pose ``(R, t)``, unit vectors ``u_i`` along the legs, exact inverse kinematics ``L_i``
of the nominal machine and displacements ``q_i`` by the scales:

    y_i = L_i(R, t) - q0_i - q_i
        = sum_s (A_is q0_i + B_is q_i) dT_is                                       legs (paper, eq. 4)
          - alpha_p dT_p (u_i . R p_i) + alpha_b dT_b (u_i . b_i)                  plates (eq. 1)
          + [J (v + w x (t - h), w)]_i                                             the tracker's frame, in each run
          + [J n]_i + e_i                                                          its noise; what no law explains

so everything is linear in the coefficients. What the machine's file states beyond its laws is taken off before: see
`hexathermal.learn.hexapod_stated`. The covariance of a row is ``V = J N J' + s^2 I``: noise of the six
coordinates, and of the legs.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError
from hexathermal.kinematics.inverse import inverse_kinematics
from hexathermal.kinematics.jacobian import jacobian
from hexathermal.learn.hexapod_data import PLATES, HexapodRows
from hexathermal.learn.hexapod_stated import in_machine_frame, stated_lengths
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray
from hexathermal.predict.pose_errors import moved_back

FRAMES = ("run", "campaign", "none")
"""What the positioning system's frame is free in: each run, the whole campaign, or nothing."""


def coefficient_names(sensors: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names of the model's coefficients: leg by leg ``A`` and ``B`` of each sensor, platform, base.

    Examples
    --------
    >>> coefficient_names(("T1",))[:3], coefficient_names(("T1",))[-2:]
    (('leg1 A T1', 'leg1 B T1', 'leg2 A T1'), ('platform', 'base'))
    """
    legs = tuple(f"leg{leg} {symbol} {sensor}" for leg in range(1, 7) for symbol in "AB" for sensor in sensors)
    return (*legs, *PLATES)


def columns(hexapod: Hexapod, poses: FloatArray, q: FloatArray, dT: FloatArray, plates: FloatArray) -> FloatArray:
    """Return the columns of the coefficients in leg lengths, shape (n, 6, 12 s + 2) [m K].

    Parameters
    ----------
    hexapod : Hexapod
    poses : array, shape (n, 4, 4) [m]
    q : array, shape (n, 6) [m]
    dT : array, shape (n, 6, s) [K]
        That tell each leg: `HexapodRows.heat`.
    plates : array, shape (n, 2) [K]
        Of platform and base; NaN: the column is zero.
    """
    n, _six, s = dT.shape
    q0 = hexapod.retracted_length
    assert q0 is not None  # checked where rows are made
    out = np.zeros((n, 6, 12 * s + 2))
    for leg in range(6):
        out[:, leg, 2 * s * leg : 2 * s * leg + s] = q0[leg] * dT[:, leg]
        out[:, leg, 2 * s * leg + s : 2 * s * (leg + 1)] = q[:, leg, None] * dT[:, leg]
    u = jacobian(hexapod, poses)[..., :3]
    heat = np.nan_to_num(plates)
    turned = np.einsum("nij,kj->nki", poses[:, :3, :3], hexapod.platform_joints)
    out[:, :, -2] = -heat[:, :1] * (u * turned).sum(axis=-1)
    out[:, :, -1] = heat[:, 1:] * (u * hexapod.base_joints).sum(axis=-1)
    return out


def frame_columns(hexapod: Hexapod, poses: FloatArray) -> FloatArray:
    """Return what a motion ``[v, w]`` of the frame about home does to the leg lengths, shape (n, 6, 6)."""
    J = jacobian(hexapod, poses)
    arm = poses[:, :3, 3] - hexapod.home[:3, 3]
    moved = J.copy()
    # J_v . (w x a) = w . (a x J_v)
    moved[..., 3:] += np.cross(np.broadcast_to(arm[:, None, :], J[..., :3].shape), J[..., :3])
    return moved


def turn_axes(poses: FloatArray, home: FloatArray) -> FloatArray:
    """Return the axes, in the base, about which small changes of rx, ry, rz turn the platform, shape (n, 3, 3).

    Columns: of ``R = H Rz Ry Rx``, the axes are ``H Rz Ry e_x``, ``H Rz e_y`` and ``H e_z``.
    """
    H = home[:3, :3]
    R = np.swapaxes(np.broadcast_to(H, poses[:, :3, :3].shape), -1, -2) @ poses[:, :3, :3]
    x = R[:, :, 0]
    across = np.hypot(x[:, 0], x[:, 1])
    safe = np.where(across > 1e-12, across, 1.0)
    y = np.stack([-x[:, 1] / safe, x[:, 0] / safe, np.zeros(len(x))], axis=-1)
    y[across <= 1e-12] = R[across <= 1e-12][:, :, 1]
    z = np.broadcast_to([0.0, 0.0, 1.0], x.shape)
    return np.asarray(H @ np.stack([x, y, z], axis=-1))


def row_covariance(hexapod: Hexapod, poses: FloatArray, noise: FloatArray, leg_noise: float) -> FloatArray:
    """Return the covariance of the six lengths of each row, ``J N J' + s^2 I``, shape (n, 6, 6) [m^2].

    Parameters
    ----------
    noise : array, shape (6,) [m, m, m, rad, rad, rad]
        Standard deviations of the six measured coordinates.
    leg_noise : float [m]
        ``s``.
    """
    J = jacobian(hexapod, poses)
    to = np.zeros(J.shape)
    to[:, :, :3] = J[:, :, :3] * noise[:3]
    to[:, :, 3:] = J[:, :, 3:] @ turn_axes(poses, hexapod.home) * noise[3:]
    return np.asarray(to @ np.swapaxes(to, -1, -2) + leg_noise**2 * np.eye(6))


@dataclass(frozen=True, eq=False)
class RunEquations:
    """The weighted normal equations of a run, its own frame eliminated.

    Attributes
    ----------
    run : str
    rows : int
    freedom : int
        Lengths less the eliminated unknowns.
    S, z, yy : array (p, p), array (p,), float
        ``X' V^-1 X``, ``X' V^-1 y``, ``y' V^-1 y`` after elimination; weighted square of any b:
        ``yy - 2 b z + b S b``.
    back, start : array, shape (6, p), (6,)
        The frame that belongs to b is ``start - back b``; empty rows where it is not free in each run.
    """

    run: str
    rows: int
    freedom: int
    S: FloatArray
    z: FloatArray
    yy: float
    back: FloatArray
    start: FloatArray

    def square(self, b: FloatArray) -> float:
        """Return the weighted sum of squared residuals at b."""
        return max(float(self.yy - 2.0 * b @ self.z + b @ self.S @ b), 0.0)

    def frame(self, b: FloatArray) -> FloatArray:
        """Return the run's frame at b, shape (6,) [m, rad]."""
        return np.asarray(self.start - self.back @ b)


@dataclass(frozen=True, eq=False)
class HexapodEquations:
    """What rows say about the coefficients, before anything is solved.

    Attributes
    ----------
    names : tuple of str
        Of the coefficients; with a frame for the whole campaign its six motions are the last.
    runs : tuple of RunEquations
    """

    names: tuple[str, ...]
    runs: tuple[RunEquations, ...]

    @property
    def S(self) -> FloatArray:
        """Information of all runs."""
        return np.asarray(np.sum([run.S for run in self.runs], axis=0))

    @property
    def z(self) -> FloatArray:
        """Right side of all runs."""
        return np.asarray(np.sum([run.z for run in self.runs], axis=0))


def measured_lengths(rows: HexapodRows, poses: FloatArray) -> FloatArray:
    """Return by how much each leg is longer than its scale says, as the nominal machine sees poses, (n, 6) [m]."""
    return np.asarray(inverse_kinematics(rows.hexapod, poses) - rows.retracted - rows.q)


def lengths_of_laws(rows: HexapodRows, poses: FloatArray) -> FloatArray:
    """Return what of `measured_lengths` is left to laws and plates: without sag and terms that the machine states."""
    return measured_lengths(rows, poses) - stated_lengths(rows, poses)


def whitened(V: FloatArray, values: FloatArray) -> FloatArray:
    """Return values (n, 6, k) with rows of unit covariance."""
    return np.asarray(np.linalg.solve(np.linalg.cholesky(V), values))


def hexapod_equations(
    rows: HexapodRows, noise: FloatArray, leg_noise: float, frame: str = "run", frames: FloatArray | None = None
) -> HexapodEquations:
    """Return the normal equations of rows.

    Parameters
    ----------
    rows : HexapodRows
    noise, leg_noise
        See `row_covariance`.
    frame : str
        ``"run"``: the positioning system's frame is free in each run, ``"campaign"``: one for all, ``"none"``.
    frames : array, shape (runs, 6), optional
        Frames that measured poses are freed of first: of large ones only the linear rest is left to the equations.
    """
    if frame not in FRAMES:
        raise ArgumentError(f"frame is {frame!r}, expected one of {', '.join(map(repr, FRAMES))}")
    poses = unframed(rows, frames)
    X = columns(rows.hexapod, poses, rows.q, rows.heat, rows.plates)
    F = frame_columns(rows.hexapod, poses)
    names = coefficient_names(rows.sensors)
    if frame == "campaign":
        X, names = (
            np.concatenate([X, F], axis=2),
            (*names, *(f"frame {axis}" for axis in ("x", "y", "z", "rx", "ry", "rz"))),
        )
    y = lengths_of_laws(rows, poses)
    V = row_covariance(rows.hexapod, poses, noise, leg_noise)
    parts = [X, F, y[..., None]] if frame == "run" else [X, y[..., None]]
    W = whitened(V, np.concatenate(parts, axis=2))
    p = X.shape[2]
    made = []
    for k, name in enumerate(rows.runs):
        here = rows.run == k
        if here.any():
            made.append(_run_equations(name, W[here].reshape(-1, W.shape[2]), p, int(here.sum())))
    return HexapodEquations(names, tuple(made))


def unframed(rows: HexapodRows, frames: FloatArray | None) -> FloatArray:
    """Return the measured poses freed of the stated drift of the frame and of each run's frame, shape (n, 4, 4)."""
    poses = in_machine_frame(rows)
    return poses if frames is None else moved_back(poses, frames[rows.run], rows.hexapod.home[:3, 3])


def _run_equations(name: str, W: FloatArray, p: int, rows: int) -> RunEquations:
    """Return the equations of a run from its whitened columns ``[X, F, y]`` or ``[X, y]``."""
    G = W.T @ W
    f = G.shape[0] - p - 1
    X, y = slice(0, p), G.shape[0] - 1
    if f == 0:
        return RunEquations(name, rows, 6 * rows, G[X, X], G[X, y], float(G[y, y]), np.zeros((6, p)), np.zeros(6))
    F = slice(p, p + f)
    size = np.sqrt(np.diagonal(G[F, F]))
    solved = np.linalg.lstsq(G[F, F] / np.outer(size, size), np.column_stack([G[F, X], G[F, y]]) / size[:, None],
                             rcond=1e-12)[0] / size[:, None]  # fmt: skip
    back, start = solved[:, :p], solved[:, p]
    S = G[X, X] - G[X, F] @ back
    return RunEquations(
        name, rows, 6 * rows - f, 0.5 * (S + S.T), G[X, y] - G[X, F] @ start, float(G[y, y] - G[y, F] @ start),
        back, start,
    )  # fmt: skip


def length_residuals(rows: HexapodRows, b: FloatArray, frames: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return residuals of the lengths (n, 6) [m] at coefficients and frames (runs, 6), and the poses they belong to."""
    poses = unframed(rows, frames)
    X = columns(rows.hexapod, poses, rows.q, rows.heat, rows.plates)
    return lengths_of_laws(rows, poses) - X @ b, poses


def pose_residuals(rows: HexapodRows, b: FloatArray, frames: FloatArray) -> FloatArray:
    """Return residuals of the measured coordinates, shape (n, 6) [m, m, m, rad, rad, rad]: ``J^-1`` of the lengths'.

    Rotations are about the axes of rx, ry, rz, as the coordinates' noise is.
    """
    e, poses = length_residuals(rows, b, frames)
    twist = np.linalg.solve(jacobian(rows.hexapod, poses), e[..., None])[..., 0]
    axes = turn_axes(poses, rows.hexapod.home)
    twist[:, 3:] = np.linalg.solve(axes, twist[:, 3:, None])[..., 0]
    return np.asarray(twist, dtype=np.float64)


def used(rows: HexapodRows, keep: npt.NDArray[np.bool_], reason: str) -> HexapodRows:
    """Return rows without those not kept, their number noted under a reason."""
    lost = int((~keep).sum())
    if not lost:
        return rows
    return replace(rows.rows(keep), left_out=rows.left_out | {reason: rows.left_out.get(reason, 0) + lost})
