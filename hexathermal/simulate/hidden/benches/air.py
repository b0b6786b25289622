"""Air of a room: daily swing, a cycle of the air conditioning, slow changes; pressure that moves; humidity."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.benches.noises import log_uniform, remembering

DAY = 86400.0


@dataclass(frozen=True)
class Room:
    """How a room's air changes.

    Attributes
    ----------
    level : float [degC]
    swing, coldest : float [K], [s]
        Half the daily swing, and the time of day when it is coldest.
    cycle, period, duty : float [K], [s], [1]
        Half the height of the air conditioning's saw-tooth, its mean period, and the part of it in which it warms.
    slow, slow_time : float [K], [s]
        Standard deviation and correlation time of what remains: doors, people, weather.
    pressure : (float, float) [Pa]
        Smallest and largest movement within a record.
    """

    level: float
    swing: float
    coldest: float
    cycle: float
    period: float
    duty: float
    slow: float
    slow_time: float = 5400.0
    pressure: tuple[float, float] = (200.0, 1500.0)

    def air(self, begin: float, step: float, count: int, generator: np.random.Generator) -> FloatArray:
        """Return temperature [degC], pressure [Pa] and relative humidity [1] of `count` rows, shape (n, 3).

        Parameters
        ----------
        begin : float [s]
            Time of the first row; 0 is midnight.
        step : float [s]
        count : int
        generator : numpy.random.Generator
        """
        time = begin + step * np.arange(count)
        warm = self.level - self.swing * np.cos(2.0 * np.pi * (time - self.coldest) / DAY)
        # the period wanders by some per cent: a thermostat keeps no clock
        rate = 1.0 + 0.1 * remembering(1800.0 / step, (count,), generator)
        turn = (generator.uniform() + np.cumsum(rate) * step / self.period) % 1.0
        tooth = np.where(turn < self.duty, turn / self.duty, (1.0 - turn) / (1.0 - self.duty))
        warm = warm + self.cycle * (2.0 * tooth - 1.0)
        warm = warm + self.slow * _smooth(self.slow_time / step, count, generator)
        front = _smooth(10800.0 / step, count, generator)
        height = log_uniform(*self.pressure, generator)
        pressure = generator.uniform(98500.0, 102800.0) + height * (front - front[0]) / np.ptp(front)
        moist = generator.uniform(0.3, 0.55) + 0.03 * _smooth(10800.0 / step, count, generator)
        # warm air of the same water is relatively drier by some 6 % a kelvin
        humidity = moist * np.exp(-0.06 * (warm - self.level))
        return np.column_stack([warm, pressure, humidity])


def _smooth(forgotten: float, count: int, generator: np.random.Generator) -> FloatArray:
    """Return a process of about unit variance that has no kinks: one that remembers, passed through a moving mean."""
    width = max(2, int(forgotten / 4.0))
    rough = remembering(forgotten, (count + width,), generator)
    sums = np.cumsum(rough)
    return np.asarray((sums[width:] - sums[:-width]) / width)
