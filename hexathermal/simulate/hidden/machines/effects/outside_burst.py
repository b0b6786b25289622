"""The tracker is noisier for a while: people walk through its beams."""

from __future__ import annotations

import numpy as np

from hexathermal.simulate.hidden.effect import Parameters
from hexathermal.simulate.hidden.machines.effect import MachineEffect, add
from hexathermal.simulate.hidden.machines.truth import MachineTruth


def draw(truth: MachineTruth, generator: np.random.Generator) -> Parameters:
    """Draw how many times the usual noise is added, in which part of each run, and the seed of what is added."""
    begin = float(generator.uniform(0.0, 0.7))
    return {"times": 2.0, "begin": begin, "end": begin + float(generator.uniform(0.1, 0.3)),
            "seed": int(generator.integers(2**32))}  # fmt: skip


def hide(truth: MachineTruth, parameters: Parameters) -> MachineTruth:
    """Add the noise."""
    generator = np.random.default_rng(int(parameters["seed"]))
    place = np.concatenate([(run.time - run.time[0]) / np.ptp(run.time) for run in truth.runs])
    now = (place >= float(parameters["begin"])) & (place < float(parameters["end"]))
    more = float(parameters["times"]) * truth.levels * generator.standard_normal((place.size, 6))
    return add(truth, "moved", np.where(now[:, None], more, 0.0))


EFFECT = MachineEffect("outside: burst", draw, hide, amplitude="times", limits=(1e-3, 1e3))
