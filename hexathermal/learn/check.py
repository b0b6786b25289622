"""What a metrologist asks of a campaign before a fit: noise, ranges, collinearity, what can be told apart.

All of it comes from one pass over the usable rows, in constant memory. How the numbers are judged stands in
`hexathermal.learn.check_words`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from hexathermal.learn.air import RED_HELIUM_NEON, refractive_index
from hexathermal.learn.campaign import Campaign, RunFile
from hexathermal.learn.check_sums import RunSums, Separability, Trace, collinearity, separability
from hexathermal.learn.cleaning import usable_blocks
from hexathermal.learn.cleaning_record import CleaningRecord
from hexathermal.poses import FloatArray

Progress = Callable[[int, int, str], None]


@dataclass(frozen=True, eq=False)
class RunCheck:
    """What is seen in one run.

    Attributes
    ----------
    run : RunFile
    record : CleaningRecord
    landings : int
        Rests, or stretches between changes of the inputs.
    lowest_degC, highest_degC : array, shape (s,)
        Of each thermocouple.
    lowest_dT, highest_dT : array, shape (s,) [K]
    drift, q : tuple of float [m]
        Lowest and highest; `q` is None for a part without a stroke.
    sensor_noise : array, shape (s,) [K]
        Of single readings, robust and blind to trends.
    drift_noise, landing_noise : float [m]
        Of the drift from row to row of a rest, and from rest to rest.
    air : array, shape (2, 3)
        Lowest and highest of temperature [degC], pressure [Pa] and humidity [1].
    trace : Trace
        Some of the rows, evenly, for plots.
    spikes : dict of str to array, shape (n, 2)
        Spikes that were left out: of each thermometer's column time [s] and reading [degC], of ``"drift"`` time and
        drift [m].
    """

    run: RunFile
    record: CleaningRecord
    landings: int
    lowest_degC: FloatArray
    highest_degC: FloatArray
    lowest_dT: FloatArray
    highest_dT: FloatArray
    drift: tuple[float, float]
    q: tuple[float, float] | None
    sensor_noise: FloatArray
    drift_noise: float
    landing_noise: float
    air: FloatArray
    trace: Trace
    spikes: dict[str, FloatArray] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class CampaignCheck:
    """What is seen in a campaign.

    Attributes
    ----------
    campaign : Campaign
    runs : tuple of RunCheck
    sensor_noise : array, shape (s,) [K]
        Over all runs.
    sensor_slow : array, shape (s,) [K]
        Slow deviation of each sensor from what the others say of it, noise taken off: an upper bound of its bias.
    correlation : array, shape (s, s)
        Of the temperatures within runs; NaN where a sensor does not change.
    inflation : array, shape (s,)
        Variance inflation factor of each sensor among all.
    condition : float
        Condition number of the correlation's square root.
    separability : tuple of Separability
        One a sensor, from the runs for identification (from all where there are none).
    weather : array, shape (2, 3)
        Lowest and highest of temperature [degC], pressure [Pa] and humidity [1]; NaN where not recorded.
    weather_effect : float [m]
        What that span does to the beams over the longest path; NaN where it cannot be said.
    """

    campaign: Campaign
    runs: tuple[RunCheck, ...]
    sensor_noise: FloatArray
    sensor_slow: FloatArray
    correlation: FloatArray
    inflation: FloatArray
    condition: float
    separability: tuple[Separability, ...]
    weather: FloatArray
    weather_effect: float


def check_campaign(campaign: Campaign, progress: Progress | None = None) -> CampaignCheck:
    """Return what is seen in the usable rows of a campaign.

    Parameters
    ----------
    campaign : Campaign
        Of kind ``"leg"`` or ``"component"``.
    progress : callable, optional
        Called as ``progress(done, total, label)``.

    Raises
    ------
    ArgumentError
        The campaign is of kind ``"hexapod"``.
    CampaignError
        A table is at fault.
    """
    count = len(campaign.runs)
    sums, runs = [], []
    for k, run in enumerate(campaign.runs):
        blocks = usable_blocks(campaign, run, least=0.0)
        total = RunSums(len(campaign.sensors))
        for block in blocks:
            total.add(block)
            if progress is not None:
                progress(int(1000 * (k + blocks.done)), 1000 * count, f"checking {run.name}")
        sums.append(total)
        zero = np.full(len(campaign.sensors), np.nan) if blocks.zero is None else blocks.zero.heat
        spikes = dict(blocks.spikes)
        for channel in ("drift_um", "drift"):
            if channel in spikes and blocks.zero is not None:
                spikes["drift"] = spikes.pop(channel) - [0.0, blocks.zero.drift]
        runs.append(replace(_run_check(run, blocks.record, total, zero), spikes=spikes))
    used = [total for total, run in zip(sums, campaign.runs, strict=True) if run.role == "identification"]
    noise = _mean_square([run.sensor_noise for run in runs], [total.rows for total in sums])
    correlation, inflation, condition, slow = collinearity(sums, noise)
    length = None if campaign.leg is None else campaign.leg.retracted_length
    with np.errstate(all="ignore"):
        weather = np.array([np.fmin.reduce([run.air[0] for run in runs]), np.fmax.reduce([run.air[1] for run in runs])])
    return CampaignCheck(campaign, tuple(runs), noise, slow, correlation, inflation, condition,
                         separability(used or sums, length, campaign.sensors), weather,
                         _weather_effect(campaign, weather))  # fmt: skip


def _run_check(run: RunFile, record: CleaningRecord, total: RunSums, zero: FloatArray) -> RunCheck:
    """Return what is seen in one run."""
    low, high = total.lowest, total.highest
    s = len(zero)
    q = (float(low[s + 1]), float(high[s + 1])) if np.isfinite(low[s + 1]) else None
    drift_noise, landing_noise = total.drift_noises()
    low, high = _finite(low), _finite(high)
    return RunCheck(run, record, total.landings, low[:s] + zero, high[:s] + zero, low[:s], high[:s],
                    (float(low[s]), float(high[s])), q, total.sensor_noise(), drift_noise, landing_noise,
                    np.array([low[s + 2 :], high[s + 2 :]]), total.trace())  # fmt: skip


def _finite(values: FloatArray) -> FloatArray:
    """Return extremes with NaN where nothing was seen."""
    return np.where(np.isfinite(values), values, np.nan)


def _mean_square(parts: list[FloatArray], rows: list[int]) -> FloatArray:
    """Return the root of the mean square of numbers, by rows; NaN where there is none."""
    squares, weights = np.square(np.array(parts)), np.array(rows, dtype=np.float64)[:, None]
    known = np.isfinite(squares)
    weight = (weights * known).sum(axis=0)
    total = np.where(known, squares * weights, 0.0).sum(axis=0)
    return np.sqrt(np.where(weight > 0.0, total / np.maximum(weight, 1.0), np.nan))


def _weather_effect(campaign: Campaign, weather: FloatArray) -> float:
    """Return by how much the span of the weather makes the longest path of the beams seem to change [m]."""
    if campaign.kind != "leg" or campaign.beams is None or campaign.leg is None or not np.isfinite(weather).all():
        return float("nan")
    path = campaign.beams.dead_path + campaign.leg.stroke[1]
    (t_low, p_low, h_low), (t_high, p_high, h_high) = weather
    try:
        dense = refractive_index(RED_HELIUM_NEON, t_low, p_high, h_low)
        thin = refractive_index(RED_HELIUM_NEON, t_high, p_low, h_high)
    except ValueError:  # readings outside the equation's range: the check must go on, and the readings are shown
        return float("nan")
    return float(path * (dense - thin))
