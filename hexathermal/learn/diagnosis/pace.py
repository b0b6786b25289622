"""What follows the speed of the last move, without a name: how fast the rod came to where it is."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hexathermal.learn.diagnosis.view import View
from hexathermal.machine.leg_signals import Memory
from hexathermal.poses import FloatArray

PAUSE_S, OVER_S = 150.0, 600.0
"""Pauses that are shorter belong to a way; its speed is that of so long before its end."""

SLOWEST = 0.1
"""Of the usual speed, with which the rod came where it stands at first; slower ones count as this."""

UNLIKE, LEAST_UNLIKE = (0.1, 0.9), 0.2
"""Speeds are told apart where these quantiles of theirs differ by so much of the usual one."""


def paces(view: View) -> Iterator[FloatArray]:
    """Give how fast the rod went on its way to where it is, and the logarithm of that, each shape (n, 1).

    Nothing where it always goes as fast.
    """
    speeds = [_speeds(signals.time, signals.q) for signals in view.signals]
    usual = float(np.nanmedian(np.concatenate(speeds)))
    scaled = [np.nan_to_num(own / usual, nan=1.0) for own in speeds]
    slow, fast = np.quantile(np.concatenate(scaled), UNLIKE)
    if fast - slow < LEAST_UNLIKE:
        return
    yield view.windows_zeroed([own[:, None] for own in scaled])
    yield view.windows_zeroed([np.log(np.maximum(own, SLOWEST))[:, None] for own in scaled])


def _speeds(time: FloatArray, q: FloatArray) -> FloatArray:
    """Return the speed of the way that led to where the rod is in each row, NaN before the first, shape (n,) [m/s]."""
    steps = np.abs(Memory().moves(q))
    moved = np.flatnonzero(steps)
    if not len(moved):
        return np.full(len(q), np.nan)
    gone, at = np.cumsum(steps)[moved], time[moved]
    apart = np.append(True, np.diff(at) > PAUSE_S)
    began = np.maximum.accumulate(np.where(apart, np.arange(len(moved)), 0))
    first = np.maximum(began, np.searchsorted(at, at - OVER_S))
    alone = first == np.arange(len(moved))  # the only step of a way took its row, others the time since the one before
    way = np.where(alone, steps[moved], gone - gone[first])
    speed = way / np.where(alone, np.diff(time, prepend=-np.inf)[moved], at - at[first])
    last = np.searchsorted(moved, np.arange(len(q)), side="right") - 1
    return np.where(last < 0, np.nan, speed[last])
