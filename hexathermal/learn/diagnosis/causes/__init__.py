"""The catalogue: one file a cause, found by itself. A file has `CAUSE` and `trials`, see `CauseModule`."""

from __future__ import annotations

import pkgutil
from functools import cache
from importlib import import_module
from typing import cast

from hexathermal.learn.diagnosis.trials import CauseModule


@cache
def catalogue() -> dict[str, CauseModule]:
    """Return the causes by their names, sorted."""
    found = {}
    for item in pkgutil.iter_modules(__path__):
        module = cast(CauseModule, import_module(f"{__name__}.{item.name}"))
        found[module.CAUSE.name] = module
    return dict(sorted(found.items()))
