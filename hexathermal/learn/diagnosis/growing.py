"""What joined a law grows along the part as the law does: as it does now, not as it did before other causes joined.

A term on the law's own expansion, as a lag, is ``(q0 + r q)`` times something of the temperatures, with r of the law,
B / A. A scale that is wrong, or the lag itself, bends that ratio until it has joined.
"""

from __future__ import annotations

from dataclasses import replace

from hexathermal.learn.diagnosis.channels import Levels
from hexathermal.learn.diagnosis.evidence import Scored
from hexathermal.learn.diagnosis.mending import columns_anew
from hexathermal.learn.diagnosis.stage import Stage

ROUNDS = 3
"""Each ratio is one of a law whose terms had the ratio before."""

LIKELIER, APART = 1.0, 0.02
"""Log evidence that another ratio must have more, and by how much it must differ to be asked."""


def grown(stage: Stage, levels: Levels) -> Stage:
    """Return a stage whose terms have the ratio of the law that they joined, where that is likelier, in their order.

    Parameters
    ----------
    stage : Stage
    levels : Levels
        Noise at which both are asked.
    """
    said = _said(stage, levels)
    for _round in range(ROUNDS):
        before = stage
        for item in stage.joined:
            other = _as_the_law(stage, item)
            if other is None:
                continue
            joined = tuple(other if one is item else one for one in stage.joined)
            after = replace(stage, joined=joined, most=None)
            if (says := _said(after, levels)) > said + LIKELIER:
                stage, said = after, says
        if stage is before:
            break
    return stage


def _as_the_law(stage: Stage, item: Scored) -> Scored | None:
    """Return what joined with the ratio of the law as it is now; None where it has none, or this one."""
    trial, ratios = item.trial, stage.bench.ratios
    if not trial.shape or "ratio" not in trial.parameters or trial.starts:
        return None
    ratio = ratios.get(str(trial.target), ratios[stage.bench.main])
    if abs(ratio - trial.parameters["ratio"]) < APART:
        return None
    parameters = {**trial.parameters, "ratio": ratio}
    columns = columns_anew(trial, parameters, stage.view, stage.view)
    return replace(item, trial=replace(trial, parameters=parameters, columns=columns))


def _said(stage: Stage, levels: Levels) -> float:
    """Return the log evidence of a stage's null at one noise."""
    return stage.channel.evidences(stage.base.X, stage.base.sd, [levels])[0]
