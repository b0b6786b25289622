"""What runs left out of the fit say of a cause: whether it is real to them, and whether a law with it foretells them.

A cause that stands above chance in all runs together must also pay on each that did not help to size it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from hexathermal.learn.diagnosis.borne_out import JOLT
from hexathermal.learn.diagnosis.causes import catalogue
from hexathermal.learn.diagnosis.grid_spread import grid_spread
from hexathermal.learn.diagnosis.ranking import Ranked
from hexathermal.learn.diagnosis.rivals import STEP
from hexathermal.learn.diagnosis.spans import beside
from hexathermal.poses import FloatArray

if TYPE_CHECKING:
    from hexathermal.learn.diagnosis.stage import Stage

LEAST_SHARE = 0.03
"""Every cause after the first must take away this part of the squared residual of runs left out."""

MOST_LOSS = 0.5
"""A first cause that makes runs left out less likely, or adds more than this part to their squares, is passed over."""

FALLING = 0.2
"""A first cause of `FAINT` or more of evidence pays also where squares of runs left out fall by more than this part."""

FAINT = 9.0
"""What has less evidence, named or not, may not add to the squares of runs left out by more than they scatter:
thermometers that wander, and landings that stand off, which no noise is drawn with, feign a little now and then."""

CLEAR_STEP = 13.0
"""Log evidence that a step of one run needs: it may begin at any landing, of which a few stand off far."""

BLURRED_S = 1800.0
"""A step of the zero whose moment is known no better than this, one standard uncertainty, is none: it wanders."""

FORESEEN, CLEARLY_FORESEEN = 10.0, 20.0
"""Log likelihood of runs left out from which on a first cause, or a later one, joins although their squares do not
fall: squares of few runs, whose rows share most of their scatter, tell less; they may not rise by more than chance, or
those about each run's mean must fall."""

MOST_UNLIKE = 40.0
"""Log likelihood that runs left out may lose by a cause whose state before them nobody knows: a sound leg whose room
wandered showed a frame of evidence 15, by which they lost 81."""

REPEATS, BY_CHANCE = 0.1, 3.0
"""Part of their squares that runs left out must lose for it to count as the same in all of them; and the log evidence
by which a few runs lose alike by chance."""

FEWEST_ALIKE, LEAST_SCATTER = 3, 0.05
"""Runs that are needed for this, and the least scatter of what they lose over its mean: few runs scatter little by
chance."""


def repeated(before: Stage, after: Stage, leader: Ranked) -> float:
    """Return the log evidence that a leader takes from each run left out alike, which wandering thermometers do not.

    Of the mean squares that n runs lose, mean m and standard deviation s, the likelihood ratio of Student's test
    against a mean of zero, ``n/2 log(1 + n m^2 / ((n - 1) s^2))``, less what chance says; 0 where that is more.
    """
    old, new = _left(before, after, leader)
    if len(old) < FEWEST_ALIKE or (old - new).sum() < REPEATS * old.sum():
        return 0.0
    run, rows = before.channel.run, before.channel.rows
    lost = (old - new) / np.array([rows[run == k].sum() for k in np.unique(run)])
    n, m = len(lost), float(lost.mean())
    s = max(float(lost.std(ddof=1)), LEAST_SCATTER * abs(m))
    return max(0.0, 0.5 * n * float(np.log1p(n * m**2 / ((n - 1) * s**2))) - BY_CHANCE)


def worth(stage: Stage, after: Stage, leader: Ranked, *, later: bool) -> tuple[bool, bool]:
    """Return whether runs left out speak for a leader, and whether it is to join the law."""
    share, sure = part_saved(stage, after, leader), foresight(stage, after, leader)
    clear = sure >= (CLEARLY_FORESEEN if later else FORESEEN) and (
        not _rises(stage, after, leader) or _falls_within(stage, after, leader)
    )
    # a law that thermometers' errors move a little in each window may lose more likelihood than a slow cause brings
    stands = not later and leader.gated >= FAINT and share > FALLING
    falls = stands and share > part_spread(stage, after, leader)
    least = LEAST_SHARE if later else -MOST_LOSS
    pays = (sure > 0.0 or falls) and not denied(stage, after, leader) and (clear or share > least)
    # what was before a run left out is not known: it is seen, although a law of its rows alone does without it
    seen = _begins(leader, stage) and leader.gated >= FAINT and sure > -MOST_UNLIKE
    feigned = stage.view.stroked and catalogue()[leader.cause].CAUSE.thermal
    told = later or share > 0.0 or not feigned or saved_besides(stage, after, leader) > 0.0
    return told and (pays or seen), told and pays and (share > 0.0 or clear)


def saved_besides(before: Stage, after: Stage, leader: Ranked) -> float:
    """Return by which part less is left of runs left out, besides their zeros and what each may have begun with.

    A first cause that goes as temperatures do and takes nothing from them stands for the law, which noise of its
    thermometers shrinks in quick changes: beside one with less noise it fits these better and slow ones worse.
    """
    run = before.channel.run
    weight = np.sqrt(before.channel.rows)[:, None]
    begun = weight * np.column_stack([np.ones(len(run)), _begun(leader, before)])
    sums = []
    for stage in (before, after):
        left = weight * _kinder(stage, before, leader)[:, None]
        own = [run == k for k in np.unique(run)]
        apart = [beside(left[k], begun[k][:, np.any(begun[k] != 0.0, axis=0)]) for k in own]
        sums.append(sum(float((one**2).sum()) for one in apart))
    return 1.0 - sums[1] / sums[0]


def denied(stage: Stage, after: Stage, leader: Ranked) -> bool:
    """Return whether a leader is faint, and runs left out speak against it, or none can tell of it."""
    if tells_of_one_run(leader):
        faint = leader.value < CLEAR_STEP
        return faint or (leader.cause == STEP and grid_spread(leader, stage, "time_s") > BLURRED_S)
    own = not leader.named and leader.value >= FAINT and _differs_by_run(leader, stage)
    if leader.gated >= FAINT or own or not _rises(stage, after, leader):
        return False
    return not _falls_within(stage, after, leader) or foresight(stage, after, leader) < FORESEEN


def _differs_by_run(leader: Ranked, stage: Stage) -> bool:
    """Return whether all columns are of one run each, as of a rhythm whose phases differ: runs foretell no other."""
    return bool(_of_one_run(leader.best.trial.columns, stage).all())


def _begins(leader: Ranked, stage: Stage) -> bool:
    """Return whether a leader has columns of what had not come to rest before each run."""
    return leader.best.trial.starts > 0 and _begun(leader, stage).shape[1] > 0


def _begun(leader: Ranked, stage: Stage) -> FloatArray:
    """Return the columns of what had not come to rest before each run, shape (n, k): such as no run foretells."""
    trial = leader.best.trial
    besides = trial.columns[:, trial.carried :]
    return besides[:, _of_one_run(besides, stage)]


def _of_one_run(columns: FloatArray, stage: Stage) -> npt.NDArray[np.bool_]:
    """Return which columns are of one run, of several, shape (k,)."""
    run = stage.channel.run
    shows = np.array([np.any(columns[run == k] != 0.0, axis=0) for k in np.unique(run)])
    return np.asarray((shows.sum(axis=0) == 1) & (len(shows) > 1))


def _rises(before: Stage, after: Stage, leader: Ranked) -> bool:
    """Return whether squares of runs left out rise by more than they scatter."""
    return part_saved(before, after, leader) <= -part_spread(before, after, leader)


def _falls_within(before: Stage, after: Stage, leader: Ranked) -> bool:
    """Return whether squares about each run's mean fall: noisy first rows put a run off as a whole."""
    return part_saved(before, after, leader, within=True) > LEAST_SHARE


def tells_of_one_run(leader: Ranked) -> bool:
    """Whether a cause belongs to one run, so that no run left out can tell of it."""
    return leader.cause in (STEP, JOLT)


def _kinder(stage: Stage, before: Stage, leader: Ranked, *, within: bool = False) -> FloatArray:
    """Return what a stage leaves of runs left out, at the noise with the leader or at that before: the kinder one.

    With `within` it is less each run's mean, where runs have zeros of their own: the noise of few first rows.
    """
    run, rows = stage.channel.run, stage.channel.rows
    both = [stage.left_out(levels)[0] for levels in (leader.levels, before.plain)]
    if within and stage.channel.zeroed_by_run:
        both = [left - (np.bincount(run, rows * left) / np.bincount(run, rows))[run] for left in both]
    return min(both, key=lambda left: float((rows * left**2).sum()))


def _left(before: Stage, after: Stage, leader: Ranked, *, within: bool = False) -> list[FloatArray]:
    """Return the mean squares of both stages in a row, by the run left out; see `_kinder`."""
    found = []
    for stage in (before, after):
        run, rows = stage.channel.run, stage.channel.rows
        table = rows * _kinder(stage, before, leader, within=within) ** 2 / rows.sum()
        found.append(np.array([table[run == k].sum() for k in np.unique(run)]))
    return found


def part_saved(before: Stage, after: Stage, leader: Ranked, *, within: bool = False) -> float:
    """Return by which part a stage leaves less, squared, of runs left out; see `_left`."""
    if tells_of_one_run(leader):
        return 1.0
    old, new = _left(before, after, leader, within=within)
    return float(1.0 - new.sum() / old.sum())


def part_spread(before: Stage, after: Stage, leader: Ranked) -> float:
    """Return the standard uncertainty of `part_saved` by the scatter among runs."""
    old, new = _left(before, after, leader)
    return float(np.sqrt(len(old)) * (old - new).std(ddof=1) / old.sum())


def foresight(before: Stage, after: Stage, leader: Ranked) -> float:
    """Return by how much runs left out become more likely (log), each stage at the likeliest of the same noises."""
    if tells_of_one_run(leader):
        return np.inf
    noises = before.step.levels, leader.levels, after.levels
    old, new = (max(stage.left_likelihood(levels) for levels in noises) for stage in (before, after))
    return new - old
