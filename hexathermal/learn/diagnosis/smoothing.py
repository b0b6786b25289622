"""Temperatures smoothed by parabolas, and the profiles that lead among them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise

import numpy as np
from scipy import ndimage

from hexathermal.machine.leg_signals import LegSignals
from hexathermal.poses import FloatArray

SMOOTHED_S = 300.0
"""Temperatures are smoothed by a parabola over so long: short against heat's times, long against readings' noise."""

FEWEST_SMOOTHED = 5
"""Fewer rows than this are not smoothed."""

BANDS_S = (SMOOTHED_S, 900.0, 2400.0)
"""Times over which a temperature is smoothed to tell what in it is how quick."""

THINNED_ROWS = 300
"""About so many rows of a run are enough to tell its leading profiles."""


GAP, GAP_ROWS = 0.5, 3.0
"""Times without rows, over that of the parabola and over the usual time from row to row, across which nothing is
smoothed: that is a gap of the logger."""

UNEVEN, FINEST = 0.25, 300.0
"""Rows whose times differ from even ones by more than this part of a row are smoothed on even ones, of which there are
at most so many in the time of a parabola."""


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
    return np.concatenate([_stretch(time[part], values[part], over) for part in _stretches(time, over)])


def noise_left(time: FloatArray, over: float = SMOOTHED_S) -> FloatArray:
    """Return what smoothing leaves of the white noise of each row, RMS, shape (n,): 3 / (2 sqrt(m)) of m rows.

    Of a parabola through the m rows within `over` seconds of one stretch, the middle has that, m being
    ``(sum dt)^2 / sum dt^2`` where rows stand for times dt that differ; 1 where nothing is smoothed.

    Examples
    --------
    >>> noise_left(np.arange(0.0, 3000.0, 20.0)).max().round(3)
    np.float64(0.387)
    """
    found = []
    for part in _stretches(time, over):
        own = time[part]
        rows = _told_by(own, over) if _uneven(own) else np.full(len(own), float(_count(own, over)))
        found.append(np.where(rows < FEWEST_SMOOTHED, 1.0, 1.5 / np.sqrt(rows)))
    return np.concatenate(found)


def _stretches(time: FloatArray, over: float) -> list[slice]:
    """Return the rows of each stretch without a gap."""
    if len(time) < FEWEST_SMOOTHED:
        return [slice(0, len(time))]
    step = np.diff(time)
    begins = np.flatnonzero(step > max(GAP * over, GAP_ROWS * float(np.median(step)))) + 1
    edges = [0, *begins.tolist(), len(time)]
    return [slice(first, last) for first, last in pairwise(edges)]


def _uneven(time: FloatArray) -> bool:
    """Return whether rows differ from even ones by more than `UNEVEN`."""
    step = np.diff(time)
    usual = float(np.median(step)) if len(step) else 0.0
    return usual > 0.0 and bool(np.abs(step - usual).max() > UNEVEN * usual)


def _told_by(time: FloatArray, over: float) -> FloatArray:
    """Return how many rows tell of each: within `over` seconds, each for the time that it stands for."""
    own = np.gradient(time)
    begin = np.clip(time - 0.5 * over, time[0], max(time[0], time[-1] - over))
    first, last = np.searchsorted(time, begin, "left"), np.searchsorted(time, begin + over, "right")
    sums, squares = (np.concatenate([[0.0], np.cumsum(values)]) for values in (own, own**2))
    return np.asarray((sums[last] - sums[first]) ** 2 / (squares[last] - squares[first]))


def _count(time: FloatArray, over: float) -> int:
    """Return the rows of the parabola that smooths a stretch of even rows: all of a short one, an odd number."""
    return min(smoothing_rows(time, over), _odd(len(time))) if len(time) > 1 else 1


def _odd(count: int) -> int:
    """Return the largest odd number up to a count."""
    return count - 1 + count % 2


def _stretch(time: FloatArray, values: FloatArray, over: float) -> FloatArray:
    """Return values of rows without a gap, smoothed; those of few rows as they are."""
    if len(time) < FEWEST_SMOOTHED:
        return values
    if not _uneven(time):
        return _even(values, _count(time, over))
    step = max(float(np.median(np.diff(time))), over / FINEST)
    place = np.floor((time - time[0]) / step).astype(int)  # rows closer than that are one, their mean
    _, place = np.unique(place, return_inverse=True)
    rows = np.bincount(place)
    at = np.bincount(place, time) / rows
    even = np.linspace(time[0], time[-1], 1 + max(round((time[-1] - time[0]) / step), 1))
    table = np.column_stack([np.interp(even, at, np.bincount(place, column) / rows) for column in values.T])
    table = _even(table, _count(even, over))
    return np.column_stack([np.interp(time, even, column) for column in table.T])


def _even(values: FloatArray, count: int) -> FloatArray:
    """Return values of even rows, smoothed over `count` of them; where these are few, as they are."""
    if count < FEWEST_SMOOTHED:
        return values
    weights = _parabola(count)
    out = np.asarray(ndimage.convolve1d(values, weights[-1], axis=0, mode="nearest"))
    edge = weights[:-1]
    out[: len(edge)] = edge @ values[:count]
    out[len(out) - len(edge) :] = edge[::-1, ::-1] @ values[len(values) - count :]
    return out


def smoothing_rows(time: FloatArray, over: float) -> int:
    """Return the rows of a parabola that smooths over so many seconds: an odd number."""
    return 2 * int(over / float(np.median(np.diff(time))) / 2.0) + 1


@lru_cache(maxsize=64)
def _parabola(count: int) -> FloatArray:
    """Return the weights of `count` values of which the parabola through them is made, shape (count // 2 + 1, count).

    A row for each value from the first to the middle one (Savitzky and Golay, 1964).
    """
    design = np.vander(np.linspace(-1.0, 1.0, count), 3)
    weights = design[: count // 2 + 1] @ np.linalg.pinv(design)
    weights.flags.writeable = False
    return weights


def smoothed_air(signals: LegSignals) -> FloatArray | None:
    """Return the smoothed temperature of the air, shape (n,) [K]; None where it is not recorded."""
    return None if signals.air is None else smoothed(signals.time, signals.air[:, None])[:, 0]


def bands(time: FloatArray, values: FloatArray) -> FloatArray:
    """Return what smoothing over each of `BANDS_S` takes that the one before left of values, shape (n,), as (n, 3)."""
    slower = [values, *(smoothed(time, values[:, None], over)[:, 0] for over in BANDS_S)]
    return np.asarray(-np.diff(np.column_stack(slower), axis=1))


def leading_profiles(tables: Sequence[FloatArray], count: int) -> FloatArray:
    """Return the weights of columns in their leading profiles over all runs, largest first, shape (s, count)."""
    stacked = np.concatenate([table[:: max(1, len(table) // THINNED_ROWS)] for table in tables])
    _w, vectors = np.linalg.eigh(stacked.T @ stacked)
    return np.asarray(vectors[:, ::-1][:, :count])
