"""Tables of numbers read as a stream: CSV or Parquet in constant memory, every row checked before it is handed on.

A CSV file has one header line; fields are separated by commas, numbers have a decimal point, the text is UTF-8.
Empty lines are passed over, and a quoted text may not run over the end of its line.  What is wrong with a row is said
with its physical line, see `hexathermal.predict.bad_rows`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute
import pyarrow.csv
import pyarrow.parquet

from hexathermal.errors import ArgumentError, FileFormatError, Problem
from hexathermal.poses import FloatArray
from hexathermal.predict.bad_rows import (
    LONGEST_LINE,
    Header,
    Place,
    bad_row,
    line_ends,
    line_of,
    match_columns,
    read_header,
)

BLOCK_BYTES = 2 << 20
"""Part of a CSV file read at a time: some 30 000 rows of a trajectory."""

BLOCK_ROWS = 1 << 15
"""Rows of a Parquet file read at a time."""

NO_ROWS = "the file has a header but no rows; expected at least one"


@dataclass(frozen=True, eq=False)
class Rows:
    """Consecutive rows of a table: number of the first (from 0), times [s], numbers (n, k), and the other columns."""

    first: int
    time: FloatArray | None
    numbers: FloatArray
    extras: tuple[Any, ...]

    def __len__(self) -> int:
        return len(self.numbers)


class TableStream(ABC):
    """A table being read from front to back.

    Attributes
    ----------
    header : Header
        Columns of the file and which of them are read as numbers.
    count : int
        Rows handed on so far.
    first_time, last_time : float or None
        Of the rows handed on so far [s].
    size : int
        Bytes of the file.
    """

    def __init__(self, path: Path, header: Header) -> None:
        self.path, self.header = path, header
        self.size = path.stat().st_size
        self.count = 0
        self.first_time: float | None = None
        self.last_time: float | None = None
        self._blocks = self._read()

    @abstractmethod
    def _read(self) -> Iterator[pa.RecordBatch]:
        """Return the blocks of the file, columns named as in the header."""

    @abstractmethod
    def done(self) -> int:
        """Return about how many bytes have been read."""

    @abstractmethod
    def line(self, row: int) -> int:
        """Return the physical line of a row of a text file, or the row's number from 1."""

    @abstractmethod
    def refuse(self, reason: str) -> FileFormatError:
        """Return what is wrong with the first bad row after those handed on; `reason` where none is found."""

    def close(self) -> None:
        """Let go of the file."""
        self._blocks.close()  # type: ignore[attr-defined]

    def next_rows(self) -> Rows | None:
        """Return the next rows, or None at the end of the file.

        Raises
        ------
        FileFormatError
            A field is missing, no number or not finite, or a time does not increase; or the file has no rows.
        """
        for block in self._blocks:
            if block.num_rows:
                return self._checked(block)
        if not self.count:
            raise FileFormatError(str(self.path), (Problem(self.header.line, 1, NO_ROWS),))
        return None

    def drain(self) -> None:
        """Read the rest of the file, so that `count` and `last_time` are those of the whole."""
        while self.next_rows() is not None:
            pass

    def _checked(self, block: pa.RecordBatch) -> Rows:
        """Return a block as checked rows."""
        columns = {name: block.column(k) for k, name in enumerate(block.schema.names)}
        numbers = np.column_stack([doubles(columns[name]) for name in self.header.wanted])
        time = doubles(columns["time_s"]) if self.header.has_time else None
        extras = tuple(columns[name] for name in self.header.extras)
        if not np.isfinite(numbers).all() or any(_breaks_lines(column) for column in extras):
            raise self.refuse("a value is missing or not finite")
        if time is not None:
            before = -np.inf if self.last_time is None else self.last_time
            if not np.isfinite(time).all() or not (np.diff(time, prepend=before) > 0.0).all():
                raise self.refuse("time_s does not increase")
            self.first_time = float(time[0]) if self.first_time is None else self.first_time
            self.last_time = float(time[-1])
        rows = Rows(self.count, time, numbers, extras)
        self.count += len(rows)
        return rows


def doubles(column: Any) -> FloatArray:
    """Return a column of numbers as doubles, shape (N,); NaN where a number is missing."""
    if column.type == pa.float64() and not column.null_count:
        return np.asarray(np.from_dlpack(column), dtype=np.float64)  # `to_numpy` would load pandas, a tenth of a second
    return np.asarray(column.to_numpy(zero_copy_only=False), dtype=np.float64)


def _breaks_lines(column: Any) -> bool:
    """Whether a text of a column holds a line end: a quote was not closed."""
    if not pa.types.is_string(column.type):
        return False
    return bool(pa.compute.any(pa.compute.match_substring_regex(column, "[\r\n]")).as_py())


class CsvStream(TableStream):
    """A CSV file being read."""

    def __init__(self, path: Path, wanted: tuple[str, ...]) -> None:
        super().__init__(path, read_header(path, wanted))
        self._places: list[Place] = []

    def _read(self) -> Iterator[pa.RecordBatch]:
        texts = dict.fromkeys(self.header.names, pa.string())
        types = texts | dict.fromkeys(self.header.numbers, pa.float64())
        # an empty or spelled-out missing value is an error here, never a silent null
        convert = pa.csv.ConvertOptions(column_types=types, null_values=[], strings_can_be_null=False)
        for text in self._texts():
            if not text.strip(b"\r\n"):
                continue
            read = pa.csv.ReadOptions(column_names=list(self.header.names), block_size=len(text) + 1, use_threads=False)
            try:
                table = pa.csv.read_csv(pa.BufferReader(text), read_options=read, convert_options=convert)
            except pa.ArrowInvalid as error:
                raise self.refuse(str(error)) from None
            yield from table.combine_chunks().to_batches()

    def _texts(self) -> Iterator[bytes]:
        """Return the file in blocks of whole lines, and note where each begins."""
        line, rest = self.header.line + 1, b""
        with self.path.open("rb", buffering=0) as file:
            file.seek(self.header.end)
            while got := file.read(BLOCK_BYTES):
                text = rest + got
                # a carriage return alone may end a line too, unless its line feed is still to come
                cut = text.rfind(b"\n") + 1 or text.rfind(b"\r", 0, len(text) - 1) + 1
                self._places.append(Place(self.count, file.tell() - len(text), line))
                if not cut and len(text) > LONGEST_LINE:
                    raise self.refuse("a line is too long")
                block, rest = text[:cut], text[cut:]
                if block:
                    line += line_ends(block)
                    yield block
            self._places.append(Place(self.count, self.size - len(rest), line))
            yield rest

    def done(self) -> int:
        """Return about how many bytes have been read."""
        return self._places[-1].byte if self._places else 0

    def line(self, row: int) -> int:
        """Return the physical line of a row."""
        return line_of(self.path, self._places[bisect_right(self._places, row, key=lambda place: place.row) - 1], row)

    def refuse(self, reason: str) -> FileFormatError:
        """Return what is wrong with the first bad row after those handed on."""
        return bad_row(self.path, self.header, self._places[-1], self.last_time, reason)


class ParquetStream(TableStream):
    """A Parquet file being read; its rows are counted from 1 where a text file has lines."""

    def __init__(self, path: Path, wanted: tuple[str, ...]) -> None:
        try:
            self._file = pa.parquet.ParquetFile(path, pre_buffer=False)
        except pa.ArrowInvalid as error:
            raise FileFormatError(str(path), (Problem(1, 1, f"not a Parquet file: {error}"),)) from None
        schema = self._file.schema_arrow
        header = match_columns(path, tuple(schema.names), wanted, line=1, end=0)
        odd = [name for name in header.numbers if not _is_number(schema.field(name).type)]
        if odd:
            problems = tuple(
                Problem(1, header.column(name), f"column {name} holds {schema.field(name).type}, expected numbers")
                for name in odd
            )
            raise FileFormatError(str(path), problems)
        super().__init__(path, header)

    def _read(self) -> Iterator[pa.RecordBatch]:
        schema = self._file.schema_arrow
        for name in self.header.numbers:
            schema = schema.set(schema.get_field_index(name), pa.field(name, pa.float64()))
        with self._file:
            for block in self._file.iter_batches(BLOCK_ROWS):
                # values over 2**53 or decimals may be rounded to the nearest double, as a text would be
                yield block.cast(schema, safe=False)

    def done(self) -> int:
        """Return about how many bytes have been read."""
        return int(self.size * self.count / max(1, self._file.metadata.num_rows))

    def line(self, row: int) -> int:
        """Return the row's number from 1."""
        return row + 1

    def refuse(self, reason: str) -> FileFormatError:
        """Return what is wrong with the first bad row after those handed on."""
        found = next(filter(None, self._again()), (Problem(self.count + 1, 1, reason),))
        return FileFormatError(str(self.path), found)

    def _again(self) -> Iterator[tuple[Problem, ...]]:
        """Return the problems of each row after those handed on."""
        last = -np.inf if self.last_time is None else self.last_time
        names = list(self.header.numbers)
        with pa.parquet.ParquetFile(self.path, pre_buffer=False) as file:
            row = 0
            for block in file.iter_batches(BLOCK_ROWS, columns=names):
                columns = {name: block.column(name).cast(pa.float64(), safe=False).to_pylist() for name in names}
                for k in range(block.num_rows):
                    if row >= self.count:
                        values = {name: columns[name][k] for name in names}
                        yield _problems_of(self.header, row + 1, values, last)
                        last = values.get("time_s", last)
                    row += 1


def _problems_of(header: Header, row: int, values: dict[str, float | None], last: float) -> tuple[Problem, ...]:
    """Return what is wrong with the numbers of one row of a Parquet file."""
    problems = []
    for name, value in values.items():
        if value is None:
            message = f"{name} is missing, expected a number"
        elif not np.isfinite(value):
            message = f"{name} is {value}, expected a finite number"
        elif name == "time_s" and not value > last:
            message = f"time_s is {value!r}, expected more than {last!r}, the row before: times must increase"
        else:
            continue
        problems.append(Problem(row, header.column(name), f"(row {row}) {message}"))
    return tuple(problems)


def _is_number(kind: Any) -> bool:
    """Whether a column type is a number."""
    return bool(pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_decimal(kind))


def is_parquet(path: Path) -> bool:
    """Whether a file is Parquet by its name; every other is CSV."""
    return path.suffix.lower() in (".parquet", ".pq")


def open_table(path: str | Path, wanted: tuple[str, ...], what: str) -> TableStream:
    """Return a table ready to be read; the header is read and checked.

    Parameters
    ----------
    path : str or Path
        ``.parquet`` or ``.pq``: Parquet; anything else: CSV.
    wanted : tuple of str
        Columns that must be there, read as numbers in this order; ``time_s`` is read where it is there.
    what : str
        What the file holds, for messages.

    Raises
    ------
    ArgumentError
        There is no such file, or it cannot be read.
    FileFormatError
        The header is missing, or columns are missing or named twice.
    """
    file = Path(path)
    if not file.is_file():
        kind = "a folder" if file.is_dir() else "not there" if not file.exists() else "no plain file"
        raise ArgumentError(f"{what} file {file} is {kind}; give the path of a CSV or Parquet file")
    try:
        with file.open("rb"):
            pass
        return ParquetStream(file, wanted) if is_parquet(file) else CsvStream(file, wanted)
    except OSError as error:
        raise ArgumentError(f"{what} file {file} cannot be read: {error.strerror or error}") from None
