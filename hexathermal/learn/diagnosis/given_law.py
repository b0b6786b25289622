"""A law that was given to a diagnosis, against the same law with coefficients that were fitted anew.

What a diagnosis tells of causes is told beside coefficients of the campaign's own runs, since a cause biases them. What
those of another campaign leave besides is theirs, and no cause's gain.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hexathermal.learn.campaign import Campaign
from hexathermal.learn.diagnosis.as_json import UM, ends_of
from hexathermal.learn.law import IdentifiedLaw
from hexathermal.learn.validation_gain import Gain

SAME_LENGTH = 1e-4
"""Retracted lengths that differ by no more are those of one leg [m]."""


@dataclass(frozen=True, eq=False)
class Given:
    """A law as it was given.

    Attributes
    ----------
    law : IdentifiedLaw
    gain : Gain or None
        Of the same law fitted anew over it, on runs never fitted; None where there are none.
    """

    law: IdentifiedLaw
    gain: Gain | None

    @property
    def wrong(self) -> bool:
        """Whether its coefficients leave more than those fitted anew, beyond doubt."""
        return self.gain is not None and self.gain.proven

    @property
    def words(self) -> tuple[str, ...]:
        """In a sentence that its coefficients do not fit these data; empty where they may."""
        if self.gain is None or not self.wrong:
            return ()
        total = self.gain.total
        return (
            "The coefficients of the law as it was given do not fit these data: on runs never fitted they leave an "
            f"RMSE of {total.rmse_before * UM:.3f} um, those fitted anew {total.rmse_after.value * UM:.3f} um; all "
            "that is told here is told beside those.",
        )

    def to_json(self) -> dict[str, Any] | None:
        """Return both RMSEs, the gain with its 95 % interval, and the words; None without runs never fitted."""
        if self.gain is None:
            return None
        total = self.gain.total
        return {"rmse_um": total.rmse_before * UM, "rmse_refitted_um": total.rmse_after.value * UM,
                "rmse_gain": total.rmse_gain.value, "rmse_gain_95": ends_of(total.rmse_gain),
                "sentence": " ".join(self.words)}  # fmt: skip


def of_another_form(law: IdentifiedLaw | None, base: IdentifiedLaw) -> list[str]:
    """Return that a law that was given does not read where a part stands, as these data ask for, or the reverse."""
    if law is None or law.stroked == base.stroked:
        return []
    forms = {True: "C dT + D q dT", False: "C dT"}
    return [
        f"the law that was given is {forms[law.stroked]}, these data speak for {forms[base.stroked]}: all that is told "
        "here is told beside that form"
    ]


def of_another_leg(law: IdentifiedLaw | None, campaign: Campaign) -> list[str]:
    """Return that a law that was given is of a leg of another length than the campaign's."""
    if law is None or law.retracted_length is None or campaign.leg is None:
        return []
    own = campaign.leg.retracted_length
    if abs(law.retracted_length - own) <= SAME_LENGTH:
        return []
    return [
        f"the law that was given is of a leg with q0 = {law.retracted_length * 1e3:g} mm, this campaign's has "
        f"{own * 1e3:g} mm: its sensors are taken, what its coefficients leave is those of another leg"
    ]
