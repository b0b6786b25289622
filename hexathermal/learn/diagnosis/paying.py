"""Whether an extended law pays on runs never fitted: what foretells them worse stays out of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from hexathermal.learn.campaign import Campaign
from hexathermal.learn.diagnosis.constants_beside import BesideConstants, beside_constants
from hexathermal.learn.diagnosis.course import Course
from hexathermal.learn.diagnosis.extension import extended_law, gained
from hexathermal.learn.diagnosis.refused import Refused
from hexathermal.learn.diagnosis.residuals import run_residuals
from hexathermal.learn.diagnosis.result import Effect, RunResidual
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.law import IdentifiedLaw
from hexathermal.learn.signals import RunRows
from hexathermal.learn.validation_gain import Gain

NOTHING = 1e-9
"""Part by which the RMSE on runs never fitted may rise by rounding alone."""

BORNE_OUT, FEWEST_BEARING = 0.05, 3
"""A rise as measured is of first rows alone where the RMSE beside a constant in each run falls by this part, in each of
so many runs or more."""

STAYS_OUT = "; runs never fitted are foretold worse with it: it stays out of the law."
"""What the sentence of a cause ends with that was refused."""


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
    extended: IdentifiedLaw, course: Course, read: Mapping[str, RunRows], *, sure: bool,
) -> Paid:  # fmt: skip
    """Return the law by the causes that do not make it foretell worse.

    As long as it does, the term without which it foretells best is taken out.

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
    sure : bool
        Whether others than the drift told of what is mended: then no drift refuses it.
    """

    def judge(law: IdentifiedLaw) -> tuple[Gain | None, tuple[RunResidual, ...], BesideConstants | None]:
        gain, residuals = gained(before, law, seen, read), run_residuals(campaign, rows, held, before, law)
        return gain, residuals, beside_constants(residuals, gain, before.zero)

    gain, residuals, beside = judge(extended)
    if gain is None or sure or not loses(gain, beside):
        return Paid(extended, course.last, gain, residuals, frozenset())
    refused = Refused(gain, beside)
    for out, stage in _fewer(course, lambda stage: judge(extended_law(before, stage))[0]):
        law = extended_law(before, stage)
        gain, residuals, beside = judge(law)
        if gain is not None and not loses(gain, beside):
            return Paid(law, stage, gain, residuals, out, refused)
    gain, residuals, _ = judge(before)
    return Paid(before, course.first, gain, residuals, frozenset(range(len(course.found))), refused)


def _fewer(course: Course, judge: Callable[[Stage], Gain | None]) -> Iterator[tuple[frozenset[int], Stage]]:
    """Yield places of causes that stay out, one more each time, and the stage without them that foretells best.

    What joined after a repair was found in data that it mends: a repair is not taken out alone.
    """
    last = course.last
    terms = {k for k, one in enumerate(course.found) if any(item is one.ranked.best for item in last.joined)}
    out = frozenset[int]()

    def foretells(k: int) -> float:
        gain = judge(_without(last, course, out | {k}))
        return -math.inf if gain is None else gain.total.rmse_gain.value

    while left := sorted(terms - out):
        out |= {left[0] if len(left) == 1 else max(left, key=foretells)}
        yield out, _without(last, course, out)


def _without(last: Stage, course: Course, out: frozenset[int]) -> Stage:
    """Return the last stage without the terms of some causes."""
    gone = [course.found[k].ranked.best for k in out]
    return replace(last, joined=tuple(item for item in last.joined if not any(item is one for one in gone)))


def loses(gain: Gain, beside: BesideConstants | None) -> bool:
    """Return whether a law foretells runs worse, as measured; but for what first rows alone speak against.

    Where each run counts from its own first row, that row's noise shifts it: what is left beside a constant in each run
    is all that its rows tell of a law.
    """
    return gain.total.rmse_gain.value < -NOTHING and not (
        beside is not None
        and beside.falls == beside.runs >= FEWEST_BEARING
        and beside.rmse_after < (1.0 - BORNE_OUT) * beside.rmse_before
    )


def kept_out(one: Effect) -> Effect:
    """Return a cause as it is told where it stays out of the law."""
    if not one.joined:
        return one
    return replace(one, joined=False, refused=True, sentence=one.sentence.removesuffix(".") + STAYS_OUT)
