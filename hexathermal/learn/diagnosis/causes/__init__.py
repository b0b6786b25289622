"""The catalogue: one file a cause, found by itself. A file has `CAUSE` and `trials`, see `CauseModule`."""

from __future__ import annotations

from functools import cache

from hexathermal.learn.cause_files import causes_in
from hexathermal.learn.diagnosis.trials import CauseModule


@cache
def catalogue() -> dict[str, CauseModule]:
    """Return the causes by their names, sorted."""
    return causes_in(__name__, __path__)


def confused(one: str, other: str) -> bool:
    """Return whether the catalogue says that one cause is confused with another, or that with it."""
    known = catalogue()
    return other in known[one].CAUSE.confused_with or one in known[other].CAUSE.confused_with
