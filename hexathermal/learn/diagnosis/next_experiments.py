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
    for pair in confusions:
        for cause in pair.causes:
            separation = course.threshold + max(pair.separation, 0.0)
            found.setdefault(known[cause], Experiment(known[cause], pair.causes, separation))
    for one in names:
        found.setdefault(known[one.cause], Experiment(known[one.cause], (one.cause,), course.threshold))
    return tuple(found.values())[:MOST]


def _where(words: str, leader: Candidate) -> str:
    """Return an experiment with the thermometers that it is about."""
    if leader.target is None:
        return words
    pair = f"{leader.target} or {leader.settings['other']}" if "other" in leader.settings else leader.target
    return words.replace("that thermometer", leader.target).replace("one of the two", pair)
