"""Where each quantity that may be off stands among all the numbers of a machine, and what a source makes of them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray
from hexathermal.predict.sources import Source
from hexathermal.predict.temperatures import active_model

LOAD_SIZE = 10
"""Numbers of a machine with a payload that may be off: compliances of six legs, mass, centre of mass."""


def sensor_counts(hexapod: Hexapod) -> tuple[int, int]:
    """Return the number of sensors, and of those on legs."""
    model = active_model(hexapod)
    return len(model.sensor_names), sum(len(law.sensors) for law in model.legs)


def deviation_size(hexapod: Hexapod) -> int:
    """Return how many numbers of a machine may be off."""
    n, m = sensor_counts(hexapod)
    return 3 * n + 2 * m + 65 + sum(amplitude_counts(hexapod)) + LOAD_SIZE * (hexapod.compliance is not None)


def amplitude_counts(hexapod: Hexapod) -> list[int]:
    """Return how many amplitudes the terms of each leg's law have."""
    return [sum(len(term.amplitudes) for term in law.terms) for law in active_model(hexapod).legs]


def blocks(hexapod: Hexapod, quantity: str) -> tuple[npt.NDArray[np.int64], int, int]:
    """Return where a quantity's numbers stand in a deviation, in how many groups, and how many a group has."""
    n, m = sensor_counts(hexapod)
    after = 3 * n + 2 * m
    simple = {
        "temperature": (0, n, 1), "gain": (n, n, 1), "contact": (2 * n, n, 1), "growth": (after, 6, 1),
        "length": (after + 6, 6, 1), "scale": (after + 12, 6, 1), "base joints": (after + 18, 6, 3),
        "platform joints": (after + 36, 6, 3), "plate expansion": (after + 54, 2, 1),
        "plate temperature": (after + 56, 2, 1), "plate gradient": (after + 58, 2, 3),
        "reference temperature": (after + 64, 1, 1),
    }  # fmt: skip
    if quantity in simple:
        first, groups, width = simple[quantity]
        return np.arange(first, first + groups * width), groups, width
    if quantity == "amplitudes":
        counts, first = amplitude_counts(hexapod), after + 65
        alike = len(set(counts)) == 1
        return np.arange(first, first + sum(counts)), 6 if alike else 1, counts[0] if alike else sum(counts)
    load = {"compliance": (0, 6, 1), "payload mass": (6, 1, 1), "payload centre": (7, 1, 3)}
    if quantity in load:
        first, groups, width = load[quantity]
        groups = 0 if hexapod.compliance is None else groups
        first += after + 65 + sum(amplitude_counts(hexapod))
        return np.arange(first, first + groups * width), groups, width
    counts = [len(law.sensors) for law in active_model(hexapod).legs]
    columns = active_model(hexapod).columns_of_leg
    index = [3 * n + half * m + k for own in columns for half in (0, 1) for k in range(own.start, own.stop)]
    if len(set(counts)) > 1:
        return np.array(index), 1, 2 * m
    return np.array(index), 6, 2 * counts[0]


def source_factors(hexapod: Hexapod, source: Source) -> FloatArray:
    """Return `Source.factors` on a machine.

    Raises
    ------
    ArgumentError
        The source's numbers do not fit the machine.
    """
    _, groups, width = (None, 1, 6) if source.quantity == "pose" else blocks(hexapod, source.quantity)
    if not groups * width:
        raise ArgumentError(
            f"source {source.label!r} is of {source.quantity}, of which the machine has none; leave it out, or add "
            "what it speaks of to the machine's file"
        )
    common = isinstance(source.correlation, str) and source.correlation == "common"
    if source.quantity in ("coefficients", "amplitudes") and groups == 1 and common:
        what = "sensors" if source.quantity == "coefficients" else "amplitudes"
        raise ArgumentError(
            f"source {source.label!r} is common to legs with different numbers of {what}, which is not defined; "
            "make it independent, or give a matrix"
        )
    return source.factors(groups, width)


def deviation_factors(hexapod: Hexapod, source: Source) -> FloatArray:
    """Return how the variables of a source move a deviation, shape (size + 6, r); the last six are the pose's."""
    own, size = source_factors(hexapod, source), deviation_size(hexapod)
    out = np.zeros((size + 6, own.shape[1]))
    out[np.arange(size, size + 6) if source.quantity == "pose" else blocks(hexapod, source.quantity)[0]] = own
    return out
