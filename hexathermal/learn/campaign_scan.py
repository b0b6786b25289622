"""Every fault of a campaign's tables, found in one pass over all rows in constant memory.

A fault is what no cleaning can make good without guessing: a text in a number, a required column that is missing, a row
that ends early, a block of missing values, a clock that runs back. Single missing values, missing codes, spikes and
dead channels are no faults; they are cleaned, see `hexathermal.learn.cleaning`.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError, Problem
from hexathermal.learn.campaign import Campaign, RunFile
from hexathermal.learn.campaign_clocks import ClockWarning, RunClock, doubt, impossible, unlike_others
from hexathermal.learn.campaign_columns import Column
from hexathermal.learn.campaign_faults import Faults
from hexathermal.learn.campaign_streams import RunTable
from hexathermal.learn.campaign_units import Sample, unit_faults
from hexathermal.learn.cleaning_rules import jumping_ahead
from hexathermal.poses import FloatArray

LONGEST_GAP_ROWS = 10
"""So many missing values in a row, one below the other, are a lost block; fewer are cleaned."""

MOST_DISORDER = 0.5
"""Share from which leaving such rows out is no advice: too little would be left."""

LARGEST_DISORDER = 0.01
"""Share of a run's rows whose time may lie before that of an earlier row; more is a fault."""

Progress = Callable[[int, int, str], None]


def scan_tables(
    campaign: Campaign, faults: Faults, *, rows: bool = True, clocks: bool = True, progress: Progress | None = None
) -> None:
    """Note the faults of all tables of a campaign; without `rows` those of their headers.

    With `clocks` those of clocks that no measurement has too.
    """
    count = len(campaign.runs)
    scans: list[_Scan] = []
    for k, run in enumerate(campaign.runs):
        table = RunTable(campaign, run, faults)
        if not rows:
            continue
        scan = _Scan(campaign, run, table, faults)
        try:
            for part in table:
                scan.add(part.numbers)
                if progress is not None:
                    progress(int(1000 * (k + table.done())), 1000 * count, f"reading {run.name}")
        except ArgumentError as error:
            faults.add(run.path, Problem(1, 1, str(error)))
        if table.stream is not None:
            scan.finish()
            scans.append(scan)
    if clocks:
        _scan_clocks(scans, faults)


def _scan_clocks(scans: list[_Scan], faults: Faults) -> None:
    """Note clocks that no measurement has, of runs by themselves and beside the others; warn of what looks odd."""
    intervals = [scan.clock.interval for scan in scans]
    unlike = unlike_others(intervals)
    for k, scan in enumerate(scans):
        problem = scan.at_clock(0, unlike[k]) if k in unlike else scan.impossible_clock()
        if problem is not None:
            message = f"run {scan.run.name!r}: {problem.message}"
            faults.add(scan.run.path, Problem(problem.line, problem.column, message))
    if not faults and (said := doubt([scan.run.name for scan in scans], intervals)):
        warnings.warn(said, ClockWarning, stacklevel=4)


class _Scan:
    """The rows of one run as they pass."""

    def __init__(self, campaign: Campaign, run: RunFile, table: RunTable, faults: Faults) -> None:
        self.campaign, self.run, self.table, self.faults = campaign, run, table, faults
        self.count = 0
        k = len(table.columns)
        self._missing = np.zeros(k, dtype=np.int64)
        self._since = np.full(k, -1, dtype=np.int64)
        self._blocks: dict[tuple[int, int], list[int]] = {}
        self._parts = [column.part for column in table.columns]
        self._latest, self._late, self._first_late = -np.inf, 0, -1
        self._waiting = (np.zeros(0), np.zeros(0, dtype=np.int64))
        self._faulty = np.zeros(k, dtype=np.int64)
        self._sample = Sample(k)
        self.clock = RunClock()

    def add(self, numbers: FloatArray) -> None:
        """Look at the next rows."""
        missing = np.isnan(numbers)
        self._missing += missing.sum(axis=0)
        # a field that is no number, or behind the end of its row, was noted as such when it was read
        faulty = self.table.faulty(self.count, len(numbers))
        if faulty is not None:
            self._faulty += faulty.sum(axis=0)
            missing &= ~faulty
        self._note_blocks(missing)
        self._sample.add(numbers)
        if "time" in self._parts:
            self._note_clock(numbers[:, self._parts.index("time")])
        if "settled" in self._parts:
            k = self._parts.index("settled")
            value = numbers[:, k]
            odd = np.flatnonzero(np.isfinite(value) & (value != 0.0) & (value != 1.0))
            for row in odd:
                self._fault(self.count + int(row), k, f"settled is {value[row]:g}, expected 1 at rest, 0 otherwise")
        self.count += len(numbers)

    def _note_blocks(self, missing: npt.NDArray[np.bool_]) -> None:
        """Follow runs of missing values down each column."""
        touched = missing.any(axis=0) | (self._since >= 0)
        for k in np.flatnonzero(touched):
            flags = np.concatenate([[self._since[k] >= 0], missing[:, k]]).astype(np.int8)
            edges = np.diff(flags)
            for row in np.flatnonzero(edges):
                if edges[row] > 0:
                    self._since[k] = self.count + row
                else:
                    self._close(int(k), self.count + int(row))

    def _close(self, k: int, end: int) -> None:
        """End a run of missing values of a column before row `end`; note it where it is long."""
        start = int(self._since[k])
        self._since[k] = -1
        if end - start >= LONGEST_GAP_ROWS:
            self._blocks.setdefault((start, end), []).append(k)

    def _note_clock(self, time: FloatArray, last: bool = False) -> None:
        """Count the rows whose time is before that of an earlier row; the last row waits until the next is seen."""
        time = np.concatenate([self._waiting[0], time])
        rows = np.concatenate([self._waiting[1], np.arange(self.count, self.count + len(time) - len(self._waiting[1]))])
        known = ~np.isnan(time)
        time, rows = time[known], rows[known]
        keep = ~jumping_ahead(time, self._latest)
        if not last:
            self._waiting = time[-1:], rows[-1:]
            keep[-1:] = False
        time, rows = time[keep], rows[keep]
        before = np.maximum.accumulate(np.concatenate([[self._latest], time]))
        late = rows[time < before[:-1]]
        if late.size and self._first_late < 0:
            self._first_late = int(late[0])
        self._late += late.size
        self._latest = float(before[-1])
        good = time >= before[:-1]
        self.clock.add(time[good], rows[good])

    def at_clock(self, row: int, message: str) -> Problem:
        """Return a problem of the time of a row."""
        return Problem(self.table.line(row), self.table.place(self.table.columns[self._parts.index("time")]), message)

    def impossible_clock(self) -> Problem | None:
        """Return what is wrong with the run's clock by itself, or None."""
        if "time" not in self._parts or self.clock.row < 0:
            return None
        jump = self.clock.jump
        rows = (0, 0) if jump is None else (jump.before, jump.behind)
        before, behind, last = (self.table.line(row) for row in (*rows, self.clock.row))
        return impossible(self.clock, (before, behind, last), self.at_clock(0, "").column)

    def _fault(self, row: int, k: int, message: str) -> None:
        """Note a fault of one field; the kind is the column's."""
        kind = f"{self._parts[k]} {k}"
        place = self.table.place(self.table.columns[k])
        self.faults.add(self.run.path, Problem(self.table.line(row), place, message), kind)

    def finish(self) -> None:
        """Note what only the whole table shows."""
        for k in np.flatnonzero(self._since >= 0):
            self._close(int(k), self.count)
        if "time" in self._parts:
            self._note_clock(np.zeros(0), last=True)
        if self.count == 1:
            self.faults.add(self.run.path, Problem(self.table.line(0), 1, "the table has one row, expected more"))
        self._finish_columns()
        self._finish_units()
        if "missing-blocks" not in self.campaign.accepted:
            for (start, end), columns in sorted(self._blocks.items()):
                lost = [k for k in columns if self._missing[k] < self.count]
                if lost:
                    self._lost_block(start, end, lost)
        share = self._late / max(1, self.count)
        if share > LARGEST_DISORDER and "clock-disorder" not in self.campaign.accepted:
            clock = self._parts.index("time")
            message = (
                f"time_s goes back: {self._late} of {self.count} rows are earlier than a row before them, this is the "
                "first; sort the table by time_s"
            )
            if share < MOST_DISORDER:
                message += ', or write accept = ["clock-disorder"] in [cleaning] to leave them out'
            self._fault(self._first_late, clock, message)

    def _finish_columns(self) -> None:
        """Note required columns without a single number; a thermocouple may be dead."""
        if self.count < 2:
            return
        for k in np.flatnonzero((self._missing == self.count) & (self._faulty == 0)):
            column = self.table.columns[k]
            if column.required and column.part not in ("temperature", "input"):
                self._fault(0, int(k), f"{column.name} holds no number in any of {self.count} rows")
        heat = [k for k, part in enumerate(self._parts) if part == "temperature"]
        if heat and all(self._missing[k] == self.count and not self._faulty[k] for k in heat):
            self._fault(0, heat[0], f"no thermocouple holds a number in any of {self.count} rows")

    def _finish_units(self) -> None:
        """Note values that can only be in another unit than the column's name says."""
        for found in unit_faults(self.campaign, self.table.columns, self._sample):
            place = self.table.place(self.table.columns[found.columns[0]])
            self.faults.add(self.run.path, Problem(self.table.line(0), place, found.message))

    def _lost_block(self, start: int, end: int, columns: list[int]) -> None:
        """Note a block of missing values."""
        first, last = self.table.line(start), self.table.line(end - 1)
        names = [self._own(self.table.columns[k]) for k in columns]
        which = f"column {names[0]} holds" if len(names) == 1 else f"columns {', '.join(names)} hold"
        where = "to the end of the table" if end == self.count else f"to line {last}"
        message = (
            f"{which} no number from line {first} {where} ({end - start} rows); repair the table, or write "
            'accept = ["missing-blocks"] in [cleaning] of campaign.toml to leave them out'
        )
        place = self.table.place(self.table.columns[columns[0]])
        self.faults.add(self.run.path, Problem(first, place, message))

    def _own(self, column: Column) -> str:
        """Return a column's name in the file."""
        return self.campaign.columns.get(column.name, column.name)
