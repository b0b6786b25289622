"""Which steps of the zero are none: something stands off for a while, or was jolted and comes back."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from hexathermal.learn.diagnosis.channels import Channel, Levels
from hexathermal.learn.diagnosis.evidence import Base, Scored, screened
from hexathermal.learn.diagnosis.rivals import STEP
from hexathermal.learn.diagnosis.stand_offs import FADES_S, fadings, stand_offs
from hexathermal.learn.diagnosis.trials import PREFIX, Trial
from hexathermal.poses import FloatArray

STEP_ALONE = 3.0
"""What a drift says for a step of the zero counts up to so much where what may stand off says as much."""

TRIFLE = 0.3
"""Log evidence by which new noise must help the null for everything to be screened again, or a step lead."""

Said = Callable[[Sequence[Trial]], list[Scored]]
"""Gives trials with their evidence."""

JOLT = PREFIX + "time (a jolt that fades)"
"""What is nameless and looks like a step that does not stay."""

FADED = 3.0
"""Log evidence by which what fades must lead a step, and what stands off: at the end of a run they are alike."""


def borne_out(channel: Channel, base: Base, levels: Levels, scored: list[Scored], largest: float) -> list[Scored]:
    """Return trials of which a step counts for little where what stands off for a while explains it, or what fades.

    A step is left once, what stands off is left and met again. What was jolted and comes back joins the trials, without
    a name, where it explains more than the step: it stands for as many that were not asked as there are steps that say
    little.

    Parameters
    ----------
    channel, base, levels, largest
        As `hexathermal.learn.diagnosis.evidence.screened`.
    scored : list of Scored
        All trials.
    """
    steps = [item for item in scored if item.trial.cause == STEP]
    leading = [item for item in steps if item.value > STEP_ALONE]
    if not leading:
        return scored

    def said(trials: Sequence[Trial]) -> list[Scored]:
        """Return trials with their evidence."""
        return screened(channel, base, levels, trials, largest)

    rivals = _standing_off(channel, leading, said)
    jolts, small = list[Scored](), dict[int, Scored]()
    for item, rival, faded in zip(leading, rivals, _faded(channel, leading, said), strict=True):
        if faded.value > max(item.value, rival) + FADED:
            jolts.append(faded)
        elif rival < item.value - TRIFLE:
            continue
        small[id(item)] = replace(item, value=STEP_ALONE, trial=replace(item.trial, most=STEP_ALONE))
    price = math.log(len(FADES_S) * len(steps) / max(len(jolts), 1))
    priced = [replace(item, value=item.value - price, trial=replace(item.trial, advantage=-price)) for item in jolts]
    return [small.get(id(item), item) for item in scored] + priced


def _standing_off(channel: Channel, steps: Sequence[Scored], said: Said) -> FloatArray:
    """Return the evidence of the best that may stand off in place of each step."""
    bumps = [stand_offs(item.trial.columns, channel) for item in steps]
    kinds = (
        [Trial(PREFIX + STEP, bump) for own, _two in bumps for bump in own],
        [Trial(PREFIX + STEP, two) for _own, pairs in bumps for two in pairs],
    )
    values = [np.reshape([item.value for item in said(kind)], (len(steps), -1)) for kind in kinds]
    return np.asarray(np.column_stack(values).max(axis=1))


def _faded(channel: Channel, steps: Sequence[Scored], said: Said) -> list[Scored]:
    """Return the best that fades in place of each step."""
    trials = [
        Trial(JOLT, column, "t", "", {**item.trial.parameters, "time_constant_s": tau})
        for item in steps
        for tau, column in zip(FADES_S, fadings(item.trial.columns, channel), strict=True)
    ]
    found, count = said(trials), len(FADES_S)
    return [max(found[i : i + count], key=lambda item: item.value) for i in range(0, len(found), count)]
