"""Whether an extended law pays on runs never fitted: what foretells them worse stays out of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

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
    kept : int
        How many of the causes that were named, in their order, stay in it.
    refused : Refused or None
        What the law by all of them would leave, where some stay out.
    """

    law: IdentifiedLaw
    stage: Stage
    gain: Gain | None
    residuals: tuple[RunResidual, ...]
    kept: int
    refused: Refused | None = None


def paid(
    campaign: Campaign, seen: Campaign, rows: Sequence[RunRows], held: Sequence[RunRows], before: IdentifiedLaw,
    extended: IdentifiedLaw, course: Course, read: Mapping[str, RunRows], *, sure: bool,
) -> Paid:  # fmt: skip
    """Return the law by as many of the causes, in the order in which they were named, as do not make it foretell worse.

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
    count = len(course.found)
    gain, residuals = gained(before, extended, seen, read), run_residuals(campaign, rows, held, before, extended)
    if gain is None or sure or not loses(gain):
        return Paid(extended, course.last, gain, residuals, count)
    refused = Refused(gain, beside_constants(residuals, gain, before.zero))
    kept, stage, law, gain = next(one for one in _laws(course, before, seen, read) if not loses(one[-1]))
    return Paid(law, stage, gain, run_residuals(campaign, rows, held, before, law), kept, refused)


def _laws(
    course: Course, before: IdentifiedLaw, seen: Campaign, read: Mapping[str, RunRows]
) -> Iterator[tuple[int, Stage, IdentifiedLaw, Gain]]:
    """Yield laws by fewer causes each time, the one before at the end, and what they gain."""
    for kept, stage in _fewer(course):
        law = extended_law(before, stage)
        gain = gained(before, law, seen, read)
        assert gain is not None  # there are runs for validation: the law by all causes was judged on them
        yield kept, stage, law, gain
    gain = gained(before, before, seen, read)
    assert gain is not None
    yield 0, course.first, before, gain


def _fewer(course: Course) -> Iterator[tuple[int, Stage]]:
    """Yield how many causes stay, and the last stage without the terms of the others, fewer each time.

    What joined after a repair was found in data that it mends: a repair is not taken out alone.
    """
    last = course.last
    for kept in range(len(course.found) - 1, 0, -1):
        out = [one.ranked.best for one in course.found[kept:]]
        joined = tuple(item for item in last.joined if not any(item is one for one in out))
        if any(one.trial.repair is not None for one in out):
            return
        if len(joined) < len(last.joined) and (joined or last.repairs):
            yield kept, replace(last, joined=joined)


def loses(gain: Gain) -> bool:
    """Return whether a law foretells runs worse, by their RMSE as measured."""
    return gain.total.rmse_gain.value < -NOTHING


def kept_out(one: Effect) -> Effect:
    """Return a cause as it is told where it stays out of the law."""
    if not one.joined:
        return one
    return replace(one, joined=False, refused=True, sentence=one.sentence.removesuffix(".") + STAYS_OUT)
