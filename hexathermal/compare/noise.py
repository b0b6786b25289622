"""Noise of the channels of a comparison: white, slow, and what all thermocouples share.

The covariance of a run's windows:

    thermocouples   a_c^2 s^2 exp(-|t - t'| / tau)  +  u^2 exp(-|t - t'| / tau)  (of all)  +  white / rows
    drift           d^2 exp(-|t - t'| / tau_d)  +  scatter^2 * (share of common landings)
    slope of drift  white: scatter^2 / (landings * spread of q)

and a free offset of every channel in every run (the zero's own error), and what is not known of the run itself, see
`SimulatedRun.doubts`. ``s, u, tau, d, tau_d`` are found by the evidence of the
campaign at hand with every parameter free, so that what the bench gets wrong is not taken for noise.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from hexathermal.compare.bench_runs import UM, SimulatedRun
from hexathermal.compare.measured import MeasuredRun
from hexathermal.machine.thermal import frozen
from hexathermal.poses import FloatArray

OFFSET_K, OFFSET_UM = 1.0, 10.0
"""Standard deviation of a channel's zero in a run: practically free."""

SLOPE_SLOW = 0.05
"""Slow error of the slope of drift, as from the index of air [um/m]."""

LEAST_K = 0.001
"""What every window's mean temperature is uncertain by at least [K]: the logger's steps."""

TYPICAL = (0.02, 0.02, 7200.0, 0.05, 7200.0)
"""Centre of the prior of s [K], u [K], tau [s], d [um], tau_d [s]."""

SPREADS = (1.0, 1.0, 0.7, 1.0, 0.7)
"""Standard deviations of their logarithms."""

EVALUATIONS = 90
"""Largest number of evaluations in the search for them."""


@dataclass(frozen=True, eq=False)
class Noise:
    """Noise of a campaign's channels.

    Attributes
    ----------
    slow, common : float [K]
        Slow error of each thermocouple, and of all together.
    time : float [s]
        Correlation time of both.
    drift_slow, drift_time : float [um], [s]
    scatter : float [um]
        From landing to landing.
    own : array, shape (s,) [1]
        Factor of each thermocouple's slow error.
    """

    slow: float
    common: float
    time: float
    drift_slow: float
    drift_time: float
    scatter: float
    own: FloatArray

    def with_logs(self, logs: FloatArray) -> Noise:
        """Return the noise with the five numbers that are searched for, given as logarithms over `TYPICAL`."""
        s, u, tau, d, tau_d = (float(value) for value in np.exp(logs) * TYPICAL)
        return replace(self, slow=s, common=u, time=tau, drift_slow=d, drift_time=tau_d)

    def covariance(self, run: MeasuredRun, simulated: SimulatedRun) -> FloatArray:
        """Return the covariance of a run's channels and windows, shape (c, w, c, w); K, um, um/m."""
        windows, count = run.windows, len(self.own)
        w = len(windows.time)
        lag = np.abs(windows.time[:, None] - windows.time)
        found = np.zeros((count + 2, w, count + 2, w))
        slow = np.exp(-lag / self.time)
        found[:count, :, :count, :] += (self.common**2 * slow)[None, :, None, :]
        for k in range(count):
            found[k, :, k, :] += (self.own[k] * self.slow) ** 2 * slow + OFFSET_K**2
            found[k, :, k, :] += np.diag(run.row_noise[k] ** 2 / windows.count + LEAST_K**2)
        shared = self.scatter**2 * (windows.landings @ windows.landings.T)
        found[count, :, count, :] = self.drift_slow**2 * np.exp(-lag / self.drift_time) + shared + OFFSET_UM**2
        landings = (windows.landings > 0.0).sum(axis=1)
        spread = np.where(windows.spread > 0.0, windows.spread, 1.0)
        found[count + 1, :, count + 1, :] = np.diag(self.scatter**2 / (landings * spread))
        found[count + 1, :, count + 1, :] += SLOPE_SLOW**2 * np.exp(-lag / self.drift_time)
        doubts = simulated.doubts.reshape(len(simulated.doubts), -1)
        return np.asarray(found + (doubts.T @ doubts).reshape(found.shape))


def first_noise(runs: tuple[MeasuredRun, ...]) -> Noise:
    """Return where the search begins."""
    s, u, tau, d, tau_d = TYPICAL
    scatter = float(np.median([run.landing_scatter for run in runs])) * UM
    return Noise(s, u, tau, d, tau_d, scatter, frozen(np.ones(runs[0].rises.shape[1])))


def fitted_noise(noise: Noise, evidence: Callable[[Noise], float]) -> Noise:
    """Return the noise of the largest evidence, weighed with the prior.

    Parameters
    ----------
    noise : Noise
        Where the search begins.
    evidence : callable
        Logarithm of the evidence of the data under a noise.
    """
    from scipy.optimize import minimize

    def cost(logs: FloatArray) -> float:
        return 0.5 * float((logs / SPREADS) @ (logs / SPREADS)) - evidence(noise.with_logs(logs))

    now = (noise.slow, noise.common, noise.time, noise.drift_slow, noise.drift_time)
    begin = np.log(np.array(now) / TYPICAL)
    simplex = np.vstack([begin, begin + 0.5 * np.eye(5)])
    options = {"maxfev": EVALUATIONS, "xatol": 0.05, "fatol": 0.2, "initial_simplex": simplex}
    return noise.with_logs(minimize(cost, begin, method="Nelder-Mead", options=options).x)
