"""From log odds to words: probabilities, names that data cannot tell from a cause, the verdict."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hexathermal.learn.machine_diagnosis.case import Case
from hexathermal.learn.machine_diagnosis.course import Course
from hexathermal.learn.machine_diagnosis.observability import MachineObservability
from hexathermal.learn.machine_diagnosis.search import Adoption, Step

NONE = "none"
NEAR = 3.0
"""Log odds within which another name is as good."""

NEAR_IF_ALIKE = 6.0
"""The same where poses and temperatures say beforehand that the two look alike."""


def probabilities(case: Case, found: Step) -> dict[str, float]:
    """Return the probability of each cause, and of none, after a step."""
    odds = np.array([0.0, *(one.odds for one in found.ranking)])
    weight = np.exp(odds - odds.max())
    weight /= weight.sum()
    made = {NONE: float(weight[0])}
    for one, value in zip(found.ranking, weight[1:], strict=True):
        cause = case.candidates[one.which].cause
        made[cause] = min(made.get(cause, 0.0) + float(value), 1.0)  # a sum may round to more
    return made


@dataclass(frozen=True)
class Equivalents:
    """Names that are as good as one: of causes, and with places."""

    causes: tuple[str, ...]
    places: tuple[str, ...]


def equivalents(case: Case, one: Adoption, seen: MachineObservability | None) -> Equivalents:
    """Return what these rows cannot tell from a cause that was adopted.

    Parameters
    ----------
    case : Case
        Of the step in which it was found.
    one : Adoption
    seen : MachineObservability or None
        What poses and temperatures cannot tell apart.
    """
    own = one.candidate
    alike = {name for group in (seen.classes if seen is not None else ()) if own.called in group.names
             for name in group.names}  # fmt: skip
    causes, places = list[str](), list[str]()
    for item in one.step.ranking:
        other = case.candidates[item.which]
        if other.called == own.called or not case.named(item.which):
            continue
        if one.ranked.odds - item.odds < (NEAR_IF_ALIKE if other.called in alike else NEAR):
            places.append(other.called)
            if other.cause != own.cause:
                causes.append(other.cause)
    return Equivalents(tuple(dict.fromkeys(causes)), tuple(dict.fromkeys(places)))


def verdict(course: Course) -> tuple[str, float, str | None]:
    """Return the verdict, its probability, and what something unexplained follows."""
    left = course.left
    follows = None
    if left is not None:
        other = course.case.candidates[left.which]
        follows = other.cause if not course.case.named(left.which) else f"looks like {other.called}"
    if course.adopted:
        first = course.adopted[0]
        found = probabilities(first.case, first.step)
        return "effect", found.get(first.candidate.cause, 0.0), follows
    found = probabilities(course.case, course.end)
    if follows is not None:
        return "unexplained", 1.0 - found[NONE], follows
    return "none", found[NONE], None
