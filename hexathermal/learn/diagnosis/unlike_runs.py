"""Runs never fitted in which the law leaves far more than it does in those that it was fitted on: something is new."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Protocol

import numpy as np

from hexathermal.poses import FloatArray

UM = 1e6

FAR = 2.0
"""What the law leaves of a run never fitted, standard deviation, over the most of any that was fitted. Of 86 simulated
campaigns, hidden effects named or not, the largest was 1.53; of three in which a fault begins only in the runs for
validation the least was 3.3."""

FARTHER = 1.25
"""How far the law's first thermometer goes in such a run, over the farthest of any that was fitted, from which on the
law may not reach there: its coefficients are as uncertain as they are, times that."""


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

    @property
    def signals(self) -> Mapping[str, FloatArray]:
        """In windows, shape (w,): ``dT`` of the law's first thermometer [K], and others."""
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
    fitted = [one for one in residuals if one.role == "identification"]
    judged = [one for one in residuals if one.role != "identification"]
    most = max((float(one.after.std()) for one in fitted), default=0.0)
    unlike = [one for one in judged if one.run not in told and float(one.after.std()) > FAR * most > 0.0]
    if not unlike:
        return ()
    worst = max(float(one.after.std()) for one in unlike)
    far, known = (max(float(np.abs(one.signals["dT"]).max()) for one in runs) for runs in (unlike, fitted))
    why = "something is new there, which the runs for identification do not show"
    if far > FARTHER * known:
        why = (
            f"something is new there, or the law does not reach so far: its first thermometer goes {far:.2g} K from "
            f"its zero there, {known:.2g} K at most in those"
        )
    advice = (
        'Give one of them the role "identification" and diagnose again: the others still judge'
        if len(judged) > 1
        else "Measure such a run again, to fit the one and judge by the other"
    )
    return (
        f"In {', '.join(one.run for one in unlike)}, never fitted, the law leaves up to {worst * UM:.2g} um (standard "
        f"deviation), against {most * UM:.2g} um at most in runs that it was fitted on: {why}. {advice}.",
    )
