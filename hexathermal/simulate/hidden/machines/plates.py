"""Plates that grow otherwise than their file says."""

from __future__ import annotations

import numpy as np

from hexathermal.simulate.hidden.effect import Parameters
from hexathermal.simulate.hidden.machines.truth import MachineTruth
from hexathermal.simulate.hidden.shapes import either_sign

PLATES = ("platform", "base")


def draw_growth(part: str, truth: MachineTruth, generator: np.random.Generator) -> Parameters:
    """Draw by how much a plate's expansion differs from its file's [1/K]: another lot of steel, or another metal."""
    sign = 1.0 if generator.random() < 0.75 else either_sign(generator)
    return {"target": part, "expansion": sign * 2e-6}


def plate_recorded(part: str, truth: MachineTruth) -> bool:
    """Return whether a plate's temperature is recorded: nothing else tells of its growth."""
    return truth.plates_recorded[PLATES.index(part)]


def grow(truth: MachineTruth, parameters: Parameters) -> MachineTruth:
    """Add to the expansion of the plate."""
    expansions = truth.expansions.copy()
    expansions[PLATES.index(str(parameters["target"]))] += float(parameters["expansion"])
    return truth.changed(expansions=expansions)
