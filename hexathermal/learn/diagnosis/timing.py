"""When the temperatures answer the motion: the second witness of a clock that is off.

Motion warms the leg, never the other way round: temperatures that answer before the motion, or later than heat
does, tell of clocks. The leading profiles of the thermometers are regressed on motion behind several low passes; the
likelihood of the innovations as a function of an offset is the advantage.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from hexathermal.learn.diagnosis.smoothing import leading_profiles, smoothed
from hexathermal.learn.diagnosis.view import View
from hexathermal.machine.leg_signals import Memory
from hexathermal.poses import FloatArray

TIMES_S = (60.0, 240.0, 960.0, 3840.0)
"""Low passes that heat takes on its way to the thermometers."""

GRID_S = 60.0
PROFILES = 2
FEWEST = 10
"""Points of the grid that a run must have to bear witness."""

SHARE = 0.3
"""Of this log evidence that is believed: the regression is a sketch of conduction."""

TOLERANCE_S = 30.0
"""Heat may take so much longer, or less, than the low passes can say."""

REACH_S, STEP_S = 1300.0, 20.0
MOST = 150.0


class Timing:
    """Temperatures against motion, shifted against each other."""

    def __init__(self, view: View) -> None:
        self.view = view

    @cached_property
    def _grids(self) -> list[tuple[FloatArray, FloatArray, FloatArray, FloatArray]]:
        """Of each run: times, leading profiles, the grid, and the motion's columns on it."""
        view = self.view
        tables = view.tables(view.sensors)
        chosen = leading_profiles(tables, PROFILES)
        found = []
        for signals, table in zip(view.signals, tables, strict=True):
            time = signals.time
            grid = np.arange(time[0] + REACH_S, time[-1] - REACH_S, GRID_S)
            if len(grid) < FEWEST:
                continue
            memory = Memory()
            speed = memory.speed(time, signals.q)
            passed = np.column_stack([speed, *(memory.low_pass(f"{tau}", time, speed, tau) for tau in TIMES_S)])
            # the temperatures were smoothed: so is the motion, or it would seem late
            columns = smoothed(time, passed)
            at = np.column_stack([np.interp(grid, time, column) for column in columns.T])
            rows = np.column_stack([at[1:], np.diff(at, axis=0), np.ones(len(at) - 1)])
            found.append((time, table @ chosen, grid, rows))
        return found

    def _misfit(self, offset: float) -> float:
        """Return the log likelihood of the innovations, -n / 2 log(sum of squares), of every profile."""
        response, design = [], []
        for time, profile, grid, rows in self._grids:
            shifted = np.column_stack([np.interp(grid + offset, time, own) for own in profile.T])
            # rates of change, so that slow weather does not count as noise that is correlated
            response.append(np.diff(shifted, axis=0))
            design.append(np.column_stack([rows, shifted[:-1]]))
        if not response:
            return 0.0
        Y, X = np.concatenate(response), np.concatenate(design)
        gram = X.T @ X
        scale = np.sqrt(np.diag(gram)) + 1e-30
        gram = gram / np.outer(scale, scale)
        gram[np.diag_indices_from(gram)] += 1e-9
        g = (X.T @ Y) / scale[:, None]
        left = (Y**2).sum(axis=0) - (g * np.linalg.solve(gram, g)).sum(axis=0)
        # smoothing makes neighbours alike: a fifth of the rows is independent
        return float(-0.5 * len(Y) / 5.0 * np.log(left).sum())

    @cached_property
    def _curve(self) -> tuple[FloatArray, FloatArray]:
        """Offsets [s], and the log likelihood that is believed at each."""
        offsets = np.arange(-REACH_S, REACH_S + 1.0, STEP_S)
        return offsets, SHARE * np.array([self._misfit(float(offset)) for offset in offsets])

    def _believed(self, offset: float) -> float:
        """Return the log of the likelihood averaged over the errors that heat's way may make."""
        offsets, values = self._curve
        weight = -0.5 * ((offsets - offset) / TOLERANCE_S) ** 2
        return float(np.logaddexp.reduce(values + weight) - np.logaddexp.reduce(weight))

    def advantage(self, offset: float) -> float:
        """Return the log evidence that temperatures are to be read `offset` seconds later, against now."""
        if not self.view.moves:
            return 0.0
        return float(np.clip(self._believed(offset) - self._believed(0.0), -MOST, MOST))
