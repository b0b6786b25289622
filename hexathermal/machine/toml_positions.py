"""Where keys stand in a TOML file, so that every complaint names line and column."""

from __future__ import annotations

import re

_HEADER = re.compile(r"^\s*\[\[?\s*([\w.\"' -]+?)\s*\]\]?")
_KEY = re.compile(r"^(\s*)([\w\"'.-]+)\s*=")


class Positions:
    """Line and column of tables and keys of a TOML text.

    Tables of an array (``[[thermal.legs]]``) are told apart by a number: ``thermal.legs.0``.
    """

    def __init__(self, text: str) -> None:
        self._places: dict[str, tuple[int, int]] = {}
        counts: dict[str, int] = {}
        table = ""
        for number, line in enumerate(text.splitlines(), start=1):
            header, key = _HEADER.match(line), _KEY.match(line)
            if header and "=" not in line.split("#")[0]:
                table = header.group(1).strip()
                if line.lstrip().startswith("[["):
                    counts[table] = counts.get(table, -1) + 1
                    table = f"{table}.{counts[table]}"
                self._places.setdefault(table, (number, line.index("[") + 1))
            elif key:
                name = key.group(2).strip("\"'")
                self._places.setdefault(f"{table}.{name}".lstrip("."), (number, len(key.group(1)) + 1))

    def of(self, path: str) -> tuple[int, int]:
        """Return line and column of a dotted path, of its nearest parent, or of the file's start."""
        while path:
            if path in self._places:
                return self._places[path]
            path = path.rpartition(".")[0]
        return (1, 1)
