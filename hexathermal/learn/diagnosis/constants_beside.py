"""What a law leaves of runs beside a constant in each: a run counts from its first row, whose noise shifts it all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from hexathermal.learn.diagnosis.result import RunResidual
    from hexathermal.learn.validation_gain import Gain


@dataclass(frozen=True)
class BesideConstants:
    """RMSE of means over minutes beside a constant in each run, before and after a law was extended [m].

    Attributes
    ----------
    rmse_before, rmse_after : float [m]
    falls, runs : int
        In how many of how many runs it falls.
    """

    rmse_before: float
    rmse_after: float
    falls: int
    runs: int

    def to_json(self) -> dict[str, Any]:
        """Return it as plain values."""
        return {"rmse_before_um": self.rmse_before * 1e6, "rmse_after_um": self.rmse_after * 1e6,
                "runs_that_fall": self.falls, "runs": self.runs}  # fmt: skip


def beside_constants(residuals: Sequence[RunResidual], gain: Gain | None, zero: str) -> BesideConstants | None:
    """Return what is left of judged runs beside a constant in each; None where no run counts from its own first row.

    Parameters
    ----------
    residuals : sequence of RunResidual
    gain : Gain or None
        Of which the runs were judged.
    zero : str
        From what runs count, see `Campaign.zero`.
    """
    judged = [] if gain is None else [one for one in residuals if one.role == "validation" and one.run in gain.runs]
    if zero != "run" or not judged:
        return None
    spreads = np.array([(one.before.std(), one.after.std()) for one in judged])
    weights = np.array([len(one.before) for one in judged])
    before, after = np.sqrt(np.average(spreads**2, axis=0, weights=weights)).tolist()
    return BesideConstants(before, after, int((spreads[:, 1] < spreads[:, 0]).sum()), len(judged))
