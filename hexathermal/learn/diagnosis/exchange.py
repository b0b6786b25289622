"""The first of two names, asked again beside the second: what the second left unexplained may have chosen it.

Forward steps keep what they took; one exchange mends that (sequential forward floating search: Pudil, Novovicova and
Kittler, Pattern Recognition Letters 15 (1994) 1119).
"""

from __future__ import annotations

from dataclasses import replace

from hexathermal.learn.diagnosis.causes import confused
from hexathermal.learn.diagnosis.deciding import Decision, decided
from hexathermal.learn.diagnosis.evidence import Scored
from hexathermal.learn.diagnosis.foresight import worth
from hexathermal.learn.diagnosis.ranking import Ranked
from hexathermal.learn.diagnosis.stage import Stage

RIVAL = 0.5
"""A name with this part of the first one's evidence may stand in its place, and any that is confused with it."""

AHEAD = 1.0
"""Log evidence by which it must lead beside the second name."""


def rival_beside(stage: Stage, first: Ranked, second: Scored, threshold: float) -> Decision | None:
    """Return the verdict for another first name that leads beside a second one; None where none does.

    Parameters
    ----------
    stage : Stage
        Before the first of the two.
    first : Ranked
        The name given there.
    second : Scored
        What was named over it.
    threshold : float
        Log evidence that a name needs.
    """
    rivals = {item.cause for item in stage.step.ranking if item.named and item.gated >= threshold
              and (item.value >= RIVAL * first.value or confused(item.cause, first.cause))}  # fmt: skip
    rivals -= {first.cause, second.trial.cause}
    if not rivals or first.cause == second.trial.cause:
        return None
    beside = stage.with_effect(second)
    step = beside.search.step([trial for trial in beside.search.trials if trial.cause in {first.cause, *rivals}])
    step = replace(step, ranking=tuple(beside.asked_of_runs(item) for item in step.ranking))
    own = max((item.value for item in step.ranking if item.cause == first.cause), default=0.0)
    decision = decided(step, threshold)
    leader = decision.leader
    if leader is None or leader.cause == first.cause or leader.value < own + AHEAD:
        return None
    _pays, joins = worth(beside, beside.with_effect(leader.best), leader, later=False)
    return decision if joins else None
