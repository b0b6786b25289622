"""What readings of thermometers tell of their own noise: their difference from a local parabola of time.

A parabola that fits the rows about row i best is ``sum_j w_ij x_j``; a reading has the part ``h_i = w_ii`` in it. Of
white noise of variance s^2, ``x_i - sum_j w_ij x_j`` keeps ``(1 - h_i) s^2``, and once that difference f is known, the
reading's own error is f, give or take ``s sqrt(h_i)``. The width of the parabola is that which foretells readings left
out best, ``sum (f_i / (1 - h_i))^2`` (Allen, Technometrics 16 (1974) 125): wide over slow heat, narrow over fast.

Where a run begins a parabola has rows on one side alone and follows heat worse, so the width is chosen for these rows
by themselves, and what f holds besides noise is seen in its size, ``r^2 = mean f^2 / (1 - h)``. With ``l = s^2 / r^2``
a reading's own error is ``l f`` there, give or take ``s sqrt(1 - l (1 - h))``: the best linear estimate.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from hexathermal.poses import FloatArray

WIDTHS = (11, 21, 41)
"""Rows of which a parabola of time is made; shorter runs tell nothing of noise."""

BEGINNING = 3
"""Rows with which a run begins."""


@dataclass(frozen=True, eq=False)
class Readings:
    """Noise that is seen in readings.

    Attributes
    ----------
    flicker : array, shape (n, ...) [K]
        What of each reading is off its parabola; 0 in runs too short to tell.
    own : array, shape (n, ...)
        Part h of a reading in its parabola; 1 in runs too short to tell.
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
    >>> bool(np.abs(flickering(t, np.zeros(20, dtype=int), t**2).flicker).max() < 1e-9)
    True
    """
    flat = values.reshape(len(values), -1)
    parts = [np.flatnonzero(run == k) for k in np.unique(run)]
    first = np.zeros(len(flat), dtype=bool)
    first[np.concatenate([rows[:BEGINNING] for rows in parts])] = True
    best, least = np.full(flat.shape[1], np.inf), np.inf
    flicker, own = np.zeros(flat.shape), np.ones(flat.shape)
    for width in WIDTHS:
        off, kept = _off(time, parts, flat, width)
        left_out = np.square(np.divide(off, 1.0 - kept, out=np.zeros_like(off), where=kept < 1.0))
        better = left_out[~first].sum(axis=0) < best
        best = np.where(better, left_out[~first].sum(axis=0), best)
        chosen = ~first[:, None] & better
        if left_out[first].sum() < least:
            least = float(left_out[first].sum())
            chosen |= first[:, None]
        flicker[chosen], own[chosen] = off[chosen], kept[chosen]
    told = own[first] < 1.0
    size = float(np.sqrt((flicker[first][told] ** 2 / (1.0 - own[first][told])).mean())) if told.any() else 0.0
    return Readings(flicker.reshape(values.shape), own.reshape(values.shape), size)


def _off(
    time: FloatArray, parts: list[npt.NDArray[np.int64]], values: FloatArray, width: int
) -> tuple[FloatArray, FloatArray]:
    """Return what values (n, m) are off parabolas of a width, narrower in short runs, and each one's own part."""
    off, kept = np.zeros(values.shape), np.ones(values.shape)
    for rows in parts:
        fitting = max((one for one in WIDTHS if one <= width and one < len(rows)), default=0)
        if fitting:
            at = np.ascontiguousarray(time[rows], dtype=np.float64)
            smooth, h = _smoothed(at, values[rows], fitting)
            off[rows], kept[rows] = values[rows] - smooth, h[:, None]
    return off, kept


def _smoothed(time: FloatArray, values: FloatArray, width: int) -> tuple[FloatArray, FloatArray]:
    """Return values (n, m) by the parabola through the `width` rows about each, and each row's own part, (n,)."""
    window, weights, own = _parabolas(time.tobytes(), width)
    return np.asarray(np.einsum("nk,nkm->nm", weights, values[window])), own


@lru_cache(maxsize=64)
def _parabolas(times: bytes, width: int) -> tuple[npt.NDArray[np.int64], FloatArray, FloatArray]:
    """Return windows (n, width) of rows, their weights (n, width), and each row's own weight (n,); plans ask often."""
    time = np.frombuffer(times)
    n = len(time)
    first = np.clip(np.arange(n) - width // 2, 0, n - width)
    window = first[:, None] + np.arange(width)
    x = time[window] - time[:, None]
    span = np.abs(x).max(axis=1, keepdims=True)
    V = (x / np.where(span > 0.0, span, 1.0))[..., None] ** np.arange(3)
    # rows of one and the same time carry no slope: the pseudo-inverse leaves it 0
    inverse = np.linalg.pinv(np.swapaxes(V, 1, 2) @ V, hermitian=True)
    weights = np.einsum("nj,nkj->nk", inverse[:, 0], V)
    return window, weights, weights[np.arange(n), np.arange(n) - first]
