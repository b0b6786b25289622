"""Whether an extended law pays on runs never fitted: one that foretells them worse is not made."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from hexathermal.learn.campaign import Campaign
from hexathermal.learn.diagnosis.constants_beside import BesideConstants, beside_constants
from hexathermal.learn.diagnosis.extension import gained
from hexathermal.learn.diagnosis.residuals import run_residuals
from hexathermal.learn.diagnosis.result import Effect, RunResidual
from hexathermal.learn.law import IdentifiedLaw
from hexathermal.learn.signals import RunRows
from hexathermal.learn.validation_gain import Gain

LOSS = 0.02
"""Part by which the RMSE must rise beside what shifts a run as a whole: less says nothing."""

STAYS_OUT = "; runs never fitted are foretold worse with it: it stays out of the law."
"""What the sentence of a cause ends with that was refused."""


@dataclass(frozen=True, eq=False)
class Paid:
    """A law as it is judged on runs never fitted.

    Attributes
    ----------
    law : IdentifiedLaw
        The extended law, or the one before where the extended one is refused.
    gain : Gain or None
    residuals : tuple of RunResidual
    refused : Gain or None
        Of an extended law that was refused.
    """

    law: IdentifiedLaw
    gain: Gain | None
    residuals: tuple[RunResidual, ...]
    refused: Gain | None = None


def paid(
    campaign: Campaign, seen: Campaign, rows: Sequence[RunRows], held: Sequence[RunRows], before: IdentifiedLaw,
    extended: IdentifiedLaw, read: Mapping[str, RunRows], *, sure: bool,
) -> Paid:  # fmt: skip
    """Return the extended law, with its gain and what it leaves; the law before where the extended one does not pay.

    Parameters
    ----------
    campaign, seen : Campaign
        Whole, and without runs for validation that cannot be judged.
    rows, held : sequence of RunRows
        Runs for identification, and those for validation that are judged.
    before, extended : IdentifiedLaw
    read : mapping of str to RunRows
        Runs that are in memory.
    sure : bool
        Whether others than the drift told of what is mended: then no drift refuses it.
    """
    gain, residuals = gained(before, extended, seen, read), run_residuals(campaign, rows, held, before, extended)
    if gain is None or sure or not loses(gain, beside_constants(residuals, gain, before.zero)):
        return Paid(extended, gain, residuals)
    plain = run_residuals(campaign, rows, held, before, before)
    return Paid(before, gained(before, before, seen, read), plain, gain)


def loses(gain: Gain, beside: BesideConstants | None) -> bool:
    """Return whether a law foretells runs worse, as measured and beside a constant in each run where that is told.

    As measured alone it is not believed where each run counts from its own first row: that row's noise shifts the run,
    and laws nearer to the truth lose by it as often as they gain.
    """
    lost = -gain.total.rmse_gain.value
    if beside is None:
        return lost > LOSS
    return lost > 0.0 and beside.rmse_after > (1.0 + LOSS) * beside.rmse_before


def kept_out(one: Effect) -> Effect:
    """Return a cause as it is told where its law was refused."""
    if not one.joined:
        return one
    return replace(one, joined=False, refused=True, sentence=one.sentence.removesuffix(".") + STAYS_OUT)
