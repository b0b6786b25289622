"""What a law would leave of runs never fitted with causes that therefore stay out of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hexathermal.learn.diagnosis.as_json import gained_facts
from hexathermal.learn.diagnosis.constants_beside import BesideConstants
from hexathermal.learn.validation_gain import Gain


@dataclass(frozen=True, eq=False)
class Refused:
    """What a law would gain on runs for validation with all that was named.

    Attributes
    ----------
    gain : Gain
        As measured: below zero.
    beside : BesideConstants or None
        The same beside a constant in each run, where each counts from its own first row.
    """

    gain: Gain
    beside: BesideConstants | None

    @property
    def better_beside(self) -> bool:
        """Whether it would pay beside a constant in each run: then the noise of first rows may have refused it."""
        return self.beside is not None and self.beside.rmse_after < self.beside.rmse_before

    def to_json(self) -> dict[str, Any]:
        """Return it as plain values."""
        return {**gained_facts(self.gain.total), "beside_constants": self.beside and self.beside.to_json()}
