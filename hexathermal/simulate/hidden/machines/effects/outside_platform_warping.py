"""The platform warps slowly, by something that nobody records: its joints rise and sink in turn."""

from __future__ import annotations

import numpy as np

from hexathermal.simulate.bench.thermocouples import slow_process
from hexathermal.simulate.hidden.effect import Parameters
from hexathermal.simulate.hidden.machines.effect import MachineEffect, add
from hexathermal.simulate.hidden.machines.truth import MachineTruth
from hexathermal.simulate.hidden.shapes import log_uniform


def draw(truth: MachineTruth, generator: np.random.Generator) -> Parameters:
    """Draw how far joints move [m], how soon it is otherwise [s], and the seed of the course."""
    return {"size": 1e-6, "time": log_uniform(3600.0, 14400.0, generator), "seed": int(generator.integers(2**32))}


def hide(truth: MachineTruth, parameters: Parameters) -> MachineTruth:
    """Move the joints along the platform's axis, every other one up."""
    generator = np.random.default_rng(int(parameters["seed"]))
    course = slow_process(truth.all("time"), float(parameters["time"]), 1, generator)
    way = np.zeros((6, 3))
    way[:, 2] = [1.0, 1.0, -1.0, -1.0, 1.0, -1.0]
    return add(truth, "platform_bend", float(parameters["size"]) * course[:, :, None] * way)


EFFECT = MachineEffect("outside: platform warping", draw, hide, amplitude="size", limits=(1e-10, 1e-2))
