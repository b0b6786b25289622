"""Rules of cleaning on arrays: noise, spikes, missing codes. Each is stated, none knows of files.

Noise of a channel is robust and blind to trends: ``1.4826 median |x_i - (x_(i-1) + x_(i+1)) / 2| / sqrt(1.5)``.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hexathermal.poses import FloatArray

Flags = npt.NDArray[np.bool_]

TO_SIGMA = 1.4826
"""Standard deviation of a normal scatter over its median absolute deviation."""

CODES = (9999.0, -9999.0, 9999.9, -9999.9, 99999.0, -99999.0)
"""Readings of any channel by which loggers say that there is none."""

OVERRANGE = 1e30
"""Readings beyond it are over range (9.9e37 of many instruments)."""

COLDEST_DEGC, HOTTEST_DEGC = -100.0, 400.0
"""Temperatures beyond are no readings of a bench but codes of an open or missing thermometer: -180, 850, 9999."""

SPIKE_NOISES = 7.0
"""A spike stands off by more than so many noises of its channel,"""

SPIKE_LOCAL = 4.0
"""by more than so many noises of the 21 rows around it, where these are restless,"""

SPIKE_ROWS_OF_SLOPE = 4.0
"""and, beyond that, by what the slope before makes in so many rows: corners are no spikes;"""

SPIKE_ABRUPT = 0.5
"""and at least this share of it is made in one row: bumps are no spikes;"""

SPIKE_RETURN = 0.7
"""Where the rod moves, and of weather, this share of it both on the way out and on the way back, each in one row: what
leaps and then fades, as beside a nut that comes to rest there, is heat. Of the last row only the way out is seen; the
first row, from which all others count, stays."""

SPIKE_STEPS = 5.4
"""It stands off by more than so many median steps from row to row of the ten rows around it: where a value swings, as a
thermocouple does when a warm nut passes, its turning points are no spikes,"""

SPIKE_LEAP = 1.2
"""unless one row leaps by more than so many times what it stands off;"""

EDGE_ROWS, EDGE_FACTOR = 5, 3.0
"""So near to the ends of a run one side is missing, and all limits are so many times wider."""

HALF_WINDOW = 10
SPIKE_PASSES = 4

MARGIN = 64
"""Rows that the rules look at on either side."""

SPIKE_RULE = (
    "off the medians of 5 rows before and of 5 rows behind, on the same side and abruptly, by more than "
    f"{SPIKE_NOISES:g} noises of the channel ({SPIKE_LOCAL:g} of the {2 * HALF_WINDOW + 1} rows around) and "
    f"{SPIKE_ROWS_OF_SLOPE:g} rows of the slope before, and {SPIKE_STEPS:g} steps from row to row; where the rod "
    "moves, and of weather, out and back in one row each"
)
WEATHER_RULE = "outside the range of any air (-40 to 100 degC, 100 to 1400 hPa, 0 to 100 %), or 9999 and the like"
CODE_RULE = f"below {COLDEST_DEGC:g} degC or above {HOTTEST_DEGC:g} degC, or 9999 and the like: a logger's missing code"


def noise_of(values: FloatArray) -> FloatArray:
    """Return the robust noise of each column, blind to trends; NaN where there are fewer than three numbers.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> ramp = np.linspace(20.0, 30.0, 5000)[:, None]
    >>> round(float(noise_of(ramp + 0.05 * rng.standard_normal(ramp.shape))[0]), 3)
    0.05
    """
    bend = values[1:-1] - 0.5 * (values[:-2] + values[2:])
    middle = np.array([_median(np.abs(column[np.isfinite(column)])) for column in bend.T])
    return np.asarray(middle * TO_SIGMA / np.sqrt(1.5))


def _median(values: FloatArray) -> float:
    """Return the median, NaN of nothing."""
    return float(np.median(values)) if values.size else np.nan


def codes_in(values: FloatArray, temperatures: bool) -> Flags:
    """Return where readings are codes that say that there is none, or no temperatures of a bench [degC]."""
    with np.errstate(invalid="ignore", over="ignore"):
        if temperatures:
            return np.asarray((values < COLDEST_DEGC) | (values > HOTTEST_DEGC))
        return np.asarray(np.isin(np.round(values, 6), CODES) | (np.abs(values) > OVERRANGE))


def filled(values: FloatArray) -> FloatArray:
    """Return columns with missing numbers replaced by the last before them, or by the first behind."""
    missing = np.isnan(values)
    if not missing.any():
        return values
    n = len(values)
    rows = np.where(missing, 0, np.arange(n)[:, None])
    last = np.maximum.accumulate(rows, axis=0)
    out = np.take_along_axis(values, last, axis=0)
    first = np.take_along_axis(values, np.argmin(missing, axis=0)[None, :], axis=0)
    return np.where(np.isnan(out), np.nan_to_num(first), out)


def medians_of_five(values: FloatArray) -> FloatArray:
    """Return the running median of five rows of each column; the result is four rows shorter."""
    a, b, c, d, e = (values[k : len(values) - 4 + k] for k in range(5))
    f = np.maximum(np.minimum(a, b), np.minimum(c, d))
    g = np.minimum(np.maximum(a, b), np.maximum(c, d))
    return np.asarray(np.maximum(np.minimum(f, g), np.minimum(np.maximum(f, g), e)))


def spikes_in(values: FloatArray, noise: FloatArray, moving: Flags | None = None) -> Flags:
    """Return where columns have spikes, by `SPIKE_RULE`.

    A value on a ramp lies between the medians on both sides, one at a corner stands off by no more than its
    neighbours' slope makes: neither is a spike.
    Spikes of up to some rows are found in passes, the farthest values first.

    Parameters
    ----------
    values : array, shape (n, k)
        Rows in the order of time; the ends are mirrored.
    noise : array, shape (k,)
    moving : array of bool, shape (n, k), optional
        Where values come and fade, as beside a movement, or turn, as the air's: a spike must leap back there as it
        came.

    Returns
    -------
    spikes : array of bool, shape (n, k)

    Examples
    --------
    >>> x = np.sin(np.linspace(0.0, 6.0, 200))[:, None] + 0.01 * np.random.default_rng(1).standard_normal((200, 1))
    >>> x[[50, 120, 121]] += 0.5
    >>> np.flatnonzero(spikes_in(x, noise_of(x))).tolist()
    [50, 120, 121]
    """
    found = np.zeros(values.shape, dtype=bool)
    if len(values) < 2 * HALF_WINDOW + 1:
        return found
    columns = np.arange(values.shape[1])
    strict = np.zeros(values.shape, dtype=bool) if moving is None else moving
    for _pass in range(SPIKE_PASSES):
        part = np.where(found[:, columns], np.nan, values[:, columns])
        known = ~np.isnan(part)
        part = filled(part)
        new = _standing_off(part, noise[columns], _beside(found[:, columns]), strict[:, columns]) & known
        if not new.any():
            break
        found[:, columns] |= new
        columns = columns[new.any(axis=0)]
    return found


def _beside(found: Flags) -> Flags:
    """Return which rows stand within two rows of one that was found: the rest of a burst, whatever its steps."""
    padded = np.pad(found, ((2, 2), (0, 0)))
    return np.asarray(np.logical_or.reduce([padded[k : len(found) + k] for k in range(5)]))


def _standing_off(values: FloatArray, noise: FloatArray, burst: Flags, strict: Flags) -> Flags:
    """Return one pass of `spikes_in`; rows of a `burst` are not held against the steps around them.

    In `strict` rows a value must leap back as it came.
    """
    n = len(values)
    padded = np.pad(values, ((HALF_WINDOW, HALF_WINDOW), (0, 0)), mode="reflect")
    fives = medians_of_five(padded)
    start = HALF_WINDOW - 5
    before, behind = fives[start : start + n], fives[start + 6 : start + 6 + n]
    over, under = values - before, values - behind
    off = np.where(over * under > 0.0, np.minimum(np.abs(over), np.abs(under)), 0.0)
    found = off > SPIKE_NOISES * noise
    rows, columns = np.nonzero(found)
    if rows.size:
        around = padded[rows[:, None] + np.arange(2 * HALF_WINDOW + 1), columns[:, None]]
        slope = np.abs(fives[rows, columns] - before[rows, columns]) / 5.0
        bend = around[:, 1:-1] - 0.5 * (around[:, :-2] + around[:, 2:])
        local = TO_SIGMA * np.median(np.abs(bend), axis=1) / np.sqrt(1.5)
        allowed = np.maximum(SPIKE_NOISES * noise[columns], SPIKE_LOCAL * local) + SPIKE_ROWS_OF_SLOPE * slope
        allowed *= np.where((rows < EDGE_ROWS) | (rows >= n - EDGE_ROWS), EDGE_FACTOR, 1.0)
        steps = np.abs(np.diff(around, axis=1))
        one_row = steps[:, HALF_WINDOW - 1 : HALF_WINDOW + 1].max(axis=1)
        usual = np.median(np.delete(steps[:, HALF_WINDOW - 5 : HALF_WINDOW + 5], [4, 5], axis=1), axis=1)
        size = off[rows, columns]
        sharp = (size > SPIKE_STEPS * usual) | (one_row > SPIKE_LEAP * size) | burst[rows, columns]
        back = _part_in_one_row_each(around, np.sign(over[rows, columns]), size, rows, n - 1 - rows)
        returned = (back > SPIKE_RETURN) | ~strict[rows, columns]
        found[rows, columns] = (size > allowed) & (one_row > SPIKE_ABRUPT * size) & sharp & returned
    return np.asarray(found)


def _part_in_one_row_each(
    around: FloatArray, sign: FloatArray, size: FloatArray, before: npt.NDArray[np.int64], behind: npt.NDArray[np.int64]
) -> FloatArray:
    """Return the smaller of the largest steps out to the middle column's value and back, three rows on either side.

    As a part of what it stands off; 0 where the row before or behind stands off farther: a flank. So many rows before
    and behind are real: what is mirrored at an end would always leap back, and stands off too little. For the last row
    the way out speaks alone, since nobody sees whether it comes back; the first may be cold before heat that stays: 0.
    """
    rise = sign[:, None] * np.diff(around, axis=1)
    out, back = rise[:, HALF_WINDOW - 3 : HALF_WINDOW], -rise[:, HALF_WINDOW : HALF_WINDOW + 3]
    top = (out[:, -1] >= 0.0) & (back[:, 0] >= 0.0)
    away = np.arange(1, 4)
    sides = np.array([np.where(away[::-1] <= before[:, None], out, -np.inf).max(axis=1),
                      np.where(away <= behind[:, None], back, -np.inf).max(axis=1)])  # fmt: skip
    smaller = np.where(behind > 0, sides.min(axis=0), sides[0])
    whole = np.where(np.minimum(before, behind) < len(away), np.maximum(size, sides.max(axis=0)), size)
    return np.asarray(np.where(top & (before > 0), smaller, 0.0) / whole)


def jumping_ahead(time: FloatArray, latest: float) -> Flags:
    """Return which rows have a time beyond the next row's, which itself is beyond the row before: one wrong time.

    Parameters
    ----------
    time : array, shape (n,) [s]
    latest : float [s]
        Time of the row before the first.

    Examples
    --------
    >>> jumping_ahead(np.array([0.0, 1.0, 99.0, 3.0, 4.0]), -np.inf).tolist()
    [False, False, True, False, False]
    """
    found = np.zeros(len(time), dtype=bool)
    before = np.concatenate([[latest], time[:-1]])[: len(time)]
    found[:-1] = (time[:-1] > time[1:]) & (time[1:] > before[:-1])
    if not np.isfinite(latest) and len(time) > 2 and time[2] < time[1]:
        found[0] = False  # with no row before it the first row may be right, where the clock goes on backwards
    return found
