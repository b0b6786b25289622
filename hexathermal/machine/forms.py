"""Reading TOML files against a table of keys: units, shapes, and every bad field with its place."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np

from hexathermal.errors import ArgumentError, FileFormatError, Problem
from hexathermal.machine.toml_positions import Positions
from hexathermal.machine.units import metres, radians, same

Reader = Callable[[Decimal], float]

_READERS: dict[str, Reader] = {"mm": metres, "deg": radians, "number": same, "matrix": same}
_SIMPLE: dict[str, tuple[type, str]] = {
    "text": (str, "a text"),
    "table": (dict, "a table"),
    "tables": (list, "tables [[...]]"),
}


class Form:
    """A TOML file being read: collects every problem before anything is raised.

    Parameters
    ----------
    path : Path
    tables : mapping of table kind to its keys and their rules
        A rule is a kind (``text``, ``texts``, ``table``, ``tables``, ``mm``, ``deg``, ``number``, ``matrix``), a shape
        in brackets, ``6`` for one or six, ``+`` for one or more, and ``!`` where the key is required.

    Raises
    ------
    FileFormatError
        The file is no text in UTF-8 or no TOML.
    """

    def __init__(self, path: Path, tables: Mapping[str, Mapping[str, str]]) -> None:
        self.path = path
        self.tables = tables
        self.problems: list[Problem] = []
        try:
            text = path.read_bytes().decode("utf-8")
            self.positions = Positions(text)
            self.data: dict[str, Any] = tomllib.loads(text, parse_float=Decimal)
        except UnicodeDecodeError as error:
            raise FileFormatError(str(path), (Problem(1, 1, f"not a text file in UTF-8: {error.reason}"),)) from None
        except tomllib.TOMLDecodeError as error:
            line, column = getattr(error, "lineno", None), getattr(error, "colno", None)
            if line is None:
                digits = [
                    int(word) for word in str(error).replace(",", " ").replace(")", " ").split() if word.isdigit()
                ]
                line, column = digits[-2:] if len(digits) >= 2 else (max(1, text.count("\n")), 1)
            raise FileFormatError(str(path), (Problem(line, column or 1, f"not valid TOML: {error}"),)) from None

    def complain(self, where: str, message: str) -> Any:
        """Note a problem; returns None, so that a caller may return it."""
        line, column = self.positions.of(where)
        self.problems.append(Problem(line, column, message))
        return None

    def table(self, data: dict[str, Any], path: str, kind: str) -> dict[str, Any]:
        """Return the checked values of one table: numbers as arrays in SI units."""
        keys, found = self.tables[kind], {}
        for key in data:
            if key not in keys:
                self.complain(_join(path, key), f"unknown key {key!r}; known: {', '.join(keys)}")
        for key, rule in keys.items():
            if key in data:
                value = self.value(data[key], _join(path, key), rule.rstrip("!"))
                if value is not None:
                    found[key] = value
            elif rule.endswith("!"):
                self.complain(path, f"key {key!r} is missing{f' in [{path}]' if path else ''}")
        return found

    def value(self, value: Any, where: str, rule: str) -> Any:
        """Return one value after checking it against its rule, or None after a complaint."""
        if rule in _SIMPLE:
            kind, words = _SIMPLE[rule]
            if isinstance(value, kind):
                return value
            return self.complain(where, f"{where} must be {words}, found {shown(value)}")
        if rule == "texts":
            texts = [value] if isinstance(value, str) else value
            if isinstance(texts, list) and texts and all(isinstance(text, str) and text for text in texts):
                return tuple(texts)
            return self.complain(where, f"{where} must be a list of names, found {shown(value)}")
        unit = rule.partition("(")[0].rstrip("+6|2") if rule[:2] == "mm" else rule.partition("(")[0].rstrip("+6")
        array = self.numbers(value, where, _READERS["mm" if unit.startswith("mm") else unit])
        if array is None:
            return None
        if not _shape_fits(array.shape, rule):
            wanted = _SHAPES.get(rule, "shape " + rule.partition("(")[2].rstrip(")").join("()"))
            return self.complain(where, f"{where} has shape {array.shape}; expected {wanted}")
        return array

    def numbers(self, value: Any, where: str, reader: Reader) -> Any:
        """Return nested lists of numbers as an array in SI units, or None after a complaint."""

        def walk(item: Any) -> Any:
            if isinstance(item, list):
                return [walk(entry) for entry in item]
            if isinstance(item, bool) or not isinstance(item, int | Decimal):
                raise TypeError(f"{where} must hold numbers, found {shown(item)}")
            number = reader(Decimal(item))
            if not np.isfinite(number):
                raise TypeError(f"{where} must hold finite numbers, found {item}")
            return number

        try:
            return np.asarray(walk(value), dtype=np.float64)
        except TypeError as error:
            return self.complain(where, str(error))
        except ValueError:
            return self.complain(where, f"{where} has rows of different length")

    def build(self, where: str, make: Callable[[], Any]) -> Any:
        """Return what `make` makes, or None after a complaint at `where`."""
        try:
            return make()
        except ArgumentError as error:
            return self.complain(where, str(error))

    def finish(self) -> None:
        """Raise all complaints together, in the order of the file."""
        if self.problems:
            raise FileFormatError(str(self.path), tuple(sorted(self.problems, key=lambda p: (p.line, p.column))))


_SHAPES = {"mm6": "one value, or six", "deg6": "one value, or six", "mm": "one value", "number": "one value",
           "number+": "one value, or a list", "mm2|mm(6,2)": "[low, high], or six such pairs",
           "matrix": "a square matrix"}  # fmt: skip


def _shape_fits(shape: tuple[int, ...], rule: str) -> bool:
    """Whether an array's shape is what a rule asks for."""
    if rule in ("mm6", "deg6"):
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


def _join(path: str, key: str) -> str:
    return f"{path}.{key}" if path else key


def shown(value: Any) -> str:
    """Return a value as a short text for a message."""
    text = repr(value) if not isinstance(value, Decimal) else str(value)
    return text if len(text) <= 60 else text[:57] + "..."
