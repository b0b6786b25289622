"""The course of a diagnosis: causes are named one after the other, as long as each stands above chance and pays."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from hexathermal.errors import ArgumentError, UnknownNameError
from hexathermal.learn.campaign import Campaign
from hexathermal.learn.campaign_laws import identify_campaign
from hexathermal.learn.diagnosis.chance import chance_threshold
from hexathermal.learn.diagnosis.deciding import LEAST, Decision, decided
from hexathermal.learn.diagnosis.search import Ranked, Step
from hexathermal.learn.diagnosis.stage import Stage, view_of
from hexathermal.learn.law import IdentifiedLaw
from hexathermal.learn.signals import RunRows
from hexathermal.poses import FloatArray

MOST_EFFECTS = 3
FEWEST_WINDOWS = 40
FEWEST_RUNS = 2

Progress = Callable[[int, int, str], None]


@dataclass(frozen=True, eq=False)
class Found:
    """A cause that was named at a stage.

    Attributes
    ----------
    ranked : Ranked
    decision : Decision
    joined : bool
        Whether it pays on runs left out.
    amplitudes, spread : array, shape (k,)
        Of the trial's columns when it was named, and their standard uncertainties.
    """

    ranked: Ranked
    decision: Decision
    joined: bool
    amplitudes: FloatArray
    spread: FloatArray


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
    """

    first: Stage
    last: Stage
    stages: tuple[Stage, ...]
    steps: tuple[Step, ...]
    found: tuple[Found, ...]
    end: Decision
    threshold: float


def base_law(campaign: Campaign, sensors: Sequence[str] | None, law: IdentifiedLaw | None) -> IdentifiedLaw:
    """Return the law that is looked at: the one given, of some sensors, or the one that `identify` chooses."""
    if campaign.kind == "hexapod":
        raise ArgumentError("a campaign of kind 'hexapod' is not diagnosed as one leg")
    if law is not None:
        lost = [name for name in law.sensors if name not in campaign.sensors]
        if lost:
            raise UnknownNameError(
                f"the law reads sensor {lost[0]!r}, which this campaign does not have; it has: "
                f"{', '.join(campaign.sensors)}", campaign.sensors,
            )  # fmt: skip
        return law
    return identify_campaign(campaign, "auto" if sensors is None else tuple(sensors)).law


def searched(campaign: Campaign, law: IdentifiedLaw, rows: Sequence[RunRows], progress: Progress | None = None) -> Course:
    """Return the course of a diagnosis on the runs for identification.

    Parameters
    ----------
    campaign : Campaign
    law : IdentifiedLaw
        Whose sensors make the base; its coefficients are fitted anew.
    rows : sequence of RunRows
        Of the runs for identification.
    progress : function, optional
        Called as ``progress(done, total, label)``.
    """
    said = progress if progress is not None else (lambda _done, _total, _label: None)
    first = stage = Stage(view_of(campaign, rows, law.sensors))
    _refuse_too_little(first)
    said(1, MOST_EFFECTS + 2, "trying causes")
    step = stage.step
    seed = int.from_bytes(hashlib.sha256(first.channel.y.tobytes()).digest()[:4], "little")
    chance = chance_threshold(first.channel, first.base, step.levels, first.search.trials, first.search.largest, seed)
    threshold = max(LEAST, chance)
    steps, found, stages = [step], list[Found](), list[Stage]()
    decision = decided(step, threshold)
    while decision.named and len(found) < MOST_EFFECTS:
        assert decision.leader is not None  # named
        after = stage.with_effect(decision.leader.best)
        pays = _pays(stage, after, decision.leader)
        if not pays and found:
            break
        stages.append(stage)
        found.append(Found(decision.leader, decision, pays, *stage.amplitudes(decision.leader)))
        if not pays:
            break
        stage = after
        said(1 + len(found), MOST_EFFECTS + 2, f"{decision.leader.cause} named; trying what is left")
        step = stage.step
        steps.append(step)
        decision = decided(step, threshold)
    return Course(first, stage, tuple(stages), tuple(steps), tuple(found), decision, threshold)


def _pays(before: Stage, after: Stage, leader: Ranked) -> bool:
    """Whether a stage predicts runs left out of the fit better than the one before; a step of the zero has no such test."""
    if leader.cause == "zero-jump":
        return True
    levels = leader.levels
    old, new = before.left_out(levels), after.left_out(levels)
    rows = before.channel.rows
    return bool((rows * new**2).sum() < (rows * old**2).sum())


def _refuse_too_little(stage: Stage) -> None:
    """Refuse a campaign from which nothing can be told."""
    windows, runs = len(stage.channel), len(stage.view.runs)
    if windows < FEWEST_WINDOWS or runs < FEWEST_RUNS:
        raise ArgumentError(
            f"too little data for a diagnosis: {windows} windows of landings in {runs} runs for identification; it "
            f"needs {FEWEST_WINDOWS} and {FEWEST_RUNS}: measure more runs, or longer ones with more moves and rests"
        )
