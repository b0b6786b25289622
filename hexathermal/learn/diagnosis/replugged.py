"""Plugs that changed places between runs: the other thermometers tell, in runs for validation too.

What a thermometer reads is foretold by all but the two of a pair, with the same weights in all runs::

    T_s = sum_k w_sk T_k + e_s,      s = i, j                                                                  (1)

In runs L whose plugs i and j changed places, both are off as recorded, and neither is once they are exchanged. Of all
single runs, and all runs from one on, and of these with one run more or less as long as that helps, L leaves least of
(1), its weights fitted to the temperatures so exchanged. All runs but L leave the same: the order along the leg tells
which of both are wrong, and that plugs sit right in most runs; where they changed places once, the drift of the fitted
runs, too. Where all runs count from one zero, it was read with the plugs of the first run, so that a plug exchanged
since counts from the zero of another (`SensorRepair`, ``zero_else``). With ``own`` and ``put`` the mean squares of e in
L as recorded and exchanged, and h hours of L each worth one value,

    log evidence = h/2 sum_s log(own_s / put_s)                                                                (2)
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
import numpy.typing as npt
from scipy import linalg

from hexathermal.learn.diagnosis.beforehand import Beforehand
from hexathermal.learn.diagnosis.causes.swapped_sensors import CAUSE
from hexathermal.learn.diagnosis.deciding import SOUND
from hexathermal.learn.diagnosis.mending import mended_view
from hexathermal.learn.diagnosis.order import UNSURE, Order
from hexathermal.learn.diagnosis.result import Effect
from hexathermal.learn.diagnosis.spans import visible
from hexathermal.learn.diagnosis.view import View
from hexathermal.learn.diagnosis.words import UM, two_digits
from hexathermal.machine.leg_repairs import SensorRepair
from hexathermal.poses import FloatArray

FEWEST, FEWEST_RUNS = 3, 3
"""Thermometers that must foretell, and runs that are compared."""

OFF = 3.0
"""Both thermometers must be off by so much, RMS, as recorded in these runs, and exchanged in the others, as they are
the other way round."""

ALIKE = 2.5
"""Exchanged, each may be off by so much as it is in the other runs."""

LEAST_LEFT = 4.0
"""Where it is not exchanged all together must leave more of the pair by this part of one run's share."""

FEWER = 1e-6
"""One run more, or less, must leave less by this part."""

SURE = 10.0
"""Log evidence that is needed."""

RIGHT = math.log(4.0)
"""Log odds that plugs sit right in a run."""

MOST_BY_DRIFT = 6.0
"""Log odds that a law reads its own thermometers rather than that it lacks another one of a dozen and more."""

MOST = 2
"""Pairs that are looked for, one after the other."""

RIDGE = 1e-5
"""Of the mean square temperature: thermometers side by side tell the same."""

HOUR_S = 3600.0


@dataclass(frozen=True, eq=False)
class Exchange:
    """Two plugs that changed places in some runs.

    Attributes
    ----------
    first, second : str
    runs : tuple of str
        In which they are exchanged, in the order in which they were made.
    evidence : float
        Log evidence of (2).
    repair : SensorRepair
    """

    first: str
    second: str
    runs: tuple[str, ...]
    evidence: float
    repair: SensorRepair

    @property
    def lasting(self) -> bool:
        """Whether these are all runs from one on, so that they are exchanged to this day."""
        return "not_in" in self.repair.parameters


def exchanges_between_runs(view: View) -> tuple[Exchange, ...]:
    """Return the pairs of plugs, one of them of the law, that changed places in some of a view's runs.

    Parameters
    ----------
    view : View
        Of all runs, those for validation too, in the order in which they were made.
    """
    found = list[Exchange]()
    few = len(view.runs) < FEWEST_RUNS or len(view.sensors) < FEWEST + 2
    if few or not (view.zeroed_by_run or _zero_is_known(view)) or not set(view.base) <= set(view.sensors):
        return ()
    while len(found) < MOST:
        best = max(_pairs(view), key=lambda item: item.evidence, default=None)
        if best is None:
            break
        found.append(best)
        view = mended_view(view, best.repair)
    return tuple(found)


def _pairs(view: View) -> Iterator[Exchange]:
    """Give the exchanges of single pairs that are sure."""
    zeros = _zeros(view)
    table = np.column_stack([*(view.temperatures(name) for name in view.sensors), np.ones(len(view.q))])
    run = view.channel.run
    grams = np.array([table[run == k].T @ table[run == k] for k in range(len(view.runs))])
    count = np.array([float((run == k).sum()) for k in range(len(view.runs))])
    hours = np.array([float(np.ptp(rows.signals.time)) / HOUR_S for rows in view.runs])
    for i, j in combinations(range(len(view.sensors)), 2):
        if {view.sensors[i], view.sensors[j]} & set(view.base):
            where, evidence = _where(grams, count, hours, i, j, zeros)
            found = _exchange(view, i, j, where, evidence) if evidence >= SURE else None
            if found is not None:
                yield found


def _zero_is_known(view: View) -> bool:
    """Return whether the run is there whose first row all others count from, with a reading of every thermometer."""
    known = all(set(view.sensors) <= rows.signals.zero_degC.keys() for rows in view.runs)
    return known and view.runs[0].run.name == view.order[0]


def _zeros(view: View) -> FloatArray | None:
    """Return the thermometers' zero where all runs count from one, shape (s,) [degC]; None where each has its own."""
    if view.zeroed_by_run:
        return None
    return np.array([view.runs[0].signals.zero_degC[name] for name in view.sensors])


def _where(
    grams: FloatArray, count: FloatArray, hours: FloatArray, i: int, j: int, zeros: FloatArray | None
) -> tuple[FloatArray, float]:
    """Return in which runs a pair is exchanged, shape (r,) of 0 and 1, and the log evidence; 0 where it is not so.

    Parameters
    ----------
    grams : array, shape (r, s + 1, s + 1)
        Of each run's temperatures, and of ones.
    count, hours : array, shape (r,)
        Windows and length of each run.
    i, j : int
    zeros : array, shape (s,) [degC], optional
        That all runs count from: those of the first run, in which the pair then counts as it stands.
    """
    runs, ones = len(grams), grams.shape[1] - 1
    rest = np.delete(np.arange(ones), [i, j])
    other = np.eye(ones + 1)
    other[:, [i, j]] = other[:, [j, i]]
    if zeros is not None:
        other[ones, [i, j]] = zeros[[j, i]] - zeros[[i, j]]
    both = np.stack([grams, other.T @ grams @ other])  # as recorded, and exchanged
    pair = _Pair(grams[:, rest][:, :, rest], both[:, :, rest][:, :, :, [i, j]],
                 np.stack([both[:, :, i, i], both[:, :, j, j]], axis=-1))  # fmt: skip
    free = np.eye(runs)[int(zeros is not None) :]
    ways = np.unique(np.vstack([free, np.tri(runs, runs, -1).T]), axis=0)
    ways = _in_some(ways)
    none, *left = pair.left(np.vstack([np.zeros(runs), ways])).tolist()
    where, least = _flipped(pair, ways[int(np.argmin(left))], min(left), free)
    if none < (1.0 + LEAST_LEFT / runs) * least:
        return where, 0.0
    # runs that are compared do not help to foretell: one that is warm as no other may be foretold to be anything
    few = where if 2.0 * where.sum() <= runs else 1.0 - where
    pair = pair if few is where else pair.turned
    at, sound_at = few == 1.0, few == 0.0
    own = np.array([pair.left_in(k, pair.weights(sound_at & (np.arange(runs) != k))) for k in range(runs)])
    off, right = (own[at, k].sum(axis=0) / count[at].sum() for k in (0, 1))
    sound, wrong = (own[sound_at, k].sum(axis=0) / count[sound_at].sum() for k in (0, 1))
    seen = (np.minimum(off, wrong) > OFF**2 * np.maximum(right, sound)) & (right <= ALIKE**2 * sound)
    gained = np.log(off / np.maximum(right, np.finfo(float).tiny)) if seen.all() else np.zeros(2)
    return where, 0.5 * float(hours[at].sum() * gained.sum())


def _in_some(ways: FloatArray) -> FloatArray:
    """Return the ways, shape (w, r), in which a pair is exchanged in some runs, and sits right in others."""
    exchanged = ways.sum(axis=1)
    return np.asarray(ways[(exchanged > 0.0) & (exchanged < ways.shape[1])])


def _flipped(pair: _Pair, where: FloatArray, least: float, free: FloatArray) -> tuple[FloatArray, float]:
    """Return runs in which a pair is exchanged, one more or one less as long as that leaves less, and what they leave.

    Exchanged in some runs or in all others leaves the same: the runs that may change are `free`, shape (f, r).
    """
    while True:
        ways = _in_some(np.abs(where - free))
        left = pair.left(ways) if len(ways) else np.array([least])
        if left.min() >= (1.0 - FEWER) * least:
            break
        where, least = ways[int(np.argmin(left))], float(left.min())
    return where, least


@dataclass(frozen=True, eq=False)
class _Pair:
    """A pair against the rest of the thermometers, run by run; as recorded (0) and exchanged (1).

    Attributes
    ----------
    rest : array, shape (r, k, k)
        Products of the rest.
    cross : array, shape (2, r, k, 2)
        Of the rest with the pair.
    own : array, shape (2, r, 2)
        Squares of the pair.
    """

    rest: FloatArray
    cross: FloatArray
    own: FloatArray

    @property
    def turned(self) -> _Pair:
        """The pair with recorded and exchanged in each other's place."""
        return _Pair(self.rest, self.cross[::-1], self.own[::-1])

    def weights(self, used: npt.NDArray[np.bool_]) -> FloatArray:
        """Return what foretells a pair as recorded, by the runs that are used, shape (k, 2)."""
        return np.asarray(
            linalg.solve(self._total(used.astype(float)), self.cross[0, used].sum(axis=0), assume_a="pos")
        )

    def left(self, ways: FloatArray) -> FloatArray:
        """Return the squares that stay if all runs foretell a pair, exchanged in some in each way, shape (w,)."""
        cross = np.tensordot(1.0 - ways, self.cross[0], 1) + np.tensordot(ways, self.cross[1], 1)  # (w, k, 2)
        own = (1.0 - ways) @ self.own[0].sum(axis=1) + ways @ self.own[1].sum(axis=1)
        flat = cross.transpose(1, 0, 2).reshape(cross.shape[1], -1)
        told = linalg.solve(self._total(np.ones(len(self.rest))), flat, assume_a="pos") * flat
        return np.asarray(own - told.reshape(cross.shape[1], -1, 2).sum(axis=(0, 2)))

    def left_in(self, run: int, weights: FloatArray) -> FloatArray:
        """Return the squares that weights leave in one run, as recorded and exchanged, shape (2, 2)."""
        told = np.einsum("kp,kl,lp->p", weights, self.rest[run], weights)
        return np.asarray(self.own[:, run] - 2.0 * np.einsum("wkp,kp->wp", self.cross[:, run], weights) + told)

    def _total(self, used: FloatArray) -> FloatArray:
        """Return the products of the rest over runs, with the ridge, shape (k, k)."""
        return ridged(np.tensordot(used, self.rest, 1))


def ridged(products: FloatArray) -> FloatArray:
    """Return products of thermometers with a ridge, shape (k, k)."""
    ridge = RIDGE * np.trace(products) / len(products) + np.finfo(float).tiny
    return np.asarray(products + ridge * np.eye(len(products)))


def _exchange(view: View, i: int, j: int, where: FloatArray, evidence: float) -> Exchange | None:
    """Return an exchange in those runs, or in all others, as is likelier; None where neither is."""
    first, second = (view.sensors[k] for k in ((i, j) if view.sensors[i] in view.base else (j, i)))
    wrong = _likelier(view, first, second, where == 1.0)
    if wrong is None:
        return None
    return Exchange(first, second, _names(view, wrong), evidence, _swap(view, first, second, wrong))


def _likelier(view: View, first: str, second: str, where: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_] | None:
    """Return the runs in which plugs are exchanged: some, or all others, which no foretelling tells apart.

    The order along the leg tells, and that plugs sit right in more runs than not; where they changed places but once,
    the drift, too. None where all leave it open.
    """
    right = Order(mended_view(view, _swap(view, first, second, where)))
    said = RIGHT * float((~where).sum() - where.sum()) - right.advantage(first, second)
    said += _in_the_drift(view, first, second, where) if np.diff(where).sum() == 1 else 0.0
    return None if abs(said) < UNSURE else (where if said > 0.0 else ~where)


def _in_the_drift(view: View, first: str, second: str, where: npt.NDArray[np.bool_]) -> float:
    """Return the log evidence in the drift of fitted runs for plugs exchanged in some, rather than in all others.

    The drift tells by which of both the law reads it: no more than the law's own thermometers can be trusted,
    `MOST_BY_DRIFT`, for a law may lack the other one.
    """
    fitted = replace(view, runs=tuple(rows for rows in view.runs if rows.run.role == "identification"))

    def evidence(wrong: npt.NDArray[np.bool_]) -> float:
        mended = mended_view(fitted, _swap(view, first, second, wrong))
        columns = mended.base_columns
        return mended.channel.fitted(columns, mended.channel.loose(columns))[1]

    said = evidence(where) - evidence(~where) if fitted.runs else 0.0
    return float(np.clip(said, -MOST_BY_DRIFT, MOST_BY_DRIFT))


def _swap(view: View, first: str, second: str, wrong: npt.NDArray[np.bool_]) -> SensorRepair:
    """Return the repair of two plugs that are exchanged in some runs, to this day where these are all from one on."""
    of, else_ = {"only_in": _names(view, wrong)}, _names(view, wrong != wrong[0])
    if int(np.diff(wrong).sum()) == 1 and wrong[-1]:
        start = view.order.index(_names(view, wrong)[0])
        of, else_ = {"not_in": view.order[:start]}, view.order[start:]
    if not view.zeroed_by_run:
        of["zero_else"] = else_
    return SensorRepair(CAUSE.name, "swap", {"first": first, "second": second, **of})


def _names(view: View, runs: npt.NDArray[np.bool_]) -> tuple[str, ...]:
    """Return the names of some of a view's runs."""
    return tuple(rows.run.name for rows, own in zip(view.runs, runs, strict=True) if own)


def told_of(exchange: Exchange, view: View, coefficients: FloatArray, covariance: FloatArray) -> Beforehand:
    """Return an exchange as an effect, told by what the drift would show of it.

    Parameters
    ----------
    exchange : Exchange
    view : View
        Of all runs, in which it is not mended yet.
    coefficients, covariance : array
        Of the law's columns, fitted where it is mended.
    """
    changed = mended_view(view, exchange.repair).base_columns - view.base_columns
    seen = float(visible((changed @ coefficients)[:, None], view.base_columns)[0])
    spread = float(np.sqrt(np.einsum("np,pq,nq->n", changed, covariance, changed).mean()))
    runs = exchange.runs
    settings = {"other": exchange.second, "runs": ", ".join(runs)}
    where = f"from {runs[0]} on" if exchange.lasting else f"in {', '.join(runs)}"
    sentence = (
        f"Plugs are exchanged, {CAUSE.name} ({where}): what is written there under {exchange.first} and "
        f"{exchange.second} is the other's temperature, as the thermometers beside them tell; {two_digits(seen * UM)} "
        "um of it would stay visible in the drift of all runs."
    )
    effect = Effect(CAUSE.name, exchange.first, {}, settings, SOUND, (), seen, sentence, joined=True)
    return Beforehand(effect, exchange.evidence, spread)
