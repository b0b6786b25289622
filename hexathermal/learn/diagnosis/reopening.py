"""The first cause's form, asked again beside a second cause: alone it took what it could of both.

Stored heat of two hours has most of a drift with time; of half an hour it leaves all of that. Forward steps keep the
form that explained most alone, and hide the second cause behind it.
"""

from __future__ import annotations

from hexathermal.learn.diagnosis.evidence import Scored, screened
from hexathermal.learn.diagnosis.ranking import Ranked, Step
from hexathermal.learn.diagnosis.stage import Stage

TIME = "time_constant_s"
"""Forms that differ by this take more or less of what is slow."""

REOPENED = 6.0
"""Log evidence that two causes must have more with another form of the first one."""

FEWEST_FORMS = 3
"""Forms of the first cause from which on one may hide another cause."""


def form_beside(stage: Stage, first: Ranked, later: Step) -> Scored | None:
    """Return the first cause in the form that it has beside a second one; None where that is the form it has.

    Parameters
    ----------
    stage : Stage
        Before the first cause joined.
    first : Ranked
    later : Step
        The ranking beside it.
    """
    own, search = first.best.trial, stage.search
    forms = [trial for trial in search.trials
             if trial.origin == own.origin and trial.shape == own.shape
             and trial.parameters.get("ratio") == own.parameters.get("ratio")]  # fmt: skip
    if not own.shape or own.anew or TIME not in own.parameters or len(forms) < FEWEST_FORMS:
        return None
    with_first, best, most = search.system(first.best), None, REOPENED
    for second in later.ranking:
        trial = second.best.trial
        if not second.named or trial.anew or trial.repair is not None or not trial.columns.shape[1]:
            continue
        beside = search.system(second.best)
        form = max(screened(stage.channel, beside, second.levels, forms, stage.largest), key=lambda item: item.value)
        if form.trial.parameters == own.parameters:
            continue
        both = beside.extended(form.trial.columns, form.size)
        kept = with_first.extended(trial.columns, second.best.size)
        told, before = (stage.channel.fitted(base.X, base.sd, second.levels, 40)[1] for base in (both, kept))
        if told - before > most:
            best, most = form, told - before
    return best
