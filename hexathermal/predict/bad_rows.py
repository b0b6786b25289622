"""What is wrong with a table: its header, and the first bad row with its physical line, its columns and values.

The fast reader stops at a bad row but does not say where it stands in the file.  The block is then read again line by
line, as far as the first row that breaks a rule.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from itertools import islice
from pathlib import Path

from hexathermal.errors import FileFormatError, Problem

LONGEST_LINE = 1 << 20
"""Characters; a file with a longer line is no table of numbers."""

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_NOT_FINITE = re.compile(r"[+-]?(nan|inf|infinity)", re.IGNORECASE)
_UNITS = {"mm": "mm", "deg": "degrees", "degC": "degrees Celsius", "s": "seconds"}


@dataclass(frozen=True)
class Header:
    """Columns of a table.

    `names` as they stand in the file (spaces around them removed), `wanted` and ``time_s`` are read as numbers, the
    rest are `extras`.  `line` is the header's line, `end` the byte behind it.
    """

    names: tuple[str, ...]
    wanted: tuple[str, ...]
    line: int
    end: int

    @property
    def has_time(self) -> bool:
        """Whether there is a column ``time_s``."""
        return "time_s" in self.names

    @property
    def numbers(self) -> tuple[str, ...]:
        """Names of the columns that are read as numbers."""
        return (*(("time_s",) if self.has_time else ()), *self.wanted)

    @property
    def extras(self) -> tuple[str, ...]:
        """Names of the columns that are not asked for, in the file's order."""
        return tuple(name for name in self.names if name not in self.numbers)

    def column(self, name: str) -> int:
        """Return the place of a column, from 1."""
        return self.names.index(name) + 1


def read_header(path: Path, wanted: tuple[str, ...]) -> Header:
    """Return the header of a CSV file after checking it.

    Raises
    ------
    FileFormatError
        No header, no text in UTF-8, another separator than a comma, or columns missing, unnamed or named twice.
    """
    with path.open("rb") as file:
        start = file.read(LONGEST_LINE)
    text = start[3:] if start.startswith(b"\xef\xbb\xbf") else start
    skipped = len(start) - len(text)
    blank = re.match(rb"[\r\n]*", text)
    gap = 0 if blank is None else blank.end()
    line = 1 + line_ends(text[:gap])
    end = re.search(rb"\r\n|\r|\n", text[gap:])
    content = text[gap : gap + end.start()] if end else text[gap:]

    def refuse(message: str) -> FileFormatError:
        return FileFormatError(str(path), (Problem(line, 1, message),))

    if not content:
        raise refuse(f"the file is empty; expected a header line: {','.join(wanted)}")
    if end is None and len(start) == LONGEST_LINE:
        raise refuse(f"the header line is longer than {LONGEST_LINE} bytes: this is no CSV file")
    try:
        names = next(csv.reader([content.decode("utf-8")], strict=True, skipinitialspace=True))
    except (UnicodeDecodeError, csv.Error) as error:
        raise refuse(
            f"not a CSV header in UTF-8 ({error}); is the file packed, or a spreadsheet's own format?"
        ) from None
    if "\0" in content.decode("utf-8"):
        raise refuse("the header holds zero bytes: not a text file in UTF-8 (UTF-16?)")
    if len(names) == 1 and len(wanted) > 1:
        for separator, name in ((";", "semicolons"), ("\t", "tabs")):
            if separator in names[0]:
                raise refuse(f"fields are separated by {name}; expected commas, and decimal points in numbers")
    behind = gap + (len(content) if end is None else end.end())
    return match_columns(path, tuple(name.strip() for name in names), wanted, line=line, end=skipped + behind)


def line_ends(text: bytes) -> int:
    """Return how many lines end in a text."""
    return text.count(b"\n") + text.count(b"\r") - text.count(b"\r\n")


def match_columns(path: Path, names: tuple[str, ...], wanted: tuple[str, ...], *, line: int, end: int) -> Header:
    """Return the header after checking that all wanted columns are there, and every column once; lists all problems."""
    problems = []
    for k, name in enumerate(names):
        if not name:
            problems.append(Problem(line, k + 1, "the column has no name"))
        elif name in names[:k]:
            problems.append(
                Problem(line, k + 1, f"column {name} is there twice, first as column {names.index(name) + 1}")
            )
    missing = [name for name in wanted if name not in names]
    if missing:
        problems.append(Problem(line, 1, _missing(missing, names, wanted)))
    if problems:
        raise FileFormatError(str(path), tuple(problems))
    return Header(names, wanted, line, end)


def _missing(missing: list[str], names: tuple[str, ...], wanted: tuple[str, ...]) -> str:
    """Return which columns are missing, what the header names instead, and what may have gone wrong."""
    others = [name for name in names if name not in wanted]
    close = {name: found for name in missing if (found := _meant_for(name, others))}
    once = {name: found for name, found in close.items() if list(close.values()).count(found) == 1}
    meant = "".join(f"; was {found!r} meant for {name}?" for name, found in once.items())
    shown = ", ".join(names[:20]) + (", ..." if len(names) > 20 else "")
    which = f"column {missing[0]} is" if len(missing) == 1 else f"columns {', '.join(missing)} are"
    hint = ""
    if names[0].startswith("#"):
        hint = "; a header line has no # before it, and there are no comments: remove it"
    elif all(_NUMBER.fullmatch(name) or _NOT_FINITE.fullmatch(name) for name in names):
        hint = "; this line holds numbers: is the header line missing?"
    elif kelvin := next((name for name in names if name.lower() in _in_kelvin(missing)), ""):
        own = _in_kelvin(missing)[kelvin.lower()]
        hint = f"; {kelvin!r} seems to hold kelvin: give degrees Celsius (K - 273.15) and name the column {own}"
    elif len(missing) == len(wanted) and _of_heat(wanted) != _of_heat(names) and not meant:
        hint = "; were the two files swapped?"
    return f"{which} missing{meant}; the header names: {shown}{hint}"


def _in_kelvin(names: list[str]) -> dict[str, str]:
    """Return columns of temperatures by the names, in small letters, that they may have where they hold kelvin."""
    stems = {name: name.removesuffix("_degC").lower() for name in names if name.endswith("_degC")}
    return {f"{stem}_{unit}": name for name, stem in stems.items() for unit in ("k", "kelvin", "degk")}


def _of_heat(names: tuple[str, ...]) -> bool:
    """Whether columns are those of temperatures."""
    return any(name.endswith("_degC") for name in names)


def _meant_for(name: str, others: list[str]) -> str:
    """Return the other column that may have been meant: the name in other letters, without its unit, or nearly."""
    plain = name.rpartition("_")[0].lower()
    same = [other for other in others if other.lower() in (name.lower(), plain)]
    close = same or get_close_matches(name, others, 1, 0.85)
    return close[0] if close else ""


@dataclass(frozen=True)
class Place:
    """Where a block of a text file begins: its first row (from 0), byte and physical line."""

    row: int
    byte: int
    line: int


def lines_from(path: Path, place: Place) -> Iterator[tuple[int, str]]:
    """Return the lines from a place on that are not empty, each with its number; bytes that are no UTF-8 are marked."""
    with path.open("rb") as file:
        file.seek(place.byte)
        with io.TextIOWrapper(file, encoding="utf-8", errors="surrogateescape", newline=None) as texts:
            line = place.line
            while text := texts.readline(LONGEST_LINE):
                if text != "\n":
                    yield line, text.removesuffix("\n")
                line += 1


def line_of(path: Path, place: Place, row: int) -> int:
    """Return the physical line of a row (from 0) that stands behind a place."""
    rows = islice(lines_from(path, place), row - place.row, None)
    return next((line for line, _text in rows), place.line)


def bad_row(path: Path, header: Header, place: Place, last_time: float | None, reason: str) -> FileFormatError:
    """Return what is wrong with the first bad row behind a place: all its bad fields.

    Parameters
    ----------
    last_time : float or None [s]
        Time of the row before the place.
    reason : str
        Said where no row breaks a rule known here.
    """
    for line, text in lines_from(path, place):
        problems, last_time = _problems(header, line, text, last_time)
        if problems:
            return FileFormatError(str(path), problems)
    return FileFormatError(str(path), (Problem(place.line, 1, f"the file cannot be read from here on: {reason}"),))


def _problems(
    header: Header, line: int, text: str, last_time: float | None
) -> tuple[tuple[Problem, ...], float | None]:
    """Return what is wrong with one line, and its time."""
    if len(text) >= LONGEST_LINE - 1:
        return (Problem(line, 1, f"the line is longer than {LONGEST_LINE} characters: this is no table"),), None
    if any("\udc80" <= letter <= "\udcff" for letter in text):
        return (Problem(line, 1, "the line is not text in UTF-8"),), None
    try:
        fields = next(csv.reader([text], strict=True))
    except csv.Error:
        return (Problem(line, 1, "a quote is not closed on this line, or stands inside a field"),), None
    if len(fields) != len(header.names):
        hint = "; were decimal commas written?" if len(fields) > len(header.names) else ""
        message = f"found {len(fields)} fields, expected {len(header.names)} ({','.join(header.names)}){hint}"
        return (Problem(line, min(len(fields), len(header.names)) + 1, message),), None
    problems = [_field(header, line, name, fields[header.column(name) - 1]) for name in header.numbers]
    found = tuple(problem for problem in problems if problem is not None)
    if found or not header.has_time:
        return found, None
    time = float(fields[header.column("time_s") - 1])
    if last_time is not None and not time > last_time:
        message = f"time_s is {time!r}, expected more than {last_time!r}, the row before: times must increase"
        return (Problem(line, header.column("time_s"), message),), time
    return (), time


def _field(header: Header, line: int, name: str, field: str) -> Problem | None:
    """Return what is wrong with one number."""
    text = field.strip(" \t")
    unit = _UNITS.get(name.rpartition("_")[2], "no unit")
    shown = repr(text if len(text) <= 40 else text[:37] + "...")
    if not text:
        message = f"{name} is missing, expected a number ({unit})"
    elif _NOT_FINITE.match(text):
        message = f"{name} is {shown}, expected a finite number ({unit})"
    elif not _NUMBER.fullmatch(text):
        message = f"{name} is {shown}, expected a number ({unit})"
    elif not math.isfinite(float(text)):
        message = f"{name} is {shown}, too large for a number ({unit})"
    else:
        return None
    return Problem(line, header.column(name), message)
