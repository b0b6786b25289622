"""The course of a diagnosis: causes are named one after the other, as long as each stands above chance and pays."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from hexathermal.errors import ArgumentError, DataError, UnknownNameError
from hexathermal.learn.campaign import Campaign
from hexathermal.learn.campaign_laws import identify_campaign
from hexathermal.learn.diagnosis.base_choice import FEWEST_WINDOWS, likelier_sensors
from hexathermal.learn.diagnosis.causes import confused
from hexathermal.learn.diagnosis.chance import LEAST_THRESHOLD, chance_threshold
from hexathermal.learn.diagnosis.deciding import Decision, decided, together
from hexathermal.learn.diagnosis.evidence import Scored
from hexathermal.learn.diagnosis.exchange import rival_beside
from hexathermal.learn.diagnosis.foresight import denied, part_saved, tells_of_one_run, worth
from hexathermal.learn.diagnosis.forms import as_joined
from hexathermal.learn.diagnosis.joining import Found, next_stage
from hexathermal.learn.diagnosis.law_form import grows_along
from hexathermal.learn.diagnosis.pruning import pruned
from hexathermal.learn.diagnosis.ranking import Ranked, Step
from hexathermal.learn.diagnosis.reading_noise import with_reading_noise
from hexathermal.learn.diagnosis.reopening import form_beside
from hexathermal.learn.diagnosis.rivals import SHAPE_ERROR
from hexathermal.learn.diagnosis.search import REPEATED
from hexathermal.learn.diagnosis.stage import Stage, view_of
from hexathermal.learn.diagnosis.tolerating import tolerant
from hexathermal.learn.diagnosis.view import View
from hexathermal.learn.diagnosis.wandering import with_wandering
from hexathermal.learn.identification import AUTO
from hexathermal.learn.law import IdentifiedLaw
from hexathermal.learn.signals import RunRows
from hexathermal.machine.leg_repairs import SensorRepair

MOST_EFFECTS = 6
LATER = 2.0
"""Every cause after the first needs so much more evidence: it may mop up what the first one's shape left."""

TWO_LEAD = 5.0
"""Log evidence by which two names must beat what is nameless."""

FIRST_OF_TWO = 2
"""So many of the best names are tried as the first of two."""

PROVEN = 40.0
"""A fault of a thermometer that its parity shows by so much is named although no run left out needs it."""

UNSEEN = 12.0
"""So much more where no run left out can tell: a later step of the zero in one run."""

LATER_PART, APART = 0.05, 0.03
"""Every cause after the first needs this part of the evidence of each one before that it is confused with, or of each
other one, unless its parity proves it: so much may be left of any shape that is a sketch. Of 30 later names of five
simulated benches above the first part five were wrong, four of five below it."""

LEFT_SIZE = 1.5
"""Size of what a sketch may leave over that which such a part of the evidence has in even noise."""

LATER_SURE = 0.5
"""Least probability of a later name, with those that are as good."""

MOST_REFUSED, UNDECIDED = 4, 0.5
"""First causes that stand above chance but are passed over, since runs left out deny them, at most; and the probability
of "none" where that is not enough."""

STANDING, CLEARLY = 0.1, 0.05
"""A target may stand for the leader's if it has this part of its evidence, and takes away so much more."""

FEWEST_RUNS = 2

Progress = Callable[[int, int, str], None]


@dataclass(frozen=True, eq=False)
class Course:
    """How a diagnosis went.

    Attributes
    ----------
    first, last : Stage
        Without anything, and with all that joined.
    stages : tuple of Stage
        Before each of the causes named.
    steps : tuple of Step
    found : tuple of Found
    end : Decision
        Of the last step.
    threshold : float
    refused : tuple of Ranked
        Causes that stood above chance, but do not predict runs left out better.
    """

    first: Stage
    last: Stage
    stages: tuple[Stage, ...]
    steps: tuple[Step, ...]
    found: tuple[Found, ...]
    end: Decision
    threshold: float
    refused: tuple[Ranked, ...] = ()


def base_law(
    campaign: Campaign, rows: Sequence[RunRows], sensors: Sequence[str] | None, law: IdentifiedLaw | None
) -> IdentifiedLaw:
    """Return the law that is looked at: of a given one's sensors, of some, or of those that its runs speak for."""
    if campaign.kind == "hexapod":
        raise ArgumentError("a campaign of kind 'hexapod' is not diagnosed as one leg")
    if law is not None:
        lost = [name for name in law.sensors if name not in campaign.sensors]
        if lost:
            raise UnknownNameError(
                f"the law reads sensor {lost[0]!r}, which this campaign does not have; it has: "
                f"{', '.join(campaign.sensors)}", campaign.sensors,
            )  # fmt: skip
        sensors = law.sensors
    read = {one.run.name: one for one in rows}
    chosen = identify_campaign(campaign, AUTO if sensors is None else tuple(sensors), read=read).law
    view = view_of(campaign, rows, chosen.sensors)
    placed = all(one.usable.q is not None for one in rows) and grows_along(view)
    view = replace(view, placed=placed)
    names = likelier_sensors(view) if sensors is None else chosen.sensors
    if names == chosen.sensors and chosen.stroked == view.stroked:
        return chosen
    return identify_campaign(campaign, names, along=view.stroked, read=read).law


def searched(
    campaign: Campaign, law: IdentifiedLaw, rows: Sequence[RunRows], progress: Progress | None = None,
    repairs: tuple[SensorRepair, ...] = (),
) -> Course:  # fmt: skip
    """Return the course of a diagnosis on the runs for identification.

    Parameters
    ----------
    campaign : Campaign
    law : IdentifiedLaw
        Whose sensors make the base; its coefficients are fitted anew.
    rows : sequence of RunRows
        Of the runs for identification, `repairs` made.
    progress : function of (done, total, label), optional
    repairs : tuple of SensorRepair
    """
    said = progress if progress is not None else (lambda _done, _total, _label: None)
    first = stage = _first(view_of(campaign, rows, law.sensors, placed=law.stroked), repairs)
    said(1, MOST_EFFECTS + 2, "trying causes")
    threshold = _threshold(first)
    stage = tolerant(stage, threshold)
    steps, found, stages, refused = [stage.step], list[Found](), list[Stage](), list[Ranked]()
    alone = decided(steps[0], threshold)
    decision = _two_for(stage, alone, threshold)
    given_for_two = decision is not alone
    other: Decision | None = None
    while len(found) < MOST_EFFECTS:
        leader = _leader(stage, decision, threshold + LATER * bool(found), first=not found)
        if leader is None or (found and (decision.together < LATER_SURE or _too_faint(leader, found, threshold))):
            break
        after = stage.with_effect(leader.best)
        pays, joins = (True, True) if decision is other else worth(stage, after, leader, later=bool(found))
        if not pays and (found or leader.witness < PROVEN):
            if found:
                break
            if len(refused) == MOST_REFUSED:
                decision = replace(decision, leader=None, probability=UNDECIDED, equivalent=())
                break
            refused.append(leader)
            stage = tolerant(stage.without(leader.best), threshold)
            steps[0] = stage.step
            decision = decided(steps[0], threshold)
            continue
        stages.append(stage)
        found.append(Found(leader, decision, joins, *stage.amplitudes(leader)))
        if not joins and (len(found) > 1 or leader.best.trial.repair is not None):  # data that stay as they were
            break
        if len(found) == 2 and other is None:
            other = rival_beside(stages[0], found[0].ranked, leader.best, threshold)
            if other is not None:  # the first name is another one: once more from there
                stage, decision = stages[0], other
                steps, stages, found = steps[:1], [], []
                continue
        said(1 + len(found), MOST_EFFECTS + 2, f"{leader.cause} named; trying what is left")
        stage, found, decision = _gone_on(stage, after, found, threshold)
        steps.append(stage.step)
    if given_for_two and len(found) == 1:  # the other one did not stand: something nameless led
        stage, steps, stages, found, decision = stages[0], steps[:1], [], [], alone
    end = _not_denied(stage, decision, threshold, found)
    return _asked_again(Course(first, stage, tuple(stages), tuple(steps), tuple(found), end, threshold, tuple(refused)))


def _first(view: View, repairs: tuple[SensorRepair, ...] = ()) -> Stage:
    """Return the stage that a course begins with; refuse too little data."""
    _refuse_too_little(view)
    return Stage(with_wandering(with_reading_noise(view)), repairs=repairs)


def _later(stage: Stage, found: Sequence[Found], threshold: float) -> Decision:
    """Return the decision of a later step; what only mops up errors of shapes named before hides no other cause.

    Such a one is confused with a cause that was named, and is too faint, or runs left out deny it.
    """
    step = stage.step
    while True:
        decision = _decided_beside(found, step, threshold)
        leader = decision.leader
        if leader is None or not leader.named or not _mopped_up(leader, found):
            return decision
        after = stage.with_effect(leader.best)
        if not _too_faint(leader, found, threshold) and worth(stage, after, leader, later=True)[0]:
            return decision
        step = step.without(leader)


def _decided_beside(found: Sequence[Found], step: Step, threshold: float) -> Decision:
    """Return the decision of a step beside the causes that were named before, if any were."""
    before = max((one.ranked.value for one in found), default=0.0)
    return decided(step, threshold + LATER * bool(found), before=before)


def _gone_on(
    before: Stage, after: Stage, found: Sequence[Found], threshold: float
) -> tuple[Stage, list[Found], Decision]:  # fmt: skip
    """Return the stage after one at which a cause was named, what was found as it stands there, and the decision.

    Where nothing stands beside a first name, that has another form if a second name stands beside it then.
    """
    stage, stands, decision = _beside_all(before, after, found, threshold)
    first = stands[0]
    alone = len(stands) == 1 and first.joined and not decision.named
    form = form_beside(before, first.ranked, stage.step) if alone else None
    if form is None:
        return stage, stands, decision
    ranked = replace(first.ranked, best=form)
    one = Found(ranked, first.decision, first.joined, *before.amplitudes(ranked))
    other = _beside_all(before, before.with_effect(form), [one], threshold)
    return other if other[-1].named else (stage, stands, decision)


def _beside_all(
    before: Stage, after: Stage, found: Sequence[Found], threshold: float
) -> tuple[Stage, list[Found], Decision]:  # fmt: skip
    """Return the stage with all that was found, that as it stands there, and the decision on what is left."""
    stage, stands = next_stage(before, after, found, threshold)
    stage = tolerant(stage, threshold + LATER)
    return stage, stands, _later(stage, stands, threshold)


def _too_faint(leader: Ranked, found: Sequence[Found], threshold: float) -> bool:
    """Return whether a later cause says too little."""
    if tells_of_one_run(leader) and leader.gated < threshold + UNSEEN:
        return True
    if leader.witness < PROVEN and any(_may_be_left(one.ranked, leader) for one in found):
        return True
    return leader.value < threshold + LATER + _mopped_up(leader, found)


def _may_be_left(before: Ranked, leader: Ranked) -> bool:
    """Return whether a later cause may be what the shape of one before left of it, which is a sketch.

    What is slow says less than what is quick does of the same size: it is no rest of a quick one that is as small.
    """
    part = LATER_PART if confused(before.cause, leader.cause) else APART
    small = leader.best.visible < math.sqrt(part) * before.best.visible * LEFT_SIZE
    return small and leader.value < part * before.value


def _not_denied(stage: Stage, decision: Decision, threshold: float, found: Sequence[Found]) -> Decision:
    """Return a decision; where it is for something nameless that runs left out deny, for what leads without that.

    For nothing where no other leads that has no name.
    """
    leader, step = decision.leader, stage.step
    while leader is not None and not leader.named and denied(stage, stage.with_effect(leader.best), leader):
        step = step.without(leader)
        other = _decided_beside(found, step, threshold)
        leader = other.leader
        if leader is None or leader.named:
            return replace(decision, leader=None, probability=UNDECIDED, equivalent=())
        decision = other
    return decision


def _threshold(first: Stage) -> float:
    """Return the log evidence that a name needs in a campaign: what chance says of its noise now and then, or more."""
    channel, search = first.channel, first.search
    seed = int.from_bytes(hashlib.sha256(channel.y.tobytes()).digest()[:4], "little")
    levels, terms = first.step.levels, search.terms
    drawn = chance_threshold(channel, first.base, levels, search.trials, search.largest, seed, terms)
    return max(LEAST_THRESHOLD, drawn)


def _asked_again(course: Course) -> Course:
    """Return a course whose causes still pay at the end; what does not stays named, but leaves the law.

    In a part that does not move all that warms goes alike: there a later cause that others make needless has no name.
    """
    if sum(one.joined for one in course.found) < 2 or course.last.repairs:
        return course
    kinds = [item.trial.origin for item in course.last.joined]
    bests = [one.ranked.best for one in course.found]
    asked = [best for best in bests if best.trial.shape and kinds.count(best.trial.origin) == 1]
    last, gone = pruned(course.last, asked)
    found = [replace(one, joined=one.joined and all(one.ranked.best is not item for item in gone))
             for one in course.found]  # fmt: skip
    needless = [k for k, one in enumerate(found) if k and course.found[k].joined and not one.joined]
    needless = [] if course.first.view.moves else needless
    kept = [k for k in range(len(found)) if k not in needless]
    return replace(course, last=last, found=tuple(found[k] for k in kept),
                   stages=tuple(course.stages[k] for k in kept),
                   refused=(*course.refused, *(found[k].ranked for k in needless)))  # fmt: skip


def _two_for(stage: Stage, decision: Decision, threshold: float) -> Decision:
    """Return a decision for the best name where it and another one explain more than something nameless that leads.

    What is nameless imitates two causes at once. Two names in its place beat it by `TWO_LEAD`, and leave nothing but
    errors of their shapes, or what thermometers may feign as well.
    """
    alone = decision.leader
    names = [item for item in stage.step.ranking if item.named and item.gated >= threshold]
    if alone is None or alone.named:
        return decision
    for first in names[:FIRST_OF_TWO]:
        after = stage.with_effect(first.best)
        next_best = decided(after.step, threshold + LATER, before=first.value)
        second = next_best.leader
        if second is None or not next_best.named or first.value + second.value < alone.value + TWO_LEAD:
            continue
        both = max(first.value, second.value)
        left = decided(after.with_effect(second.best).step, threshold + LATER, before=both).leader
        if left is None or left.value <= SHAPE_ERROR * both or left.gated <= SHAPE_ERROR * (first.value + second.value):
            return replace(decision, leader=first, probability=together(first, second, alone))
    return decision


def _leader(stage: Stage, decision: Decision, threshold: float, *, first: bool) -> Ranked | None:
    """Return the cause to join next, with the target that predicts runs left out best; None where there is none.

    Once a cause was named, another thermometer that pays may join although something nameless leads.
    """
    leader = decision.leader if decision.named else None
    if leader is None and not first:
        others = [item for item in stage.step.ranking if item.cause == REPEATED and item.gated >= threshold]
        leader = others[0] if others else None
    if leader is None or leader.cause != REPEATED:
        return leader
    again = [trial for trial in stage.trials_left if trial.cause == REPEATED]
    scored = [stage.search.less_feigned(item, leader.levels, stage.step.levels)
              for item in stage.search.scored(stage.step.levels, again)]  # fmt: skip
    standing = [item for item in scored if item.gated >= threshold and item.value >= STANDING * leader.value]
    targets: dict[str | None, Scored] = {leader.best.trial.target: leader.best}
    for item in sorted(standing, key=lambda item: -item.value):
        targets.setdefault(item.trial.target, replace(as_joined(item, scored), value=item.value))
    shares = {name: part_saved(stage, stage.with_effect(item), leader) for name, item in targets.items()}
    best = max(shares, key=lambda name: shares[name])
    if shares[best] - shares[leader.best.trial.target] < CLEARLY:
        return leader
    return stage.asked_of_runs(replace(leader, best=targets[best], value=targets[best].value, repeated=0.0))


def _mopped_up(leader: Ranked, found: Sequence[Found]) -> float:
    """Return what errors of the shapes of causes named before may say for one that they are confused with.

    Where one more thermometer matters, the next one may as well.
    """
    if any(one.ranked.cause == leader.cause for one in found):
        return 0.0
    kindred = (one.ranked.value for one in found if confused(one.ranked.cause, leader.cause))
    return SHAPE_ERROR * max(kindred, default=0.0)


def _refuse_too_little(view: View) -> None:
    """Refuse a campaign from which nothing can be told."""
    windows, runs = len(view.channel), len(view.runs)
    if windows < FEWEST_WINDOWS or runs < FEWEST_RUNS:
        raise DataError(
            f"too little data for a diagnosis: {windows} windows of landings in {_runs(runs)} for identification; it "
            f"needs {FEWEST_WINDOWS} and {FEWEST_RUNS}: measure more runs, or longer ones with more moves and rests"
        )


def _runs(count: int) -> str:
    """Return a number of runs in words."""
    return "1 run" if count == 1 else f"{count} runs"
