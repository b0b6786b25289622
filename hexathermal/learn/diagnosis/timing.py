"""When the temperatures answer the motion: the second witness of a clock that is off.

Motion warms the leg, never the other way round: temperatures that answer before the motion, or later than heat
does, tell of clocks. The leading profiles of the thermometers are regressed on motion behind several low passes; the
likelihood of the innovations as a function of an offset is the advantage.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy import special

from hexathermal.learn.diagnosis.view import View, smoothed
from hexathermal.machine.leg_signals import Memory
from hexathermal.poses import FloatArray

TIMES_S = (60.0, 240.0, 960.0, 3840.0)
"""Low passes that heat takes on its way to the thermometers."""

GRID_S = 60.0
PROFILES = 2
SHARE = 0.15
"""Of this log evidence that is believed: the regression is a sketch of conduction."""

TOLERANCE_S = 30.0
"""Heat may take so much longer, or less, than the low passes can say."""

REACH_S, STEP_S = 1300.0, 20.0
MOST = 60.0


class Timing:
    """Temperatures against motion, shifted against each other."""

    def __init__(self, view: View) -> None:
        self.view = view

    @cached_property
    def _rates(self) -> list[FloatArray]:
        """Differences of the leading profiles over steps of the grid, for each run."""
        tables = [np.column_stack([signals.dT[name] for name in self.view.sensors]) for signals in self.view.signals]
        stacked = np.concatenate([table[:: max(1, len(table) // 300)] for table in tables])
        _w, vectors = np.linalg.eigh(stacked.T @ stacked)
        chosen = vectors[:, ::-1][:, :PROFILES]
        return [table @ chosen for table in tables]

    def _misfit(self, offset: float) -> float:
        """Return half the log likelihood's sum of the innovations, -n / 2 log(sum of squares)."""
        response, design = [], []
        for signals, profile in zip(self.view.signals, self._rates, strict=True):
            time = signals.time
            grid = np.arange(time[0] + REACH_S, time[-1] - REACH_S, GRID_S)
            if len(grid) < 10:
                continue
            memory = Memory()
            speed = memory.speed(time, signals.q)
            passed = np.column_stack([memory.low_pass(f"{tau}", time, speed, tau) for tau in TIMES_S])
            # the temperatures were smoothed: so is the motion, or it would seem late
            columns = smoothed(time, np.column_stack([speed, passed])).T
            at = np.column_stack([np.interp(grid, time, column) for column in columns])
            shifted = np.column_stack([np.interp(grid + offset, time, profile[:, k]) for k in range(profile.shape[1])])
            # rates of change, so that slow weather does not count as noise that is correlated
            response.append(np.diff(shifted, axis=0))
            design.append(np.column_stack([at[1:], np.diff(at, axis=0), shifted[:-1], np.ones(len(at) - 1)]))
        if not response:
            return 0.0
        Y, X = np.concatenate(response), np.concatenate(design)
        X = X / (np.sqrt((X**2).mean(axis=0)) + 1e-30)
        left = Y - X @ np.linalg.lstsq(X, Y, rcond=None)[0]
        # smoothing over SMOOTHED_S makes neighbours alike: a fifth of the rows is independent
        return float(-0.5 * len(Y) / 5.0 * np.log((left**2).sum(axis=0)).sum())

    @cached_property
    def _curve(self) -> tuple[FloatArray, FloatArray]:
        """Offsets [s], and the log likelihood that is believed at each."""
        offsets = np.arange(-REACH_S, REACH_S + 1.0, STEP_S)
        return offsets, SHARE * np.array([self._misfit(float(offset)) for offset in offsets])

    def _believed(self, offset: float) -> float:
        """Return the log of the likelihood averaged over the errors that heat's way may make."""
        offsets, values = self._curve
        weight = -0.5 * ((offsets - offset) / TOLERANCE_S) ** 2
        return float(special.logsumexp(values + weight) - special.logsumexp(weight))

    def advantage(self, offset: float) -> float:
        """Return the log evidence that temperatures are to be read `offset` seconds later, against now."""
        if not self.view.moves:
            return 0.0
        return float(np.clip(self._believed(offset) - self._believed(0.0), -MOST, MOST))
