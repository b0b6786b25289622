"""What leads a ranking but may be an error of the thermometers stands in the null, and says nothing."""

from __future__ import annotations

from hexathermal.learn.diagnosis.deciding import hardly_behind
from hexathermal.learn.diagnosis.foresight import FAINT
from hexathermal.learn.diagnosis.little_errors import usual_lateness
from hexathermal.learn.diagnosis.rivals import LATE, OFF
from hexathermal.learn.diagnosis.stage import Stage

MOST_TOLERATED = 2


def tolerant(stage: Stage, threshold: float) -> Stage:
    """Return a stage whose null tolerates what leads but may be feigned by thermometers, where less leads behind it.

    What leads only by its own starts of each run, which a slow noise imitates, is not among what leads. Where a name
    stands by `FAINT` or more for which these data speak as they do for what leads, that one may be there as well.
    Seconds by which all temperatures are late stand there too, and what is left of them has no name either.
    """
    late = usual_lateness(stage.step, threshold)
    if late is not None and stage.late is None:
        stage = stage.against(late=late)
        if usual_lateness(stage.step, threshold) is not None:  # what its columns, which are sketches, leave of it
            stage = stage.against(refused=(*stage.refused, LATE, OFF))
    for _turn in range(MOST_TOLERATED):
        ranking = [item for item in stage.step.ranking
                   if not item.best.trial.starts or item.value - item.best.trial.doubt >= threshold]  # fmt: skip
        top = ranking[0]
        feigned = top.gated < threshold <= top.value and top.best.trial.columns.shape[1] > 0
        standing = [item for item in ranking if item.gated >= threshold]
        besides = [item for item in standing if item.named and item.gated >= FAINT]
        if not feigned or not standing or any(hardly_behind(item, top) for item in besides):
            break
        stage = stage.tolerating(top.best, feigned=True)
    return stage
