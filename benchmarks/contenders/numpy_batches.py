"""Batched NumPy: arrays (n, 6, 3), ``np.linalg.solve`` on (n, 6, 6), in pieces that stay in the processor's cache."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from benchmarks.case import Case, FloatArray, Quantity
from benchmarks.contender import Job, first, rows, single

PIECE = 500
MOST = 100_000
"""Poses of a batch: the rate does not change beyond."""

STEP, MOST_STEPS = 1e-7, 30


class NumpyBatches:
    """Plain NumPy."""

    name = "NumPy batches"
    note = f"version {np.__version__}: pieces of {PIECE} poses, at most {MOST} in all, no checks"

    def __init__(self, case: Case) -> None:
        self.p, self.b, self.home, self.law = (
            case.hexapod.platform_joints, case.hexapod.base_joints, case.hexapod.home, case.law,
        )  # fmt: skip

    def lengths(self, poses: FloatArray) -> FloatArray:
        """Return leg lengths (n, 6)."""
        d = self.p @ np.swapaxes(poses[:, :3, :3], -1, -2) + (poses[:, None, :3, 3] - self.b)
        return np.asarray(np.sqrt(np.einsum("nij,nij->ni", d, d)))

    def corrected(self, poses: FloatArray, temps: FloatArray) -> FloatArray:
        """Return commanded lengths (n, 6)."""
        A, B, q0, reference = self.law
        dT = temps - reference
        return np.asarray(q0 + (self.lengths(poses) - q0 - A * dT * q0) / (1.0 + B * dT))

    def jacobian(self, poses: FloatArray) -> FloatArray:
        """Return Jacobians (n, 6, 6)."""
        s = self.p @ np.swapaxes(poses[:, :3, :3], -1, -2)
        d = s + (poses[:, None, :3, 3] - self.b)
        d /= np.sqrt(np.einsum("nij,nij->ni", d, d))[..., None]
        return _with_moments(s, d)

    def poses(self, lengths: FloatArray) -> FloatArray:
        """Return poses (n, 4, 4): Newton on the squared lengths, from home; NaN where it does not converge."""
        T = np.tile(self.home, (len(lengths), 1, 1))
        wanted = lengths * lengths
        for _ in range(MOST_STEPS):
            s = self.p @ np.swapaxes(T[:, :3, :3], -1, -2)
            d = s + (T[:, None, :3, 3] - self.b)
            error = 0.5 * (wanted - np.einsum("nij,nij->ni", d, d))
            step = np.linalg.solve(_with_moments(s, d), error[..., None])[..., 0]
            T[:, :3, 3] += step[:, :3]
            T[:, :3, :3] = _turns(step[:, 3:]) @ T[:, :3, :3]
            if np.abs(step).max() < STEP:
                return T
        return np.full_like(T, np.nan)

    def jobs(self, case: Case) -> list[Job]:
        """Return batches, and batches of one."""
        work: list[tuple[Quantity, Callable[..., FloatArray], tuple[FloatArray, ...]]] = [
            (Quantity.LENGTHS, self.lengths, (case.poses,)),
            (Quantity.CORRECTED, self.corrected, (case.poses, case.temps)),
            (Quantity.POSES, self.poses, (case.lengths,)),
            (Quantity.JACOBIANS, self.jacobian, (case.poses,)),
        ]
        jobs = []
        for quantity, function, given in work:
            singles = [tuple(row[None] for row in pair) for pair in zip(*map(rows, given), strict=True)]
            jobs.append(single(quantity, function, singles, "a batch of one", _joined))
            many = tuple(array[:MOST] for array in given)
            jobs.append(Job(quantity, True, _in_pieces(function), [many], len(many[0]), first))
        return jobs


def _with_moments(s: FloatArray, d: FloatArray) -> FloatArray:
    """Return rows ``[d, s x d]``."""
    out = np.empty((*d.shape[:-1], 6))
    out[..., :3] = d
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        out[..., 3 + k] = s[..., i] * d[..., j] - s[..., j] * d[..., i]
    return out


def _turns(w: FloatArray) -> FloatArray:
    """Return rotation matrices of rotation vectors (Rodrigues)."""
    angle = np.sqrt(np.einsum("ni,ni->n", w, w))[:, None, None]
    K = np.zeros((len(w), 3, 3))
    K[:, 2, 1], K[:, 0, 2], K[:, 1, 0] = w[:, 0], w[:, 1], w[:, 2]
    K -= np.swapaxes(K, -1, -2)
    half = np.sinc(0.5 * angle / np.pi)
    return np.asarray(np.eye(3) + np.sinc(angle / np.pi) * K + 0.5 * half * half * (K @ K))


def _joined(results: Sequence[Any]) -> FloatArray:
    return np.concatenate(results)


def _in_pieces(function: Callable[..., FloatArray]) -> Callable[..., FloatArray]:
    """Return the function, working through its arguments piece by piece."""

    def call(*given: FloatArray) -> FloatArray:
        pieces = range(0, len(given[0]), PIECE)
        return np.concatenate([function(*(array[i : i + PIECE] for array in given)) for i in pieces])

    return call


def enter(case: Case) -> NumpyBatches:
    """Return the contender."""
    return NumpyBatches(case)
