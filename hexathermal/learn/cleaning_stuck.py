"""Stuck channels: readings that stand still although the channel is known to change.

Of a channel that noise moves by half a step of its resolution and more wherever it is looked at, 30 equal readings in
a row are no chance (below 1e-5). Of one with less noise than that, a thermometer that is read in steps of 0.1 K say,
they are what a steady temperature looks like; it was stuck only where it leaves the value it stood at by a leap that it
does not go on from, or where it stands to the end for much longer than it, and others like it, do.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hexathermal.learn.cleaning_rules import Flags, noise_of
from hexathermal.poses import FloatArray

LIVELY = 0.3
"""Share of steps in which a channel must change to be judged by its changes."""

STUCK_ROWS = 30
"""A value that does not change over so many rows is stuck where other channels move."""

RESTLESS_STEPS = 0.5
"""A channel is restless whose noise is at least so many steps of its resolution wherever it is looked at."""

WINDOW_ROWS, QUIETEST = 32, 0.1
"""Windows that a channel's noise is looked at in, and the share of them that may be quieter."""

LEAP_STEPS, LEAP_TIMES, LEAP_ROWS = 2.0, 3.0, 5
"""A leap off a value is larger than so many steps and so many times the median change of the rows beyond it."""

STANDING_TIMES = 3.0
"""A channel that is not restless stands for much longer than usual from so many times that on."""

STUCK_RULE = (
    f"not one change in {STUCK_ROWS} rows or more, while half of the other channels change all the time; of a channel "
    "with less noise than half a step of its resolution only where it leaves the value by a leap, or never and for "
    f"{STANDING_TIMES:g} times longer than usual"
)


@dataclass(frozen=True, eq=False)
class Scales:
    """What is usual in channels, one number each.

    Attributes
    ----------
    noise : array, shape (k,)
        At least 0.3 of the resolution.
    resolution : array, shape (k,)
        Smallest step; 0 where nothing changes.
    liveliness : array, shape (k,)
        Share of row-to-row steps in which the value changes, long stretches without any left out.
    restless : array of bool, shape (k,)
        Whether noise moves the channel by `RESTLESS_STEPS` or more wherever it is looked at.
    standing : array, shape (k,)
        Rows that the channel stands still at times: the fourth of its longest stretches of equal values, or the median
        of the longest of the channels with the same resolution, whichever is longer.
    """

    noise: FloatArray
    resolution: FloatArray
    liveliness: FloatArray
    restless: Flags
    standing: FloatArray

    def of(self, columns: Flags) -> Scales:
        """Return the scales of some columns."""
        return Scales(self.noise[columns], self.resolution[columns], self.liveliness[columns], self.restless[columns],
                      self.standing[columns])  # fmt: skip


def scales_of(values: FloatArray) -> Scales:
    """Return what is usual in the columns of `values`, shape (n, k)."""
    step = np.abs(np.diff(values, axis=0))
    k = values.shape[1]
    resolution, liveliness, restless = np.zeros(k), np.zeros(k), np.zeros(k, dtype=bool)
    longest = np.zeros((k, 4))
    for j, column in enumerate(step.T):
        lengths = stretches(values[:, j])
        resting = np.repeat(lengths >= STUCK_ROWS, lengths)[1:]
        found = np.sort(lengths)[::-1][:4]
        longest[j, : len(found)] = found
        known = column[np.isfinite(column)]
        size = np.abs(values[:, j][np.isfinite(values[:, j])]).max(initial=0.0)
        moved = known[known > 1e-12 * size]
        if moved.size:
            resolution[j] = float(np.quantile(moved, 0.01))
            flat = int((resting & (column == 0.0)).sum())
            liveliness[j] = moved.size / (known.size - flat)
            restless[j] = _quietest(values[:, j]) >= RESTLESS_STEPS * resolution[j]
    noise = np.fmax(np.nan_to_num(noise_of(values)), 0.3 * resolution)
    alike = np.abs(np.log(np.maximum(resolution, 1e-300)[:, None] / np.maximum(resolution, 1e-300))) < np.log(1.5)
    others = np.array([np.median(longest[own & (np.arange(k) != j), 0]) if own.sum() > 1 else 0.0
                       for j, own in enumerate(alike)])  # fmt: skip
    return Scales(noise, resolution, liveliness, restless, np.maximum(longest[:, 3], others))


def _quietest(column: FloatArray) -> float:
    """Return the noise of a column where it is quiet: in the quietest windows of which not all values are equal."""
    bend = np.abs(column[1:-1] - 0.5 * (column[:-2] + column[2:]))
    whole = bend[: len(bend) // WINDOW_ROWS * WINDOW_ROWS].reshape(-1, WINDOW_ROWS)
    whole = whole[np.isfinite(whole).all(axis=1) & whole.any(axis=1)]
    if not len(whole):
        return float("inf")
    # the mean of |x| of a normal x is sqrt(2 / pi) of its standard deviation, that of a bend sqrt(3 / 2) of x's
    return float(np.quantile(whole.mean(axis=1), QUIETEST) / np.sqrt(2.0 / np.pi) / np.sqrt(1.5))


def stuck_in(values: FloatArray, scales: Scales) -> Flags:
    """Return where columns are stuck, by `STUCK_RULE`; missing numbers end a stretch.

    Where more than half of the columns stand still together nothing moves, and none of them is stuck.

    Examples
    --------
    >>> x = np.random.default_rng(1).standard_normal((200, 3))
    >>> x[50:100, 1] = 0.5
    >>> found = stuck_in(x, scales_of(x))
    >>> found.sum(axis=0).tolist(), int(found[:, 1].argmax())
    ([0, 50, 0], 50)

    A steady temperature that is read in steps is no stuck thermometer:

    >>> steady = np.round(x * 0.02 + 20.0 + 0.02 * np.arange(200)[:, None] ** 0.5, 1)
    >>> bool(stuck_in(steady, scales_of(steady)).any())
    False
    """
    still = np.zeros(values.shape, dtype=bool)
    judged = np.zeros(values.shape, dtype=bool)
    for k, column in enumerate(values.T):
        lengths = stretches(column)
        ends = np.cumsum(lengths)
        for end, length in zip(ends[lengths >= STUCK_ROWS], lengths[lengths >= STUCK_ROWS], strict=True):
            rows = slice(int(end - length), int(end))
            still[rows, k] = True
            judged[rows, k] = scales.restless[k] or scales.resolution[k] == 0.0 or _odd(column, rows, scales, k)
    lively = scales.liveliness >= LIVELY
    silent = scales.resolution == 0.0
    moving = (~still & lively).sum(axis=1) >= 0.5 * max(1, values.shape[1])
    return np.asarray(judged & (lively | silent) & moving[:, None])


def _odd(column: FloatArray, rows: slice, scales: Scales, k: int) -> bool:
    """Whether a stretch of a quiet channel begins or ends with a leap, or stands to the end for very long."""
    value = column[rows.start]
    before, behind = column[max(0, rows.start - LEAP_ROWS - 1) : rows.start], column[rows.stop :][: LEAP_ROWS + 1]
    for beyond in (before[::-1], behind):
        usual = float(np.median(np.abs(np.diff(beyond)))) if len(beyond) > 1 else np.nan
        # a missing number beyond makes this NaN, and no leap
        if len(beyond) and abs(beyond[0] - value) > LEAP_STEPS * scales.resolution[k] + LEAP_TIMES * usual:
            return True
    whole = len(behind) and np.isfinite(behind[0])
    return bool(not whole and rows.stop - rows.start > STANDING_TIMES * scales.standing[k])


def stretches(column: FloatArray) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Return the lengths of the stretches of equal values, in their order."""
    edges = np.flatnonzero(np.diff(column) != 0.0) + 1
    return np.asarray(np.diff(np.concatenate([[0], edges, [len(column)]])), dtype=np.int64)
