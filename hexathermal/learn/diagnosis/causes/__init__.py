"""The catalogue: one file a cause, found by itself. A file has `CAUSE` and `trials`, see `CauseModule`."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Protocol

from hexathermal.learn.cause_files import causes_in
from hexathermal.learn.diagnosis.trials import Cause, Trial, Workbench


class CauseModule(Protocol):
    """A file of this folder: what the cause is, and its trials."""

    CAUSE: Cause

    def trials(self, bench: Workbench) -> Iterator[Trial]:
        """Give the cause's trials for a campaign; none where the data have not what it needs."""
        ...


@cache
def catalogue() -> dict[str, CauseModule]:
    """Return the causes by their names, sorted."""
    return causes_in(__name__, __path__)


def confused(one: str, other: str) -> bool:
    """Return whether the catalogue says that one cause is confused with another, or that with it."""
    known = catalogue()
    return other in known[one].CAUSE.confused_with or one in known[other].CAUSE.confused_with
