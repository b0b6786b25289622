"""Names that no data of a campaign's kind could tell apart, whatever their evidence."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from hexathermal.learn.diagnosis.own_rates import OWN_RATES
from hexathermal.learn.diagnosis.trials import PREFIX, Trial
from hexathermal.learn.diagnosis.view import View

if TYPE_CHECKING:
    from hexathermal.learn.diagnosis.result import Candidate

ANOTHER, TILT, DRIFT, CREEP = "missing-sensor", "abbe-tilt", "zero-drift", "creep"

NEARLY = 0.9
"""Part of the evidence of what has no name from which on a name is not ruled out."""


def alike_by_nature(view: View, trial: Trial) -> tuple[str, ...]:
    """Return what a cause cannot be told from in runs like these.

    Where no beams tell a part's tilt, one that bends as two sides differ is a thermometer more; and where nothing
    moves, what gives way since it was clamped is an instrument that warms up in each run.

    Parameters
    ----------
    view : View
    trial : Trial
        Of the cause that is named.
    """
    if view.kind == "leg":
        return ()
    if trial.cause == ANOTHER:
        return (TILT,)
    if trial.cause == DRIFT and trial.shape == "relaxation" and not view.moves:
        return (CREEP,)
    return ()


def explaining_as_much(follows: str, candidates: Sequence[Candidate]) -> list[Candidate]:
    """Return names that explain about as much as something without one does, the one that explains most first."""
    left = max((one.evidence for one in candidates if one.cause == follows), default=math.inf)
    names = [one for one in candidates if not one.cause.startswith(PREFIX) and one.evidence >= NEARLY * left]
    return sorted(names, key=lambda one: -one.evidence)


def not_ruled_out(follows: str, candidates: Sequence[Candidate], known: Sequence[str] = ()) -> tuple[str, ...]:
    """Return names that something without one might have, likeliest first.

    They explain nearly as much, or it is in their nature: a floor that tilts with the day, and a zero that drifts at a
    rate of its own in each run, are the same.

    Parameters
    ----------
    follows : str
        What it follows, as the candidate is called; nothing is said of another one.
    candidates : sequence of Candidate
        Of the same ranking.
    known : sequence of str
        Names that were given: what is left is something else.

    >>> not_ruled_out("follows time (a rate of each run's own)", ())
    ('zero-drift',)
    >>> not_ruled_out("follows time (a rate of each run's own)", (), ["zero-drift"])
    ()
    """
    found = [one.cause for one in explaining_as_much(follows, candidates)]
    found += [DRIFT] if follows == PREFIX + OWN_RATES else []
    return tuple(dict.fromkeys(name for name in found if name not in known))
