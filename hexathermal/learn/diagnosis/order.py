"""Whether the profile of temperatures along a leg speaks for two thermometers being exchanged."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property, partial

import numpy as np

from hexathermal.learn.diagnosis.along_leg import smooth_along
from hexathermal.learn.diagnosis.view import View
from hexathermal.poses import FloatArray

PROFILES = 4
FEWEST = 6
MOST, LEAST = 12.0, -40.0
"""Most that the order alone says for an exchange, and against one: profiles need not be smooth."""

UNSURE = 2.5
"""Where the order says more than that against an exchange, the drift says nothing for it: of 288 exchanges on four
benches looked at meanwhile the order said more than 2.2 against none, and more than 1.1 against two."""

FEIGNED = 10.0
"""An exchange needs so much more evidence than chance: where thermometers wander, a neighbour's reading fits the drift
better now and then, and the order may confirm it. Of 60 clean campaigns of a bench looked at meanwhile four showed such
an exchange, by 6 to 10; of 48 true ones on four benches all that were found at all showed 18 and more."""

HEAVY = 3.0
"""Degrees of freedom of Student's distribution for a loading off the smooth profile."""


class Order:
    """The profile of temperatures along the leg: loadings of the leading profiles against the stated positions.

    Of the runs of some numbers; by default of all.
    """

    def __init__(self, view: View, runs: Iterable[int] | None = None) -> None:
        self.view, self.runs = view, tuple(range(len(view.runs)) if runs is None else runs)
        self.names = tuple(name for name in view.sensors if name in view.positions)

    @cached_property
    def loadings(self) -> FloatArray:
        """Loadings of each placed thermometer, in the unit of the leading profile's, shape (s, k)."""
        tables = self.view.tables(self.names)
        # from each run's first row on: where all count from one zero, that of a plug may be another plug's
        table = np.concatenate([(tables[k] - tables[k][0])[::10] for k in self.runs])
        w, vectors = np.linalg.eigh(table.T @ table / len(table))
        count = min(PROFILES, len(self.names) - 2)
        return np.asarray(vectors[:, ::-1][:, :count] * np.sqrt(np.maximum(w[::-1][:count], 0.0)))

    def advantage(self, sensor: str, other: str) -> float:
        """Return the log evidence that `sensor` and `other` stand in each other's place."""
        return self.view.once(("order", self.runs, sensor, other), partial(self._advantage, sensor, other))

    def allows(self, sensor: str, other: str) -> bool:
        """Return whether the order can be asked of two thermometers, and does not deny that they are exchanged."""
        placed = len(self.names) >= FEWEST and sensor in self.names and other in self.names
        return placed and self.most(sensor, other) > 0.0

    def _advantage(self, sensor: str, other: str) -> float:
        """Return what `advantage` keeps."""
        if len(self.names) < FEWEST or sensor not in self.names or other not in self.names:
            return 0.0
        x = np.array([self.view.positions[name] for name in self.names])
        i, j = self.names.index(sensor), self.names.index(other)
        rest = np.array([k for k in range(len(x)) if k not in (i, j)])
        told, spread = smooth_along(x, self.loadings, rest, np.array([x[i], x[j]]))
        own = _heavy((self.loadings[[i, j]] - told) / spread)
        swapped = _heavy((self.loadings[[j, i]] - told) / spread)
        return float(np.clip(swapped - own, LEAST, MOST))

    def most(self, sensor: str, other: str) -> float:
        """Return the most that a drift may say for `sensor` and `other` being exchanged, where their order is against.

        Whatever makes another thermometer fit better looks like an exchange; exchanged they are out of order too.
        """
        said = self.advantage(sensor, other)
        return float(np.inf) if said >= -UNSURE else 0.0


def _heavy(z: FloatArray) -> float:
    """Return the log density of standardised values, up to a constant."""
    return float(-0.5 * (HEAVY + 1.0) * np.log1p(z**2 / HEAVY).sum())
