"""Tables of a campaign read as a stream: numbers as they stand, what is missing as NaN, faults with their lines.

The readers of trajectories stop at the first bad row; a logger's table may hold missing values, so that here every row
is handed on and every fault is noted. Memory is constant.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.csv

from hexathermal.errors import ArgumentError, FileFormatError, Problem
from hexathermal.learn.campaign import Campaign, RunFile
from hexathermal.learn.campaign_columns import Column, columns_of, meant_for
from hexathermal.learn.campaign_faults import FIELDS, Faults
from hexathermal.predict.bad_rows import line_ends, lines_from, read_header
from hexathermal.predict.table_streams import CsvStream, ParquetStream, Rows, TableStream, doubles, is_parquet

MISSING = ("", "nan", "NaN", "NAN", "null", "NULL", "NA", "N/A", "None", "-", "--")
"""Fields that say that a value is missing."""


class LoggerCsv(CsvStream):
    """A logger's CSV file being read; missing numbers are NaN, faults are noted in `faults`."""

    def __init__(self, path: Path, wanted: tuple[str, ...], faults: Faults) -> None:
        super().__init__(path, wanted)
        self.faults = faults
        self.faulty: tuple[int, npt.NDArray[np.bool_]] | None = None
        """First row and fields of the block last read that were noted as faults."""

    def _read(self) -> Iterator[pa.RecordBatch]:
        texts = dict.fromkeys(self.header.names, pa.string())
        types = texts | dict.fromkeys(self.header.wanted, pa.float64())
        convert = pa.csv.ConvertOptions(column_types=types, null_values=list(MISSING), strings_can_be_null=False)
        names = list(self.header.names)
        for text in self._texts():
            if not text.strip(b"\r\n"):
                continue
            read = pa.csv.ReadOptions(column_names=names, block_size=len(text) + 1, use_threads=False)
            try:
                table = pa.csv.read_csv(pa.BufferReader(text), read_options=read, convert_options=convert)
            except pa.ArrowInvalid:
                table = self._line_by_line()
            yield from table.combine_chunks().to_batches()

    def _line_by_line(self) -> pa.Table:
        """Return the block that was just begun, read line by line; what is no number is noted and becomes NaN."""
        place, stop = self._places[-1], self._line_after
        columns: dict[str, list[Any]] = {name: [] for name in self.header.names}
        wanted = {name: k for k, name in enumerate(self.header.wanted)}
        faulty: list[list[bool]] = []
        for line, text in lines_from(self.path, place):
            if line >= stop:
                break
            fields = self._fields(line, text)
            faulty.append([False] * len(wanted))
            for k, name in enumerate(self.header.names):
                field = fields[k] if k < len(fields) else ""
                if name not in wanted:
                    columns[name].append(field)
                    continue
                value = self._number(line, name, field)
                columns[name].append(math.nan if value is None else value)
                faulty[-1][wanted[name]] = value is None or k >= len(fields)
        self.faulty = (self.count, np.array(faulty, dtype=bool).reshape(-1, len(wanted)))
        types = {name: pa.float64() if name in self.header.wanted else pa.string() for name in columns}
        return pa.table({name: pa.array(values, types[name]) for name, values in columns.items()})

    def _texts(self) -> Iterator[bytes]:
        """Return the file in blocks of whole lines, and note where each begins and ends."""
        for text in super()._texts():
            self._line_after = self._places[-1].line + line_ends(text) + (not text.endswith((b"\n", b"\r")))
            yield text

    def _fields(self, line: int, text: str) -> list[str]:
        """Return the fields of a line; a wrong number of them is noted."""
        try:
            fields = next(csv.reader([text], strict=True))
        except csv.Error:
            self.faults.add(self.path, Problem(line, 1, "a quote is not closed, or stands inside a field"), "quotes")
            return []
        if len(fields) != len(self.header.names):
            hint = "; were decimal commas written?" if len(fields) > len(self.header.names) else ""
            lost = self.header.names[len(fields) :]
            behind = ", ".join(lost[:3]) + (f" and {len(lost) - 3} more" if len(lost) > 3 else "")
            hint = hint or f"; the row ends before {behind}: repair the table, a missing value is an empty field"
            message = f"found {len(fields)} fields, expected {len(self.header.names)}{hint}"
            column = min(len(fields), len(self.header.names)) + 1
            self.faults.add(self.path, Problem(line, column, message), FIELDS)
        return fields

    def _number(self, line: int, name: str, field: str) -> float | None:
        """Return a field as a number, NaN where it is missing; what is no number is noted, and None."""
        text = field.strip(" \t")
        if text in MISSING:
            return math.nan
        try:
            if "_" in text:
                raise ValueError
            return float(text)
        except ValueError:
            shown = repr(text if len(text) <= 40 else text[:37] + "...")
            message = f"{name} is {shown}, expected {'1 at rest, 0 otherwise' if name == 'settled' else 'a number'}"
            self.faults.add(self.path, Problem(line, self.header.column(name), message), f"text {name}")
            return None

    def _checked(self, block: pa.RecordBatch) -> Rows:
        return _as_they_stand(self, block)


class LoggerParquet(ParquetStream):
    """A Parquet table being read; missing numbers are NaN."""

    def _checked(self, block: pa.RecordBatch) -> Rows:
        return _as_they_stand(self, block)


def _as_they_stand(stream: TableStream, block: pa.RecordBatch) -> Rows:
    """Return a block as rows: what is missing or infinite is NaN."""
    place = {name: k for k, name in enumerate(block.schema.names)}
    numbers = np.empty((block.num_rows, len(stream.header.wanted)))
    for k, name in enumerate(stream.header.wanted):
        numbers[:, k] = doubles(block.column(place[name]))
    numbers[~np.isfinite(numbers)] = np.nan
    rows = Rows(stream.count, None, numbers, tuple(block.column(place[name]) for name in _others(stream)))
    stream.count += len(rows)
    return rows


def _others(stream: TableStream) -> tuple[str, ...]:
    """Return the names of the columns that are not read as numbers."""
    return tuple(name for name in stream.header.names if name not in stream.header.wanted)


class RunTable:
    """The table of a run being read: the format's columns that are there, as numbers.

    Attributes
    ----------
    columns : tuple of Column
        Those of the format that the table has; `numbers` of its rows are in this order and in the file's units.
    others : tuple of str
        Names of the columns that the format does not know; kept by `hexathermal.learn.campaign_dataset`.
    """

    def __init__(self, campaign: Campaign, run: RunFile, faults: Faults | None = None) -> None:
        self.run, self.path = run, run.path
        self.faults = Faults() if faults is None else faults
        self._strict = faults is None
        names = header_names(run.path, self.faults, campaign)
        self.columns = _present(campaign, run.path, names, self.faults) if names else ()
        self.stream: TableStream | None = None
        if self._strict:
            self.faults.finish(campaign.file)
        if names:
            own = tuple(campaign.columns.get(column.name, column.name) for column in self.columns)
            try:
                make = LoggerParquet if is_parquet(run.path) else None
                self.stream = make(run.path, own) if make else LoggerCsv(run.path, own, self.faults)
            except FileFormatError as error:
                self.faults.extend(run.path, error.problems)
        if self._strict:
            self.faults.finish(campaign.file)
        self.others = () if self.stream is None else _others(self.stream)
        self._campaign = campaign

    def __iter__(self) -> Iterator[Rows]:
        """Return the rows from front to back, some thousands at a time."""
        if self.stream is None:
            return
        try:
            while (rows := self.stream.next_rows()) is not None:
                if self._strict:
                    self.faults.finish(self._campaign.file)
                yield rows
        except FileFormatError as error:
            if self._strict:
                raise
            self.faults.extend(self.path, error.problems)
        except (pa.ArrowInvalid, OSError) as error:
            raise ArgumentError(f"{self.path} cannot be read: {error}") from None
        finally:
            self.stream.close()

    def line(self, row: int) -> int:
        """Return the physical line of a row (from 0)."""
        return 1 if self.stream is None else self.stream.line(row)

    def place(self, column: Column) -> int:
        """Return where a column stands in the file, from 1."""
        name = self._campaign.columns.get(column.name, column.name)
        return 1 if self.stream is None else self.stream.header.column(name)

    def faulty(self, first: int, count: int) -> npt.NDArray[np.bool_] | None:
        """Return which fields of the rows just read were noted as faults, shape (count, k); None where none was."""
        noted = self.stream.faulty if isinstance(self.stream, LoggerCsv) else None
        if noted is None or not noted[0] <= first < noted[0] + len(noted[1]):
            return None
        return np.asarray(noted[1][first - noted[0] :][:count], dtype=bool)

    def done(self) -> float:
        """Return which part of the file has been read, 0 to 1."""
        return 1.0 if self.stream is None else min(1.0, self.stream.done() / max(1, self.stream.size))


def header_names(path: Path, faults: Faults, campaign: Campaign | None = None) -> tuple[str, ...]:
    """Return the names of a table's columns, or none after faults were noted."""
    if not path.is_file():
        what = "is a folder" if path.is_dir() else "is not there" if not path.exists() else "is no plain file"
        twin = path.with_suffix(".csv" if is_parquet(path) else ".parquet")
        instead = f"; {twin.name} is there: write file = ... of that name" if twin.is_file() else ""
        faults.add(path, Problem(1, 1, f"the table {what}; [[runs]] in campaign.toml names it{instead}"))
        return ()
    try:
        if is_parquet(path):
            return LoggerParquet(path, ()).header.names
        wanted = _wanted(campaign)
        with path.open("rb") as file:
            empty = not file.read(4096).removeprefix(b"\xef\xbb\xbf").strip()
        names = read_header(path, wanted if empty else ()).names
        return read_header(path, wanted).names if len(names) == 1 else names
    except FileFormatError as error:
        faults.extend(path, error.problems)
    except OSError as error:
        faults.add(path, Problem(1, 1, f"cannot be read: {error.strerror or error}"))
    return ()


def _wanted(campaign: Campaign | None) -> tuple[str, ...]:
    """Return the columns that a table must have, under the names that the logger gave them."""
    if campaign is None:
        return ()
    return tuple(campaign.columns.get(column.name, column.name) for column in columns_of(campaign) if column.required)


def _present(campaign: Campaign, path: Path, names: tuple[str, ...], faults: Faults) -> tuple[Column, ...]:
    """Return the format's columns that a table has; those that it must have and has not are noted."""
    columns = columns_of(campaign)
    own = {column.name: campaign.columns.get(column.name, column.name) for column in columns}
    unknown = [name for name in names if name not in own.values()]
    for column in columns:
        name = own[column.name]
        if name in names:
            continue
        if name != column.name:
            faults.add(path, Problem(1, 1, _mapped_message(column.name, name, names, unknown)))
            continue
        hint = meant_for(name, unknown)
        if column.required or "another unit" in hint:
            place = next((k for k, other in enumerate(names, 1) if repr(other) in hint), 1)
            faults.add(path, Problem(1, place, f"column {name} is missing{hint}"))
    return tuple(column for column in columns if own[column.name] in names)


def _mapped_message(name: str, own: str, names: tuple[str, ...], unknown: list[str]) -> str:
    """Return what is said of a column that the table has not under the name that [columns] gives it."""
    close = get_close_matches(own, unknown, 1)
    hint = f"; was {close[0]!r} meant?" if close else ""
    if name in names:
        hint = f"; the table has {name} itself: take the line out of [columns]"
    return f"column {own!r} is missing, which [columns] of campaign.toml gives as the name of {name}{hint}"
