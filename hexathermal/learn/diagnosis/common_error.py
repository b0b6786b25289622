"""What may be wrong with all thermometers alike, as where a logger's cold junction drifts.

No thermometer tells it from the others, since all of them show it. But what warms a part is recorded: motion, inputs,
the room. What the thermometers show together and these do not foretell is warmth of another origin, or an error that
all readings share:

``sum_s w_s T_s = x b + e(t)``,  x: motion, inputs and air behind low passes, decays before each run

with weights, none below 0, that sum to 1. Such an error is in every mean of this kind, whole; warmth is not alike in
all places. So those weights tell most of it of which the least is left, mostly of thermometers that hardly warm.

The null of the drift may believe e or not, and errs where b is uncertain: else whatever goes as motion or the room do
stands for a better reading of the law's thermometers.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property

import numpy as np
from scipy import linalg, optimize

from hexathermal.learn.diagnosis.channels import Levels
from hexathermal.learn.diagnosis.parity_windows import parity_windows
from hexathermal.learn.diagnosis.recorded import noisy_sensors
from hexathermal.learn.diagnosis.sensor_model import FEWEST_DOUBTING
from hexathermal.learn.diagnosis.smoothing import smoothed
from hexathermal.learn.diagnosis.view import View
from hexathermal.machine.leg_signals import LegSignals, Memory
from hexathermal.poses import FloatArray

WARMING_S = (240.0, 900.0, 3600.0, 14400.0)
"""Low passes that heat, and the warmth of the room, take on their way to the thermometers."""

RESTING_S = (1800.0, 7200.0)
"""Decays of what had not come to rest before a run."""

SLOWER_S = (1800.0, 7200.0)
"""What is not foretold is doubted as it is and smoothed over so long: warmth and errors have speeds of their own."""

MOST_SHARED_K = 0.2
"""Largest error of a logger, RMS: where more is not foretold, most of it is warmth."""

LARGEST_PART = 3.0
"""Prior size of what one column foretells, over the RMS of the mean."""

LEAST_DIRECTION = 0.03
"""Directions in which what is foretold is uncertain by this part of the most uncertain one stand in the null."""

MOST_DIRECTIONS = 30
"""Of them, the most uncertain ones, so that many runs do not make many columns."""


OWN_ERROR = 0.01
"""Part of what is left of all thermometers, the mean of their squares, that each may err by besides."""

MOST_WEIGHT = 0.5
"""Of one thermometer in their mean: one that hardly answers shows little of the logger's error either."""

FEWEST_VALUES = 10
"""Different readings of a thermometer that is asked."""

HEAVY = 1e3
"""How much more it counts that weights sum to 1 than what they leave."""

BROADLY = Levels(white=0.3, landing=0.0, slow=3.0, offset=0.5)
"""Noise that warmth beside what warms is like, over the scatter from window to window."""


class CommonError:
    """The thermometers outside the law, together, against what warms them.

    Parameters
    ----------
    view : View
    sensors : tuple of str
        Whose weighted mean is asked.
    """

    def __init__(self, view: View, sensors: tuple[str, ...]) -> None:
        self.view, self.sensors = view, sensors

    @cached_property
    def weights(self) -> FloatArray:
        """Weights of the thermometers whose mean is foretold best, shape (s,): none below 0, of sum 1.

        With C the products of what the recorded causes leave of each, ``w' C w`` is least (bounded least squares,
        the sum as a heavy row: Lawson and Hanson, Solving Least Squares Problems, 1974, 23).
        """
        table, Z, _size = self._whitened
        count = table.shape[1]
        left = table - Z @ _ridge(Z, table)
        C = left.T @ left
        C[np.diag_indices(count)] += OWN_ERROR * np.trace(C) / count
        if not np.trace(C) > 0.0:  # nothing is left of any
            return np.full(count, 1.0 / count)
        heavy = HEAVY * float(np.sqrt(np.trace(C)))
        rows, wanted = np.vstack([linalg.cholesky(C), np.full(count, heavy)]), np.append(np.zeros(count), heavy)
        weights = optimize.lsq_linear(rows, wanted, (0.0, MOST_WEIGHT), method="bvls").x
        return np.asarray(weights / weights.sum())

    @cached_property
    def warmed(self) -> list[FloatArray]:
        """What the recorded causes foretell of each thermometer in all rows of each run, shape (n, s) [K]."""
        table, Z, size = self._whitened
        weights = size * _ridge(Z, table)
        return [causes @ weights for causes in self._causes]

    @cached_property
    def _whitened(self) -> tuple[FloatArray, FloatArray, float]:
        """The thermometers, shape (m, s), and what warms them times its prior size, (m, k), whitened; that size."""
        windows = parity_windows(self.view)
        X, T = windows.means(self._causes), windows.means(self.view.tables(self.sensors))
        channel = windows.channel(T.mean(axis=1))
        broadly = replace(BROADLY, white=BROADLY.white * channel.scale, slow=BROADLY.slow * channel.scale,
                          offset=BROADLY.offset * channel.scale)  # fmt: skip
        size = LARGEST_PART * float(np.sqrt((T**2).mean()))
        both, _logdet = channel.whitened(np.column_stack([T, size * X]), broadly)
        return both[:, : T.shape[1]], both[:, T.shape[1] :], size

    @cached_property
    def _own(self) -> list[FloatArray]:
        """The weighted mean of the thermometers in all rows of each run [K]."""
        return [table @ self.weights for table in self.view.tables(self.sensors)]

    @cached_property
    def _causes(self) -> list[FloatArray]:
        """What warms them in all rows of each run, less its first value, each column over its RMS, shape (n, k)."""
        view, begun = self.view, 0.0
        beginnings = np.cumsum([not goes_on for goes_on in view.goes_on]) - 1
        found = []
        runs = zip(view.signals, view.goes_on, view.rows.memories(), beginnings.tolist(), strict=True)
        for signals, goes_on, memory, own in runs:
            begun = begun if goes_on else float(signals.time[0])
            columns = list(warming(signals, memory, airy=view.airs is not None))
            decays = np.zeros((len(signals), len(RESTING_S) * (int(beginnings[-1]) + 1)))
            for k, tau in enumerate(RESTING_S):
                decays[:, len(RESTING_S) * own + k] = np.expm1(-(signals.time - begun) / tau)
            found.append(np.column_stack([*columns, decays]))
        scale = np.sqrt((np.concatenate(found) ** 2).mean(axis=0)) + 1e-30
        return [table / scale for table in found]

    @cached_property
    def _solved(self) -> tuple[Levels, FloatArray, FloatArray]:
        """Noise of the mean beside what warms it, the coefficients, and directions in which they are uncertain."""
        windows = parity_windows(self.view)
        X, y = windows.means(self._causes), windows.means(self._own)
        channel, sd = windows.channel(y), np.full(X.shape[1], LARGEST_PART * float(np.sqrt((y**2).mean())))
        levels, _ = channel.fitted(X, sd)
        mean, covariance = channel.estimated(X, sd, levels)
        w, V = np.linalg.eigh(covariance)
        spread = V * np.sqrt(np.maximum(w, 0.0))
        _, size, turn = np.linalg.svd(X @ spread, full_matrices=False)
        return levels, mean, spread @ turn[size > LEAST_DIRECTION * size[0]][:MOST_DIRECTIONS].T

    @property
    def slow(self) -> float:
        """Largest error that all may share, RMS [K]: what wanders of the mean beside what warms it, `MOST_SHARED_K`."""
        return min(self._solved[0].slow, MOST_SHARED_K)

    def beside(self, bias: float) -> float:
        """Return what of `slow` is not the thermometers' own: each has a slow bias of that size besides, RMS [K]."""
        own = bias * float(np.linalg.norm(self.weights))
        return float(np.sqrt(max(self.slow**2 - own**2, 0.0)))

    @cached_property
    def doubted(self) -> list[FloatArray]:
        """What is not foretold, as it is and smoothed, then errors of what is, in all rows of each run, (n, k) [K].

        As much of it as a logger may err by.
        """
        levels, mean, uncertain = self._solved
        part = self.slow / max(levels.slow, np.finfo(float).tiny)
        found = []
        for signals, own, causes in zip(self.view.signals, self._own, self._causes, strict=True):
            left = (own - causes @ mean)[:, None]
            # where all runs count from one zero their levels are warmth of the days between
            left = left if self.view.zeroed_by_run else left - left.mean(axis=0)
            slower = [smoothed(signals.time, left, over) for over in SLOWER_S]
            found.append(part * np.column_stack([left, *slower, causes @ uncertain]))
        return found


def _ridge(Z: FloatArray, table: FloatArray) -> FloatArray:
    """Return the coefficients of columns, of prior N(0, 1), that foretell those of a table, whitened both."""
    return np.asarray(linalg.solve(Z.T @ Z + np.eye(Z.shape[1]), Z.T @ table, assume_a="pos"))


def warming(signals: LegSignals, memory: Memory, *, airy: bool) -> Iterator[FloatArray]:
    """Give motion, recorded inputs and the air behind low passes, less their first values, shape (n,) each."""
    heats = {name: np.abs(values) for name, values in signals.inputs.items()}
    heats["motion"] = memory.speed(signals.time, signals.q)
    late = [(name, tau, values) for name, values in heats.items() for tau in WARMING_S]
    if airy and signals.air is not None:
        late += [("air", tau, signals.air) for tau in (0.0, *WARMING_S)]
    for name, tau, values in late:
        passed = memory.low_pass(f"{name} {tau}", signals.time, values, tau) if tau else values
        yield passed - memory.first(f"first {name} {tau}", passed)


def common_error(view: View) -> CommonError | None:
    """Return what the thermometers of a leg or an axis may share; None with too few outside the law, or at rest.

    In a part of many lumps, whose law reads no displacement, most of what no low pass of its inputs foretells is warmth
    that moves it.
    """
    return view.once(("common error",), lambda: _made(view), outside(view))


def outside(view: View) -> tuple[str, ...]:
    """Return the thermometers outside the law."""
    return tuple(name for name in view.sensors if name not in view.base)


def _made(view: View) -> CommonError | None:
    """Return what `common_error` keeps."""
    noisy = noisy_sensors(view.runs, outside(view))
    sensors = tuple(name for name in outside(view) if name not in noisy and answers(view, name))
    return CommonError(view, sensors) if view.stroked and view.moves and len(sensors) >= FEWEST_DOUBTING else None


def answers(view: View, sensor: str) -> bool:
    """Return whether a thermometer shows what it reads: one that is stuck, or too coarse, shows no error either."""
    return len(np.unique(np.concatenate([rows.signals.dT[sensor] for rows in view.runs]))) >= FEWEST_VALUES


def doubted_alike(view: View) -> list[FloatArray]:
    """Return what all thermometers may err alike, in all rows of each run, shape (n, k) [K]; k 0 if nobody can know."""
    found = common_error(view)
    return [np.zeros((len(one), 0)) for one in view.signals] if found is None else found.doubted
