"""Noise of the six measured coordinates, and rows in the tails: from what no column at all explains.

Law, disturbances, all causes and all flexible shapes are fitted together, each with a loose prior, so that the noise is
the same for every hypothesis and no effect, however strong, is in it.  With the residuals ``r`` of coordinates and the
effective number of unknowns ``d = sum tr(1 - (1 + D G)^-1)``::

    sigma_k^2 = sum_n w_n r_nk^2 / (n (1 - d / 6 n))

Where a run, or a stretch of it, scatters clearly more or less than the rest, its rows weigh by that; its scatter is
the median of the squared distances m^2, in which single rows do not count.

Where the tails are heavier than normal, rows weigh ``w = (nu + 6) / (nu + m^2)``, m their Mahalanobis distance: the
maximum-likelihood weights of Student's distribution (Lange, Little and Taylor, J. Am. Stat. Assoc. 84 (1989) 881).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import linalg

from hexathermal.learn.hexapod_model import turn_axes
from hexathermal.learn.machine_diagnosis.candidate import Candidate
from hexathermal.learn.machine_diagnosis.evidence import sizes_for
from hexathermal.learn.machine_diagnosis.tables import Levels, Tables, run_columns, tables_of
from hexathermal.learn.machine_diagnosis.view import MachineView
from hexathermal.poses import FloatArray

LOOSE = Levels(frame=6.4, slow=0.8, leg=0.8, campaign=200.0)
LOOSE_STRENGTH = 3
"""Number of the size, in the grid of strengths, at which all candidates are fitted together."""

ROUNDS = 3
SETTLED = 0.01
"""Relative change of the noise below which, where all rows weigh the same, no further round changes anything."""

SMALLEST_NOISE = 1e-12
FREEDOMS = (3.0, 4.0, 6.0, 10.0, 20.0)
CLEARLY = 5.0
"""Log likelihood by which Student's distribution must be better than the normal one."""


STRETCH = 15
"""Rows of a stretch of a run whose scatter is looked at."""

UNLIKELY = 3.6
"""Standard deviations by which the scatter of a run or stretch must be off that of the rest."""

BESIDE_THE_MIDDLE = (0.4, 0.6)
"""Parts of all rows, between which the density of their squared distances is taken."""


@dataclass(frozen=True, eq=False)
class PoseNoise:
    """Noise of measured poses.

    Attributes
    ----------
    coordinates : array, shape (6,) [m, m, m, rad, rad, rad]
    weight : array, shape (n,)
        Of each row.
    freedom : float
        Degrees of freedom of the tails; infinite where they are normal.
    scatter : array, shape (n,)
        Scatter of the run or stretch that a row is in, over the usual one; 1 where it is no other.
    """

    coordinates: FloatArray
    weight: FloatArray
    freedom: float
    scatter: FloatArray


def pose_noise(
    view: MachineView, y: FloatArray, law: FloatArray, candidates: Sequence[Candidate], start: FloatArray
) -> PoseNoise:
    """Return the noise of a view's measured poses.

    Parameters
    ----------
    view : MachineView
    y : array, shape (n, 6) [m]
        Residual of the leg lengths.
    law : array, shape (n, 6, p)
    candidates : sequence of Candidate
        All that may be in the data.
    start : array, shape (6,) [m, rad]
    """
    sigma, weight, freedom, scatter = start, np.ones(len(view)), np.inf, np.ones(len(view))
    columns = [one.columns for one in candidates]
    scales = np.concatenate([np.zeros(0), *(one.scale for one in candidates)])
    for _round in range(ROUNDS):
        tables = tables_of(view, y, sigma, weight, law, columns)
        left, share = _residuals(view, y, law, columns, scales, sigma, tables)
        n = len(view) * max(1.0 - share, 0.2)
        before, sigma = sigma, np.maximum(np.sqrt((weight[:, None] * left**2).sum(axis=0) / n), SMALLEST_NOISE)
        square = ((left / sigma) ** 2).sum(axis=1) / max(1.0 - share, 0.2)
        scatter = scatter_of(view, square)
        square = square / scatter**2
        freedom = _freedom(square)
        weight = np.ones(len(view)) if np.isinf(freedom) else (freedom + 6.0) / (freedom + square)
        weight = weight / scatter**2
        if np.isinf(freedom) and (scatter == 1.0).all() and np.abs(np.log(sigma / before)).max() < SETTLED:
            break
    return PoseNoise(sigma, weight, freedom, scatter)


def scatter_of(view: MachineView, square: FloatArray) -> FloatArray:
    """Return the scatter of the run and stretch that each row is in, over the usual one, shape (n,).

    Parameters
    ----------
    view : MachineView
    square : array, shape (n,)
        Squared distances of the rows.
    """
    runs = [np.flatnonzero(view.run == run) for run in np.unique(view.run)]
    found = _apart(np.asarray(square), runs)
    stretches = [part for rows in runs for part in np.array_split(rows, max(len(rows) // STRETCH, 1))]
    return np.asarray(np.sqrt(found * _apart(square / found, stretches)))


def _apart(square: FloatArray, parts: list[npt.NDArray[np.int64]]) -> FloatArray:
    """Return the middle square of each part over the usual one, for all its rows; 1 where chance may make it so.

    The median of n values of density f about it has the standard deviation ``1 / (2 f sqrt(n))``.
    """
    found, middle = np.ones(len(square)), np.array([np.median(square[rows]) for rows in parts])
    low, high = np.quantile(square, BESIDE_THE_MIDDLE)
    usual = float(np.median(middle))
    if not (low > 0.0 and usual > 0.0):
        return found
    std = np.log(high / low) / (2.0 * (BESIDE_THE_MIDDLE[1] - BESIDE_THE_MIDDLE[0]))
    for rows, own in zip(parts, middle / usual, strict=True):
        if own > 0.0 and abs(np.log(own)) > UNLIKELY * std / np.sqrt(len(rows)):
            found[rows] = own
    return found


def _residuals(
    view: MachineView, y: FloatArray, law: FloatArray, columns: list[FloatArray], scales: FloatArray,
    sigma: FloatArray, tables: Tables,
) -> tuple[FloatArray, float]:  # fmt: skip
    """Return residuals of the coordinates (n, 6), everything fitted, and the share of freedom that it took."""
    S, _cost = tables.reduced(LOOSE, slice(None))
    sd, taken = tables.sizes(LOOSE), 0.0
    for own in tables.places:
        scale = scales[own.start - tables.base : own.stop - tables.base]
        size = sizes_for(S[own, own], scale, tables.rows)
        sd = np.concatenate([sd, scale * (size[LOOSE_STRENGTH] if size.size else 0.0)])
    M = S[:-1, :-1] * np.outer(sd, sd) + np.eye(len(sd))
    inverse = np.linalg.inv(M)
    found = sd * (inverse @ (sd * S[:-1, -1]))
    taken += len(sd) - float(np.trace(inverse))
    left = y - np.concatenate([law, view.frame * sigma, *columns], axis=2) @ found
    U, d = run_columns(view, sigma, leg_noise(view, sigma)), LOOSE.run_sizes
    for run, table in zip(np.unique(view.run), tables.runs, strict=True):
        rows = view.run == run
        A = table.UU * np.outer(d, d) + np.eye(len(d))
        right = d * (table.UT[:, -1] - table.UT[:, :-1] @ found)
        left[rows] -= U[rows] @ (d * linalg.solve(A, right, assume_a="pos"))
        taken += len(d) - float(np.trace(np.linalg.inv(A)))
    return coordinates_of(view, left), taken / (6.0 * len(view))


def leg_noise(view: MachineView, sigma: FloatArray) -> float:
    """Return the usual noise of a leg length that measured coordinates of noise sigma make [m]."""
    to = view.jacobian.copy()
    to[..., 3:] = to[..., 3:] @ turn_axes(view.poses, view.hexapod.home)
    return float(np.sqrt(((to * sigma) ** 2).sum(axis=2).mean()))


def coordinates_of(view: MachineView, lengths: FloatArray) -> FloatArray:
    """Return changes of the six measured coordinates that changes of the leg lengths (n, 6) belong to, (n, 6)."""
    twist = np.linalg.solve(view.jacobian, lengths[..., None])[..., 0]
    axes = turn_axes(view.poses, view.hexapod.home)
    twist[:, 3:] = np.linalg.solve(axes, twist[:, 3:, None])[..., 0]
    return np.asarray(twist)


def _freedom(square: FloatArray) -> float:
    """Return Student's degrees of freedom that explain squared distances in six dimensions best, or infinity."""
    from scipy.special import gammaln

    normal = float((-0.5 * square).sum())
    best, freedom = normal + CLEARLY, np.inf
    for nu in FREEDOMS:
        # the scale that belongs to these tails
        scale = 1.0
        for _turn in range(8):
            scale = float(((nu + 6.0) / (nu + square / scale) * square).mean()) / 6.0
        value = len(square) * (gammaln(0.5 * (nu + 6.0)) - gammaln(0.5 * nu) - 3.0 * np.log(0.5 * nu * scale))
        value += float((-0.5 * (nu + 6.0) * np.log1p(square / (nu * scale))).sum())
        if value > best:
            best, freedom = value, nu
    return freedom
