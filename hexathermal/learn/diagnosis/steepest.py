"""How much more of a law's B than of its A is believed."""

from __future__ import annotations

import numpy as np

from hexathermal.learn.diagnosis.view import View
from hexathermal.poses import FloatArray

STEEPEST = 1.5
"""Largest B over A that is believed: a scale that is off makes B look as large as it likes."""


def believed(view: View, A: FloatArray, B: FloatArray) -> FloatArray:
    """Return what is believed of a law's B: of a leg no more than `STEEPEST` times A; C of a part has no such length.

    Parameters
    ----------
    view : View
    A, B : array, shape (k,)
        Of a leg [1/K]; C [m/K] and D [1/K] of another part.
    """
    return np.clip(B, -STEEPEST * np.abs(A), STEEPEST * np.abs(A)) if view.kind == "leg" else B
