"""The catalogue of a machine: one file a cause, found by itself. A file has `CAUSE` and `candidates`."""

from __future__ import annotations

import pkgutil
from functools import cache
from importlib import import_module
from typing import cast

from hexathermal.learn.machine_diagnosis.candidate import Candidate, MachineCauseModule
from hexathermal.learn.machine_diagnosis.view import MachineView


@cache
def catalogue() -> dict[str, MachineCauseModule]:
    """Return the causes by their names, sorted."""
    found = {}
    for item in pkgutil.iter_modules(__path__):
        module = cast(MachineCauseModule, import_module(f"{__name__}.{item.name}"))
        found[module.CAUSE.name] = module
    return dict(sorted(found.items()))


def all_candidates(view: MachineView) -> list[Candidate]:
    """Return every cause of the catalogue at every place where rows could show it."""
    return [one for module in catalogue().values() for one in module.candidates(view)]
