"""One sensor or two: the choice, made as the paper makes it, and what the whole search is worth on runs left out.

The best pair of 136 is better than the best single sensor of 17 partly by luck. A pair is taken only where its errors
on runs left out are smaller by more than their spread between runs explains. The error of the whole procedure, search
and fit, is found by leaving out each run, searching among the others, and predicting the run left out (nested).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hexathermal.errors import DataError
from hexathermal.learn.gram import Grams
from hexathermal.learn.selection import RankedSets, SetFits, fit_sets, sets_of
from hexathermal.poses import FloatArray

CONFIDENCE = 0.95


@dataclass(frozen=True)
class NestedRun:
    """A run left out of the whole search.

    Attributes
    ----------
    run : str
    sensors : tuple of str
        Chosen without the run.
    rmse : float [m]
        Of that choice on the run.
    single, double : float [m]
        RMSE on the run of the single sensor and of the pair that were best without it; NaN where there was no pair.
    """

    run: str
    sensors: tuple[str, ...]
    rmse: float
    single: float
    double: float


@dataclass(frozen=True)
class Choice:
    """A chosen set of sensors.

    Attributes
    ----------
    sensors : tuple of str
    reason : str
    gain, gain_uncertainty : float [m]
        RMSE on runs left out of the best single sensor less that of the best pair, and its standard uncertainty from
        the spread between runs; NaN where it cannot be told. Both were picked by these very numbers, which flatters
        the pair: there are more of them.
    nested_gain, nested_gain_uncertainty : float [m]
        The same where both are searched anew without each run that judges them: what the choice rests on. NaN with
        fewer than three runs.
    nested_rmse : float [m]
        RMSE of the whole search on runs left out; NaN where sensors were given, or with fewer than three runs.
    nested_runs : tuple of NestedRun
    """

    sensors: tuple[str, ...]
    reason: str
    gain: float = float("nan")
    gain_uncertainty: float = float("nan")
    nested_gain: float = float("nan")
    nested_gain_uncertainty: float = float("nan")
    nested_rmse: float = float("nan")
    nested_runs: tuple[NestedRun, ...] = ()


@dataclass(frozen=True)
class _Decision:
    """The better of the best single sensor and the best pair."""

    pair: bool
    single: int
    double: int
    gain: float
    uncertainty: float


def _decide(single: FloatArray, double: FloatArray, rows: npt.NDArray[np.int64]) -> _Decision:
    """Return the decision from mean square errors on runs left out, shapes (R, K1) and (R, K2)."""
    part = rows / rows.sum()
    one, two = part @ single, part @ double
    if not np.isfinite(one).any():
        raise DataError(
            "no sensor's law can be judged on runs left out: in all runs but one the temperatures hardly leave their "
            "zero, or q does not; record longer runs with moves"
        )
    s = int(np.nanargmin(one))
    if not np.isfinite(two).any():
        return _Decision(False, s, -1, float("nan"), float("nan"))
    d = int(np.nanargmin(two))
    return decided(single[:, s], double[:, d], rows, s, d)


def decided(one: FloatArray, two: FloatArray, rows: npt.NDArray[np.int64], s: int, d: int) -> _Decision:
    """Return whether mean square errors `two` are smaller than `one` by more than their spread between runs."""
    from scipy.special import stdtrit

    part, R = rows / rows.sum(), len(rows)
    difference = one - two
    mean = float(part @ difference)
    spread = float(np.sqrt((part**2 * (difference - mean) ** 2).sum() * R / (R - 1)))
    scale = float(np.sqrt(part @ one) + np.sqrt(part @ two))
    better = mean > float(stdtrit(R - 1, CONFIDENCE)) * spread
    return _Decision(bool(better), s, d, mean / scale if scale > 0.0 else 0.0, spread / scale if scale > 0.0 else 0.0)


def choose(ranked: RankedSets, grams: Grams) -> Choice:
    """Return the chosen set: the best single sensor, unless the best pair is better beyond doubt.

    Parameters
    ----------
    ranked : RankedSets
        Of sizes 1 and 2 at least, where there are two sensors.
    grams : Grams
    """
    if len(grams.runs) < 2:
        best = ranked.best(1, left_out=False)
        return Choice(ranked.names[best], "one run only: nothing can be judged on runs left out, so no pair is trusted")
    ones, twos = np.flatnonzero(ranked.sizes == 1), np.flatnonzero(ranked.sizes == 2)
    if not twos.size:
        return Choice(ranked.names[ranked.best(1)], "the best single sensor on runs left out; pairs were not searched")
    found = _decide(ranked.left_out_runs[:, ones], ranked.left_out_runs[:, twos], grams.rows)
    nested = _nested(grams) if len(grams.runs) > 2 else ()
    honest = found
    if nested and found.double >= 0:
        squares = np.array([(one.single, one.double) for one in nested]) ** 2
        honest = decided(squares[:, 0], squares[:, 1], grams.rows, found.single, found.double)
    single = ranked.names[ones[found.single]]
    double = ranked.names[twos[found.double]] if found.double >= 0 else ()
    square = sum(float(rows) * one.rmse**2 for rows, one in zip(grams.rows, nested, strict=False))
    judged = [ranked.left_out.rmse[ones[found.single]], ranked.left_out.rmse[twos[found.double]]]
    rmse = (float(judged[0]), float(judged[1]))
    again = honest if nested else _NOTHING
    return Choice(
        double if honest.pair else single,
        _reason(single, double, rmse, honest, bool(nested)),
        found.gain,
        found.uncertainty,
        again.gain,
        again.uncertainty,
        float(np.sqrt(square / grams.rows.sum())) if nested else float("nan"),
        nested,
    )


_NOTHING = _Decision(False, -1, -1, float("nan"), float("nan"))


def _reason(
    single: Sequence[str], double: Sequence[str], rmse: tuple[float, float], honest: _Decision, nested: bool
) -> str:
    """Return in words why a single sensor or a pair was chosen; `rmse` are theirs on runs left out [m]."""
    if not double:
        return "the best single sensor on runs left out; no pair's coefficients can be told apart"
    one, two = (value * 1e6 for value in rmse)
    pair = " + ".join(double)
    found = f"RMSE on runs left out: best single sensor {single[0]} {one:.3f} um, best pair {pair} {two:.3f} um"
    gain = f"{honest.gain * 1e6:+.3f} um (standard uncertainty {honest.uncertainty * 1e6:.3f} um)"
    if nested:
        gain += " where both are searched anew without each run that judges them"
    more = "more" if honest.pair else "not more"
    return f"{found}; a pair gains {gain}, {more} than the spread between runs explains"


def _nested(grams: Grams) -> tuple[NestedRun, ...]:
    """Return for each run what a search among the others chooses, and how it predicts the run."""
    out = []
    sets = [sets_of(grams.kept, 1), sets_of(grams.kept, 2)]
    for r, run in enumerate(grams.runs):
        others = np.arange(len(grams.runs)) != r
        inner = Grams(
            grams.columns,
            tuple(name for name, keep in zip(grams.runs, others, strict=True) if keep),
            grams.matrices[others],
            grams.rows[others],
            grams.rows_left_out[others],
            grams.left_out,
            grams.lacking_in,
        )
        fits = [fit_sets(inner, one) for one in sets]
        found = _decide(fits[0].left_out, fits[1].left_out, inner.rows)
        fit, k = (fits[1], found.double) if found.pair else (fits[0], found.single)
        single = _error(grams, r, fits[0], found.single)
        double = _error(grams, r, fits[1], found.double) if found.double >= 0 else float("nan")
        names = tuple(grams.columns.sensors[j] for j in fit.sets[k])
        out.append(NestedRun(run, names, double if found.pair else single, single, double))
    return tuple(out)


def _error(grams: Grams, run: int, fit: SetFits, k: int) -> float:
    """Return the RMSE of a fit on a run."""
    G, which, b = grams.matrices[run], grams.columns.of(fit.sets[k]), fit.coefficients[0, k]
    square = G[-1, -1] - 2.0 * b @ G[which, -1] + b @ G[np.ix_(which, which)] @ b
    return float(np.sqrt(max(square, 0.0) / grams.rows[run]))


def given(names: Sequence[str]) -> Choice:
    """Return the choice of sensors that were asked for."""
    return Choice(tuple(names), "sensors as asked for")
