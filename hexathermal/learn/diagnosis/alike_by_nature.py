"""Names that no data of a campaign's kind could tell apart, whatever their evidence."""

from __future__ import annotations

from hexathermal.learn.diagnosis.trials import Trial
from hexathermal.learn.diagnosis.view import View

ANOTHER, TILT, DRIFT, CREEP = "missing-sensor", "abbe-tilt", "zero-drift", "creep"


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
