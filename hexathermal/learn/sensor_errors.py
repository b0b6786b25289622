"""Errors of the thermometers: noise of readings, and a slow bias that their redundancy shows.

Neighbouring thermometers see the same smooth temperatures. What one of them shows beyond what all others foretell is
its own: noise, a slow bias of its contact or its logger, or heat that no other sees. Some of the last counts as an
error too, so the slow bias is an upper estimate; above `PLAUSIBLE_BIAS_K` all of it is taken for heat.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hexathermal.learn.windows import Windows, WindowSet
from hexathermal.poses import FloatArray

FEWEST_SENSORS = 6
"""Sensors that are needed to tell a bias from a temperature."""

PLAUSIBLE_BIAS_K = 0.3
"""A larger slow bias is no thermometer's (differences drift by 0.05 to 0.2 K): the sensor sees heat of its own."""

MOST_PROFILES = 4
TIMES_S = np.geomspace(900.0, 28800.0, 11)


@dataclass(frozen=True, eq=False)
class SensorErrors:
    """Errors of thermometers: ``noise`` of each reading, and a slow process.

    Parameters
    ----------
    noise : array, shape (s,) [K]
        Standard deviation of one reading.
    slow : array, shape (s,) [K]
        Standard deviation of the slow bias; zero where the sensors are too few to show it.
    slow_time : float [s]
        Its correlation time (first order).
    zeroed_by_run : bool
        Whether temperatures count from the run's first row: its error then stays in all rows of the run.
    local : tuple of int
        Sensors that see heat of their own: no slow bias could be told.
    """

    noise: FloatArray
    slow: FloatArray
    slow_time: float
    zeroed_by_run: bool = True
    local: tuple[int, ...] = ()

    def of(self, sensors: npt.ArrayLike) -> SensorErrors:
        """Return the errors of some of the sensors."""
        chosen = np.asarray(sensors, dtype=np.int64)
        return SensorErrors(self.noise[chosen], self.slow[chosen], self.slow_time, self.zeroed_by_run)

    def covariance(self, sensor: int, time: FloatArray, rows: FloatArray) -> FloatArray:
        """Return the covariance of a sensor's errors in the windows of a run, shape (w, w) [K^2]."""
        noise = self.noise[sensor] ** 2 * (np.diag(1.0 / rows) + 1.0)
        lag = np.abs(time[:, None] - time[None, :])
        slow = np.exp(-lag / self.slow_time)
        if self.zeroed_by_run:
            start = np.exp(-np.abs(time) / self.slow_time)
            slow = slow - start[:, None] - start[None, :] + 1.0
        else:
            slow = slow + 1.0
        return np.asarray(noise + self.slow[sensor] ** 2 * slow)

    def variance(self, time: FloatArray) -> FloatArray:
        """Return the variance of single readings of all sensors, shape (n, s) [K^2]."""
        start = np.exp(-np.abs(time) / self.slow_time) if self.zeroed_by_run else np.zeros(len(time))
        return np.asarray(2.0 * self.noise**2 + 2.0 * self.slow**2 * (1.0 - start)[:, None])


def sensor_errors(windows: WindowSet, kept: npt.NDArray[np.bool_], zeroed_by_run: bool = True) -> SensorErrors:
    """Return the errors of the thermometers as the windows show them.

    Parameters
    ----------
    windows : WindowSet
    kept : array of bool, shape (s,)
        Sensors with values.
    zeroed_by_run : bool
        Whether temperatures count from each run's first row.
    """
    s = len(windows.columns.sensors)
    slow, time = np.zeros(s), 3000.0
    chosen = np.flatnonzero(kept)
    long_enough = [run for run in windows.runs if len(run) > 2 * len(chosen)]
    if len(chosen) >= FEWEST_SENSORS and len(long_enough) >= 2:
        own = _own_part(long_enough, chosen)
        slow[chosen], time = _slow_process(long_enough, own, windows.sensor_noise[chosen])
    local = np.flatnonzero(slow > PLAUSIBLE_BIAS_K)
    if 3 * len(local) > len(chosen):
        # no common profile: the sensors do not foretell each other
        local = chosen
    slow[local] = 0.0
    return SensorErrors(windows.sensor_noise.copy(), slow, time, zeroed_by_run, tuple(int(k) for k in local))


def _own_part(runs: list[Windows], chosen: npt.NDArray[np.int64]) -> list[FloatArray]:
    """Return what each sensor shows beyond the others, with the number of profiles that foretells best."""
    T = [run.X[:, chosen] - run.X[:, chosen].mean(axis=0) for run in runs]
    products = [t.T @ t for t in T]
    best, smallest = T, np.inf
    for k in range(1, min(MOST_PROFILES, len(chosen) // 3) + 1):
        own, press = [], 0.0
        for r, t in enumerate(T):
            others = sum(p for j, p in enumerate(products) if j != r)
            V = np.linalg.eigh(others)[1][:, -k:]
            e = np.empty_like(t)
            for j in range(len(chosen)):
                rest = np.arange(len(chosen)) != j
                scores = np.linalg.lstsq(V[rest], t[:, rest].T, rcond=None)[0]
                # of the error, a part is that of the others
                part = np.linalg.norm(np.linalg.lstsq(V[rest].T, V[j], rcond=None)[0])
                raw = t[:, j] - V[j] @ scores
                press += float(raw @ raw)
                e[:, j] = raw / np.sqrt(1.0 + part**2)
            own.append(e)
        if press < smallest:
            best, smallest = own, press
    return best


def _slow_process(runs: list[Windows], own: list[FloatArray], noise: FloatArray) -> tuple[FloatArray, float]:
    """Return standard deviation and correlation time of a first-order process that explains differences in time."""
    edges = np.geomspace(600.0, 4 * 3600.0, 9)
    total, count, white = np.zeros((8, len(noise))), np.zeros(8), np.zeros(8)
    for run, e in zip(runs, own, strict=True):
        i, j = np.triu_indices(len(run), 1)
        where = np.digitize(run.time[j] - run.time[i], edges) - 1
        for b in range(8):
            here = where == b
            if here.any():
                total[b] += ((e[i[here]] - e[j[here]]) ** 2).sum(axis=0)
                count[b] += here.sum()
                white[b] += (1.0 / run.rows[i[here]] + 1.0 / run.rows[j[here]]).sum()
    good = count > 0
    if not good.any():
        return np.zeros(len(noise)), 3000.0
    lag = np.sqrt(edges[1:] * edges[:-1])[good]
    excess = total[good] / count[good][:, None] - (white[good] / count[good])[:, None] * noise**2
    weight = np.sqrt(count[good])
    best = (np.inf, np.zeros(len(noise)), 3000.0)
    for time in TIMES_S:
        shape = 2.0 * (1.0 - np.exp(-lag / time))
        variance = np.maximum((weight * shape) @ excess / (weight @ shape**2), 0.0)
        wrong = float((weight[:, None] * (excess - shape[:, None] * variance) ** 2).sum())
        if wrong < best[0]:
            best = (wrong, np.sqrt(variance), float(time))
    return best[1], best[2]
