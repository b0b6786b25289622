"""Friction in all joints: every leg is held back by the way it came, each by its own share."""

from __future__ import annotations

import numpy as np

from hexathermal.simulate.hidden.effect import Parameters
from hexathermal.simulate.hidden.machines.effect import MachineEffect, add
from hexathermal.simulate.hidden.machines.truth import MachineTruth
from hexathermal.simulate.hidden.shapes import play_of_many


def draw(truth: MachineTruth, generator: np.random.Generator) -> Parameters:
    """Draw by how much legs are held back [m], within which way [m], and the seed of the shares."""
    return {"size": 1e-6, "way": float(generator.uniform(1e-4, 1e-3)), "seed": int(generator.integers(2**32))}


def hide(truth: MachineTruth, parameters: Parameters) -> MachineTruth:
    """Make each leg shorter or longer by where it came from."""
    shares = np.random.default_rng(int(parameters["seed"])).uniform(0.6, 1.4, 6)
    held = [
        share * play_of_many(q, float(parameters["way"]), 0.0)
        for share, q in zip(shares, truth.all("q").T, strict=True)
    ]
    return add(truth, "stretch", float(parameters["size"]) * np.column_stack(held))


EFFECT = MachineEffect("outside: friction", draw, hide, amplitude="size", limits=(1e-10, 1e-3))
