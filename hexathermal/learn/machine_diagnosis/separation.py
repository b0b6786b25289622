"""By how much log evidence rows would separate candidates of a cause: the information of law and candidates.

A row's six leg lengths are ``y = X b + Z_i theta_i + U w_run + noise``: law ``X``, the columns ``Z_i`` of a candidate,
the run's own frame and slow errors ``U``, noise of covariance ``V``.  With those integrated out run by run, all that
rows tell is ``M = [X Z]' V^-1 [X Z]``, which adds up over runs.  With the law refitted under its prior ``D``

    G = M_zz - M_zx (M_xx + D^-1)^-1 M_xz                                            what stays visible of candidates

and amplitudes ``theta_j ~ N(0, S_j)`` of a candidate j, truth being ``theta`` of candidate i,

    E log p(y | j) / p(y | nothing) = 1/2 tr H_j (G_jj + G_ji Theta G_ij) - 1/2 log det (1 + S_j G_jj),
    H_j = (G_jj + S_j^-1)^-1,   Theta = E theta theta'

(mean of a quadratic form; evidence of a linear model, O'Hagan and Forster, Kendall's Advanced Theory of Statistics 2B,
2004, 11.27).  The separation of i from j is the difference of the two: a rival counts with what its own refit leaves.
``S_j = rho^2`` times the square of the usual sizes, with the best ``rho`` of those that give a signal of `SIGNALS`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.learn.hexapod_model import row_covariance, turn_axes, whitened
from hexathermal.learn.machine_diagnosis.law_columns import law_columns
from hexathermal.learn.machine_diagnosis.noise_levels import leg_noise
from hexathermal.learn.machine_diagnosis.tables import Levels, run_columns
from hexathermal.learn.machine_diagnosis.view import MachineView
from hexathermal.poses import FloatArray

SIGNALS = np.geomspace(0.25, 1e5, 20)
"""Prior sizes ``tr S_j G_jj`` of which each candidate is granted the best: squares of signal over noise."""

LARGEST_SIZE = 64.0
"""Amplitudes that a candidate may need at most, over their usual sizes."""

FREE_FRAME = Levels(frame=1e5)
"""The measuring frame is free in each run, and nothing else disturbs."""

READINGS = "thermometers"
"""What the words of the law's columns begin with that are errors of single readings."""

SMALLEST_SHARE = 1e-6
"""Part of a candidate's squared effect that must be left after the refit: less is rounding."""


@dataclass(frozen=True, eq=False)
class Noise:
    """Standard deviations of a measured pose.

    Attributes
    ----------
    coordinates : array, shape (6,) [m, m, m, rad, rad, rad]
        Of x, y, z, rx, ry, rz.
    leg : float [m]
        Of each leg, beside.
    """

    coordinates: FloatArray
    leg: float = 0.0

    def __post_init__(self) -> None:
        array = np.array(self.coordinates, dtype=np.float64)
        if array.shape != (6,) or not (np.isfinite(array).all() and (array > 0.0).all()):
            raise ArgumentError(f"noise is six standard deviations above 0 (x y z [m], rx ry rz [rad]), found {array}")
        if not (np.isfinite(self.leg) and self.leg >= 0.0):
            raise ArgumentError(f"noise of a leg must be 0 or more, found {self.leg!r}")
        array.setflags(write=False)
        object.__setattr__(self, "coordinates", array)


@dataclass(frozen=True, eq=False)
class Information:
    """What rows tell of the law's p coefficients and of K columns of candidates.

    Attributes
    ----------
    M : array, shape (p + K, p + K)
        ``[X Z]' V^-1 [X Z]``, law first, runs' own disturbances integrated out.
    squares : array, shape (3, K, K)
        Quadratic forms: sum over rows and coordinates of a candidate's effect on the measured pose, squared: over the
        noise, of translations [m^2], of rotations [rad^2].
    rows : int
    """

    M: FloatArray
    squares: FloatArray
    rows: int

    def __add__(self, other: Information) -> Information:
        return Information(self.M + other.M, self.squares + other.squares, self.rows + other.rows)

    def visible(self, sd: FloatArray) -> FloatArray:
        """Return ``G``, shape (K, K), the law refitted under a prior of standard deviations sd (p,); inf: free."""
        return refitted(self.M, sd)


def refitted(M: FloatArray, sd: FloatArray) -> FloatArray:
    """Return what is left of the information of unknowns behind the first p, those refitted; batches lead.

    Parameters
    ----------
    M : array, shape (..., p + K, p + K)
    sd : array, shape (p,)
        Standard deviations of the first unknowns' priors; infinite: none.
    """
    p = len(sd)
    if not p:
        return np.asarray(M)
    prior = np.where(np.isinf(sd), 0.0, 1.0 / np.square(np.where(sd > 0.0, sd, 1.0)))
    size = np.sqrt(np.maximum(np.einsum("...ii->...i", M)[..., :p] + prior, 1e-300))
    head = M[..., :p, :p] + np.diag(prior)
    head = head / (size[..., :, None] * size[..., None, :])
    # directions that neither rows nor prior know are left where they are
    ridge = 1e-12 * np.eye(p)
    cross = M[..., :p, p:] / size[..., :, None]
    G = M[..., p:, p:] - np.swapaxes(cross, -1, -2) @ np.linalg.solve(head + ridge, cross)
    return np.asarray(0.5 * (G + np.swapaxes(G, -1, -2)))


@dataclass(frozen=True, eq=False)
class Base:
    """What is there beside candidates.

    Attributes
    ----------
    own : array, shape (n, 6, o)
        Errors of the readings of these rows, which no other rows share, each for one standard deviation.
    shared : array, shape (n, 6, p)
        The law, and a campaign's frame.
    sizes : array, shape (p,)
        Standard deviations of their amplitudes.
    """

    own: FloatArray
    shared: FloatArray
    sizes: FloatArray


def base_of(view: MachineView, laws: str, noise: Noise, levels: Levels) -> Base:
    """Return what is there in the rows of a view beside candidates."""
    law = law_columns(view, laws)
    own = np.array([word.startswith(READINGS) for word in law.words], dtype=bool)
    shared, sizes = law.columns[..., ~own], np.ones(int((~own).sum()))
    if levels.campaign > 0.0:
        shared = np.concatenate([shared, view.frame * noise.coordinates], axis=2)
        sizes = np.concatenate([sizes, np.full(6, levels.campaign)])
    return Base(law.columns[..., own], shared, sizes)


def information_of_rows(
    view: MachineView, base: Base, columns: FloatArray, noise: Noise, levels: Levels
) -> Information:
    """Return the information of a view's rows.

    Parameters
    ----------
    view : MachineView
    base : Base
        Errors of readings are integrated out with the runs' own disturbances.
    columns : array, shape (n, 6, K)
        Columns of the candidates beside each other.
    noise : Noise
    levels : Levels
        Sizes of each run's own disturbances.
    """
    there = np.concatenate([base.own, base.shared], axis=2)
    W, f = whitened_rows(view, there, columns, noise, levels)
    u = W.shape[2] - len(f)
    M = np.zeros((u, u))
    for run in np.unique(view.run):
        rows = W[view.run == run].reshape(-1, W.shape[2])
        M += refitted(rows.T @ rows, f)
    M = refitted(M, np.ones(base.own.shape[2]))
    e = effects(view, columns)
    squares = np.array([
        np.einsum("nck,ncl->kl", part, part, optimize=True)
        for part in (e / noise.coordinates[:, None], e[:, :3], e[:, 3:])
    ])  # fmt: skip
    return Information(M, squares, len(view))


def whitened_rows(
    view: MachineView, base: FloatArray, columns: FloatArray, noise: Noise, levels: Levels
) -> tuple[FloatArray, FloatArray]:
    """Return whitened columns (n, 6, f + p + K), the run's own disturbances first, and the sizes of those (f,)."""
    sizes = levels.run_sizes
    live = sizes > 0.0
    own = run_columns(view, noise.coordinates, leg_noise(view, noise.coordinates))[..., live]
    V = row_covariance(view.hexapod, view.poses, noise.coordinates, noise.leg)
    return whitened(V, np.concatenate([own, base, columns], axis=2)), sizes[live]


def effects(view: MachineView, columns: FloatArray) -> FloatArray:
    """Return what columns in leg lengths (n, 6, K) do to the six measured coordinates, shape (n, 6, K)."""
    twist = np.linalg.solve(view.jacobian, columns)
    twist[:, 3:] = np.linalg.solve(turn_axes(view.poses, view.hexapod.home), twist[:, 3:])
    return np.asarray(twist)


def places_of(counts: Sequence[int]) -> tuple[slice, ...]:
    """Return where each candidate's columns stand."""
    edges = np.cumsum([0, *counts]).tolist()
    return tuple(slice(a, b) for a, b in pairwise(edges))


def expected_evidence(
    G: FloatArray, own: slice, truth: slice | None, Theta: FloatArray, scale: FloatArray
) -> FloatArray:
    """Return the mean log evidence of a candidate against nothing, at its best size; batches lead.

    Parameters
    ----------
    G : array, shape (..., K, K)
        See the module.
    own : slice
        The candidate's columns.
    truth : slice or None
        Columns of the candidate that is true; None: nothing is.
    Theta : array, shape (k, k)
        Mean square of the truth's amplitudes.
    scale : array, shape (K,)
        Usual sizes of all amplitudes.
    """
    s = scale[own]
    A = G[..., own, own] * np.outer(s, s)
    mean = A if truth is None else A + _seen(G, own, truth, Theta) * np.outer(s, s)
    # in the eigenvectors of A a size common to all amplitudes needs no inverse: directions that are not seen give 0
    a, U = np.linalg.eigh(A)
    a = np.maximum(a, 0.0)[..., None]
    m = np.einsum("...ji,...jk,...ki->...i", U, mean, U)[..., None]
    total = np.maximum(a.sum(axis=-2, keepdims=True), 1e-300)
    S = np.minimum(SIGNALS / total, LARGEST_SIZE**2)
    values = 0.5 * (S * m / (1.0 + S * a) - np.log1p(S * a)).sum(axis=-2)
    return np.asarray(values.max(axis=-1))


def _seen(G: FloatArray, own: slice, truth: slice, Theta: FloatArray) -> FloatArray:
    """Return ``G_ji Theta G_ij``."""
    cross = G[..., own, truth]
    return np.asarray(cross @ Theta @ np.swapaxes(cross, -1, -2))


def separation(G: FloatArray, first: slice, second: slice, Theta: FloatArray, scale: FloatArray) -> FloatArray:
    """Return by how much log evidence the first candidate, being true, beats the second on average; batches lead.

    Parameters
    ----------
    G, scale
        As `expected_evidence`.
    first, second : slice
        Columns of the two.
    Theta : array, shape (k, k)
        Mean square of the first one's amplitudes.

    Returns
    -------
    array, shape (...)
        Natural logarithm of the Bayes factor; 0 where the two look the same.
    """
    return expected_evidence(G, first, first, Theta, scale) - expected_evidence(G, second, first, Theta, scale)


def share_left(information: Information, G: FloatArray, own: slice, scale: FloatArray) -> float:
    """Return which part of a candidate's effect, RMS, the refit of law and frames leaves, 0 to 1."""
    weight = np.square(scale[own])
    before = float(weight @ np.diagonal(information.squares[0][own, own]))
    left = float(weight @ np.diagonal(G[own, own]))
    return float(np.sqrt(min(left / before, 1.0))) if left > SMALLEST_SHARE * before else 0.0


def needed_square(threshold: float, k: int) -> float:
    """Return the square that k parameters must explain to gain a log evidence, their prior at its best size.

    The root of ``q - k - k log(q / k) = 2 threshold``.

    Examples
    --------
    >>> round(needed_square(5.0, 1), 2), round(needed_square(5.0, 6), 2)
    (13.61, 24.42)
    """
    q = 2.0 * threshold + k
    # a contraction: its slope k / q is below 1
    for _turn in range(100):
        q = 2.0 * threshold + k + k * np.log(q / k)
    return float(q)


def least_amplitude(need: float, power: float, k: int) -> float:
    """Return the noncentrality at which a quadratic form of k squares exceeds a need with a power.

    ``P(chi2_k(x) >= need) = power``; 0 where chance alone does.
    """
    from scipy.special import chndtr, chndtrinc

    if chndtr(need, k, 0.0) <= 1.0 - power:
        return 0.0
    return float(chndtrinc(need, k, 1.0 - power))
