"""How far a still machine moves when the room changes, and how far it moves while it warms up (ISO 230-3:2020).

::

    ETVE(dt) = max over all windows [t, t + dt] of (max x - min x)
    d_60 = x(t0 + 60 min) - x(t0)          d_t = x(t_end) - x(t0)

Windows are closed and start at every sample, so that samples may come at any interval; what happened between samples is
not known, and the longest gap is told.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError
from hexathermal.poses import FloatArray, finite_array

HOUR = 3600.0
Indices = npt.NDArray[np.int64]


@dataclass(frozen=True)
class EnvironmentalVariation:
    """Largest range of a coordinate within a window.

    Attributes
    ----------
    value : float
        ETVE, in the unit of the coordinate.
    window : float [s]
        Length of the window; that of the record where the whole was asked for.
    start, end : float [s]
        Times of the first and the last sample of the window in which the range was largest (the first of several).
    temperature_ranges : dict of str to float [K]
        ``max - min`` of each thermometer in that same window.
    longest_gap : float [s]
        Longest time between two samples of the record.
    """

    value: float
    window: float
    start: float
    end: float
    temperature_ranges: dict[str, float] = field(default_factory=dict)
    longest_gap: float = 0.0


@dataclass(frozen=True)
class WarmUpDistortion:
    """Change of a coordinate while the machine warms up.

    Attributes
    ----------
    d_60, d_t : float
        Change after 60 minutes and at the end, in the unit of the coordinate.
    range_60, range_t : float
        ``max - min`` over the first 60 minutes and up to the end.
    end : float [s]
        Time of the end, counted from the first sample.
    """

    d_60: float
    d_t: float
    range_60: float
    range_t: float
    end: float


def environmental_variation(
    time: npt.ArrayLike,
    values: npt.ArrayLike,
    window: float | None = None,
    temperatures: Mapping[str, npt.ArrayLike] | None = None,
) -> EnvironmentalVariation:
    """Return the environmental temperature variation error of one coordinate (ISO 230-3:2020, ETVE).

    Parameters
    ----------
    time : array, shape (n,) [s]
        Increasing, at any intervals; n >= 2.
    values : array, shape (n,)
        The coordinate, in any unit.
    window : float, optional [s]
        Length of the window; default the whole record.
    temperatures : mapping of str to array, shape (n,) [degC], optional

    Returns
    -------
    EnvironmentalVariation

    Raises
    ------
    ArgumentError
        Shapes differ, fewer than two samples, times do not increase, or the window is longer than the record.

    Examples
    --------
    >>> time = np.arange(0.0, 5.0)
    >>> found = environmental_variation(time, [0.0, 1.0, 5.0, 2.0, 2.0], 1.0, {"room": [20, 20, 21, 22, 22]})
    >>> found.value, found.start, found.temperature_ranges
    (4.0, 1.0, {'room': 1.0})
    """
    times, x = _record(time, values)
    length = float(times[-1] - times[0])
    if window is not None and not (math.isfinite(window) and window > 0.0):
        raise ArgumentError(f"the window is {window:g} s; expected above 0")
    if window is not None and window > length * (1.0 + 1e-12):
        raise ArgumentError(
            f"the window of {window:g} s is longer than the record, {length:g} s; "
            "measure longer, or take a shorter window"
        )
    wanted = length if window is None else window
    # times such as 0.1 + 0.2 end a window that they belong to
    slack = max(1e-9 * float(np.diff(times).min()), 4.0 * float(np.spacing(np.abs(times).max())))
    ends = np.searchsorted(times, times + wanted + slack, side="right").astype(np.int64)
    ranges = _range(x, ends)
    worst = int(ranges.argmax())
    inside = slice(worst, int(ends[worst]))
    spans = {}
    for name, series in (temperatures or {}).items():
        degrees = finite_array(series, (len(times),), f"temperature {name}")
        spans[name] = float(np.ptp(degrees[inside]))
    gap = float(np.diff(times).max())
    return EnvironmentalVariation(
        float(ranges[worst]), wanted, float(times[worst]), float(times[inside][-1]), spans, gap
    )


def allowed_gap(time: npt.ArrayLike, window: float) -> float:
    """Return the longest time between samples [s] that a window may hold: five usual intervals, or 5 % of the window.

    The larger of both, and never more than half the window: a machine may move and return in a longer gap.

    Examples
    --------
    >>> allowed_gap(np.arange(0.0, 600.0), 3600.0), allowed_gap(np.arange(0.0, 7200.0, 600.0), 3600.0)
    (180.0, 1800.0)
    """
    return min(0.5 * window, max(5.0 * float(np.median(np.diff(np.asarray(time)))), 0.05 * window))


def warm_up_distortion(time: npt.ArrayLike, values: npt.ArrayLike, end: float | None = None) -> WarmUpDistortion:
    """Return how far a coordinate moves while the machine warms up (ISO 230-3:2020, d_60 and d_t).

    Between samples the coordinate is interpolated linearly.

    Parameters
    ----------
    time : array, shape (n,) [s]
        Increasing; warming starts at the first sample.
    values : array, shape (n,)
        The coordinate, in any unit.
    end : float, optional [s]
        End of warming, counted from the first sample, at least 60 minutes; default the last sample.

    Returns
    -------
    WarmUpDistortion

    Raises
    ------
    ArgumentError
        As in `environmental_variation`; or the record, or warming, is shorter than 60 minutes.

    Examples
    --------
    >>> found = warm_up_distortion([0.0, 3000.0, 6000.0], [1.0, 4.0, 5.0])
    >>> round(found.d_60, 12), found.d_t
    (3.2, 4.0)
    """
    times, x = _record(time, values)
    times = times - times[0]
    last = float(times[-1]) if end is None else end
    if not HOUR <= last:
        raise ArgumentError(f"warming lasts {last:g} s; expected at least {HOUR:g} s, after which d_60 is taken")
    if last > times[-1]:
        raise ArgumentError(f"warming ends after {last:g} s, the record after {float(times[-1]):g} s")
    at_hour, at_end = (float(np.interp(moment, times, x)) for moment in (HOUR, last))
    spans = [float(np.ptp(np.append(x[times <= moment], there))) for moment, there in ((HOUR, at_hour), (last, at_end))]
    return WarmUpDistortion(at_hour - float(x[0]), at_end - float(x[0]), spans[0], spans[1], last)


def _record(time: npt.ArrayLike, values: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return times and values after checking them."""
    times = finite_array(time, (), "time")
    if times.ndim != 1 or len(times) < 2:
        raise ArgumentError(
            f"the record holds {times.size} sample(s) of time, shape {times.shape}; two or more are needed"
        )
    x = finite_array(values, (len(times),), "values")
    if x.ndim != 1:
        raise ArgumentError(f"values has shape {x.shape}; expected {times.shape}, one coordinate")
    steps = np.diff(times)
    if not (steps > 0.0).all():
        k = int((steps <= 0.0).argmax()) + 1
        raise ArgumentError(f"time does not increase at index {k}: {times[k]:g} s after {times[k - 1]:g} s")
    return times, x


def _range(x: FloatArray, ends: Indices) -> FloatArray:
    """Return ``max - min`` of ``x[k:ends[k]]`` for every k.

    Two blocks of a power of two samples cover each window: the maxima of all such blocks are made by doubling.
    """
    starts = np.arange(len(x))
    level = np.frexp(ends - starts)[1] - 1
    high, low, ranges = x, x, np.zeros(len(x))
    for k in range(int(level.max()) + 1):
        if k:
            half = 1 << (k - 1)
            high = np.maximum(high[:-half], high[half:])
            low = np.minimum(low[:-half], low[half:])
        here = np.flatnonzero(level == k)
        last = ends[here] - (1 << k)
        ranges[here] = np.maximum(high[here], high[last]) - np.minimum(low[here], low[last])
    return ranges
