"""A channel of measurements in windows, and its noise: white, scatter of landings, a slow process, an offset of runs.

``y_w = x_w b + wander_w (offset_run + slow(t_w)) + landing_l + white / sqrt(rows)``. The landing, each stop after a
move, is the independent unit, not the sample. The levels maximise the likelihood with the coefficients' priors
integrated out; the slow process is of first order (Ornstein-Uhlenbeck). Of a leg whose runs count from their own first
rows, so does it: ``offset_run = -slow(0) - noise of that row``. A Kalman filter of three states whitens in linear time.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from hexathermal.learn.diagnosis.coefficients import expected, marginal, sized, solution, sums_without
from hexathermal.poses import FloatArray

Rows = TypeVar("Rows", float, FloatArray)

SLOW_TIMES, WALKING_S = (900.0, 2400.0, 7200.0), 21600.0
"""Correlation times that the slow process may have [s]; and one as slow as a run, of what walks without an end."""

ALIKE = 1e-6
"""Of the values' scatter: a smaller middle difference of neighbours is none."""

UNDECIDED = 3.0
"""Log likelihood that the second slow time may lack half-way and still be the first when both are followed."""

MANY = 12
"""Columns from which on a fit of the noise leaves out what says nothing."""

SILENT = 0.5
"""Information on a coefficient of prior N(0, 1) below which its column hardly moves the levels of the noise."""


@dataclass(frozen=True)
class Levels:
    """Standard deviations of the noise's parts, in the channel's unit, and the slow process's correlation time [s].

    `least` is what each window has at least, `rows` how many rows a usual one is the mean of. Of a channel that `walks`
    the offset holds what the slow process is when a run begins, and goes against it: `Channel.counted` gives parts that
    are independent.
    """

    white: float
    landing: float
    slow: float
    offset: float
    slow_time: float = 2400.0
    least: float = 0.0
    rows: float = 1.0

    @property
    def usual(self) -> float:
        """RMS of a usual window, offsets apart."""
        return math.sqrt(self.variance(self.rows))

    @property
    def rms(self) -> float:
        """RMS of a single row, offsets apart."""
        return math.hypot(self.landing, self.slow, self.white, self.least)

    def variance(self, rows: Rows) -> Rows:
        """Return the variance of windows that are means of so many rows, offsets apart."""
        return self.white**2 / rows + self.landing**2 + self.slow**2 + self.least**2


@dataclass(frozen=True, eq=False)
class Channel:
    """One measured quantity in windows, n of them, run after run.

    Attributes
    ----------
    y : array, shape (n,)
    start, fresh : array of bool, shape (n,)
        First window of a run, of a landing.
    step : array, shape (n,) [s]
        Since the window before; 0 at a start.
    rows : array, shape (n,)
        That the window is the mean of.
    run : array of int, shape (n,)
    has_landings : bool
        Whether landings scatter: there is none where nothing moves.
    tied_offsets : bool
        Whether the offset of a run is the noise of its own first row, from which it counts, what wanders apart;
        otherwise offsets of runs are what they are: thermometers walk through a long campaign.
    zeroed_by_run : bool
        Whether each run counts from its own first row.
    shown : array, shape (n,), optional
        How much of what wanders, the slow process and offsets, each window shows; by default 1.
    floor : array, shape (n,), optional
        Noise of each window that no level makes smaller; by default 0.
    walks : bool
        Whether what wanders counts from each run's first row, where it is nothing, too, and may be as slow as a run.
    """

    y: FloatArray
    start: npt.NDArray[np.bool_]
    fresh: npt.NDArray[np.bool_]
    step: FloatArray
    rows: FloatArray
    run: npt.NDArray[np.int64]
    has_landings: bool = True
    tied_offsets: bool = True
    zeroed_by_run: bool = True
    shown: FloatArray | None = None
    floor: FloatArray | None = None
    walks: bool = False

    def __len__(self) -> int:
        return len(self.y)

    @cached_property
    def wander(self) -> FloatArray:
        """How much of what wanders each window shows, shape (n,)."""
        return np.ones(len(self)) if self.shown is None else self.shown

    @cached_property
    def _least(self) -> FloatArray:
        """Least variance of each window, shape (n,)."""
        return np.zeros(len(self)) if self.floor is None else self.floor**2

    @cached_property
    def _usual_rows(self) -> float:
        """How many rows a usual window is the mean of."""
        return float(np.median(self.rows))

    @cached_property
    def _since(self) -> FloatArray:
        """Time since the first window of its run of each window, shape (n,) [s]."""
        time = np.cumsum(np.where(self.start, 0.0, self.step))
        return np.asarray(time - np.maximum.accumulate(np.where(self.start, time, 0.0)))

    def counted(self, levels: Levels) -> Levels:
        """Return levels whose parts are independent: what walks by its mean square over windows, the row's noise alone.

        ``var(slow(t) - slow(0)) = 2 s^2 (1 - exp(-t / tau))``.
        """
        if not self.walks:
            return levels
        grown = -2.0 * float(np.expm1(-self._since / levels.slow_time).mean())
        own = math.sqrt(max(levels.offset**2 - levels.slow**2, 0.0))
        return replace(levels, slow=levels.slow * math.sqrt(grown), offset=own)

    def alone(self, levels: Levels) -> FloatArray:
        """Return the variance of each window by itself, shape (n,)."""
        return np.asarray(levels.white**2 / self.rows + self._least)

    @cached_property
    def scale(self) -> float:
        """A first guess of the noise: from differences of neighbouring windows."""
        inside = ~self.start
        jump = np.diff(self.y, prepend=self.y[:1])[inside]
        middle = float(np.median(np.abs(jump)) / 0.954) if jump.size else float(np.std(self.y))
        # most neighbours alike: of a reading in coarse steps the middle difference says nothing
        size = middle if middle > ALIKE * float(np.std(self.y)) else float(np.sqrt(np.mean(self.y**2)))
        return max(size, 1e-12)

    def whitened(self, columns: FloatArray, levels: Levels) -> tuple[FloatArray, float]:
        """Return columns (n, m) whitened, and log det V."""
        from hexathermal.learn.diagnosis.whitening_loops import whiten

        table = np.ascontiguousarray(columns, dtype=np.float64)
        out = np.empty_like(table)
        white, landing = self.alone(levels), levels.landing**2
        logdet = whiten(table, self.start, self.fresh, self._decay(levels.slow_time), self.wander, white, landing,
                        levels.slow**2, levels.offset**2, self.walks, out)  # fmt: skip
        return out, float(logdet)

    def _decay(self, slow_time: float) -> FloatArray:
        """Return what stays of the slow process since the window before, shape (n,); it is made once."""
        if slow_time not in self._decays:
            self._decays[slow_time] = np.exp(-self.step / slow_time)
        return self._decays[slow_time]

    @cached_property
    def _decays(self) -> dict[float, FloatArray]:
        """What `_decay` keeps."""
        return {}

    def spread(self, G: FloatArray, levels: Levels) -> FloatArray:
        """Return ``G' V G`` of columns G, shape (n, m): the covariance of sums over windows that G weighs, (m, m)."""
        landing = np.cumsum(self.fresh)
        total = np.zeros((G.shape[1], G.shape[1]))
        for k in np.unique(self.run):
            own = self.run == k
            time = self._since[own]
            V = levels.slow**2 * np.exp(-np.abs(time[:, None] - time) / levels.slow_time) + levels.offset**2
            if self.walks:
                begun = np.exp(-time / levels.slow_time)
                V -= min(levels.slow, levels.offset) ** 2 * (begun[:, None] + begun)
            V *= self.wander[own][:, None] * self.wander[own]
            V += levels.landing**2 * (landing[own][:, None] == landing[own])
            V[np.diag_indices_from(V)] += self.alone(levels)[own]
            total += G[own].T @ V @ G[own]
        return total

    def loose(self, X: FloatArray) -> FloatArray:
        """Return loose priors of coefficients, shape (m,): each column alone could make ten times the values."""
        return np.asarray(10.0 * np.sqrt((self.y**2).mean()) / np.sqrt((X**2).mean(axis=0) + 1e-30))

    def with_y(self, y: FloatArray) -> Channel:
        """Return the channel with other values."""
        return replace(self, y=y)

    def levels(self, theta: Sequence[float], slow_time: float) -> Levels:
        """Return the levels of log ratios to `scale`."""
        from hexathermal.learn.diagnosis.whitening_loops import levels_at

        white, landing, slow, offset = levels_at(np.asarray(theta), self.scale, self.has_landings, self.walks)
        return Levels(white, landing, slow, offset, slow_time, float(np.sqrt(self._least.min())), self._usual_rows)

    def theta(self, levels: Levels) -> tuple[float, ...]:
        """Return the logarithms of levels over `scale`, and of the offset's over what the first row's should be."""
        from hexathermal.learn.diagnosis.whitening_loops import logarithms

        parts = levels.white, levels.landing, levels.slow, levels.offset
        return tuple(logarithms(*parts, self.scale, self.walks).tolist())

    def evidence(self, X: FloatArray, sd: FloatArray, levels: Levels) -> float:
        """Return log p(y) with coefficients of columns X integrated over N(0, sd^2), constants left out."""
        return self.evidences(X, sd, [levels])[0]

    def evidences(self, X: FloatArray, sd: FloatArray, pool: Iterable[Levels]) -> list[float]:
        """Return `evidence` at several levels."""
        table = sized(self.y, X, sd)
        return [self._evidence(table, levels) for levels in pool]

    def _evidence(self, table: FloatArray, levels: Levels) -> float:
        """Return `evidence` of a table as `sized` gives it."""
        from hexathermal.learn.diagnosis.whitening_loops import log_evidence

        white, landing = self.alone(levels), levels.landing**2
        value = log_evidence(table, self.start, self.fresh, self._decay(levels.slow_time), self.wander, white, landing,
                             levels.slow**2, levels.offset**2, self.walks)  # fmt: skip
        return float(value) + self.prior(levels)

    def solved(self, X: FloatArray, sd: FloatArray, levels: Levels) -> tuple[float, FloatArray]:
        """Return the evidence of the whitened channel with columns X, without log det V, and coefficients' means."""
        table, _ = self.whitened(np.column_stack([self.y, X]), levels)
        return expected(table[:, 0], table[:, 1:], sd)

    def estimated(self, X: FloatArray, sd: FloatArray, levels: Levels) -> tuple[FloatArray, FloatArray]:
        """Return means and covariance of the coefficients of columns X."""
        table, _ = self.whitened(np.column_stack([self.y, X]), levels)
        return marginal(table[:, 0], table[:, 1:], sd)[1:]

    def left_out(self, X: FloatArray, sd: FloatArray, levels: Levels) -> tuple[FloatArray, FloatArray]:
        """Return residuals of each run by a fit of all others, as they are and whitened, shape (n,)."""
        table, _ = self.whitened(np.column_stack([self.y, X]), levels)
        left, white = np.empty(len(self)), np.empty(len(self))
        for k, mean in zip(np.unique(self.run), self._without_each(table, sd), strict=True):
            own = self.run == k
            left[own] = self.y[own] - X[own] @ mean
            white[own] = table[own, 0] - table[own, 1:] @ mean
        return left, white

    def without_each(self, X: FloatArray, sd: FloatArray, levels: Levels) -> FloatArray:
        """Return the coefficients of fits without each run, shape (r, m)."""
        return self._without_each(self.whitened(np.column_stack([self.y, X]), levels)[0], sd)

    def _without_each(self, table: FloatArray, sd: FloatArray) -> FloatArray:
        """Return the coefficients of fits without each run, of whitened data and columns, shape (r, m)."""
        scaled = table * np.append(1.0, sd)
        products = [scaled[own].T @ scaled[own] for own in (self.run == k for k in np.unique(self.run))]
        return np.array([sd * solution(others)[1] for others in sums_without(products)])

    def plain(self, levels: Levels) -> Levels:
        """Return a noise that weighs windows by their rows alone: least squares, as a law without causes is fitted."""
        size, little = levels.rms, 1e-3 * levels.rms
        return replace(levels, white=size * math.sqrt(self._usual_rows), landing=little, slow=little, offset=little)

    def prior(self, levels: Levels) -> float:
        """Return the log prior of levels: loose about the channel's own scale; an offset is the first row's noise."""
        from hexathermal.learn.diagnosis.whitening_loops import log_prior

        parts = levels.white, levels.landing, levels.slow, levels.offset
        return float(log_prior(*parts, self.scale, self.has_landings, self.tied_offsets, self.walks))

    def fitted(
        self, X: FloatArray, sd: FloatArray, begin: Levels | None = None, most: int = 90, near: Levels | None = None
    ) -> tuple[Levels, float]:
        """Return the levels of the largest evidence, and that evidence.

        Parameters
        ----------
        X : array, shape (n, m)
        sd : array, shape (m,)
            Standard deviations of the coefficients' priors.
        begin : Levels, optional
            Where to start, with its slow time, or a shorter one where that is likelier; by default all slow times are
            tried, and the best, or the best two where they are near each other, are followed to the end.
        most : int
            Evaluations of the likelihood, for each slow time that is followed.
        near : Levels, optional
            Where to start with each slow time.
        """
        whole = sized(self.y, X, sd)
        if begin is not None:
            return self._quicker(whole, *self._closer(whole, begin, most, 0.35), most)
        table = whole if near is None else self._telling(whole, near)
        found = [self._fitted(table, self._begin(near, time), time, most // 2, 0.8) for time in self._times]
        first, second = sorted(found, key=lambda pair: -pair[1])[:2]
        ends = [self._closer(whole, first[0], 2 * most, 0.4)]
        if second[1] > first[1] - UNDECIDED:
            ends.append(self._closer(whole, second[0], 2 * most, 0.4))
        return max(ends, key=lambda pair: pair[1])

    @property
    def _times(self) -> tuple[float, ...]:
        """The correlation times that the slow process may have [s]."""
        return (*SLOW_TIMES, WALKING_S) if self.walks else SLOW_TIMES

    def quick(self, levels: Levels) -> Levels:
        """Return noise of the shortest slow time that changes as much within minutes as another one."""
        time = SLOW_TIMES[0]
        return levels if levels.slow_time <= time else self.levels(self._begin(levels, time), time)

    def _quicker(self, whole: FloatArray, found: Levels, value: float, most: int) -> tuple[Levels, float]:
        """Return levels and evidence, of a shorter slow time where that is likelier.

        What a column explains may be why it seemed to walk: with it, what is left wanders faster, and less far.
        """
        shorter = [self.levels(self._begin(found, time), time) for time in self._times if time < found.slow_time]
        if not shorter:
            return found, value
        told, best = max(((self._evidence(whole, one), one) for one in shorter), key=lambda pair: pair[0])
        if told <= value - UNDECIDED:
            return found, value
        closer, worth = self._closer(whole, best, most, 0.35)
        # from where that ends a still shorter one is nearer than from where it began
        return self._quicker(whole, closer, worth, most) if worth > value else (found, value)

    def _begin(self, near: Levels | None, slow_time: float) -> tuple[float, ...]:
        """Return logarithms of levels to start from with a slow time: such as change as much within minutes.

        ``var(slow(t + dt) - slow(t)) = 2 s^2 dt / tau`` for short dt: what seemed to walk may stay near where it is.
        """
        if near is None:
            return tuple(math.log(value) for value in (0.7, 0.7, 0.4, 1.0))
        white, landing, slow, offset = self.theta(near)
        return white, landing, slow + 0.5 * math.log(slow_time / near.slow_time), offset

    def _closer(self, whole: FloatArray, begin: Levels, most: int, spread: float) -> tuple[Levels, float]:
        """Return the best levels near some, and the evidence of all columns of a table there.

        Where the noise falls so far that more columns say something, once more with these.
        """
        table = self._telling(whole, begin)
        levels, value = self._fitted(table, self.theta(begin), begin.slow_time, most, spread)
        if table is whole:
            return levels, value
        more = self._telling(whole, levels)
        if more.shape[1] > table.shape[1]:
            levels, _ = self._fitted(more, self.theta(levels), levels.slow_time, most, spread)
        # what was left out might have spoken against going from where the search began
        ends = [(self._evidence(whole, one), one) for one in (levels, begin)]
        value, best = max(ends, key=lambda pair: pair[0])
        return best, value

    def _telling(self, table: FloatArray, levels: Levels) -> FloatArray:
        """Return y and the turned columns of unit priors that say something, of a table of many columns.

        A turn changes nothing: ``X b = (X V)(V' b)``, and V'b is N(0, 1) as b is. V are the eigenvectors of ``X' V^-1
        X`` at these levels; a coefficient of information g adds ``g z^2 / (1 + g) / 2 - log(1 + g) / 2``, nearly
        nothing where g is small.
        """
        if table.shape[1] <= MANY:
            return table
        white, _ = self.whitened(table[:, 1:], levels)
        told, turn = np.linalg.eigh(white.T @ white)
        return np.column_stack([table[:, 0], table[:, 1:] @ turn[:, told > SILENT]])

    def _fitted(
        self, table: FloatArray, theta: Sequence[float], slow_time: float, most: int, spread: float
    ) -> tuple[Levels, float]:
        """Return the best levels near a start for one slow time; `table` as `sized` gives it."""
        from hexathermal.learn.diagnosis.whitening_loops import likeliest

        found = np.array(theta)
        value = likeliest(found, spread, most, table, self.start, self.fresh, self._decay(slow_time), self.wander,
                          1.0 / self.rows, self._least, self.scale, self.has_landings, self.tied_offsets,
                          self.walks)  # fmt: skip
        return self.levels(found.tolist(), slow_time), float(value)
