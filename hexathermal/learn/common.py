"""One law for several legs, or one each: decided on runs left out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hexathermal.errors import ArgumentError, DataError
from hexathermal.learn.gram import Grams
from hexathermal.poses import FloatArray

CONFIDENCE = 0.95


@dataclass(frozen=True)
class LegLoss:
    """What a leg loses by the common law, on its runs left out.

    Attributes
    ----------
    common_rmse, own_rmse : float [m]
        Of the common law and of the leg's own.
    loss, loss_uncertainty : float [m]
        Mean over the leg's runs of common RMSE less own, and its standard uncertainty from the spread between them.
    worse : bool
        The common law is clearly worse: the loss exceeds its uncertainty by more than Student's one-sided 95 % bound.
    """

    common_rmse: float
    own_rmse: float
    loss: float
    loss_uncertainty: float
    worse: bool


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
        Mean over the runs of all legs of common RMSE less own, and its standard uncertainty from their spread.
    by_leg : dict of str to LegLoss
    use_common : bool
        The common law is clearly worse neither for all legs together nor for any leg.
    reason : str
    """

    legs: tuple[str, ...]
    common: FloatArray
    own: FloatArray
    common_rmse: float
    own_rmse: float
    loss: float
    loss_uncertainty: float
    by_leg: dict[str, LegLoss]
    use_common: bool
    reason: str


def fit_common(legs: Mapping[str, Grams], sensors: Sequence[str]) -> CommonLaw:
    """Return whether several legs can share one law.

    On each run left out, the law fitted to all other runs of all legs is compared with the one fitted to the other runs
    of the same leg. The common law serves unless it is clearly worse for a leg, or for all legs together: its RMSE is
    larger on average, by more than Student's one-sided 95 % bound of the spread between runs.

    Parameters
    ----------
    legs : mapping of a leg's name to its Gram matrices
        At least two legs, of two runs each.
    sensors : sequence of str
        Of the law; every leg has them.

    Raises
    ------
    ArgumentError
        Fewer legs than needed.
    DataError
        Fewer runs than needed, or a sensor is missing.
    """
    if len(legs) < 2:
        raise ArgumentError(f"a common law needs at least two legs, found {len(legs)}")
    reduced = {name: _reduced(name, grams, sensors) for name, grams in legs.items()}
    totals = {name: G.sum(axis=0) for name, (G, _rows) in reduced.items()}
    everything = sum(totals.values())
    squares = {}
    for name, (G, _rows) in reduced.items():
        laws = [(_solved(everything - one), _solved(totals[name] - one)) for one in G]
        squares[name] = np.array([[_square(one, b) for b in both] for one, both in zip(G, laws, strict=True)])
    by_leg = {name: _loss(squares[name], rows) for name, (_G, rows) in reduced.items()}
    total = _loss(np.concatenate(list(squares.values())), np.concatenate([rows for _G, rows in reduced.values()]))
    badly = [name for name, one in by_leg.items() if one.worse]
    use = not badly and not total.worse
    reason = (
        f"on {sum(map(len, squares.values()))} runs left out, the common law's RMSE is {total.loss * 1e6:+.3f} um from "
        f"that of own laws (standard uncertainty {total.loss_uncertainty * 1e6:.3f} um); "
    )
    if badly:
        reason += f"it serves {', '.join(badly)} clearly worse than an own law: each leg needs its own law"
    else:
        reason += "one law serves all legs" if use else "each leg needs its own law"
    return CommonLaw(
        tuple(legs), _solved(everything), np.array([_solved(one) for one in totals.values()]), total.common_rmse,
        total.own_rmse, total.loss, total.loss_uncertainty, by_leg, use, reason,
    )  # fmt: skip


def _loss(squares: FloatArray, rows: FloatArray) -> LegLoss:
    """Return what some runs lose, from their squared residuals under both laws, shape (R, 2), and their rows."""
    from scipy.special import stdtrit

    part, R = rows / rows.sum(), len(rows)
    common, own = (float(value) for value in np.sqrt(squares.sum(axis=0) / rows.sum()))
    # roots: squares would let the warmest run alone decide, and hide what all runs agree on
    difference = np.sqrt(squares[:, 0] / rows) - np.sqrt(squares[:, 1] / rows)
    mean = float(part @ difference)
    spread = float(np.sqrt((part**2 * (difference - mean) ** 2).sum() * R / (R - 1)))
    worse = mean > float(stdtrit(R - 1, CONFIDENCE)) * spread
    return LegLoss(common, own, mean, spread, bool(worse))


def _reduced(name: str, grams: Grams, sensors: Sequence[str]) -> tuple[FloatArray, FloatArray]:
    """Return the Gram matrices of ``q0 dT_s, q dT_s`` and the drift for the law's sensors, and the runs' rows."""
    missing = [sensor for sensor in sensors if sensor not in grams.columns.sensors or sensor in grams.left_out]
    if missing:
        raise DataError(f"leg {name} has no usable sensor {missing[0]!r}, which the common law needs")
    if len(grams.runs) < 2:
        raise DataError(f"leg {name} has one run; at least two are needed to judge on runs left out")
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
        raise DataError("a sensor of the law never leaves its zero in some leg: its coefficient cannot be told")
    scaled = inner / np.outer(size, size)
    if np.linalg.cond(scaled) > 1e13:
        raise DataError("the sensors' columns depend on each other in some leg: choose fewer sensors")
    return np.asarray(np.linalg.solve(scaled, G[:-1, -1] / size) / size)


def _square(G: FloatArray, b: FloatArray) -> float:
    """Return the sum of squared residuals; rounding below zero counts as zero."""
    return float(max(G[-1, -1] - 2.0 * b @ G[:-1, -1] + b @ G[:-1, :-1] @ b, 0.0))
