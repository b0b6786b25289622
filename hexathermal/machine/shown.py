"""Values that a notebook shows as tables.

A notebook asks a value for `_repr_html_`. Tables are drawn in an upper storey, which machines, budgets and laws may not
import; the package puts what draws them in place when it is imported, as it does for `hexathermal.machine.ports`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

Painter: TypeAlias = Callable[[Any], str]
"""From a value to its HTML."""

_painters: list[Painter] = []


class Shown:
    """Base of the values that notebooks show as tables; it holds nothing."""

    __slots__ = ()

    def _repr_html_(self) -> str | None:
        """Return the value as HTML, as notebooks ask for it; None, and they show its text, where nothing draws it."""
        return _painters[-1](self) if _painters else None


def show_with(painter: Painter) -> None:
    """Let a function draw values for notebooks.

    Examples
    --------
    >>> class Length(Shown):
    ...     def __repr__(self):
    ...         return "2 m"
    >>> before = list(_painters)
    >>> show_with(lambda value: f"<b>{value!r}</b>")
    >>> Length()._repr_html_()
    '<b>2 m</b>'
    >>> _painters[:] = before
    """
    _painters[:] = [painter]
