"""What an effect on a whole hexapod is, and how it changes legs, joints and what is measured."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.effect import HiddenEffect
from hexathermal.simulate.hidden.machines.truth import MachineRunTruth, MachineTruth

MachineEffect: TypeAlias = HiddenEffect[MachineTruth]
"""An effect on a hexapod; its ``target``, where it has one: ``leg3``, ``leg2+leg5``, ``platform``, ``base joint 4``."""


def draw_leg(generator: np.random.Generator) -> str:
    """Return a leg: ``leg1`` to ``leg6``."""
    return f"leg{int(generator.integers(1, 7))}"


def number_of(part: str) -> int:
    """Return the number, from 0, at the end of a part's name.

    Examples
    --------
    >>> number_of("leg3"), number_of("base joint 6")
    (2, 5)
    """
    return int(part[-1]) - 1


def draw_direction(generator: np.random.Generator) -> FloatArray:
    """Return a unit vector, shape (3,)."""
    found = generator.standard_normal(3)
    return np.asarray(found / np.linalg.norm(found))


def stretch_leg(truth: MachineTruth, leg: str, longer: FloatArray) -> MachineTruth:
    """Return the campaign with a leg longer by so much in all rows, run behind run, shape (n,) [m]."""
    column = np.zeros((longer.size, 6))
    column[:, number_of(leg)] = longer
    return add(truth, "stretch", column)


def add(truth: MachineTruth, field: str, values: FloatArray) -> MachineTruth:
    """Return the campaign with values of all rows, run behind run, added to a field of its runs."""
    ends = np.cumsum([run.time.size for run in truth.runs])[:-1]
    parts = zip(truth.runs, np.split(values, ends), strict=True)
    return truth.changed(runs=tuple(run.changed(**{field: getattr(run, field) + part}) for run, part in parts))


def each_run(truth: MachineTruth, values_of: Callable[[MachineRunTruth], FloatArray]) -> FloatArray:
    """Return values of all runs, one behind the other."""
    return np.concatenate([values_of(run) for run in truth.runs])
