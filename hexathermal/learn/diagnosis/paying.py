"""Whether an extended law pays on runs never fitted: what foretells them worse stays out of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from hexathermal.learn.campaign import Campaign
from hexathermal.learn.diagnosis.constants_beside import beside_constants
from hexathermal.learn.diagnosis.course import Course
from hexathermal.learn.diagnosis.extension import extended_law, gained
from hexathermal.learn.diagnosis.judged_steps import JudgedStep
from hexathermal.learn.diagnosis.refused import Refused
from hexathermal.learn.diagnosis.residuals import run_residuals
from hexathermal.learn.diagnosis.result import Effect, RunResidual
from hexathermal.learn.diagnosis.rivals import STEP
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.law import IdentifiedLaw
from hexathermal.learn.signals import RunRows
from hexathermal.learn.validation_gain import Gain

NOTHING = 1e-9
"""Part by which the RMSE on runs never fitted may rise by rounding alone."""

BORNE_OUT = {2: 0.4, 3: 0.05}
"""A rise as measured is of first rows alone where the RMSE beside a constant in each run falls by this part or more, in
each of so many runs or more: two may fall by chance, but not by nearly half."""

STAYS_OUT = "; runs never fitted are foretold worse with it: it stays out of the law."
STAYS_FITTED = "; coefficients freed of it foretell runs never fitted worse: they stay as they were."
"""What the sentence of a cause ends with that was refused; that of a step of the zero, which joins no law anyway."""


@dataclass(frozen=True, eq=False)
class Paid:
    """A law as it is judged on runs never fitted.

    Attributes
    ----------
    law : IdentifiedLaw
        The extended law, one by fewer causes, or the one before.
    stage : Stage
        With what joined that law.
    gain : Gain or None
    residuals : tuple of RunResidual
    out : frozenset of int
        Places of the causes that were named, but stay out of it.
    refused : Refused or None
        What the law by all of them would leave, where some stay out.
    """

    law: IdentifiedLaw
    stage: Stage
    gain: Gain | None
    residuals: tuple[RunResidual, ...]
    out: frozenset[int]
    refused: Refused | None = None


def paid(
    campaign: Campaign, seen: Campaign, rows: Sequence[RunRows], held: Sequence[RunRows], before: IdentifiedLaw,
    extended: IdentifiedLaw, course: Course, read: Mapping[str, RunRows], jumped: Sequence[JudgedStep],
) -> Paid:  # fmt: skip
    """Return the law by the causes that do not make it foretell worse.

    As long as it does, the cause without which it foretells best is taken out. What others than the drift told of is
    mended either way, and steps of the zero that runs for validation have are no word against a law.

    Parameters
    ----------
    campaign, seen : Campaign
        Whole, and without runs for validation that cannot be judged.
    rows, held : sequence of RunRows
        Runs for identification, and those for validation that are judged.
    before, extended : IdentifiedLaw
    course : Course
        In which the extended one was found.
    read : mapping of str to RunRows
        Runs that are in memory.
    jumped : sequence of JudgedStep
        Steps of the zero in runs for validation.
    """
    floor = extended_law(before, course.first)
    as_measured = floor is before and not jumped
    steady = {name: _without_steps(one, jumped) for name, one in read.items()}
    calm = [_without_steps(one, jumped) for one in held]

    def law_by(stage: Stage) -> IdentifiedLaw:
        law = extended_law(before, stage)  # repairs that the extended law ends with a run end with it here, too
        return replace(law, repairs=extended.repairs) if law.repairs else law

    @cache
    def measured(law: IdentifiedLaw) -> tuple[Gain | None, tuple[RunResidual, ...]]:
        return gained(before, law, seen, read), run_residuals(campaign, rows, held, before, law)

    def judge(law: IdentifiedLaw) -> Refused | None:
        gain, residuals = measured(law) if as_measured else (
            gained(floor, law, seen, steady), run_residuals(campaign, rows, calm, floor, law))  # fmt: skip
        return None if gain is None else Refused(gain, beside_constants(residuals, gain, before.zero))

    lost = judge(extended)
    if lost is None or not loses(lost):
        return Paid(extended, course.last, *measured(extended), frozenset())
    for out, stage in _fewer(course, lambda stage: gained(floor, law_by(stage), seen, steady)):
        law = law_by(stage)
        found = judge(law)
        if found is not None and not loses(found):
            return Paid(law, stage, *measured(law), out, lost)
    return Paid(floor, course.first, *measured(floor), frozenset(range(len(course.found))), lost)


def _without_steps(rows: RunRows, jumped: Sequence[JudgedStep]) -> RunRows:
    """Return a run without its steps of the zero."""
    since = rows.signals.time - rows.signals.time[0]
    steps = [one.size * (since >= one.time) for one in jumped if one.run == rows.run.name]
    return replace(rows, drift=rows.drift - np.sum(steps, axis=0)) if steps else rows


def _fewer(course: Course, gain_of: Callable[[Stage], Gain | None]) -> Iterator[tuple[frozenset[int], Stage]]:
    """Yield places of causes that stay out, one more each time, and the stage without them that foretells best.

    What joined after a repair was found in data that it mends: a repair is not taken out alone.
    """
    last = course.last
    joined = {item.trial.origin for item in last.joined}
    terms = {k for k, one in enumerate(course.found) if one.ranked.best.trial.origin in joined}
    out = frozenset[int]()

    def foretells(k: int) -> float:
        gain = gain_of(_without(last, course, out | {k}))
        return -math.inf if gain is None else gain.total.rmse_gain.value

    while left := sorted(terms - out):
        out |= {left[0] if len(left) == 1 else max(left, key=foretells)}
        yield out, _without(last, course, out)


def _without(last: Stage, course: Course, out: frozenset[int]) -> Stage:
    """Return the last stage without all terms of some causes."""
    gone = {course.found[k].ranked.best.trial.origin for k in out}
    return replace(last, joined=tuple(item for item in last.joined if item.trial.origin not in gone))


def loses(found: Refused) -> bool:
    """Return whether a law foretells runs worse, as measured; but for what first rows alone speak against.

    Where each run counts from its own first row, that row's noise shifts it: what is left beside a constant in each run
    is all that its rows tell of a law.
    """
    rises, beside = found.gain.total.rmse_gain.value < -NOTHING, found.beside
    if not rises or beside is None or beside.falls < beside.runs:
        return rises
    falls = 1.0 - beside.rmse_after / beside.rmse_before
    return not any(beside.runs >= runs and falls > least for runs, least in BORNE_OUT.items())


def kept_out(one: Effect) -> Effect:
    """Return a cause as it is told where it stays out of the law."""
    if not one.joined:
        return one
    end = STAYS_FITTED if one.cause == STEP else STAYS_OUT
    return replace(one, joined=False, refused=True, sentence=one.sentence.removesuffix(".") + end)
