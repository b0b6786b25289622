"""Residuals against motion: how they step at reversals, and how they age within a landing; constant in memory.

Neighbouring landings are compared with each other, so that slow changes, which moves go along with, drop out.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hexathermal.poses import FloatArray

AFTER_MOVE_S = (60.0, 300.0)
"""Ages of a landing that residuals are compared between: younger than the first, older than the second [s]."""

SMALLEST_TURN_M = 1e-6
"""Displacement that a move must exceed to count as a reversal."""

GROUPS = ("reversals: outwards less inwards", "less than a minute of rest, less its landing's mean",
          "more than five minutes of rest, less its landing's mean")  # fmt: skip


@dataclass(frozen=True)
class MotionGroup:
    """Mean residual of some landings: what they have in common, how many, the mean and its uncertainty [m]."""

    name: str
    landings: int
    mean: float
    uncertainty: float

    @property
    def notable(self) -> bool:
        """Whether the mean differs from zero by more than three standard uncertainties."""
        return self.landings > 3 and abs(self.mean) > 3.0 * self.uncertainty


@dataclass
class _Spread:
    """Number, mean and sum of squares about the mean of values as they come."""

    count: int = 0
    mean: float = 0.0
    squares: float = 0.0

    def add(self, count: int, mean: float, squares: float) -> None:
        """Add values by their number, mean and sum of squares about the mean."""
        if count:
            total, apart = self.count + count, mean - self.mean
            self.squares += squares + apart**2 * self.count * count / total
            self.mean += apart * count / total
            self.count = total

    def add_values(self, values: FloatArray) -> None:
        """Add values."""
        if len(values):
            self.add(len(values), float(values.mean()), float(((values - values.mean()) ** 2).sum()))


class RunMotion:
    """Residuals of one run against its motion, landing by landing as they end."""

    def __init__(self) -> None:
        self.spreads = tuple(_Spread() for _ in GROUPS)
        self._number = -1
        self._open: FloatArray = np.empty((0, 7))
        self._before: FloatArray = np.empty((0, 2))

    def add(self, numbers: npt.NDArray[np.int64], table: FloatArray) -> None:
        """Add landings, shape (k,), by their sums, shape (k, 7); the last may go on, and be the first of the next call.

        Columns: rows, sum of residuals, the same of young and of old rows, displacement at the first row.
        """
        if len(self._open) and numbers[0] == self._number:
            table = table.copy()
            table[0, :6] += self._open[0, :6]
            table[0, 6] = self._open[0, 6]
            self._open = self._open[:0]
        whole = np.concatenate([self._open, table])
        self._close(whole[:-1])
        self._open, self._number = whole[-1:], int(numbers[-1])

    def finish(self) -> None:
        """End the last landing."""
        self._close(self._open)
        self._open = self._open[:0]

    def _close(self, table: FloatArray) -> None:
        """Add landings that have ended."""
        if not len(table):
            return
        mean = table[:, 1] / table[:, 0]
        for spread, k in zip(self.spreads[1:], (2, 4), strict=True):
            part = (table[:, k] > 0) & (table[:, k] < table[:, 0])
            spread.add_values(table[part, k + 1] / table[part, k] - mean[part])
        series = np.concatenate([self._before, np.column_stack([mean, table[:, 6]])])
        step = np.diff(series[:, 1])
        turned = np.flatnonzero(
            (np.sign(step[1:]) * np.sign(step[:-1]) < 0.0) & (np.abs(step[1:]) > SMALLEST_TURN_M)
        ) + 1  # fmt: skip
        self.spreads[0].add_values(np.sign(step[turned]) * np.diff(series[:, 0])[turned])
        self._before = series[-2:]


def motion_groups(runs: Iterable[RunMotion]) -> tuple[MotionGroup, ...]:
    """Return the groups of some runs together; those with fewer than two landings are left out."""
    totals = tuple(_Spread() for _ in GROUPS)
    for run in runs:
        for total, one in zip(totals, run.spreads, strict=True):
            total.add(one.count, one.mean, one.squares)
    return tuple(
        MotionGroup(name, one.count, one.mean, float(np.sqrt(one.squares / (one.count - 1) / one.count)))
        for name, one in zip(GROUPS, totals, strict=True)
        if one.count > 1
    )
