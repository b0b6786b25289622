"""The next experiments: which measurement would tell causes apart, and by how much."""

from __future__ import annotations

from collections.abc import Sequence

from hexathermal.learn.diagnosis.causes import catalogue
from hexathermal.learn.diagnosis.course import Course
from hexathermal.learn.diagnosis.result import Candidate, Confusion, Experiment

MOST = 3


def next_experiments(
    course: Course, confusions: Sequence[Confusion], candidates: Sequence[Candidate]
) -> tuple[Experiment, ...]:
    """Return up to three measurements.

    First for what was named and its closest rival, then for pairs that this campaign confuses. The separation promised
    is that of one more campaign of this size in which the rival's part is taken away: the leader's whole evidence.
    """
    known = {name: module.CAUSE.experiment for name, module in catalogue().items()}
    found: dict[str, Experiment] = {}
    names = [one for one in candidates if one.cause in known]
    if course.found:
        leader = names[0]
        rivals = tuple(dict.fromkeys(one.cause for one in names[1:] if one.cause != leader.cause))[:2]
        words = known[leader.cause]
        found[words] = Experiment(_where(words, leader), (leader.cause, *rivals), leader.evidence)
    seen = {one.cause: one for one in reversed(names) if one.evidence > 0.0}
    for pair in confusions:
        for cause in pair.causes:
            separation = course.threshold + max(pair.separation, 0.0)
            words = _where(known[cause], seen.get(cause))
            found.setdefault(known[cause], Experiment(words, pair.causes, separation))
    for one in names:
        words = _where(known[one.cause], seen.get(one.cause))
        found.setdefault(known[one.cause], Experiment(words, (one.cause,), course.threshold))
    return tuple(found.values())[:MOST]


def _where(words: str, one: Candidate | None) -> str:
    """Return an experiment with the thermometers that it is about, where something speaks for some."""
    target, pair = "the thermometer in question", "one of the two thermometers in question"
    if one is not None and one.target is not None:
        target = one.target
        pair = f"{target} or {one.settings['other']}" if "other" in one.settings else target
    return words.replace("that thermometer", target).replace("one of the two", pair)
