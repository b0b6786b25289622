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
    names = ("compiled.py", "formulas.py", "elimination.py", "layout.py")
    return hashlib.sha256(b"".join((folder / name).read_bytes() for name in names)).hexdigest()


_DIGEST = sources_digest()


def loop(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a loop over poses on its first call, or take the build that is kept on disk."""
    dispatcher: Any = nb.njit(cache=True, **OPTIONS)(function)
    index = dispatcher._cache._cache_file
    index._source_stamp = (index._source_stamp, _DIGEST)
    return dispatcher  # type: ignore[no-any-return]
