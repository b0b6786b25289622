"""Clocks that no measurement has: a time that jumps by weeks, runs of decades, one run in milliseconds among others.

Such a clock is a fault, for all that is made of it (lags, rates, even grids of time) is wrong or without end. What only
looks odd, as rows that are hours apart in every run, is warned of.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hexathermal.errors import Problem
from hexathermal.poses import FloatArray

MINUTE_S, HOUR_S, DAY_S, YEAR_S = 60.0, 3600.0, 86400.0, 365.25 * 86400.0

LONGEST_PAUSE_S = 30.0 * DAY_S
"""No run pauses for longer [s].

A long campaign, a telescope's months at a row every ten minutes say, loses hours to power cuts and days to holidays.
What begins again after a month begins anew: the machine was cold, the beams were set up again, and it is another run.
A wrong year, an epoch written for a time since the start, and milliseconds for a pause of three quarters of an hour all
lie beyond."""

LONGEST_RUN_S = 10.0 * YEAR_S
"""No run lasts longer [s]: a hundred times the longest that are known, and no recording holds its zero for so long."""

TIMES_APART, SLOWEST_S = 100.0, HOUR_S
"""A run whose rows are so many times farther apart than those of the others, and by more than this [s].

Runs of one campaign may well be a row every second of a warm-up and a row every ten minutes of a season, 600 times
apart; but not beyond an hour, which 3.6 s written in milliseconds are."""

THOUSAND, NEARLY = 1000.0, 0.01
"""Quicker rows are told to be in milliseconds where they are a thousand times apart to this share: one logger's."""

FEWEST_STILL = 10
"""So many rows are not all of one moment."""

STUDIED_STEPS = 32768
"""Steps in time from which a run's usual one is taken."""


class ClockWarning(UserWarning):
    """Times of a campaign look as if they were in another unit than seconds."""


@dataclass(frozen=True)
class Jump:
    """A step in time over which no run pauses: the rows before and behind, and their times [s]."""

    before: int
    behind: int
    start: float
    end: float


class RunClock:
    """The clock of one run as its rows pass, in constant memory.

    Attributes
    ----------
    first, latest : float [s]
        NaN where there is no time.
    row : int
        Row of the latest time.
    jump : Jump or None
        The first step that is too long.
    rows : int
        How many passed.
    """

    def __init__(self) -> None:
        self.first, self.latest, self.row = np.nan, np.nan, -1
        self.jump: Jump | None = None
        self._steps: list[FloatArray] = []
        self._studied, self.rows = 0, 0

    def add(self, time: FloatArray, rows: npt.NDArray[np.int64]) -> None:
        """Look at the next rows; their times [s] do not fall."""
        if not len(time):
            return
        self.rows += len(time)
        if self.row < 0:
            self.first, self.latest, self.row = float(time[0]), float(time[0]), int(rows[0])
        with np.errstate(over="ignore"):
            steps = np.diff(time, prepend=self.latest)
        if self.jump is None and (long := np.flatnonzero(steps > LONGEST_PAUSE_S)).size:
            k = int(long[0])
            before = (int(rows[k - 1]), float(time[k - 1])) if k else (self.row, self.latest)
            self.jump = Jump(before[0], int(rows[k]), before[1], float(time[k]))
        if self._studied < STUDIED_STEPS:
            taken = steps[steps > 0.0][: STUDIED_STEPS - self._studied]
            self._steps.append(taken)
            self._studied += len(taken)
        self.latest, self.row = float(time[-1]), int(rows[-1])

    @property
    def interval(self) -> float:
        """Median step from row to row [s]; NaN where there is none."""
        return float(np.median(np.concatenate(self._steps))) if self._studied else np.nan

    @property
    def duration(self) -> float:
        """From the first to the latest row [s]."""
        return self.latest - self.first


def long_words(seconds: float) -> str:
    """Return a span of time in the unit in which it is read easily.

    Examples
    --------
    >>> long_words(20.0), long_words(20000.0), long_words(1.7e9), long_words(1e300)
    ('20 s', '5.56 h', '53.9 years', '3.17e+292 years')
    """
    units = ((YEAR_S, "years"), (DAY_S, "days"), (HOUR_S, "h"), (MINUTE_S, "min"))
    unit, words = next((one for one in units if seconds >= one[0]), (1.0, "s"))
    return f"{seconds / unit:.3g} {words}"


def impossible(clock: RunClock, lines: tuple[int, int, int], column: int) -> Problem | None:
    """Return what is wrong with the clock of a run by itself, or None.

    Parameters
    ----------
    clock : RunClock
    lines : (int, int, int)
        Of the row before and the row behind the jump, if any, and of the latest row.
    column : int
        Place of the time in the table.
    """
    if clock.jump is not None:
        step = clock.jump.end - clock.jump.start
        return Problem(lines[1], column, (
            f"time_s jumps by {long_words(step)} from line {lines[0]} to {lines[1]}, from {clock.jump.start:.10g} to "
            f"{clock.jump.end:.10g}; a run pauses for no more than {LONGEST_PAUSE_S / DAY_S:g} days: is time_s in "
            "milliseconds there, or did the logger's clock jump? Mend it; what begins again after such a pause is "
            "another run"
        ))  # fmt: skip
    if clock.rows >= FEWEST_STILL and clock.duration == 0.0:
        return Problem(lines[0], column, (
            f"time_s is {clock.first:.10g} in all {clock.rows} rows: it does not advance; write when each row was read"
        ))  # fmt: skip
    if clock.duration > LONGEST_RUN_S:
        return Problem(lines[2], column, (
            f"time_s runs over {long_words(clock.duration)}, from {clock.first:.10g} to {clock.latest:.10g}; a run "
            f"lasts no more than {LONGEST_RUN_S / YEAR_S:g} years: is time_s in milliseconds?"
        ))  # fmt: skip
    return None


def unlike_others(intervals: Sequence[float]) -> dict[int, str]:
    """Return the runs whose rows are so far apart, or so near, that their time is in another unit, and what is said.

    Where half of the runs are quick and half are slow, the slow ones are named.

    Parameters
    ----------
    intervals : sequence of float [s]
        Median step from row to row of each run; NaN where there is none.

    Examples
    --------
    >>> sorted(unlike_others([20.0, 20.0, 20000.0, 20.0]))
    [2]
    >>> unlike_others([1.0, 600.0])
    {}
    """
    known = sorted(value for value in intervals if value > 0.0)
    if len(known) < 2:
        return {}
    usual = known[(len(known) - 1) // 2]
    found = {}
    for k, value in enumerate(intervals):
        if not value > 0.0 or not _apart(*sorted((value, usual))):
            continue
        asked = "is its time_s in milliseconds" if value > usual else "is time_s of the others in milliseconds"
        found[k] = (
            f"one row every {long_words(value)}, in the other runs every {long_words(usual)}; runs of one campaign "
            f"are no more than {TIMES_APART:g} times apart: {asked}? Convert it, or, if both are right, make two "
            "campaigns"
        )
    return found


def _apart(quick: float, slow: float) -> bool:
    """Whether two steps in time [s] cannot be in one unit."""
    exact = abs(slow / quick / THOUSAND - 1.0) <= NEARLY
    return exact or (slow > TIMES_APART * quick and slow > SLOWEST_S)


def doubt(runs: Sequence[str], intervals: Sequence[float]) -> str:
    """Return what is said of runs whose rows are more than an hour apart, though alike; empty where there is none."""
    slow = {name: value for name, value in zip(runs, intervals, strict=True) if value > SLOWEST_S}
    if not slow:
        return ""
    which = "every run" if len(slow) == len(runs) > 1 else ", ".join(slow)
    return f"{which}: one row every {long_words(max(slow.values()))}: is time_s in milliseconds?"
