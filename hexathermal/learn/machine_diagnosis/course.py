"""The course of a diagnosis: causes adopted one after the other, exchanged for better ones, and what is left then."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hexathermal.learn.machine_diagnosis.candidate import Candidate
from hexathermal.learn.machine_diagnosis.case import Case, with_exchanged, with_finer
from hexathermal.learn.machine_diagnosis.evidence import hypothesis, log_bayes, scored
from hexathermal.learn.machine_diagnosis.finer import finer_setting
from hexathermal.learn.machine_diagnosis.leg_sensors import SWAPPED, swapped_law, with_laws
from hexathermal.learn.machine_diagnosis.search import (
    NAMELESS_MARGIN,
    Adoption,
    Ranked,
    Step,
    best_pair,
    candidates_left,
    priors_of,
    step,
)
from hexathermal.machine.hexapod import Hexapod

MOST_EFFECTS = 3
EXCHANGED = 3.0
"""Log odds by which another cause must be better for it to take the place of one adopted before."""

SWAPS = ("swapped-legs", SWAPPED)
"""Exchanges of thermometers: they are undone, not fitted."""


@dataclass(frozen=True, eq=False)
class Course:
    """The whole search.

    Attributes
    ----------
    first : Case
        As the machine's file has it.
    case : Case
        Exchanges undone.
    adopted : tuple of Adoption
        Named causes, the strongest first.
    end : Step
        Over all that was adopted.
    notes : tuple of str
    """

    first: Case
    case: Case
    adopted: tuple[Adoption, ...]
    end: Step
    notes: tuple[str, ...] = ()

    @property
    def left(self) -> Ranked | None:
        """What is left beyond chance and has no name that holds."""
        best = self.end.ranking[0] if self.end.ranking else None
        return best if best is not None and best.odds > self.end.threshold else None


def searched(case: Case) -> Course:
    """Return the causes that a case names.

    Parameters
    ----------
    case : Case
    """
    first, adopted, notes = case, list[Adoption](), list[str]()
    now = step(case, adopted)
    while len(adopted) < MOST_EFFECTS:
        leader = _leader(case, now, not adopted)
        if leader is None:
            break
        if finer_setting(case.view, case.candidates[leader.which]):
            case = with_finer(case, case.candidates[leader.which])
            now = step(case, adopted, now.null)
            leader = _leader(case, now, False) or leader
        found = _adoption(case, now, leader, adopted)
        if not _paying(found):
            notes.append(f"{found.candidate.called} does not pay on runs left out of the fit: it is not named")
            break
        adopted.append(found)
        case = _behind(case, found)
        if found.which < 0:
            adopted = [_found_again(case, one) for one in adopted]
        now = step(case, adopted, now.null)
    adopted = _exchanged(case, adopted)
    adopted.sort(key=lambda one: -one.ranked.odds)
    if adopted:
        now = step(case, adopted, now.null)
        held = _held(case, adopted, now)
        if len(held) < len(adopted):
            lost = [one.candidate.called for one in adopted if one not in held]
            notes.append(f"{' and '.join(lost)} would explain part of what is there, but a shape without a name "
                         "explains all of it as well alone")  # fmt: skip
            adopted, now = held, step(case, held, now.null)
    return Course(first, case, tuple(adopted), now, tuple(notes))


def _leader(case: Case, now: Step, alone: bool) -> Ranked | None:
    """Return the candidate to adopt: the best, or of two that together are better the stronger one; None: no name."""
    if not now.ranking or now.ranking[0].odds <= now.threshold:
        return None
    pair = best_pair(case, now) if alone else None
    if pair is not None:
        return next(one for one in now.ranking if one.which in pair[:2])
    best = next((one for one in now.ranking if case.named(one.which)), None)
    if best is None or best.odds <= now.threshold or now.ranking[0].odds > best.odds + NAMELESS_MARGIN:
        return None
    return best


def _adoption(case: Case, now: Step, ranked: Ranked, adopted: Sequence[Adoption]) -> Adoption:
    """Return a candidate as adopted, with what it gains on each run left out."""
    candidate = case.candidates[ranked.which]
    which = -1 if candidate.cause in SWAPS else ranked.which
    return Adoption(which, candidate, ranked.scored.size, ranked, now, case, _gains(case, now, ranked, adopted))


def _gains(case: Case, now: Step, ranked: Ranked, adopted: Sequence[Adoption]) -> tuple[float, ...]:
    """Return the log evidence by which a candidate foretells each run from the others, over what is without it.

    ``log p(y_r | others, cause) - log p(y_r | others)``: the evidence of all runs less that of the others.
    """
    if len(case.tables.runs) < 2:
        return ()
    one, own = case.candidates[ranked.which], case.tables.places[ranked.which]
    place = slice(own.start - case.tables.base, own.stop - case.tables.base)
    base, sd = priors_of(case, adopted), one.scale * ranked.scored.size

    def evidence(skip: int | None) -> float:
        S = candidates_left(case, ranked.levels, base, skip)
        return log_bayes(S[place, place], S[place, -1], one.mean, sd)[0]

    whole = evidence(None)
    return tuple(whole - evidence(run) for run in range(len(case.tables.runs)))


def _paying(found: Adoption) -> bool:
    """Whether a cause pays on runs left out, all together."""
    return not found.pays or sum(found.pays) > 0.0


def _behind(case: Case, found: Adoption) -> Case:
    """Return the case behind an adoption: an exchange of thermometers is undone."""
    return case if found.which >= 0 else with_exchanged(case, exchanged(case.view.hexapod, found.candidate))


def exchanged(hexapod: Hexapod, one: Candidate) -> Hexapod:
    """Return a machine two of whose legs read each other's thermometers, or one leg two of its own."""
    thermal = hexapod.thermal
    assert thermal is not None  # checked where views are made
    if one.cause == SWAPPED:
        laws = list(thermal.legs)
        laws[one.legs[0]] = swapped_law(laws[one.legs[0]], one.settings)
        return replace(hexapod, thermal=with_laws(thermal, laws))
    order = list(thermal.thermometers_of_leg)
    first, second = one.legs
    order[first], order[second] = order[second], order[first]
    return replace(hexapod, thermal=replace(thermal, thermometers_of_leg=tuple(order)))


def _found_again(case: Case, one: Adoption) -> Adoption:
    """Return an adoption in a case whose candidates were made anew."""
    if one.which < 0:
        return one
    for k, other in enumerate(case.candidates):
        if (other.called, other.settings) == (one.candidate.called, one.candidate.settings):
            return replace(one, which=k, candidate=other)
    raise AssertionError(one.candidate.called)


def _exchanged(case: Case, adopted: list[Adoption]) -> list[Adoption]:
    """Return what was adopted, each cause for the best over the others where that is clearly better."""
    if len(adopted) < 2:
        return adopted
    for k, one in enumerate(adopted):
        others = [other for other in adopted if other is not one]
        if one.which < 0:
            continue
        now = step(case, others, one.step.null)
        best = now.ranking[0]
        own = next((item for item in now.ranking if item.which == one.which), None)
        chosen = best if own is None or best.odds > own.odds + EXCHANGED else own
        if case.named(chosen.which) and case.candidates[chosen.which].cause not in SWAPS:
            found = _adoption(case, now, chosen, others)
            adopted = [*adopted[:k], found, *adopted[k + 1 :]]
    return [one for one in adopted if one.which < 0 or one.ranked.odds > one.step.threshold]


def _held(case: Case, adopted: Sequence[Adoption], end: Step) -> list[Adoption]:
    """Return the names that hold beside what is left and has no name.

    What is left may be the rest of something of which a name is but a part: the name goes where, with one shape without
    a name allowed, it is less probable than that shape without it.
    """
    kept = list(adopted)
    left = end.ranking[0] if end.ranking else None
    if left is None or left.odds <= end.threshold or case.named(left.which):
        return kept
    shapes = [k for k in range(len(case.candidates)) if not case.named(k)]
    for one in sorted(adopted, key=lambda one: one.ranked.odds):
        if one.which < 0:
            continue
        others = [other for other in kept if other is not one]
        whole = _beside(case, kept, shapes, end) + float(case.prior[one.which])
        if whole <= _beside(case, others, shapes, end):
            kept = others
    return kept


def _beside(case: Case, adopted: Sequence[Adoption], shapes: Sequence[int], end: Step) -> float:
    """Return the log evidence of what was adopted with the best shape without a name."""
    base, best = priors_of(case, adopted), -np.inf
    value = hypothesis(case.tables, end.null, base)[0]
    S = candidates_left(case, end.null, base)
    for which in shapes:
        own = case.tables.places[which]
        place = slice(own.start - case.tables.base, own.stop - case.tables.base)
        found = scored(S[place, place], S[place, -1], case.candidates[which], case.tables.rows, which)
        best = best if found is None else max(best, found.value + float(case.prior[which]))
    return value + max(best, 0.0)


def visible_strength(one: Adoption) -> float:
    """Return the RMS of what was found, visible, over the noise."""
    return float(np.abs(one.ranked.scored.strength))
