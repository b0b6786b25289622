"""What the other thermometers foretell of one: a second residual (parity) that tells a sensor's fault from the part's.

``T_b = P c + bias_b(t) + white``: P are the leading profiles of the other thermometers. What is left, the parity, is
the sensor's own: noise, a slow bias, or heat that no other sees.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hexathermal.learn.diagnosis.channels import Channel, Levels
from hexathermal.learn.diagnosis.view import View, smoothed
from hexathermal.poses import FloatArray

FEWEST_OTHERS = 5
"""Other thermometers that are needed to foretell one."""

MOST_PROFILES = 6
PARITY_WINDOW_S = 600.0
SLOW_PARITY_S = 1800.0
"""The parity that goes with the law is smoothed over so long: what is quicker is noise of readings."""


@dataclass(frozen=True, eq=False)
class SensorModel:
    """One thermometer against the others.

    Attributes
    ----------
    view : View
    sensor : str
    """

    view: View
    sensor: str

    @property
    def others(self) -> tuple[str, ...]:
        """The other thermometers."""
        return tuple(name for name in self.view.sensors if name != self.sensor)

    @cached_property
    def profiles(self) -> list[FloatArray]:
        """Leading profiles of the others in all rows of each run, shape (n, k)."""
        basis = self.basis
        return [np.column_stack([s.dT[name] for name in self.others]) @ basis for s in self.view.signals]

    @cached_property
    def own(self) -> list[FloatArray]:
        """The sensor's smoothed temperature in all rows of each run [K]."""
        return [signals.dT[self.sensor] for signals in self.view.signals]

    @cached_property
    def basis(self) -> FloatArray:
        """Weights of the others in each leading profile, shape (s, k)."""
        tables = [np.column_stack([signals.dT[name] for name in self.others]) for signals in self.view.signals]
        stacked = np.concatenate([table[:: max(1, len(table) // 300)] for table in tables])
        _w, vectors = np.linalg.eigh(stacked.T @ stacked)
        return np.asarray(vectors[:, ::-1][:, : min(MOST_PROFILES, max(1, len(self.others) // 2))])

    def weights(self, rows: list[slice] | None = None, nuisance: list[FloatArray] | None = None) -> FloatArray:
        """Return the weights of the leading profiles that foretell the sensor, shape (k,).

        Parameters
        ----------
        rows : list of slice, optional
            Of each run, to learn from; by default all.
        nuisance : list of array, optional
            Columns in all rows of each run that the sensor may follow besides.
        """
        chosen = [slice(None)] * len(self.own) if rows is None else rows
        P = np.concatenate([p[part] for p, part in zip(self.profiles, chosen, strict=True)])
        y = np.concatenate([t[part] for t, part in zip(self.own, chosen, strict=True)])
        if len(y) < 10:
            return self.weights()
        k = P.shape[1]
        if nuisance is not None:
            P = np.column_stack([P, np.concatenate([n[part] for n, part in zip(nuisance, chosen, strict=True)])])
        gram = P.T @ P
        scale = np.sqrt(np.diag(gram)) + 1e-12
        gram = gram / np.outer(scale, scale)
        gram[np.diag_indices_from(gram)] += 1e-6
        return np.asarray((np.linalg.solve(gram, (P.T @ y) / scale) / scale)[:k])

    def sensor_weights(self, weights: FloatArray) -> dict[str, float]:
        """Return what weights of the profiles are for each other sensor."""
        return dict(zip(self.others, (self.basis @ weights).tolist(), strict=True))

    def foretold(self, rows: list[slice] | None = None, nuisance: list[FloatArray] | None = None) -> list[FloatArray]:
        """Return what the others foretell in all rows of each run; learnt from some rows of each, or from all."""
        weights = self.weights(rows, nuisance)
        return [p @ weights for p in self.profiles]

    @cached_property
    def innovation(self) -> FloatArray:
        """The parity and its slow part in windows of the drift, shape (n, 2) [K]: the law may believe them or not."""
        found = []
        for signals, own, told in zip(self.view.signals, self.own, self.foretold(), strict=True):
            slow = smoothed(signals.time, (own - told)[:, None], SLOW_PARITY_S)[:, 0]
            found.append(np.column_stack([own - told, slow]))
        return np.column_stack([self.view.windows_zeroed([both[:, k] for both in found]) for k in range(2)])

    @cached_property
    def windows(self) -> list[np.ndarray]:
        """Rows where windows of the parity begin, for each run."""
        found = []
        for signals in self.view.signals:
            piece = np.floor(signals.time / PARITY_WINDOW_S)
            found.append(np.flatnonzero(np.concatenate([[True], piece[1:] != piece[:-1]])))
        return found

    def means(self, values: list[FloatArray]) -> FloatArray:
        """Return means over the parity's windows, run after run."""
        parts = []
        for edges, value in zip(self.windows, values, strict=True):
            count = np.diff(np.append(edges, len(value))).reshape((-1,) + (1,) * (value.ndim - 1))
            parts.append(np.add.reduceat(value, edges, axis=0) / count)
        return np.asarray(np.concatenate(parts))

    @cached_property
    def channel(self) -> Channel:
        """The sensor's temperature in the parity's windows."""
        start = np.concatenate([np.arange(len(edges)) == 0 for edges in self.windows])
        time = self.means([signals.time for signals in self.view.signals])
        step = np.where(start, 0.0, np.diff(time, prepend=time[:1]))
        run = np.repeat(np.arange(len(self.windows)), [len(edges) for edges in self.windows])
        n = len(start)
        return Channel(self.means(self.own), start, start, step, np.ones(n), run, np.ones(n), False)

    @cached_property
    def X(self) -> FloatArray:
        """The others' profiles in the parity's windows, and the air, which any imperfect contact lets in."""
        profiles = self.means(self.profiles)
        air = [signals.air for signals in self.view.signals if signals.air is not None]
        return profiles if len(air) < len(self.view.signals) else np.column_stack([profiles, self.means(air)])

    @cached_property
    def sd(self) -> FloatArray:
        """Loose priors of the profiles' coefficients."""
        scale = np.sqrt((self.X**2).mean(axis=0) + 1e-18)
        return np.asarray(3.0 * self.channel.y.std() / scale + 1e-9)

    @cached_property
    def null(self) -> tuple[Levels, float]:
        """Noise and evidence of the parity with nothing hidden in it."""
        return self.channel.fitted(self.X, self.sd)

    def gain(self, columns: FloatArray, sizes: FloatArray) -> float:
        """Return by how much columns, shape (n, k), of prior sizes (k,), raise the log evidence of the parity."""
        X, sd = np.column_stack([self.X, columns]), np.concatenate([self.sd, sizes])
        levels, value = self.channel.fitted(X, sd, self.null[0], 30)
        # the same noise must be open to both
        return value - max(self.null[1], self.channel.evidence(self.X, self.sd, levels))


def sensor_model(view: View, sensor: str) -> SensorModel | None:
    """Return the model of a sensor; None where there are too few others."""
    model = SensorModel(view, sensor)
    return model if len(model.others) >= FEWEST_OTHERS else None
