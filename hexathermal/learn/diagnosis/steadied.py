"""Temperatures as motion and the air explain them: without the noise of readings, which rates would make large.

A thermometer that is late shows its part by its rate, ``T + tau dT/dt``, and what takes the noise from a rate takes
what is quick as well. In a leg heat of motion is what is quick, and rows tell that without noise::

    T = c_0 + sum_k c_1k lp_k(v) + c_2k lp_k(lp_k(v)) + sum_j c_3j lp_j(T_air) + slow(t)

with v the speed and lp low passes; c by least squares over all runs, of readings as recorded, since smoothing takes
what is quick, and what they leave smoothed over `SLOW_S`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy import linalg

from hexathermal.learn.diagnosis.smoothing import smoothed
from hexathermal.learn.diagnosis.view import View
from hexathermal.poses import FloatArray

TIMES_S = (60.0, 120.0, 240.0, 480.0, 960.0, 1920.0, 3840.0, 7680.0)
"""Low passes of the speed, once and twice, that heat takes on its way to a thermometer."""

AIR_TIMES_S = (600.0, 2400.0, 9600.0)
"""Low passes of the air's temperature."""

SLOW_S = 1500.0
"""What neither explains is smoothed over so long."""

RIDGE = 1e-4
"""Prior of the coefficients: low passes of neighbouring times are nearly one."""


STEADIER = 0.5
"""Part of the evidence of a lateness that steadier temperatures alone may have."""


@dataclass(frozen=True, eq=False)
class Motion:
    """What motion and the air explain of values in the rows of a view, those of temperatures as recorded."""

    view: View

    def steadied(self, rows: Sequence[FloatArray]) -> list[FloatArray]:
        """Return values of each run, shape (n, k), as both explain them, and slowly what is left."""
        c = self._coefficients(rows)
        runs = zip(self.view.runs, self._told, rows, strict=True)
        return [told @ c + smoothed(run.signals.time, values - told @ c, SLOW_S) for run, told, values in runs]

    def heats(self, rows: Sequence[FloatArray]) -> dict[str, Any]:
        """Return the coefficients of motion for values, shape (n, 1), as parameters of the shape ``lead-by-motion``."""
        c = (self._coefficients(rows) / self._size[:, None])[1 : 1 + 2 * len(TIMES_S), 0]
        return {"heat_times_s": list(TIMES_S), "once": c[::2].tolist(), "twice": c[1::2].tolist()}

    def _coefficients(self, rows: Sequence[FloatArray]) -> FloatArray:
        """Return c of columns of the size 1, shape (1 + 2 t + a, k)."""
        g = np.sum([told.T @ values for told, values in zip(self._told, rows, strict=True)], axis=0)
        return np.asarray(linalg.cho_solve(self._factor, g))

    @cached_property
    def _factor(self) -> tuple[FloatArray, bool]:
        """Cholesky factor of the products of the columns with their prior."""
        M = np.concatenate(self._told)
        factor: tuple[FloatArray, bool] = linalg.cho_factor(M.T @ M + RIDGE * len(M) * np.eye(M.shape[1]))
        return factor

    @cached_property
    def _told(self) -> list[FloatArray]:
        """The columns in all rows of each run, each of the size 1."""
        return [columns / self._size for columns in self._columns]

    @cached_property
    def _size(self) -> FloatArray:
        """RMS of the columns; 1 of the constant one."""
        return np.asarray(np.sqrt(np.mean(np.concatenate(self._columns) ** 2, axis=0)) + np.finfo(float).tiny)

    @cached_property
    def _columns(self) -> list[FloatArray]:
        """1, heat of motion behind its low passes, and the air behind its own, in all rows of each run."""
        found, airs = list[FloatArray](), self.view.as_recorded.airs
        for run, memory in zip(self.view.runs, self.view.rows.memories(), strict=True):
            signals = run.signals
            heats, _rates = memory.heats(signals.time, signals.q, TIMES_S)
            columns = [np.ones(len(signals.time)), *heats.T]
            if airs is not None:
                air = airs[len(found)]
                columns += [memory.low_pass(f"air {tau}", signals.time, air, tau) for tau in AIR_TIMES_S]
            found.append(np.column_stack(columns))
        return found


def motion_of(view: View) -> Motion:
    """Return what motion explains in a view; it is made once."""
    return view.once(("motion",), lambda: Motion(view), ())


def steadied_price(late: float, unlate: float) -> float:
    """Return what does not count of the evidence of a lateness that is told by steadier temperatures.

    These alone, without lateness, explain `unlate`: where that is more than `STEADIER` of it, it is what they explain.

    >>> steadied_price(200.0, 40.0), steadied_price(60.0, 50.0), steadied_price(30.0, -5.0)
    (0.0, 50.0, 0.0)
    """
    return unlate if unlate > max(STEADIER * late, 0.0) else 0.0
