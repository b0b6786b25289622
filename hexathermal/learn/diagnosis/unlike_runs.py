"""Runs never fitted in which the law leaves far more than it does in those that it was fitted on: something is new."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Protocol

from hexathermal.poses import FloatArray

UM = 1e6

FAR = 2.0
"""What the law leaves of a run never fitted, standard deviation, over the most of any that was fitted. Of 86 simulated
campaigns, hidden effects named or not, the largest was 1.53; of three in which a fault begins only in the runs for
validation the least was 3.3."""


class Left(Protocol):
    """What a law leaves of a run, as `hexathermal.learn.diagnosis.result.RunResidual` tells it."""

    @property
    def run(self) -> str:
        """Its name."""
        ...

    @property
    def role(self) -> str:
        """``"identification"`` or ``"validation"``."""
        ...

    @property
    def after(self) -> FloatArray:
        """Residuals of the extended law in windows [m], shape (w,)."""
        ...


def unlike_words(residuals: Sequence[Left], told: Collection[str] = ()) -> tuple[str, ...]:
    """Return in a sentence which runs are unlike those that the law knows; nothing where none is.

    Parameters
    ----------
    residuals : sequence
        Of all runs.
    told : collection of str
        Runs of which it is told otherwise what is new in them.
    """
    left = {one.run: float(one.after.std()) for one in residuals}
    fitted = [left[one.run] for one in residuals if one.role == "identification"]
    most = max(fitted, default=0.0)
    unlike = [one.run for one in residuals
              if one.role != "identification" and one.run not in told and left[one.run] > FAR * most > 0.0]  # fmt: skip
    if not unlike:
        return ()
    worst = max(left[name] for name in unlike)
    return (
        f"In {', '.join(unlike)}, never fitted, the law leaves up to {worst * UM:.2g} um (standard deviation), against "
        f"{most * UM:.2g} um at most in runs that it was fitted on: something is new there, which those for "
        'identification do not show. Give such a run the role "identification", and diagnose again.',
    )
