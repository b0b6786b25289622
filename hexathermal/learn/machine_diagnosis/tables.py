"""All that rows say about columns, run by run: Gram matrices, and what stays of them after a run's own part.

A row's lengths are whitened with ``V = J N J'``.  With columns T of law and candidates, of which all runs share the
amplitudes, and columns U of a run's own disturbances, of prior ``N(0, D_r)``::

    y = T a + U_r w_r + e,     S_r = T' T - T' U (U' U + D_r^-1)^-1 U' T,     S = sum_r S_r

U holds a motion of the measuring frame, constant and slow, and a slow error of each leg (what thermometers misread):
cosines of time whose sizes fall as those of a random walk (Karhunen-Loeve; Loeve, Probability Theory II, 1978, 37.5).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
from scipy.linalg import lapack

from hexathermal.learn.hexapod_model import row_covariance, whitened
from hexathermal.learn.machine_diagnosis.view import MachineView
from hexathermal.poses import FloatArray

Triangle: TypeAlias = npt.NDArray[np.floating[Any]]

WAVES = 4
"""Cosines of a run's time in which something slow is written."""


@dataclass(frozen=True)
class Levels:
    """Sizes of what is no cause, over the noise of a single pose: standard deviations.

    Attributes
    ----------
    frame : float
        Of a run's own frame of the measuring system.
    slow : float
        Of its slow drift within a run.
    leg : float
        Of slow errors of the legs, constant or not, as those of thermometers.
    campaign : float
        Of one frame for the whole campaign.
    """

    frame: float = 0.0
    slow: float = 0.0
    leg: float = 0.0
    campaign: float = 0.0

    @property
    def run_sizes(self) -> FloatArray:
        """Standard deviations of the amplitudes of a run's own columns, shape (u,)."""
        waves = np.arange(1, WAVES + 1)
        drift = np.repeat(self.slow / waves, 6)
        legs = np.repeat(np.concatenate([[1.0], 1.0 / waves]) * self.leg, 6)
        return np.concatenate([np.full(6, self.frame), drift, legs])


@dataclass(frozen=True, eq=False)
class RunTable:
    """Gram matrices of one run: ``U' U``, ``U' T`` and ``T' T``, the residual being the last column of T."""

    UU: FloatArray
    UT: FloatArray
    TT: FloatArray

    def reduced(self, sizes: FloatArray, which: npt.NDArray[np.int64] | slice) -> tuple[FloatArray, float]:
        """Return S of some columns, and the log determinant that the run's own part costs."""
        live = sizes > 0.0
        TT = self.TT[which][:, which]
        if not live.any():
            return TT, 0.0
        d = sizes[live]
        M = self.UU[np.ix_(live, live)] * np.outer(d, d)
        M[np.diag_indices_from(M)] += 1.0
        factor = np.linalg.cholesky(M)
        cross = forward(factor, d[:, None] * self.UT[live][:, which])
        return TT - cross.T @ cross, 2.0 * float(np.log(np.diagonal(factor)).sum())


@dataclass(frozen=True, eq=False)
class Tables:
    """What rows say of shared columns: law and campaign frame (the first `base`), candidates, the residual last.

    Attributes
    ----------
    runs : tuple of RunTable
    law : int
        Number of the law's columns; a campaign's six motions follow.
    places : tuple of slice
        Of each candidate's columns.
    rows : int
    """

    runs: tuple[RunTable, ...]
    law: int
    places: tuple[slice, ...]
    rows: int

    @property
    def base(self) -> int:
        """Columns of law and campaign frame."""
        return self.law + 6

    @property
    def count(self) -> int:
        """All columns but the residual."""
        return len(self.runs[0].TT) - 1

    def sizes(self, levels: Levels) -> FloatArray:
        """Return the standard deviations of the base's amplitudes, shape (base,)."""
        return np.concatenate([np.ones(self.law), np.full(6, levels.campaign)])

    def reduced(
        self, levels: Levels, which: npt.NDArray[np.int64] | slice, skip: int | None = None
    ) -> tuple[FloatArray, float]:
        """Return S of some columns summed over runs, without one where `skip` is given, and the log determinant."""
        sizes = levels.run_sizes
        parts = [run.reduced(sizes, which) for k, run in enumerate(self.runs) if k != skip]
        total = np.sum([part[0] for part in parts], axis=0)
        return total, float(sum(part[1] for part in parts))


def forward(factor: Triangle, right: FloatArray) -> FloatArray:
    """Return ``L^-1 b`` of a lower triangle L, as NumPy's Cholesky makes it; LAPACK itself, for small ones are many."""
    return np.asarray(lapack.dtrtrs(factor.T, right, lower=0, trans=1)[0])


def backward(factor: Triangle, right: FloatArray) -> FloatArray:
    """Return ``L'^-1 b`` of a lower triangle L."""
    return np.asarray(lapack.dtrtrs(factor.T, right, lower=0, trans=0)[0])


def eliminated(S: FloatArray, sizes: FloatArray) -> tuple[FloatArray, float]:
    """Return S of the columns behind the first ``len(sizes)``, those integrated over N(0, sizes^2), and the cost.

    The cost is the log determinant ``log det(1 + D S_bb)``.
    """
    b, live = len(sizes), np.flatnonzero(sizes > 0.0)
    rest = S[b:, b:]
    if not live.size:
        return rest, 0.0
    d = sizes[live]
    M = S[np.ix_(live, live)] * np.outer(d, d)
    M[np.diag_indices_from(M)] += 1.0
    factor = np.linalg.cholesky(M)
    cross = forward(factor, d[:, None] * S[live][:, b:])
    return np.asarray(rest - cross.T @ cross), 2.0 * float(np.log(np.diagonal(factor)).sum())


def time_waves(view: MachineView, rows: npt.NDArray[np.int64]) -> FloatArray:
    """Return cosines of a run's time, ``sqrt(2) cos(pi k t / T)``, shape (n, WAVES)."""
    t = view.time[rows]
    span = float(np.ptp(t))
    x = (t - t.min()) / span if span > 0.0 else np.linspace(0.0, 1.0, len(rows))
    return np.asarray(np.sqrt(2.0) * np.cos(np.pi * x[:, None] * np.arange(1, WAVES + 1)))


def run_columns(view: MachineView, noise: FloatArray, leg: float) -> FloatArray:
    """Return the columns of a run's own disturbances, each for a size of the noise, shape (n, 6, u).

    Parameters
    ----------
    view : MachineView
    noise : array, shape (6,) [m, rad]
    leg : float [m]
        Usual noise of a leg length.
    """
    waves = np.zeros((len(view), WAVES))
    for run in np.unique(view.run):
        rows = np.flatnonzero(view.run == run)
        waves[rows] = time_waves(view, rows)
    frame = view.frame * noise
    legs = np.broadcast_to(leg * np.eye(6), frame.shape)
    times = np.concatenate([np.ones((len(view), 1)), waves], axis=1)
    shape = (len(view), 6, -1)
    drift = (frame[:, :, None, :] * waves[:, None, :, None]).reshape(shape)
    slow = (legs[:, :, None, :] * times[:, None, :, None]).reshape(shape)
    return np.concatenate([frame, drift, slow], axis=2)


def tables_of(
    view: MachineView, y: FloatArray, noise: FloatArray, weight: FloatArray, law: FloatArray, columns: list[FloatArray]
) -> Tables:
    """Return the tables of rows.

    Parameters
    ----------
    view : MachineView
    y : array, shape (n, 6) [m]
        Residual of the leg lengths.
    noise : array, shape (6,) [m, m, m, rad, rad, rad]
        Of the measured coordinates.
    weight : array, shape (n,)
        Of each row: 1, less for a row in the tails.
    law : array, shape (n, 6, p)
        For one standard deviation each.
    columns : list of array, shape (n, 6, k)
        Of the candidates.
    """
    V = row_covariance(view.hexapod, view.poses, noise, 0.0)
    leg = float(np.sqrt(np.einsum("nii->n", V).mean() / 6.0))
    U = run_columns(view, noise, leg)
    T = np.concatenate([law, view.frame * noise, *columns, y[..., None]], axis=2)
    W = whitened(V, np.concatenate([U, T], axis=2)) * np.sqrt(weight)[:, None, None]
    u, found = U.shape[2], []
    for run in np.unique(view.run):
        flat = W[view.run == run].reshape(-1, W.shape[2])
        G = flat.T @ flat
        found.append(RunTable(G[:u, :u], G[:u, u:], G[u:, u:]))
    edges = np.cumsum([law.shape[2] + 6, *(part.shape[2] for part in columns)]).tolist()
    return Tables(tuple(found), law.shape[2], tuple(slice(a, b) for a, b in pairwise(edges)), len(view))
