"""What a map of error budgets holds: arrays over poses or times, which place is worst, and why."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hexathermal.errors import ArgumentError, UnknownNameError
from hexathermal.machine.thermal import refreeze
from hexathermal.poses import FloatArray
from hexathermal.predict.budget import AXES
from hexathermal.predict.budget_causes import NO_CAUSE

MEASURES = ("shift", "turn")


@dataclass(frozen=True, eq=False)
class BudgetMap:
    """Budgets at many poses or times; errors are ``[x, y, z, rx, ry, rz]``, m and rad.

    Attributes
    ----------
    poses : array, shape (N, 4, 4) [m]
    temps : array, shape (N, n) [degC]
    uncorrected, remaining, uncertainty, worst_case : array, shape (N, 6)
        Drift with nominal lengths, bias that remains, standard uncertainty, and ``|remaining| + U``; NaN where the
        pose cannot be reached.
    refused : tuple of (int, str)
        Place and reason of every pose that cannot be reached.
    labels : tuple of str
        Of the sources.
    shares : array, shape (N, sources, 6)
        Part of each variance that a source makes up.
    probability : float
    frame : str
    causes : tuple of str
        Of `remaining`.
    cause_parts : array, shape (N, causes, 6) [m, rad]
        Parts of `remaining`, which add up to it.
    """

    poses: FloatArray
    temps: FloatArray
    uncorrected: FloatArray
    remaining: FloatArray
    uncertainty: FloatArray
    worst_case: FloatArray
    refused: tuple[tuple[int, str], ...]
    labels: tuple[str, ...]
    shares: FloatArray
    probability: float
    frame: str
    causes: tuple[str, ...]
    cause_parts: FloatArray

    def size(self, what: str, measure: str = "shift") -> FloatArray:
        """Return the length of the shift [m] or of the turn [rad] of one of the arrays, shape (N,).

        For ``worst_case`` and ``uncertainty``: the root of the sum of squares over the three axes.
        """
        known = ("uncorrected", "remaining", "uncertainty", "worst_case")
        if what not in known:
            raise UnknownNameError(f"{what!r} is not known; choose from {', '.join(known)}", known)
        if measure not in MEASURES:
            raise UnknownNameError(f"{measure!r} is not known; choose from {', '.join(MEASURES)}", MEASURES)
        values = getattr(self, what)
        return np.asarray(np.linalg.norm(values[:, :3] if measure == "shift" else values[:, 3:], axis=1))

    def worst(self, measure: str = "shift") -> Worst:
        """Return which place is worst in shift or turn, and why.

        Raises
        ------
        ArgumentError
            No pose of the map can be reached.
        """
        sizes = self.size("worst_case", measure)
        if not np.isfinite(sizes).any():
            reason = f": {self.refused[0][1]}" if self.refused else ""
            raise ArgumentError(f"no pose of the map can be reached{reason}")
        index = int(np.nanargmax(sizes))
        part = slice(0, 3) if measure == "shift" else slice(3, 6)
        axis = int(np.argmax(self.worst_case[index, part])) + part.start
        bias, u = abs(float(self.remaining[index, axis])), float(self.uncertainty[index, axis])
        share = self.shares[index, :, axis]
        pushed = self.cause_parts[index, :, axis] * (np.sign(self.remaining[index, axis]) or 1.0)
        return Worst(
            index, measure, AXES[axis], float(sizes[index]), bias, u, _equal(self.labels, share),
            float(share.max(initial=0.0)), bias > float(self.worst_case[index, axis]) - bias,
            _equal(self.causes, pushed), float(pushed.max(initial=0.0)),
        )  # fmt: skip

    def __setstate__(self, state: dict[str, Any]) -> None:
        refreeze(self, state)


@dataclass(frozen=True)
class Worst:
    """The worst place of a map.

    Attributes
    ----------
    index : int
    measure, axis : str
        ``"shift"`` or ``"turn"``, and the axis that is worst there.
    value : float [m or rad]
        Size of the worst case, all three axes.
    bias, uncertainty : float [m or rad]
        In the worst axis.
    sources : tuple of str
        The source with the largest part of the variance in that axis; several that are equal.
    share : float
        That part, of each.
    mostly_bias : bool
        Whether the bias is larger than the expanded uncertainty there.
    causes : tuple of str
        What makes up most of the bias in that axis; several that are equal.
    cause_part : float [m or rad]
        How much of the bias, each.
    """

    index: int
    measure: str
    axis: str
    value: float
    bias: float
    uncertainty: float
    sources: tuple[str, ...]
    share: float
    mostly_bias: bool
    causes: tuple[str, ...]
    cause_part: float

    @property
    def source(self) -> str:
        """The first of `sources`; empty where there is none."""
        return self.sources[0] if self.sources else ""

    @property
    def reason(self) -> str:
        """One sentence: why it is the worst."""
        unit = "um" if self.measure == "shift" else "urad"
        if self.bias <= NO_CAUSE and self.uncertainty == 0.0:
            return "no bias and no uncertainty: nothing is off"
        each = " each" * (len(self.sources) > 1)
        source = f"{' and '.join(self.sources)}, {100 * self.share:.0f} % of the variance{each}"
        each = " each" * (len(self.causes) > 1)
        cause = f"the {' and the '.join(self.causes)}, {self.cause_part * 1e6:.3f} {unit} of it{each}"
        biased, uncertain = f"the bias that remains ({cause})" if self.causes else "the bias that remains", source
        first, second = (biased, uncertain) if self.mostly_bias else (uncertain, biased)
        small, large = sorted((self.bias, self.uncertainty))
        told = f"mostly {first}" + (f"; then {second}" if small > MINOR * large else "")
        return (
            f"{self.axis} weighs most: bias {self.bias * 1e6:.3f} {unit}, standard uncertainty "
            f"{self.uncertainty * 1e6:.3f} {unit}; {told}"
        )


MINOR = 0.05
"""Of bias and uncertainty, the smaller one is told where it is more than this part of the larger."""

EQUAL = 0.99
"""Causes at least this part of the largest are named together with it."""


def _equal(names: tuple[str, ...], sizes: FloatArray) -> tuple[str, ...]:
    """Return the names of the largest sizes, equal ones together; none where nothing is above 0."""
    largest = sizes.max(initial=0.0)
    return tuple(name for name, size in zip(names, sizes, strict=True) if largest > 0.0 and size >= EQUAL * largest)
