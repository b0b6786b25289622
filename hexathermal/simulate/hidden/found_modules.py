"""Modules of a folder that are found by themselves: benches, halls, effects."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from types import ModuleType
from typing import TypeVar

from hexathermal.errors import UnknownNameError

Found = TypeVar("Found")


def modules_of(package: str, file: str) -> list[ModuleType]:
    """Return the modules of a package in the order of their names; its ``__name__`` and ``__file__`` are given."""
    names = sorted(item.name for item in iter_modules([str(Path(file).parent)]))
    return [import_module(f"{package}.{name}") for name in names]


def chosen(name: str, among: Mapping[str, Found], what: str) -> Found:
    """Return what has a name.

    Raises
    ------
    UnknownNameError
        Nothing has it.
    """
    if name not in among:
        raise UnknownNameError(f"no {what} is called {name!r}; there are {', '.join(among)}", tuple(among))
    return among[name]
