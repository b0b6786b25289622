"""What readings of thermometers tell of their own noise: their difference from a smooth course of time.

A course is a normal process of covariance ``c k(t - t')``, smooth over a length of time, beside a parabola that may be
anything; readings add white noise of variance ``s^2``.  With ``G = s^2 (c K + s^2)^-1`` the readings x hold the errors

    f = G x,    each give or take  s sqrt(h),   h_i = 1 - G_ii

(Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, 2.25 and 2.26): ``h_i`` is the part that a
reading has in its own smooth course, and ``f_i`` has the variance ``(1 - h_i) s^2``.  Length and ``s^2 / c`` are those
of a grid that make the readings likeliest: long over slow heat, short over fast.

Where a run begins, heat often sets in, and is less smooth than elsewhere.  What f holds there besides noise is seen in
its size, ``r^2 = mean f^2 / (1 - h)``. With ``l = s^2 / r^2`` a reading's own error is ``l f`` there, give or take ``s
sqrt(1 - l (1 - h))``: the best linear estimate.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from hexathermal.poses import FloatArray

FEWEST = 12
"""Rows of a run that tell of noise; shorter runs tell nothing."""

MOST = 150
"""Rows that are looked at together; longer runs are cut."""

LENGTHS = (4.0, 8.0, 16.0, 32.0, 64.0)
"""Of what is smooth, in intervals of rows."""

RATIOS = 10.0 ** np.arange(-6.0, 1.1, 0.5)
"""Variance of the noise over that of the course."""

ANYTHING = 1e4
"""Prior variance of the parabola, over that of the course."""

BEGINNING = 3
"""Rows with which a run begins."""


@dataclass(frozen=True, eq=False)
class Readings:
    """Noise that is seen in readings.

    Attributes
    ----------
    flicker : array, shape (n, ...) [K]
        What of each reading is off its smooth course; 0 in runs too short to tell.
    own : array, shape (n, ...)
        Part h of a reading in its smooth course; 1 in runs too short to tell.
    beginning : float [K]
        Size r of all thermometers' flicker where runs begin, as noise; 0 where it cannot be told.
    """

    flicker: FloatArray
    own: FloatArray
    beginning: float = 0.0

    @property
    def noise(self) -> FloatArray:
        """Standard deviation of each thermometer's noise, shape (...) [K]; 0 where it cannot be told."""
        freedom = (1.0 - self.own).sum(axis=0)
        square = (self.flicker**2).sum(axis=0)
        return np.asarray(np.sqrt(np.divide(square, freedom, out=np.zeros_like(square), where=freedom > 0.0)))


def flickering(time: FloatArray, run: npt.NDArray[np.int64], values: FloatArray) -> Readings:
    """Return what readings tell of their noise.

    Parameters
    ----------
    time : array, shape (n,) [s]
    run : array, shape (n,), int
    values : array, shape (n, ...) [K]

    Examples
    --------
    >>> t = np.arange(20.0)
    >>> bool(np.abs(flickering(t, np.zeros(20, dtype=int), t**2).flicker).max() < 0.01)
    True
    """
    flat = values.reshape(len(values), -1)
    parts = [np.flatnonzero(run == k) for k in np.unique(run)]
    cut = [own for rows in parts if len(rows) >= FEWEST for own in np.array_split(rows, -(-len(rows) // MOST))]
    flicker, own = np.zeros(flat.shape), np.ones(flat.shape)
    for k, (length, ratio) in enumerate(_likeliest(time, cut, flat)):
        for rows in cut:
            w, V = _modes(_steps(time[rows]).tobytes(), length)
            g = ratio / (w + ratio)
            flicker[rows, k] = V @ (g * (V.T @ (flat[rows, k] - flat[rows[0], k])))
            own[rows, k] = 1.0 - V**2 @ g
    first = np.concatenate([rows[:BEGINNING] for rows in parts])
    told = own[first] < 1.0
    size = float(np.sqrt((flicker[first][told] ** 2 / (1.0 - own[first][told])).mean())) if told.any() else 0.0
    return Readings(flicker.reshape(values.shape), own.reshape(values.shape), size)


def _likeliest(time: FloatArray, parts: list[npt.NDArray[np.int64]], values: FloatArray) -> list[tuple[float, float]]:
    """Return length and ratio of each column of values (n, m) that make it likeliest, with the best noise."""
    count = sum(len(rows) for rows in parts)
    if not count:
        return []
    best, found = np.full(values.shape[1], -np.inf), [(LENGTHS[0], float(RATIOS[0]))] * values.shape[1]
    for length in LENGTHS:
        square, cost = np.zeros((len(RATIOS), values.shape[1])), np.zeros(len(RATIOS))
        for rows in parts:
            w, V = _modes(_steps(time[rows]).tobytes(), length)
            g = RATIOS[:, None] / (w + RATIOS[:, None])
            square += g @ (V.T @ (values[rows] - values[rows[0]])) ** 2
            cost += np.log(g).sum(axis=1)
        # a course without any noise at all has no likeliest size of it
        value = 0.5 * cost[:, None] - 0.5 * count * np.log(np.maximum(square / count, 1e-24))
        for k in np.flatnonzero(value.max(axis=0) > best):
            at = int(np.argmax(value[:, k]))
            best[k], found[k] = value[at, k], (length, float(RATIOS[at]))
    return found


def _steps(time: FloatArray) -> FloatArray:
    """Return times from the first on, in usual intervals."""
    usual = float(np.median(np.diff(time)))
    return np.asarray((time - time[0]) / usual if usual > 0.0 else np.arange(len(time), dtype=np.float64))


@lru_cache(maxsize=128)
def _modes(steps: bytes, length: float) -> tuple[FloatArray, FloatArray]:
    """Return the course's variances and modes at times, (n,) and (n, n); plans ask often."""
    t = np.frombuffer(steps)
    x = np.linspace(-1.0, 1.0, len(t)) if not np.ptp(t) else 2.0 * t / t[-1] - 1.0
    K = (
        np.exp(-0.5 * ((t[:, None] - t) / length) ** 2)
        + ANYTHING * (x[:, None] ** np.arange(3)) @ (x[:, None] ** np.arange(3)).T
    )
    w, V = np.linalg.eigh(K)
    return np.maximum(w, 0.0), V
