"""The catalogue of a machine: one file a cause, found by itself. A file has `CAUSE` and `candidates`."""

from __future__ import annotations

from functools import cache

from hexathermal.learn.cause_files import causes_in
from hexathermal.learn.machine_diagnosis.candidate import Candidate, MachineCauseModule
from hexathermal.learn.machine_diagnosis.view import MachineView


@cache
def catalogue() -> dict[str, MachineCauseModule]:
    """Return the causes by their names, sorted."""
    return causes_in(__name__, __path__)


def all_candidates(view: MachineView) -> list[Candidate]:
    """Return every cause of the catalogue at every place where rows could show it."""
    return [one for module in catalogue().values() for one in module.candidates(view)]
