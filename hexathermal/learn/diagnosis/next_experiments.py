"""The next experiments: which measurement would tell causes apart, and by how much.

An experiment shows a cause's whole effect in N readings, while what looks alike holds still. Of an effect of RMS w
beside a noise of sigma a reading it brings, on average, the log evidence::

    1/2 N (w / sigma)^2

(half the noncentrality of a chi-squared: Basseville and Nikiforov, Detection of Abrupt Changes, 1993, 4.2). Sigma is
that of a landing in this campaign; N stands with each cause. What shows the fault itself decides.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hexathermal.learn.diagnosis.causes import catalogue
from hexathermal.learn.diagnosis.course import Course
from hexathermal.learn.diagnosis.result import Candidate, Confusion, Experiment, Limit

MOST = 3

DECIDED = 150.0
"""Log evidence that is told of an experiment at most, and of one that shows the fault itself."""

SUPPOSED = 2.0
"""Size of an effect that was not found, over its limit of detection: what confusions are told for."""


def next_experiments(
    course: Course, limits: Sequence[Limit], confusions: Sequence[Confusion], candidates: Sequence[Candidate]
) -> tuple[Experiment, ...]:
    """Return up to three measurements.

    First for what was named and its closest rivals, and for later names that others are as likely as, or for what stood
    above chance but foretold runs left out no better; then for pairs that this campaign confuses, then for what it
    sees worst.

    Parameters
    ----------
    course : Course
    limits : sequence of Limit
    confusions : sequence of Confusion
    candidates : sequence of Candidate
        Best first.
    """
    known = {name: module.CAUSE for name, module in catalogue().items()}
    ranked = [one for one in candidates if one.cause in known]
    seen = {one.cause: one for one in reversed(ranked)}
    sizes = {one.cause: one for one in limits}
    found: dict[str, Experiment] = {}

    def add(cause: str, causes: tuple[str, ...], visible: float | None) -> None:
        size = _whole(sizes.get(cause), visible)
        own = known[cause]
        words = _where(own.experiment, seen.get(cause), course.first.view.base[0])
        promise = _promised(own.readings, size, course)
        found.setdefault(own.experiment, Experiment(words, causes, promise, size))

    if course.found:
        leader = ranked[0]
        first = course.found[0]  # what thermometers told of before may lead it
        alike = [name for name in first.decision.equivalent if name in known and leader.cause == first.ranked.cause]
        rivals = tuple(dict.fromkeys([*alike, *(one.cause for one in ranked[1:] if one.cause != leader.cause)]))[:2]
        add(leader.cause, (leader.cause, *rivals), leader.visible)
        for rival in alike[:1]:  # what shows the rival decides as well
            add(rival, (leader.cause, rival), leader.visible)
    for later in course.found[1:]:
        if later.decision.equivalent:  # it is told that an experiment must decide
            causes = (later.ranked.cause, *later.decision.equivalent[:2])
            add(causes[0], causes, later.ranked.best.visible)
    for one in course.refused:
        if one.cause in known:
            add(one.cause, (one.cause,), one.best.visible)
    for pair in confusions:
        for cause in pair.causes:
            add(cause, pair.causes, None)
    for limit in sorted(limits, key=lambda one: -one.whole):
        add(limit.cause, (limit.cause,), None)
    return tuple(found.values())[:MOST]


def _whole(limit: Limit | None, visible: float | None) -> float:
    """Return the whole RMS of an effect [m]: of one that was found, or of one that would be named well."""
    if limit is None:
        return 0.0 if visible is None else visible
    return SUPPOSED * limit.whole if visible is None else visible * limit.whole / limit.visible


def _promised(readings: int, size: float, course: Course) -> float:
    """Return the log evidence that an experiment brings on average."""
    if not readings:
        return DECIDED
    variance = course.last.levels.variance(float(np.median(course.first.channel.rows)))
    return float(min(0.5 * readings * size**2 / max(variance, np.finfo(float).tiny), DECIDED))


def _where(words: str, one: Candidate | None, usual: str) -> str:
    """Return an experiment with the thermometers that it is about: those that the data speak for, or one of the law."""
    target, pair = usual, f"{usual} or another one"
    if one is not None and one.target is not None:
        target = one.target
        pair = f"{target} or {one.settings['other']}" if "other" in one.settings else target
    return words.replace("that thermometer", target).replace("one of the two", pair)
