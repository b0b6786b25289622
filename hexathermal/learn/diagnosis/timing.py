"""When the temperatures answer the motion: the second witness of a clock that is off.

Motion warms the leg, never the other way round: temperatures that answer before the motion, or later than heat
does, tell of clocks. The leading profiles of the thermometers are regressed on motion behind several low passes; the
likelihood of the innovations as a function of an offset is the advantage.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline

from hexathermal.learn.diagnosis.read_later import rows_at
from hexathermal.learn.diagnosis.smoothing import leading_profiles, smoothed
from hexathermal.learn.diagnosis.view import View
from hexathermal.machine.leg_signals import Memory
from hexathermal.poses import FloatArray

TIMES_S = (60.0, 240.0, 960.0, 3840.0)
"""Low passes that heat takes on its way to the thermometers."""

PROFILES = 2
FEWEST = 10
"""Points of the grid that a run must have to bear witness."""

SHARE = 0.3
"""Of this log evidence that is believed: the regression is a sketch of conduction."""

TOLERANCE_S = 5.0
"""Heat may take so much longer, or less, than the low passes can say; or a row of the record, where that is more."""

REACH_S, STEP_S, FINE_S = 1300.0, 20.0, 2.5
"""Shifts that are asked, from one to the next, and from one to the next of those between them [s]."""

GRID_STEPS = 3
"""Steps of the offset from one point of the grid to the next."""

MOST_POINTS = 2_000_000
"""A run whose grid every `STEP_S` would have more points bears no witness: more than a year."""

MOST = 150.0


class Timing:
    """Temperatures against motion, shifted against each other."""

    def __init__(self, view: View) -> None:
        self.view = view

    @cached_property
    def _grids(self) -> list[tuple[FloatArray, FloatArray]]:
        """Of each run: leading profiles every `STEP_S`, and on the grid within `REACH_S` the motion's columns."""
        view = self.view
        tables = view.tables(view.sensors)
        chosen = leading_profiles(tables, PROFILES)
        found = []
        for signals, table in zip(view.signals, tables, strict=True):
            time = signals.time
            span = float(time[-1] - time[0])
            if span > REACH_S * len(time) or span > MOST_POINTS * STEP_S:  # rows farther apart than shifts tell nothing
                continue
            grid = np.arange(time[0] + REACH_S, time[-1] - REACH_S, GRID_STEPS * STEP_S)
            if len(grid) < FEWEST:
                continue
            memory = Memory()
            speed = memory.speed(time, signals.q)
            passed = np.column_stack([speed, *(memory.low_pass(f"{tau}", time, speed, tau) for tau in TIMES_S)])
            # a speed is that of the middle of two rows; smoothed as the temperatures were, or it would seem late
            at = _interpolated(grid, time - 0.5 * view.sampling, smoothed(time, passed))
            rows = np.column_stack([at[1:], np.diff(at, axis=0), np.ones(len(at) - 1)])
            fine = np.arange(time[0], time[-1] + STEP_S, STEP_S)
            found.append((_interpolated(fine, time, table @ chosen), rows))
        return found

    def _misfit(self, steps: float, gains: float = 0.0) -> float:
        """Return the log likelihood of the innovations, -n / 2 log(sum of squares), of every profile.

        Profiles are read so many times `STEP_S` later, and with each hour of a run `gains` [s/h] later.
        """
        response, design = [], []
        for fine, rows in self._grids:
            place = REACH_S / STEP_S + GRID_STEPS * np.arange(len(rows) + 1.0)
            shifted = rows_at(fine, place + steps + gains * place / 3600.0)
            # rates of change, so that slow weather does not count as noise that is correlated
            response.append(shifted[1:] - shifted[:-1])
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
    def _as_logged(self) -> float:
        """The log likelihood of temperatures that are read when they were logged."""
        return self._misfit(0.0)

    @cached_property
    def _curve(self) -> tuple[FloatArray, FloatArray]:
        """Offsets [s], and the log likelihood that is believed at each."""
        most = round(REACH_S / STEP_S)
        steps = range(-most, most + 1)
        curve = CubicSpline(STEP_S * np.array(steps), SHARE * np.array([self._misfit(one) for one in steps]))
        fine = np.arange(-REACH_S, REACH_S + FINE_S, FINE_S)
        return fine, curve(fine)

    def _believed(self, offset: float) -> float:
        """Return the log of the likelihood averaged over the errors that heat's way may make."""
        offsets, values = self._curve
        weight = -0.5 * ((offsets - offset) / max(TOLERANCE_S, self.view.sampling)) ** 2
        return float(np.logaddexp.reduce(values + weight) - np.logaddexp.reduce(weight))

    def advantage(self, offset: float, gains: float = 0.0) -> float:
        """Return the log evidence that temperatures are to be read `offset` seconds later, against now.

        Of a clock that gains time as well, `gains` [s/h], it is that of its course itself.
        """
        if not self.view.moves:
            return 0.0
        if gains:
            apart = self._misfit(offset / STEP_S, gains) - self._as_logged
            return float(np.clip(SHARE * apart, -MOST, MOST))
        return float(np.clip(self._believed(offset) - self._believed(0.0), -MOST, MOST))


def _interpolated(at: FloatArray, time: FloatArray, table: FloatArray) -> FloatArray:
    """Return the rows of a table, shape (n, k), at other times, linear between rows."""
    return np.column_stack([np.interp(at, time, column) for column in table.T])
