"""Which temperatures belong to which pose of a trajectory, both read as streams.

Three ways, chosen from the files: a single row of temperatures serves all poses; where both files have ``time_s``,
temperatures are interpolated linearly at the times of the poses; else row k belongs to row k.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from hexathermal.errors import FileFormatError, Problem, TemperatureError
from hexathermal.kinematics.batches import where
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray
from hexathermal.predict.table_streams import Rows, TableStream
from hexathermal.predict.temperatures import check_temperatures

TIMES = ("time", "t", "t_s", "times", "timestamp", "time_ms", "time_us", "time_min", "time_h", "time_s")
"""Names, in small letters, of columns that may have been meant as time."""


class Temperatures(Protocol):
    """Temperatures that follow a stream of poses.

    `pairing` says in words how; `one_row` that a single row serves all poses.
    """

    pairing: str
    one_row: bool

    def of(self, poses: Rows) -> tuple[FloatArray, FloatArray | None]:
        """Return temperatures (n, s) or (s,) [degC] of the next poses, and their times [s] where only they have any."""

    def pieces(self, poses: Rows, *, unmet: bool) -> Iterator[Piece]:
        """Give the next poses piece by piece, as memory allows, where asked for with the rows that no pose meets."""

    def finish(self) -> None:
        """Read what is left after the last pose, and refuse what does not fit."""


@dataclass(frozen=True, eq=False)
class Piece:
    """Some of the next poses, and the rows of temperatures since the pose before that no pose meets.

    Attributes
    ----------
    first, last : int
        Poses ``first:last``; none where a block of temperatures meets none.
    numbers : array, shape (last - first, s) or (s,) [degC]
        Temperatures of the poses.
    time : array, shape (last - first,) [s], or None
        Of the poses, where only the temperatures have any.
    between : (array (u,) [s], array (u, s) [degC])
    """

    first: int
    last: int
    numbers: FloatArray
    time: FloatArray | None
    between: tuple[FloatArray, FloatArray]


def _all(poses: Rows, numbers: FloatArray, time: FloatArray | None) -> Piece:
    """Return all of the next poses as one piece, none of whose rows goes unmet."""
    return Piece(0, len(poses), numbers, time, _none(numbers.shape[-1]))


def _none(sensors: int) -> tuple[FloatArray, FloatArray]:
    """Return the times and temperatures of no rows."""
    return np.empty(0), np.empty((0, sensors))


class _Checked:
    """A stream of temperatures, every row held against the law's range."""

    def __init__(self, hexapod: Hexapod, stream: TableStream) -> None:
        self.hexapod, self.stream = hexapod, stream
        self.lowest, self.highest = np.inf, -np.inf

    def next_rows(self) -> Rows | None:
        rows = self.stream.next_rows()
        if rows is None:
            return None
        try:
            check_temperatures(self.hexapod, rows.numbers)
        except TemperatureError as error:
            line = self.stream.line(rows.first + error.index[0])
            column = self.stream.header.column(f"{error.sensor}_degC")
            text = str(error).replace(where(error.index), "", 1)
            raise TemperatureError(
                f"{self.stream.path}, line {line}, column {column}: {text}",
                sensor=error.sensor, value=error.value, lower=error.lower, upper=error.upper,
                index=(rows.first + error.index[0],),
            ) from None  # fmt: skip
        self.lowest = min(self.lowest, float(rows.numbers.min()))
        self.highest = max(self.highest, float(rows.numbers.max()))
        return rows


class _One:
    """One row of temperatures for all poses."""

    pairing, one_row = "one row of temperatures for all poses", True

    def __init__(self, row: FloatArray, note: str = "") -> None:
        self.row, self.pairing = row, _One.pairing + note

    def of(self, poses: Rows) -> tuple[FloatArray, FloatArray | None]:
        return self.row, None

    def pieces(self, poses: Rows, *, unmet: bool) -> Iterator[Piece]:
        yield _all(poses, *self.of(poses))

    def finish(self) -> None:
        return None


class _ByRow:
    """Row k of the temperatures for row k of the poses."""

    pairing, one_row = "row by row", False

    def __init__(self, poses: TableStream, temps: _Checked, seen: list[Rows], note: str = "") -> None:
        self.poses, self.temps, self.waiting, self.pairing = poses, temps, seen, _ByRow.pairing + note

    def of(self, poses: Rows) -> tuple[FloatArray, FloatArray | None]:
        numbers: list[FloatArray] = []
        times: list[FloatArray] = []
        missing = len(poses)
        while missing:
            rows = self.waiting.pop(0) if self.waiting else self.temps.next_rows()
            if rows is None:
                self.poses.drain()
                raise self._unequal()
            if len(rows) > missing:
                self.waiting.insert(0, _part(rows, missing, len(rows)))
                rows = _part(rows, 0, missing)
            missing -= len(rows)
            numbers.append(rows.numbers)
            times += [] if rows.time is None else [rows.time]
        return np.concatenate(numbers), np.concatenate(times) if times and poses.time is None else None

    def pieces(self, poses: Rows, *, unmet: bool) -> Iterator[Piece]:
        yield _all(poses, *self.of(poses))

    def finish(self) -> None:
        if self.waiting or self.temps.next_rows() is not None:
            self.temps.stream.drain()
            raise self._unequal()

    def _unequal(self) -> FileFormatError:
        """Return the error of files with different numbers of rows."""
        poses, temps = self.poses, self.temps.stream
        shorter = temps if temps.count < poses.count else poses
        message = (
            f"the file ends too early: {poses.path} has {_rows(poses.count)}, {temps.path} has {_rows(temps.count)}, "
            "and row k belongs to row k; give as many, or one row of temperatures for all, or time_s in both files"
        )
        return FileFormatError(str(shorter.path), (Problem(shorter.line(shorter.count - 1), 1, message),))


class _ByTime:
    """Temperatures interpolated linearly at the times of the poses."""

    pairing, one_row = "interpolated linearly at the poses' time_s", False

    def __init__(self, poses: TableStream, temps: _Checked, seen: list[Rows]) -> None:
        self.poses, self.temps, self.waiting = poses, temps, seen
        self.first = float(_time(seen[0])[0])
        self.time, self.numbers = np.empty(0), np.empty((0, seen[0].numbers.shape[1]))
        self.passed = -np.inf

    def of(self, poses: Rows) -> tuple[FloatArray, FloatArray | None]:
        return np.concatenate([piece.numbers for piece in self.pieces(poses, unmet=False)]), None

    def pieces(self, poses: Rows, *, unmet: bool) -> Iterator[Piece]:
        time = _time(poses)
        if time[0] < self.first:
            raise self._outside(poses, 0)
        done = 0
        while True:
            until = int(np.searchsorted(time, self.time[-1], side="right")) if self.time.size else 0
            if self.time.size and (until > done or (unmet and len(self.time) > 1)):
                numbers = interpolated(self.time, self.numbers, time[done:until])
                # a block without a pose has passed; of one with the last pose, what lies behind it has not
                between = (
                    self._between(time[done:until], done < until == len(poses)) if unmet else _none(numbers.shape[1])
                )
                yield Piece(done, until, numbers, None, between)
                done = until
            if done == len(poses):
                return
            rows = self.waiting.pop(0) if self.waiting else self.temps.next_rows()
            if rows is None:
                raise self._outside(poses, done)
            # the last row stays: a pose may stand between two blocks
            self.time = np.concatenate([self.time[-1:], _time(rows)])
            self.numbers = np.concatenate([self.numbers[-1:], rows.numbers])

    def _between(self, time: FloatArray, to_last: bool) -> tuple[FloatArray, FloatArray]:
        """Return the rows at hand that no pose has met nor meets at these times, up to the last pose or all of them."""
        until = float(time[-1]) if to_last else float(self.time[-1])
        own = (self.time > self.passed) & (self.time <= until) & ~np.isin(self.time, time)
        self.passed = until
        return self.time[own], self.numbers[own]

    def finish(self) -> None:
        while self.temps.next_rows() is not None:
            pass

    def _outside(self, poses: Rows, k: int) -> FileFormatError:
        """Return the error of a pose before the first or after the last temperatures."""
        line = self.poses.line(poses.first + k)
        self.poses.drain()
        self.temps.stream.drain()
        column, temps, own = self.poses.header.column("time_s"), self.temps.stream, self.poses
        message = (
            f"time_s is {_time(poses)[k]!s}, outside the time span of the temperatures: {temps.path} spans "
            f"[{temps.first_time}, {temps.last_time}] s, poses span [{own.first_time}, {own.last_time}] s: "
            "nothing is extrapolated: both files must count from the same zero and the temperatures reach further"
        )
        return FileFormatError(str(own.path), (Problem(line, column, message),))


def _time(rows: Rows) -> FloatArray:
    """Return the times of rows that have them."""
    return np.empty(0) if rows.time is None else rows.time


def _rows(count: int) -> str:
    """Return a number of rows in words."""
    return f"{count} row" + ("s" if count != 1 else "")


def _part(rows: Rows, first: int, last: int) -> Rows:
    """Return some of the rows."""
    time = None if rows.time is None else rows.time[first:last]
    return Rows(rows.first + first, time, rows.numbers[first:last], ())


def interpolated(time: FloatArray, values: FloatArray, wanted: FloatArray) -> FloatArray:
    """Return values at wanted times, linear between the two rows around each; exact at the rows themselves.

    Parameters
    ----------
    time : array, shape (n,) [s]
        Increasing; ``time[0] <= wanted <= time[-1]``.
    values : array, shape (n, s)
    wanted : array, shape (m,) [s]

    Returns
    -------
    array, shape (m, s)
    """
    if len(time) == 1:
        return np.repeat(values, len(wanted), axis=0)
    k = np.clip(np.searchsorted(time, wanted, side="right") - 1, 0, len(time) - 2)
    share = ((wanted - time[k]) / (time[k + 1] - time[k]))[:, None]
    return np.asarray(values[k] * (1.0 - share) + values[k + 1] * share)


def time_hints(*streams: TableStream) -> tuple[str, ...]:
    """Return a note for each column that looks like time but is not called ``time_s``."""
    return tuple(
        f"{stream.path.name}: column {name} is not read as time; only time_s (in seconds) is"
        for stream in streams
        if not stream.header.has_time
        for name in stream.header.extras
        if name.lower() in TIMES
    )


def paired(hexapod: Hexapod, poses: TableStream, temps: TableStream) -> tuple[Temperatures, _Checked]:
    """Return the temperatures that follow the poses, in the way that the two files ask for, and their stream."""
    checked = _Checked(hexapod, temps)
    seen: list[Rows] = []
    while sum(map(len, seen)) < 2 and (rows := checked.next_rows()) is not None:
        seen.append(rows)
    timed = [stream.path.name for stream in (poses, temps) if stream.header.has_time]
    note = f" (time_s only in {timed[0]}: not used for pairing)" if len(timed) == 1 else ""
    if sum(map(len, seen)) == 1:
        # a single row needs no time: only times of its own that go unused are worth a word
        return _One(seen[0].numbers[0], note if temps.header.has_time else ""), checked
    if poses.header.has_time and temps.header.has_time:
        return _ByTime(poses, checked, seen), checked
    return _ByRow(poses, checked, seen, note), checked
