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


def smoothed(time: FloatArray, values: FloatArray, over: float = SMOOTHED_S) -> FloatArray:
    """Return values, shape (n, s), smoothed by a parabola over `over` seconds (Savitzky and Golay, 1964)."""
    count = smoothing_rows(time, over)
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
