"""Reading TOML files against a table of keys: units, shapes, and every bad field with its place."""

from __future__ import annotations

import os
import re
import tomllib
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from difflib import get_close_matches
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError, FileFormatError, Problem, UnknownNameError
from hexathermal.machine.toml_positions import Positions, Where, excess, line_and_column
from hexathermal.machine.units import from_millionths, metres, radians, same

Reader = Callable[[Decimal], float]
Made = TypeVar("Made")

_READERS: dict[str, Reader] = {
    "mm": metres,
    "um": from_millionths,
    "deg": radians,
    "number": same,
    "matrix": same,
}
_SIMPLE: dict[str, tuple[type, str]] = {
    "text": (str, "a text"),
    "flag": (bool, "true or false"),
    "table": (dict, "a table"),
    "tables": (list, "tables [[...]]"),
}
_SHAPES = {"mm6": "one value, or six", "deg6": "one value, or six", "um6": "one value, or six",
           "mm": "one value", "number": "one value",
           "number+": "one value, or a list", "mm2|mm(6,2)": "[low, high], or six such pairs",
           "matrix": "a square matrix"}  # fmt: skip
_ERROR_PLACE = re.compile(r" \(at (?:line (\d+), column (\d+)|end of document)\)$")


@dataclass(frozen=True)
class _Unreadable:
    """A number whose exponent no decimal can hold."""

    text: str


def _decimal(text: str) -> Decimal | _Unreadable:
    """Return a number of the file."""
    try:
        return Decimal(text)
    except InvalidOperation:
        return _Unreadable(text)


class Form:
    """A TOML file being read: collects every problem before anything is raised.

    Parameters
    ----------
    path : Path
    tables : mapping of table kind to its keys and their rules
        A rule is a kind (``text``, ``texts``, ``flag``, ``table``, ``tables``, ``mm``, ``um`` (millionths), ``deg``,
        ``number``, ``matrix``), a shape in brackets, ``6`` for one or six, ``+`` for one or more, and ``!`` where the
        key is required.

    Raises
    ------
    FileFormatError
        The file cannot be read, or is no text in UTF-8, or no TOML.
    """

    def __init__(self, path: Path, tables: Mapping[str, Mapping[str, str]]) -> None:
        self.path = path
        self.tables = tables
        self.top: dict[str, Any] = {}
        self.problems: list[Problem] = []
        text = _text(path)
        try:
            self.data: dict[str, Any] = tomllib.loads(text, parse_float=_decimal)
            self.positions = Positions(text)
        except tomllib.TOMLDecodeError as error:
            place = _ERROR_PLACE.search(str(error))
            line, column = line_and_column(text, len(text))
            if place and place.group(1):
                line, column = int(place.group(1)), int(place.group(2))
            message = f"not valid TOML: {_ERROR_PLACE.sub('', str(error))}"
            raise FileFormatError(str(path), (Problem(line, column, message),)) from None
        except (RecursionError, ValueError):
            message = "brackets are nested too deep, or a number has too many digits"
            raise FileFormatError(str(path), (Problem(*excess(text), message),)) from None

    @classmethod
    def opened(
        cls,
        path: str | os.PathLike[str],
        tables: Mapping[str, Mapping[str, str]],
        form: str,
        what: str,
        expected: str,
        name: str = "",
    ) -> Form:
        """Return a file of a known format being read; `top` holds the checked values of its top table.

        Parameters
        ----------
        path : str or Path
        tables : mapping
            As in `Form`; the top table is ``""``.
        form : str
            What its key ``format`` must say.
        what, expected : str
            For the error where there is no file: what it is, and which file is expected.
        name : str
            Of the file, where `path` may be the folder that holds it.

        Raises
        ------
        ArgumentError
            There is no such file.
        FileFormatError
            As `Form`.
        """
        if not isinstance(path, str | os.PathLike):
            raise ArgumentError(f"a {what} is named by a text or a path, not by {type(path).__name__}")
        file = Path(path)
        if name and os.path.isdir(file):
            if not os.path.exists(file / name):
                raise ArgumentError(f"no {what} at {file / name}: the folder is there, but holds no {name}")
            file = file / name
        if not os.path.isfile(file):
            found = " (it is a folder)" if os.path.isdir(file) else " (it is no plain file)" * os.path.exists(file)
            raise ArgumentError(f"no {what} at {file}{found}; expected {expected}")
        self = cls(file, tables)
        stated = self.data.get("format", form)
        if isinstance(stated, str) and stated != form:
            # a file of another kind has other keys: to list them all would hide what it is
            kind = "" if stated.rpartition("/")[0] == form.rpartition("/")[0] else f"; expected is {expected}"
            self.complain(("format",), f"format is {shown(stated)}; this version reads {form!r}{kind}")
            self.finish()
        self.top = self.table(self.data, (), "")
        return self

    def complain(self, where: Where, message: str) -> Any:
        """Note a problem at a key or an array element; returns None, so that a caller may return it."""
        line, column = self.positions.of(where)
        self.problems.append(Problem(line, column, message))
        return None

    def table(self, data: dict[str, Any], path: Where, kind: str) -> dict[str, Any]:
        """Return the checked values of one table: numbers as arrays in SI units."""
        keys, found = self.tables[kind], {}
        for key in data:
            if key not in keys:
                close = meant(key, keys)
                self.complain((*path, key), f"unknown key {key!r}; {close + ' ' * bool(close)}known: {', '.join(keys)}")
        for key, rule in keys.items():
            if key in data:
                value = self.value(data[key], (*path, key), rule.rstrip("!"))
                if value is not None:
                    found[key] = value
            elif rule.endswith("!"):
                self.complain(path, f"key {key!r} is missing{f' in [{dotted(path)}]' if path else ''}")
        return found

    def value(self, value: Any, where: Where, rule: str) -> Any:
        """Return one value after checking it against its rule, or None after a complaint."""
        if rule in _SIMPLE:
            kind, words = _SIMPLE[rule]
            if isinstance(value, kind):
                return value
            return self.complain(where, f"{dotted(where)} must be {words}, found {shown(value)}")
        if rule == "texts":
            return self._names(value, where)
        array = self._numbers(value, where, next(_READERS[unit] for unit in _READERS if rule.startswith(unit)))
        if array is None:
            return None
        if not _shape_fits(array.shape, rule):
            wanted = _SHAPES.get(rule, "shape " + rule.partition("(")[2].rstrip(")").join("()"))
            return self.complain(where, f"{dotted(where)} has shape {array.shape}; expected {wanted}")
        return array

    def _names(self, value: Any, where: Where) -> Any:
        """Return one or more names, none of them twice, or None after complaints."""
        names = [value] if isinstance(value, str) else value
        if not isinstance(names, list) or not names:
            return self.complain(where, f"{dotted(where)} must be a list of names, found {shown(value)}")
        before = len(self.problems)
        for i, name in enumerate(names):
            if not isinstance(name, str) or not name:
                self.complain((*where, i), f"{dotted(where)} must be a list of names, found {shown(name)} in it")
            elif name in names[:i]:
                self.complain((*where, i), f"{dotted(where)} holds {name!r} twice")
        return tuple(names) if len(self.problems) == before else None

    def _numbers(self, value: Any, where: Where, reader: Reader) -> Any:
        """Return nested lists of numbers as an array in SI units, or None after complaints."""

        def walk(item: Any, place: Where) -> Any:
            if not isinstance(item, list):
                return self._number(item, place, reader)
            if len(place) - len(where) == 2:
                return self.complain(place, f"{dotted(where)} is nested too deep")
            return [walk(entry, (*place, i)) for i, entry in enumerate(item)]

        before = len(self.problems)
        nested = walk(value, where)
        if len(self.problems) > before:
            return None
        try:
            return np.asarray(nested, dtype=np.float64)
        except ValueError:
            shapes = [np.shape(row) for row in nested]
            usual = Counter(shapes).most_common(1)[0][0]
            odd = next(i for i, shape in enumerate(shapes) if shape != usual)
            return self.complain((*where, odd), f"{dotted(where)} has rows of different length")

    def _number(self, item: Any, where: Where, reader: Reader) -> Any:
        """Return one number in SI units, or None after a complaint."""
        if isinstance(item, bool) or not isinstance(item, int | Decimal | _Unreadable):
            return self.complain(where, f"{dotted(where)} must be a number, found {shown(item)}")
        exact = Decimal("nan") if isinstance(item, _Unreadable) else Decimal(item)
        number = reader(exact) if exact.is_finite() else np.nan
        if not np.isfinite(number):
            return self.complain(where, f"{dotted(where)} must be a finite number, found {shown(item)}")
        if number == 0.0 and not exact.is_zero():
            return self.complain(where, f"{dotted(where)} is too small: {shown(item)} would be read as 0")
        return number

    def check(self, where: Where, good: npt.ArrayLike, wanted: str) -> bool:
        """Whether all entries of a value are good; complain at each one that is not."""
        bad = np.argwhere(~np.asarray(good, dtype=bool))
        for index in bad:
            place = (*where, *(int(k) for k in index))
            self.complain(place, f"{dotted(place)} must be {wanted}, found {shown(self._found(place))}")
        return not len(bad)

    def _found(self, where: Where) -> Any:
        """Return what the file holds at a place."""
        value: Any = self.data
        for step in where:
            value = value[step]
        return value

    def build(self, where: Where, make: Callable[[], Made]) -> Made | None:
        """Return what `make` makes, or None after a complaint at `where`."""
        try:
            return make()
        except (ArgumentError, UnknownNameError) as error:
            self.complain(where, str(error))
            return None

    def finish(self) -> None:
        """Raise all complaints together, in the order of the file."""
        if self.problems:
            raise FileFormatError(str(self.path), tuple(sorted(self.problems, key=lambda p: (p.line, p.column))))


def meant(word: Any, known: Iterable[str], count: int = 1, cutoff: float = 0.6) -> str:
    """Return the question which known words may be meant; empty where none is near.

    Examples
    --------
    >>> meant("titel", ["title", "kind"])
    "did you mean 'title'?"
    """
    close = nearest(str(word), known, count, cutoff)
    return f"did you mean {' or '.join(map(repr, close))}?" if close else ""


def nearest(word: str, known: Iterable[str], count: int = 1, cutoff: float = 0.6) -> list[str]:
    """Return the known words nearest to one; those that differ only in how a number is written stand alone.

    Examples
    --------
    >>> nearest("T7", ["T07", "T17"])
    ['T07']
    """
    names = list(known)
    # a letter more or less tells T7 and T17 apart no better than T7 and T07: only the numbers do
    same = [name for name in names if _plain_numbers(name) == _plain_numbers(word)]
    return same[:count] or get_close_matches(word, names, count, cutoff)


def _plain_numbers(name: str) -> str:
    """Return a name in small letters, its numbers without leading zeros and without what joins them to letters."""
    return re.sub(r"[-_ ]*0*(\d+)", r"\1", name.strip().lower())


def _text(path: Path) -> str:
    """Return a file's text, with or without a byte order mark."""
    try:
        return path.read_bytes().decode("utf-8-sig")
    except OSError as error:
        raise FileFormatError(str(path), (Problem(1, 1, f"cannot be read: {error.strerror}"),)) from None
    except UnicodeDecodeError as error:
        before = error.object[: error.start].decode("utf-8")
        problem = Problem(*line_and_column(before, len(before)), f"not a text file in UTF-8: {error.reason}")
        raise FileFormatError(str(path), (problem,)) from None


def _shape_fits(shape: tuple[int, ...], rule: str) -> bool:
    """Whether an array's shape is what a rule asks for."""
    if rule in ("mm6", "deg6", "um6"):
        return shape in ((), (6,))
    if rule in ("mm", "number"):
        return shape == ()
    if rule == "number+":
        return len(shape) <= 1 and shape != (0,)
    if rule == "mm2|mm(6,2)":
        return shape in ((2,), (6, 2))
    if rule == "matrix":
        return len(shape) == 2 and shape[0] == shape[1]
    return shape == tuple(int(n) for n in rule.partition("(")[2].rstrip(")").split(","))


def dotted(where: Where) -> str:
    """Return a place as it is written in messages: ``thermal.legs[0].A_per_K``."""
    return "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in where).lstrip(".")


def shown(value: Any, depth: int = 2) -> str:
    """Return a value as a short text for a message."""
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list):
        inner = [shown(item, depth - 1) for item in value[:8]] if depth else ["..."] * bool(value)
        text = f"[{', '.join(inner)}]"
    elif isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, _Unreadable):
        text = value.text
    else:
        # A decimal shows integers of any length; Python's int refuses some thousand digits.
        text = str(Decimal(value)) if isinstance(value, int | Decimal) else repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
