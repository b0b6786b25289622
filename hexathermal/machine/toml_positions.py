"""Where keys and array elements stand in a TOML file, so that every complaint names line and column."""

from __future__ import annotations

import re
import tomllib
from bisect import bisect_right
from collections.abc import Iterator
from typing import TypeAlias

Where: TypeAlias = tuple[str | int, ...]
"""Keys and array indices from the top of a file down to a value."""

_TOKEN = re.compile(
    r"(?P<skip>[ \t\r]+|#[^\n]*)|(?P<newline>\n)"
    r'|(?P<string>"""(?:\\[\s\S]|[^\\])*?"{3,5}|\'\'\'[\s\S]*?\'{3,5}|"(?:\\.|[^"\\\n])*"|\'[^\'\n]*\')'
    r"|(?P<mark>[\[\]{}=,.])|(?P<bare>[^\s\[\]{}=,.#\"']+|.)"
)
_LONG_NUMBER = re.compile(r"[+-]?[0-9_]{640,}")
"""Python refuses to read longer integers; 640 digits is the lowest limit that can be set."""

_VALUE_ENDS = ("\n", ",", "]", "}")


def _tokens(text: str) -> Iterator[tuple[str, int]]:
    """Yield the tokens of a TOML text and their offsets, without blanks and comments."""
    for match in _TOKEN.finditer(text):
        if match.lastgroup != "skip":
            yield match.group(), match.start()


def line_and_column(text: str, offset: int) -> tuple[int, int]:
    """Return line and column, counted from 1; only a line feed ends a line, as in TOML."""
    return text.count("\n", 0, offset) + 1, offset - text.rfind("\n", 0, offset)


def excess(text: str) -> tuple[int, int]:
    """Return the place of the first overlong integer, or of the innermost of too many brackets."""
    depth, deepest, found = 0, 0, 0
    for token, offset in _tokens(text):
        if _LONG_NUMBER.fullmatch(token):
            return line_and_column(text, offset)
        depth += (token in ("[", "{")) - (token in ("]", "}"))
        if depth > deepest:
            deepest, found = depth, offset
    return line_and_column(text, found)


class Positions:
    """Line and column of tables, keys and array elements of a TOML text that `tomllib` accepts.

    Tables of an array (``[[thermal.legs]]``) are told apart by their index: ``("thermal", "legs", 0)``.
    """

    def __init__(self, text: str) -> None:
        self._line_starts = [0, *(match.end() for match in re.finditer("\n", text))]
        self._offsets: dict[Where, int] = {}
        self._tokens = [*_tokens(text), ("\n", len(text))]
        self._at = 0
        counts: dict[Where, int] = {}
        table: Where = ()
        while self._at < len(self._tokens):
            token = self._tokens[self._at][0]
            if token == "\n":  # noqa: S105
                self._at += 1
            elif token == "[":  # noqa: S105
                table = self._header(counts)
            else:
                self._pair(table)

    def of(self, where: Where) -> tuple[int, int]:
        """Return line and column of a value, of its nearest parent, or of the file's start."""
        while where and where not in self._offsets:
            where = where[:-1]
        offset = self._offsets.get(where, 0)
        line = bisect_right(self._line_starts, offset)
        return line, offset - self._line_starts[line - 1] + 1

    def _header(self, counts: dict[Where, int]) -> Where:
        """Read ``[a.b]`` or ``[[a.b]]``; return the table that it opens."""
        start = self._tokens[self._at][1]
        brackets = 2 if self._tokens[self._at + 1][0] == "[" else 1
        self._at += brackets
        keys = self._keys()
        self._at += brackets
        table: Where = ()
        for left, (name, _) in zip(range(len(keys), 0, -1), keys, strict=True):
            table = (*table, name)
            self._offsets.setdefault(table, start)
            if left == 1 and brackets == 2:
                counts[table] = counts.get(table, -1) + 1
            if table in counts:
                table = (*table, counts[table])
        if brackets == 1 or isinstance(table[-1], int):
            self._offsets[table] = start
        return table

    def _keys(self) -> list[tuple[str, int]]:
        """Read a key with its dots; return its parts and their offsets."""
        keys = []
        while True:
            token, offset = self._tokens[self._at]
            name = tomllib.loads(f"key = {token}")["key"] if token[0] in "\"'" else token
            keys.append((name, offset))
            self._at += 1
            if self._tokens[self._at][0] != ".":
                return keys
            self._at += 1

    def _pair(self, table: Where) -> None:
        """Read ``key = value``."""
        for name, offset in self._keys():
            table = (*table, name)
            self._offsets.setdefault(table, offset)
        self._at += 1
        self._value(table)

    def _value(self, where: Where) -> None:
        """Read a value up to the token behind it."""
        opening = self._tokens[self._at][0]
        if opening not in ("[", "{"):
            while self._tokens[self._at][0] not in _VALUE_ENDS:
                self._at += 1
            return
        self._at += 1
        index = 0
        while (token := self._tokens[self._at])[0] not in ("]", "}"):
            if token[0] in ("\n", ","):
                self._at += 1
            elif opening == "{":
                self._pair(where)
            else:
                self._offsets[(*where, index)] = token[1]
                self._value((*where, index))
                index += 1
        self._at += 1
