"""What joins a law beside a cause that was named: more of its own shapes, and what errors of its shape may leave."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hexathermal.learn.diagnosis.deciding import Decision
from hexathermal.learn.diagnosis.evidence import Scored, screened, stacked_columns
from hexathermal.learn.diagnosis.foresight import LEAST_SHARE, part_saved
from hexathermal.learn.diagnosis.growing import grown
from hexathermal.learn.diagnosis.ranking import Ranked
from hexathermal.learn.diagnosis.spans import beside
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.trials import Trial
from hexathermal.poses import FloatArray

MOST_REFINED = 2
"""Shapes of one cause that may join beside its first."""

MOST_KIN, SEEN_KIN, KIN_SIZE = 3, 0.05, 0.2
"""Directions in which the shapes of a named cause differ, the smallest of them over the largest, and the error of its
shape over what is visible of it."""

ROUNDING = 1e-9
"""What is less than this part of a column, RMS, is an error of rounding."""


@dataclass(frozen=True, eq=False)
class Found:
    """A cause that was named at a stage.

    Attributes
    ----------
    ranked : Ranked
    decision : Decision
    joined : bool
        Whether it predicts runs left out better, so that it joins the law.
    amplitudes, spread : array, shape (k,)
        Of the trial's columns when it was named, and their standard uncertainties.
    """

    ranked: Ranked
    decision: Decision
    joined: bool
    amplitudes: FloatArray
    spread: FloatArray


def next_stage(
    before: Stage, after: Stage, found: Sequence[Found], threshold: float
) -> tuple[Stage, list[Found]]:  # fmt: skip
    """Return the stage after one with the last cause joined: more of its own shapes beside, errors of them tolerated.

    And what was found, as it stands in that stage. Where the last one mends data, what is tolerated of the shapes of
    causes named before is made anew. What joins no law leaves its shape in the null.
    """
    leader = found[-1].ranked
    if not found[-1].joined:
        return before.beside(leader.best), list(found)
    refined = _refined(before, after, leader, threshold)
    stage = grown(refined, leader.levels)
    now = {id(one): other for one, other in zip(refined.joined, stage.joined, strict=True)}
    stands = [replace(one, ranked=replace(one.ranked, best=now.get(id(one.ranked.best), one.ranked.best)))
              for one in found]  # fmt: skip
    stage = _with_kin(stage, before, leader)
    if leader.best.trial.repair is not None:
        for one in stands[:-1]:
            stage = _with_kin(stage, stage, one.ranked)
    return stage, stands


def _kin(stage: Stage, leader: Ranked) -> list[Trial]:
    """Return the trials of a stage that tell of the same cause on the same target by columns, or are compared so."""
    own = leader.best.trial
    return [trial for trial in stage.search.trials
            if own.shape and (trial.shape or (trial.term is not None and trial.carried)) and not trial.starts
            and trial.origin == own.origin]  # fmt: skip


def _refined(before: Stage, after: Stage, leader: Ranked, threshold: float) -> Stage:
    """Return a stage with the leader's cause joined and more of its own shapes beside, as far as they pay.

    Nature's creep is no single exponential, nor is a lag of one time: a second of the same cause is no other cause.
    """
    kin = [trial for trial in _kin(before, leader) if trial.shape and trial.shape != "direction"]  # a nut has one play
    for _more in range(MOST_REFINED):
        # a shape with temperatures as recorded is the same term of a law as with smoothed ones
        joined = [(item.trial.shape, item.trial.parameters) for item in after.joined]
        kin = [trial for trial in kin if (trial.shape, trial.parameters) not in joined]
        scored = screened(after.channel, after.base, leader.levels, kin, before.search.largest) if kin else []
        best = max(scored, key=lambda item: item.value, default=None)
        if best is None or best.gated < threshold:
            break
        finer = after.with_effect(best)
        if part_saved(after, finer, leader) < LEAST_SHARE:
            break
        after = finer
    return after


def _with_kin(after: Stage, before: Stage, leader: Ranked) -> Stage:
    """Return a stage whose null has what other shapes of the same cause look like, as large as an error of its shape.

    A sketch of a cause leaves a part of it, which another cause would mop up.
    """
    kin = _kin(before, leader)
    if not kin:
        return after
    base = after.base
    columns = stacked_columns(len(after.channel), kin)
    left = beside(columns, base.hiding)
    scale = np.sqrt((left**2).mean(axis=0))
    # of the shape that joined only rounding is left
    seen = scale > ROUNDING * np.sqrt((columns**2).mean(axis=0))
    U, size, _V = np.linalg.svd(left[:, seen] / scale[seen], full_matrices=False)
    keep = np.flatnonzero(size > SEEN_KIN * size[:1])[:MOST_KIN]
    columns = U[:, keep] * np.sqrt(len(U))
    sizes = np.full(len(keep), KIN_SIZE * leader.best.visible)
    shape = Scored(Trial(leader.cause, columns), 0.0, 0.0, 1.0, 0.0, 0.0, sizes)
    return after.tolerating(shape)
