"""Whether an extended law pays on runs never fitted: what foretells them worse stays out of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

from hexathermal.learn.campaign import Campaign
from hexathermal.learn.diagnosis.constants_beside import beside_constants
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
    gain, residuals = gained(before, extended, seen, read), run_residuals(campaign, rows, held, before, extended)
    if gain is None or sure or not loses(gain):
        return Paid(extended, course.last, gain, residuals, frozenset())
    refused = Refused(gain, beside_constants(residuals, gain, before.zero))
    judge = partial(gained, before, campaign=seen, read=read)
    out, stage = _taken_out(course, before, judge)
    law = before if stage is None else extended_law(before, stage)
    left = run_residuals(campaign, rows, held, before, law)
    return Paid(law, stage or course.first, judge(law), left, out, refused)


def _taken_out(
    course: Course, before: IdentifiedLaw, judge: Callable[[IdentifiedLaw], Gain | None]
) -> tuple[frozenset[int], Stage | None]:
    """Return places of causes that stay out, and the stage without them; None where nothing pays.

    What joined after a repair was found in data that it mends: a repair is not taken out alone.
    """
    last = course.last
    terms = [k for k, one in enumerate(course.found) if any(item is one.ranked.best for item in last.joined)]
    out = frozenset[int]()
    while len(out) < len(terms):
        tried = []
        for k in terms:
            if k not in out:
                stage = _without(last, course, out | {k})
                gain = judge(extended_law(before, stage))
                assert gain is not None  # there are runs for validation: the law by all causes was judged on them
                tried.append((gain, k, stage))
        gain, k, stage = max(tried, key=lambda one: one[0].total.rmse_gain.value)
        out |= {k}
        if not loses(gain):
            return out, stage
    return frozenset(range(len(course.found))), None


def _without(last: Stage, course: Course, out: frozenset[int]) -> Stage:
    """Return the last stage without the terms of some causes."""
    gone = [course.found[k].ranked.best for k in out]
    return replace(last, joined=tuple(item for item in last.joined if not any(item is one for one in gone)))


def loses(gain: Gain) -> bool:
    """Return whether a law foretells runs worse, by their RMSE as measured."""
    return gain.total.rmse_gain.value < -NOTHING


def kept_out(one: Effect) -> Effect:
    """Return a cause as it is told where it stays out of the law."""
    if not one.joined:
        return one
    return replace(one, joined=False, refused=True, sentence=one.sentence.removesuffix(".") + STAYS_OUT)
