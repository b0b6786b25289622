"""What joined, asked again at the end: beside all that joined after it, a cause must still pay on runs left out.

Step by step a cause may join in whose place a later one stands in truth (backward steps of a floating search: Pudil,
Novovicova and Kittler, Pattern Recognition Letters 15 (1994) 1119).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from hexathermal.learn.diagnosis.evidence import Scored
from hexathermal.learn.diagnosis.stage import Stage

LEAST_HARM = 0.25
"""Part by which the squares of runs left out must fall without a cause, for it to leave the law: few runs tell
little."""


def pruned(stage: Stage, asked: Sequence[Scored]) -> tuple[Stage, tuple[Scored, ...]]:
    """Return a stage without what does harm to runs left out, and what that was, the worst first.

    Parameters
    ----------
    stage : Stage
        With all that joined.
    asked : sequence of Scored
        Which of them may leave; the last one never does.
    """
    gone: list[Scored] = []
    while len(stage.joined) > 1:
        rest = [item for item in asked if all(item is not one for one in gone)]
        ways = [(_without(stage, item), item) for item in rest]
        best = min(ways, key=lambda way: way[0].kinder_left, default=None)
        if best is None or best[0].kinder_left > (1.0 - LEAST_HARM) * stage.kinder_left:
            break
        stage = best[0]
        gone.append(best[1])
    return stage, tuple(gone)


def _without(stage: Stage, gone: Scored) -> Stage:
    """Return the stage without one that joined."""
    return replace(stage, joined=tuple(item for item in stage.joined if item is not gone))
