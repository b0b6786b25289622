"""One law for several legs, or one each: decided on runs left out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.learn.gram import Grams
from hexathermal.poses import FloatArray

CONFIDENCE = 0.95


@dataclass(frozen=True, eq=False)
class CommonLaw:
    """The comparison of one law for all legs with one each.

    Attributes
    ----------
    legs : tuple of str
    common : array, shape (p,)
        ``[A .. B ..]`` fitted to all legs by least squares.
    own : array, shape (l, p)
        One law each.
    common_rmse, own_rmse : float [m]
        On runs left out, all legs.
    loss, loss_uncertainty : float [m]
        Common RMSE less own, and its standard uncertainty from the spread between runs.
    by_leg : dict of str to (float, float) [m]
        RMSE on runs left out of the common and of the own law.
    use_common : bool
        The legs' own laws are not better beyond their uncertainty.
    reason : str
    """

    legs: tuple[str, ...]
    common: FloatArray
    own: FloatArray
    common_rmse: float
    own_rmse: float
    loss: float
    loss_uncertainty: float
    by_leg: dict[str, tuple[float, float]]
    use_common: bool
    reason: str


def fit_common(legs: Mapping[str, Grams], sensors: Sequence[str]) -> CommonLaw:
    """Return whether several legs can share one law.

    Parameters
    ----------
    legs : mapping of a leg's name to its Gram matrices
        At least two legs, of two runs each.
    sensors : sequence of str
        Of the law; every leg has them.

    Raises
    ------
    ArgumentError
        Fewer legs or runs than needed, or a sensor is missing.
    """
    from scipy.stats import t

    if len(legs) < 2:
        raise ArgumentError(f"a common law needs at least two legs, found {len(legs)}")
    reduced = {name: _reduced(name, grams, sensors) for name, grams in legs.items()}
    totals = {name: G.sum(axis=0) for name, (G, _rows) in reduced.items()}
    everything = sum(totals.values())
    difference, rows, by_leg = [], [], {}
    squares = np.zeros(2)
    for name, (G, counts) in reduced.items():
        here = np.zeros(2)
        for r in range(len(G)):
            both = [_square(G[r], _solved(total - G[r])) for total in (everything, totals[name])]
            here += both
            difference.append((both[0] - both[1]) / counts[r])
            rows.append(counts[r])
        squares += here
        by_leg[name] = (float(np.sqrt(here[0] / counts.sum())), float(np.sqrt(here[1] / counts.sum())))
    part = np.array(rows) / np.sum(rows)
    d, R = np.array(difference), len(rows)
    mean = float(part @ d)
    spread = float(np.sqrt((part**2 * (d - mean) ** 2).sum() * R / (R - 1)))
    common_rmse, own_rmse = (float(value) for value in np.sqrt(squares / np.sum(rows)))
    scale = max(common_rmse + own_rmse, 1e-15)
    use = mean <= float(t.ppf(CONFIDENCE, R - 1)) * spread
    loss, uncertainty = mean / scale, spread / scale
    reason = (
        f"on {R} runs left out, the common law's RMSE is {loss * 1e6:+.3f} um from that of own laws (standard "
        f"uncertainty {uncertainty * 1e6:.3f} um): "
        + ("one law serves all legs" if use else "each leg needs its own law")
    )
    return CommonLaw(
        tuple(legs), _solved(everything), np.array([_solved(total) for total in totals.values()]),
        common_rmse, own_rmse, loss, uncertainty, by_leg, bool(use), reason,
    )  # fmt: skip


def _reduced(name: str, grams: Grams, sensors: Sequence[str]) -> tuple[FloatArray, FloatArray]:
    """Return the Gram matrices of ``q0 dT_s, q dT_s`` and the drift for the law's sensors, and the runs' rows."""
    missing = [sensor for sensor in sensors if sensor not in grams.columns.sensors or sensor in grams.left_out]
    if missing:
        raise ArgumentError(f"leg {name} has no usable sensor {missing[0]!r}, which the common law needs")
    if len(grams.runs) < 2:
        raise ArgumentError(f"leg {name} has one run; at least two are needed to judge on runs left out")
    which = grams.columns.of([grams.columns.sensors.index(sensor) for sensor in sensors])
    which = np.append(which, grams.columns.count)
    G = grams.matrices[:, which[:, None], which[None, :]]
    M = np.eye(len(which))
    # columns of the law: x_law = inverse(M).T x, since x b = x_law (M b)
    M[:-1, :-1] = np.linalg.inv(grams.columns.law_matrix(len(which) - 1))
    return np.asarray(M.T @ G @ M), grams.rows.astype(np.float64)


def _solved(G: FloatArray) -> FloatArray:
    """Return the least-squares coefficients."""
    inner, size = G[:-1, :-1], np.sqrt(np.diagonal(G)[:-1])
    if not size.all():
        raise ArgumentError("a sensor of the law never leaves its zero in some leg: its coefficient cannot be told")
    scaled = inner / np.outer(size, size)
    if np.linalg.cond(scaled) > 1e13:
        raise ArgumentError("the sensors' columns depend on each other in some leg: choose fewer sensors")
    return np.asarray(np.linalg.solve(scaled, G[:-1, -1] / size) / size)


def _square(G: FloatArray, b: FloatArray) -> float:
    """Return the sum of squared residuals; rounding below zero counts as zero."""
    return float(max(G[-1, -1] - 2.0 * b @ G[:-1, -1] + b @ G[:-1, :-1] @ b, 0.0))
