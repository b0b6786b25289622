"""How the equations are compiled and cached: two decorators, and when a cached build is stale.

The compiler keeps one cache per source file and looks only at that file's age.  A loop contains the formulas of
another file, so its cached build is stamped with those files' contents too: edit a formula, and every loop is built
again.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba as nb

# 'contract' only: the compiler may fuse a*b+c but may not assume that NaN and infinity do not exist.
OPTIONS: dict[str, Any] = {"fastmath": {"contract"}, "error_model": "numpy", "nogil": True}

formula: Callable[[Callable[..., Any]], Callable[..., Any]] = nb.njit(forceinline=True, **OPTIONS)
"""Compile an equation: always inlined into the loop that uses it, never cached alone."""


def sources_digest(folder: Path = Path(__file__).parent) -> str:
    """Return one digest of the files whose text ends up inside every compiled loop."""
    names = ("compiled", "correction_loops", "elimination", "formulas", "forward_loops", "layout", "lengths_loops")
    return hashlib.sha256(b"".join((folder / f"{name}.py").read_bytes() for name in names)).hexdigest()


_DIGEST = sources_digest()


def loop(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a loop over poses on its first call, or take the build that is kept on disk."""
    compiled: Callable[..., Any] = _dispatcher(function)
    return compiled


def typed_loop(signature: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Compile a loop for one kind of arguments only; any other kind is a `TypeError` at once, before any work."""

    def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
        dispatcher = _dispatcher(function)
        dispatcher.compile(signature)
        dispatcher.disable_compile()
        typed: Callable[..., Any] = dispatcher
        return typed

    return compiled


def _dispatcher(function: Callable[..., Any]) -> Any:
    """Return numba's dispatcher: its build is kept where that is possible, and stale when a formula changes."""
    try:
        dispatcher: Any = nb.njit(cache=True, **OPTIONS)(function)
    except RuntimeError:  # neither the package's folder nor the user's can be written
        return nb.njit(**OPTIONS)(function)
    index = dispatcher._cache._cache_file
    index._source_stamp = (index._source_stamp, _DIGEST)
    return dispatcher
