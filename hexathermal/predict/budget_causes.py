"""Which causes the expected error of a machine comes from: its plates, gradients across them, its legs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.thermal import frozen
from hexathermal.poses import FloatArray
from hexathermal.predict.budget_inputs import Situation
from hexathermal.predict.budget_plates import PARTS
from hexathermal.predict.temperatures import active_model

NO_CAUSE = 1e-12
"""An error [m, rad] below rounding of kinematics."""


def cause_steps(hexapod: Hexapod, plates: FloatArray, correction: bool) -> list[tuple[str, FloatArray, float]]:
    """Return causes in the order in which they are taken away, each with the plates (2, 8) and the load then left.

    Gradients across the plates, the expansion of plates that is not corrected, the sag under a payload that is not.
    """
    model, rows = active_model(hexapod), plates.copy()
    steps: list[tuple[str, FloatArray, float]] = []
    for k, part in enumerate(PARTS):
        if rows[k, 0] and rows[k, 2:5].any():
            rows[k, 2:5] = 0.0
            steps.append((f"gradient across the {part}", rows.copy(), 1.0))
    for k, part in enumerate(PARTS):
        plate = getattr(model, part)
        blind = plate is not None and plate.sensor is None
        if plate is not None and (blind or not correction):
            rows[k, 1 if blind else 0] = 0.0
            steps.append((f"expansion of the {part}", rows.copy(), 1.0))
    if hexapod.compliance is not None and not correction:
        steps.append(("sag under the payload", rows.copy(), 0.0))
    return steps


def parts_of_bias(names: Sequence[str], errors: FloatArray, correction: bool) -> tuple[tuple[str, ...], FloatArray]:
    """Return causes and their parts (c, 6), which add up to the expected error.

    Parameters
    ----------
    names : sequence of str
        Of `cause_steps`.
    errors : array, shape (names + 1, 6)
        Expected error, and what is left of it after each step: at the end that of the legs, or, where corrected
        lengths are commanded, nothing.
    correction : bool
    """
    left = errors[-1]
    if correction and np.abs(left).max() <= NO_CAUSE:
        return tuple(names), frozen(errors[:-1] - errors[1:])
    rest = "corrections that are not exact" if correction else "expansion of the legs"
    return (*names, rest), frozen(np.concatenate([errors[:-1] - errors[1:], left[None]]))


def bias_causes(here: Situation) -> tuple[tuple[str, ...], FloatArray]:
    """Return the causes of a situation's expected error, and their parts (c, 6), which add up to it."""
    steps = cause_steps(here.hexapod, here.plates, here.correction)
    errors = [here.errors(), *(replace(here, plates=rows).errors(load=load) for _name, rows, load in steps)]
    return parts_of_bias([name for name, _rows, _load in steps], np.concatenate(errors), here.correction)
