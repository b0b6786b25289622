"""Temperatures smoothed by parabolas, and the profiles that lead among them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from scipy import ndimage, signal

from hexathermal.poses import FloatArray

SMOOTHED_S = 300.0
"""Temperatures are smoothed by a parabola over so long: short against heat's times, long against readings' noise."""

FEWEST_SMOOTHED = 5
"""Fewer rows than this are not smoothed."""

THINNED_ROWS = 300
"""About so many rows of a run are enough to tell its leading profiles."""


GAP, GAP_ROWS = 0.5, 3.0
"""Times without rows, over that of the parabola and over the usual time from row to row, across which nothing is
smoothed: that is a gap of the logger."""

UNEVEN = 0.25
"""Rows whose times differ from even ones by more than this part of a row are smoothed on even ones."""


def smoothed(time: FloatArray, values: FloatArray, over: float = SMOOTHED_S) -> FloatArray:
    """Return values, shape (n, s), smoothed by a parabola over `over` seconds (Savitzky and Golay, 1964).

    Each stretch without a gap by itself; rows at uneven times by way of even ones.

    Examples
    --------
    A line stays one across a gap.

    >>> time = np.concatenate([np.arange(0.0, 1000.0, 20.0), np.arange(4600.0, 6000.0, 20.0)])
    >>> float(np.abs(smoothed(time, time[:, None]) - time[:, None]).max()) < 1e-9
    True
    """
    step = np.diff(time)
    usual = float(np.median(step))
    begins = np.flatnonzero(step > max(GAP * over, GAP_ROWS * usual)) + 1
    if not len(begins):
        return _stretch(time, values, over)
    pieces = zip(np.split(time, begins), np.split(values, begins), strict=True)
    return np.concatenate([_stretch(*piece, over) for piece in pieces])


def _stretch(time: FloatArray, values: FloatArray, over: float) -> FloatArray:
    """Return values of rows without a gap, smoothed; those of few rows as they are."""
    if len(time) < FEWEST_SMOOTHED:
        return values
    step = np.diff(time)
    usual = float(np.median(step))
    if np.abs(step - usual).max() <= UNEVEN * usual or usual <= 0.0:
        return _even(values, smoothing_rows(time, over))
    even = np.linspace(time[0], time[-1], 1 + max(round((time[-1] - time[0]) / usual), 1))
    table = np.column_stack([np.interp(even, time, column) for column in values.T])
    table = _even(table, smoothing_rows(even, over))
    return np.column_stack([np.interp(time, even, column) for column in table.T])


def _even(values: FloatArray, count: int) -> FloatArray:
    """Return values of even rows, smoothed over `count` of them; where there are not so many, as they are."""
    if count < FEWEST_SMOOTHED or count > len(values):
        return values
    out = np.asarray(ndimage.convolve1d(values, _parabola(count), axis=0, mode="nearest"))
    edge = _edge(count)
    out[: len(edge)] = edge @ values[:count]
    out[len(out) - len(edge) :] = edge[::-1, ::-1] @ values[len(values) - count :]
    return out


def smoothing_rows(time: FloatArray, over: float) -> int:
    """Return the rows of a parabola that smooths over so many seconds: an odd number."""
    return 2 * int(over / float(np.median(np.diff(time))) / 2.0) + 1


@lru_cache(maxsize=64)
def _parabola(count: int) -> FloatArray:
    """Return the weights of neighbours of which the middle of the parabola through them is made, shape (count,)."""
    weights = np.asarray(signal.savgol_coeffs(count, 2))
    weights.flags.writeable = False
    return weights


@lru_cache(maxsize=64)
def _edge(count: int) -> FloatArray:
    """Return the weights of the first values of which the parabola through them is made, shape (count // 2, count)."""
    design = np.vander(np.linspace(-1.0, 1.0, count), 3)
    edge = design[: count // 2] @ np.linalg.pinv(design)
    edge.flags.writeable = False
    return np.asarray(edge)


def leading_profiles(tables: Sequence[FloatArray], count: int) -> FloatArray:
    """Return the weights of columns in their leading profiles over all runs, largest first, shape (s, count)."""
    stacked = np.concatenate([table[:: max(1, len(table) // THINNED_ROWS)] for table in tables])
    _w, vectors = np.linalg.eigh(stacked.T @ stacked)
    return np.asarray(vectors[:, ::-1][:, :count])
