"""From a ranking to a verdict: which name, which others these data cannot tell from it, and how sure.

The probability of each hypothesis is proportional to its prior times a tempered evidence; at the threshold that this
campaign's own noise sets, the odds against nothing are even. Models are sketches: what a
sketch gets wrong of a shape grows with the effect, so that the evidence between causes counts by
``1 / (1 + shape_error * evidence)`` or less, and against nothing only as far as a null that tolerates a small misfit
lets it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hexathermal.learn.diagnosis.alike_by_nature import not_ruled_out
from hexathermal.learn.diagnosis.ranking import NONE, Ranked, Step
from hexathermal.learn.diagnosis.rivals import SHAPE_ERROR
from hexathermal.learn.diagnosis.trials import MOVED, STOOD, WORN

NAMED_PRIOR = 0.75
"""Of the catalogue, against something nameless."""

SOUND = 0.96
"""How often the truth is among the hypotheses as they are drawn: of what was given as certain on benches of this
project 0.98 was right, on legs of four generators of other hands 0.93."""

NAME_LEAD, NAME_SHARE = 0.5, 0.03
"""A cause may be that far behind flexible columns, which imitate any shape, and by this part of what they say besides,
and still be the name."""

NAME_AHEAD, AHEAD_SHARE, AHEAD_OF_WEAR = 0.5, 0.05, 0.02
"""Of one column without a name, which imitates nothing, it must be that far ahead, and by this part of what that says:
the shape of either may be a little wrong. Less of wear, which goes as the way travelled: what imitates that, as time
does, is one column as well, while what is not linear bends as a kink does."""

AHEAD_OF_MOVES = -0.01
"""The same of one column that follows moves: a cable that is drawn along, a brake that closes and creep are sketches of
one another, and whichever explains more is likelier."""

IMITATED = 0.6
"""Part of what is nameless that counts for a name which is given although something nameless fits as well."""

ALIKE = 0.7
"""Names with this share of the first one's probability are as good: the first is the one that is least a misfit."""

CLEAR = 100.0
"""Log evidence against a tolerated misfit from which on more of it makes no name any better."""

NEARLY, FAR, UNBOUNDED = 0.7, 10.0, 2.0
"""Part of the threshold that a name needs which is so far ahead of one that stands, and how many times the threshold
that one may have against a tolerated misfit."""

EVEN = 0.5
"""Least probability of something without a name that a name is hardly ahead of, or that leads all names: five of eight
of the first kind had none, and twelve of fifteen of the second that had less."""

RECORDED, SKETCHES = "missing-sensor", ("hidden-heat", "thermal-lag")
"""A cause whose shape is as it was recorded, and those whose shapes are sketches of heat that thermometers see too."""

LOST, HARDLY_EVEN = 0.3, 0.45
"""The most that a sketch may lose of its evidence, and its chance beside an exact shape that is ahead: on legs of five
generators of other hands a missing thermometer was right in 6 of 10 that were ahead of a sketch by 0.1 to 0.3, in all
of 13 further ahead."""

OUTSIDE = 0.6
"""Most that a rate of each run's own is to have no name: on benches of this project what tilts with the day has none;
generators of two other hands call it a drift of the zero."""

LEAST_NAMED = 0.25
"""Least probability of a name: below, what is there has none."""

SECONDED = 2.0
"""Log evidence by which its own parity must speak for a fault that is told to be as good as the name."""

DENIED = 1.0
"""Log evidence by which its parity must be against it to deny one whose error the drift and the parity both tell."""

EQUIVALENT = 0.05
"""Share of the leader's probability from which on another name is equivalent."""


@dataclass(frozen=True, eq=False)
class Decision:
    """What a step's ranking says.

    Attributes
    ----------
    leader : Ranked or None
        The cause that is named, or what is nameless; None: nothing is there.
    probability : float
        Of the verdict.
    probabilities : dict of str to float
        Of each cause, of what is nameless, and of ``"none"``.
    equivalent : tuple of str
    """

    leader: Ranked | None
    probability: float
    probabilities: dict[str, float]
    equivalent: tuple[str, ...]

    @property
    def named(self) -> bool:
        """Whether a cause of the catalogue leads."""
        return self.leader is not None and self.leader.named

    @property
    def together(self) -> float:
        """The probability of the leader or of one of those that are as good."""
        alike = () if self.leader is None else (self.leader.cause, *self.equivalent)
        return max(self.probability, sum(self.probabilities[name] for name in alike))


def decided(step: Step, threshold: float, *, before: float = 0.0) -> Decision:
    """Return the verdict of a ranking.

    Parameters
    ----------
    step : Step
    threshold : float
        Log evidence that a name needs in this campaign.
    before : float
        Largest evidence of the causes named before; 0 where this is the first. What is left has a name more often than
        not: two faults of the catalogue at once are likelier than one of them and something outside it.
    """
    named = [item for item in step.ranking if item.named]
    nameless = [item for item in step.ranking if not item.named]
    values = _tempered(step, threshold, len(named), len(nameless))
    top = max(values.values())
    weights = {name: float(np.exp(value - top)) for name, value in values.items()}
    total = sum(weights.values())
    probabilities = {name: SOUND * weight / total for name, weight in weights.items()}
    standing = _standing(step, threshold)
    if not standing:
        return Decision(None, probabilities[NONE], probabilities, ())
    best = standing[0]
    names = [item for item in standing if item.named]
    if names and names[0].value >= _wanted(standing, before):
        # of names that fit alike, the one that the least of a tolerated misfit could stand for
        as_good = ALIKE * probabilities[names[0].cause]
        fitting = [item for item in names if probabilities[item.cause] >= as_good and not item.unlikely] or names[:1]
        best = max(fitting, key=lambda item: (min(item.gated, CLEAR), item.value))
    elif best.named:
        return _handed(standing, probabilities)
    if best.named and probabilities[best.cause] < LEAST_NAMED:
        best = max(nameless, key=lambda item: item.value, default=best)
    if not best.named:
        share = sum(probabilities[item.cause] for item in nameless)
        rivals = probabilities[NONE] + max(probabilities[item.cause] for item in named)
        told = _as_by_nature(Decision(best, max(share, SOUND - rivals), probabilities, ()))
        return _at_least_even(told, [item.cause for item in nameless]) if best is standing[0] else told
    probabilities = _beside_sketches(probabilities, best, standing)
    own = probabilities[best.cause] + IMITATED * sum(probabilities[item.cause] for item in nameless)
    faults = _as_good(best, named)
    alike = [
        item.cause
        for item in names
        if item is not best and probabilities[item.cause] > EQUIVALENT * probabilities[best.cause]
    ]
    alike += [name for name in (*faults, *_as_likely(best, named, threshold)) if name not in alike]
    return Decision(best, own / (1.0 + sum(faults.values())), probabilities, tuple(alike))


def _standing(step: Step, threshold: float) -> list[Ranked]:
    """Return what stands above chance, best first.

    With a name that errors of the thermometers may feign in part, or with something nameless, stands another name that
    explains far more, of which they may feign hardly more: there is something, and the gate asks no more than that.
    """
    sure = [item for item in step.ranking if item.gated >= threshold]
    bounded = [item.value for item in sure
               if not item.named or item.gated < min(item.value, UNBOUNDED * threshold)]  # fmt: skip
    return [
        item
        for item in step.ranking
        if item in sure
        or (bounded and item.named and item.gated >= NEARLY * threshold and item.value >= FAR + max(bounded))
    ]


def _beside_sketches(probabilities: dict[str, float], best: Ranked, standing: Sequence[Ranked]) -> dict[str, float]:
    """Return probabilities beside a missing thermometer, of which the shape is no sketch: it was recorded.

    The sketch of heat that is stored or late loses a part of its evidence, uniform up to `LOST`: it is likelier than
    what was recorded where it would be ahead without that loss.
    """
    sketches = [item for item in standing if item.cause in SKETCHES]
    if best.cause != RECORDED or not sketches:
        return probabilities
    nearest = max(sketches, key=lambda item: item.value)
    chance = min(1.0 - (1.0 - nearest.value / best.value) / LOST, HARDLY_EVEN)
    own, beside = probabilities[best.cause], probabilities[nearest.cause]
    others = [probabilities[item.cause] for item in standing if item.named and item not in (best, nearest)]
    # the name stays, so that no other may be likelier
    kept = max((1.0 - chance) * (own + beside), LEAST_NAMED, *others)
    if kept >= own:
        return probabilities
    return {**probabilities, best.cause: kept, nearest.cause: own + beside - kept}


def _handed(standing: Sequence[Ranked], probabilities: dict[str, float]) -> Decision:
    """Return the verdict for what has no name, behind a name that is not far enough ahead of it: as likely as that."""
    best = next(item for item in standing if not item.named)
    return _at_least_even(Decision(best, probabilities[best.cause], probabilities, ()), [best.cause])


def _as_by_nature(told: Decision) -> Decision:
    """Return a verdict that something has no name; less sure where a name's own nature is the same."""
    assert told.leader is not None  # something leads
    own = told.leader.cause
    names = [name for name in not_ruled_out(own, ()) if name in told.probabilities]
    more = told.probability - OUTSIDE
    if not names or more <= 0.0:
        return told
    moved = min(more, told.probabilities[own])
    shares = {own: -moved, **dict.fromkeys(names, moved / len(names))}
    probabilities = {name: value + shares.get(name, 0.0) for name, value in told.probabilities.items()}
    return replace(told, probability=OUTSIDE, probabilities=probabilities)


def _at_least_even(told: Decision, names: Sequence[str]) -> Decision:
    """Return a verdict that some names share, with a probability of `EVEN` or more; others have the rest."""
    if told.probability >= EVEN:
        return told
    own, whole = sum(told.probabilities[name] for name in names), sum(told.probabilities.values())
    probabilities = {name: value * (EVEN / own if name in names else (whole - EVEN) / (whole - own))
                     for name, value in told.probabilities.items()}  # fmt: skip
    return replace(told, probability=EVEN, probabilities=probabilities)


def hardly_behind(item: Ranked, leader: Ranked) -> bool:
    """Return whether the data speak for one cause as for another that leads it: by no more than errors of shapes."""
    lead = (leader.value - item.value) / (1.0 + SHAPE_ERROR * max(item.value, 0.0))
    return lead < -math.log(EQUIVALENT)


def _as_likely(best: Ranked, named: Sequence[Ranked], threshold: float) -> list[str]:
    """Return names that the data speak for as they do for the best, but which errors of the thermometers may feign."""
    cool = _cool(best)
    others = [item for item in named if item is not best and item.value >= threshold]
    return [item.cause for item in others if (item.value - best.value) / cool > np.log(EQUIVALENT)]


def _as_good(best: Ranked, named: Sequence[Ranked]) -> dict[str, float]:
    """Return faults of a thermometer that the drift alone speaks for as it does for the best, and their odds.

    Its parity speaks for them too, but no more than that of sound ones may, or is too uncertain to deny them: too
    little for a name of their own.
    """
    found = {}
    for item in named:
        lead = item.value + item.withheld - best.value
        may_be = item.seconded > SECONDED or item.agreed > -DENIED
        if item is not best and may_be and item.withheld > 0.0 and lead > np.log(EQUIVALENT):
            found[item.cause] = float(np.exp(min(lead, 0.0)))
    return found


def _wanted(standing: Sequence[Ranked], before: float) -> float:
    """Return the log evidence that a name needs among what stands, so that what has no name is no better.

    Of a later name one column without a name asks no more than flexible ones do, and what imitates anything takes with
    it what errors of the shapes of causes named before leave.
    """
    best, left = standing[0], SHAPE_ERROR * before
    alone = [item for item in standing if not item.named and _alone(item) and not before]
    imitating = not best.named and (before > 0.0 or not _alone(best))
    wanted = best.value - (NAME_LEAD + NAME_SHARE * best.value + left) * imitating
    return max([wanted, *(NAME_AHEAD + (1.0 + _share(item)) * item.value for item in alone)])


def _share(item: Ranked) -> float:
    """Return the part of what one column without a name says by which a name must be ahead of it."""
    return {WORN: AHEAD_OF_WEAR, MOVED: AHEAD_OF_MOVES}.get(str(item.best.trial.target), AHEAD_SHARE)


def _cool(best: Ranked) -> float:
    """Return what the evidence between causes is divided by, beside the best: its shape is a sketch.

    And what errors of the thermometers may feign of it, they may feign of the lead over another as well.
    """
    value = max(best.value, 0.0)
    return max(1.0 + SHAPE_ERROR * value, value / max(best.gated, 1.0))


def _alone(item: Ranked) -> bool:
    """Whether it is one column, which imitates nothing but itself, as the time at each displacement does time."""
    return int(item.best.trial.columns.shape[1]) == 1 and item.best.trial.target != STOOD


def together(first: Ranked, second: Ranked, alone: Ranked) -> float:
    """Return the probability of two causes, one over the other, against something that explains both alone."""
    lead = (first.value + second.value - alone.value) / (1.0 + SHAPE_ERROR * max(alone.value, 0.0))
    return float(SOUND / (1.0 + np.exp(-lead)))


def _tempered(step: Step, threshold: float, named: int, nameless: int) -> dict[str, float]:
    """Return tempered log posteriors against nothing: even odds at the threshold.

    What does not stand above a null that tolerates a small misfit counts as that null lets it.
    """
    standing = _standing(step, threshold)
    shown = {item.cause: item.value if item in standing else min(item.value, item.gated) for item in step.ranking}
    lead = max(shown.values(), default=0.0)
    gate = max((item.gated for item in step.ranking), default=0.0)
    leading = [item for item in standing if shown[item.cause] == lead]
    cool = _cool(leading[0]) if leading else 1.0 + SHAPE_ERROR * max(lead, 0.0)
    found = {NONE: 0.0}
    for item in step.ranking:
        prior = NAMED_PRIOR / max(named, 1) if item.named else (1.0 - NAMED_PRIOR) / max(nameless, 1)
        found[item.cause] = np.log(prior * (named + nameless)) + (shown[item.cause] - lead) / cool + gate - threshold
    return {name: float(value) for name, value in found.items()}
