"""Which causes the expected error of a machine comes from: its plates, gradients across them, its legs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hexathermal.machine.thermal import frozen
from hexathermal.poses import FloatArray
from hexathermal.predict.budget_inputs import Situation
from hexathermal.predict.budget_plates import PARTS
from hexathermal.predict.temperatures import active_model

NO_CAUSE = 1e-12
"""An error [m, rad] below rounding of kinematics."""


def bias_causes(here: Situation) -> tuple[tuple[str, ...], FloatArray]:
    """Return the causes of a situation's expected error, and their parts (c, 6), which add up to it.

    Causes are taken away one after the other: gradients across the plates, then the expansion of plates that is not
    corrected; what is left is that of the legs, or, where corrected lengths are commanded, nothing.
    """
    model, rows = active_model(here.hexapod), here.plates.copy()
    left = here.errors()[0]
    names: list[str] = []
    parts: list[FloatArray] = []

    def take(name: str) -> None:
        nonlocal left
        less = replace(here, plates=rows.copy()).errors()[0]
        names.append(name)
        parts.append(left - less)
        left = less

    for k, part in enumerate(PARTS):
        if rows[k, 0] and rows[k, 2:5].any():
            rows[k, 2:5] = 0.0
            take(f"gradient across the {part}")
    for k, part in enumerate(PARTS):
        plate = getattr(model, part)
        blind = plate is not None and plate.sensor is None
        if plate is not None and (blind or not here.correction):
            rows[k, 1 if blind else 0] = 0.0
            take(f"expansion of the {part}")
    if not here.correction or np.abs(left).max() > NO_CAUSE:
        names.append("corrections that are not exact" if here.correction else "expansion of the legs")
        parts.append(left)
    return tuple(names), frozen(np.array(parts).reshape(-1, 6))
