"""Somebody knocks against the tracker: it moves at once and creeps back within the hour."""

from __future__ import annotations

import numpy as np

from hexathermal.simulate.hidden.effect import Parameters
from hexathermal.simulate.hidden.machines.effect import MachineEffect, add, draw_direction
from hexathermal.simulate.hidden.machines.truth import MachineTruth


def draw(truth: MachineTruth, generator: np.random.Generator) -> Parameters:
    """Draw when, how soon it is back [s], and the direction."""
    runs = [run for run in truth.runs if run.role == "identification"]
    run = runs[int(generator.integers(len(runs)))]
    shift, turn = draw_direction(generator), draw_direction(generator)
    return {
        "size": 3e-6, "back": float(generator.uniform(900.0, 3600.0)),
        "at": float(run.time[0] + generator.uniform(0.1, 0.7) * np.ptp(run.time)),
        **{name: float(value) for name, value in zip("xyz", shift, strict=True)},
        **{f"r{name}": float(value) for name, value in zip("xyz", turn, strict=True)},
    }  # fmt: skip


def hide(truth: MachineTruth, parameters: Parameters) -> MachineTruth:
    """Move what is measured."""
    since = truth.all("time") - float(parameters["at"])
    left = np.where(since >= 0.0, np.exp(-np.maximum(since, 0.0) / float(parameters["back"])), 0.0)
    six = np.array([float(parameters[name]) for name in ("x", "y", "z", "rx", "ry", "rz")])
    return add(truth, "moved", float(parameters["size"]) * np.outer(left, six))


EFFECT = MachineEffect("outside: knock", draw, hide, amplitude="size", limits=(1e-9, 1e-2))
