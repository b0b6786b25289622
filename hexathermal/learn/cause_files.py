"""Catalogues of causes: one file a cause, found by itself."""

from __future__ import annotations

import pkgutil
from collections.abc import Iterable
from importlib import import_module
from typing import Any


def causes_in(package: str, folders: Iterable[str]) -> dict[str, Any]:
    """Return the modules of a package by the names of their causes, sorted.

    Parameters
    ----------
    package : str
        Name of the package; each of its modules has a ``CAUSE``.
    folders : iterable of str
        Where its modules lie (``__path__``).

    Examples
    --------
    >>> from hexathermal.learn.diagnosis import causes
    >>> "backlash" in causes_in(causes.__name__, causes.__path__)
    True
    """
    modules = [import_module(f"{package}.{item.name}") for item in pkgutil.iter_modules(folders)]
    return dict(sorted((module.CAUSE.name, module) for module in modules))
