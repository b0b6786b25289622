"""What the numbers of a check mean, in words: warnings, what can be told apart, cycles of the room; and plain data."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hexathermal.learn.check import CampaignCheck, RunCheck
from hexathermal.learn.check_sums import Separability
from hexathermal.learn.cleaning_record import NOTED, CleaningStep
from hexathermal.poses import FloatArray

FORMAT = "hexathermal-check/1"

APART, HARDLY = 0.97, 0.99
"""Cosine between ``q0 dT`` and ``q dT``: up to the first `A` and `B` are told apart, beyond the second not."""

SMALLEST_SPAN_K = 0.5
"""Temperatures that rise by less teach next to nothing."""

LARGEST_INFLATION = 30.0
"""Variance inflation from which a sensor says what the others say."""

CYCLE_SHARE = 0.35
"""Share of a temperature's swing, trend taken off, that one period must have to be called a cycle."""

CYCLE_NOISES = 5.0
LARGEST_DRIFT_M = 1e-3
COMMON_STEPS = ("spike", "beam spike", "drift spike")


@dataclass(frozen=True)
class Cycle:
    """A temperature that swings: sensor, period [s] and amplitude [K], medians over the runs that show it."""

    sensor: str
    period: float
    amplitude: float
    runs: int


def cycles(check: CampaignCheck) -> tuple[Cycle, ...]:
    """Return the sensors that swing with one period in half of the runs or more, as a room does by its conditioning.

    Each run's temperature less a cubic in time is taken apart by a periodogram; its strongest period counts where it
    makes up `CYCLE_SHARE` of the variance and fits into the run four times.
    """
    found = []
    for k, sensor in enumerate(check.campaign.sensors):
        seen = [item for run in check.runs if (item := _cycle(run, k)) is not None]
        if seen and len(seen) >= 0.5 * len(check.runs):
            period, amplitude = np.median(np.array(seen), axis=0)
            if amplitude > CYCLE_NOISES * check.sensor_noise[k]:
                found.append(Cycle(sensor, float(period), float(amplitude), len(seen)))
    return tuple(found)


def _cycle(run: RunCheck, k: int) -> tuple[float, float] | None:
    """Return period [s] and amplitude [K] of a sensor's cycle in a run, or None."""
    from scipy.signal import periodogram

    time, value = run.trace.time, run.trace.dT[:, k]
    good = np.isfinite(value)
    if good.sum() < 64:
        return None
    even = np.linspace(time[0], time[-1], int(good.sum()))
    value = np.interp(even, time[good], value[good])
    scaled = np.linspace(-1.0, 1.0, len(even))
    value = value - np.polynomial.Polynomial.fit(scaled, value, 3)(scaled)
    frequency, power = periodogram(value, fs=1.0 / (even[1] - even[0]), window="hann")
    low = int(np.searchsorted(frequency, 4.0 / (even[-1] - even[0])))
    if low >= len(power) - 2 or not power.any():
        return None
    top = low + int(np.argmax(power[low:]))
    band = power[max(top - 2, 1) : top + 3].sum()
    if top <= low or band < CYCLE_SHARE * power[1:].sum():
        return None
    return float(1.0 / frequency[top]), float(np.sqrt(2.0 * band * (frequency[1] - frequency[0])))


def told_apart(item: Separability, stroke: float | None = None) -> str:
    """Return in words whether the data can tell `A` and `B` of a sensor apart, and what to measure where they cannot.

    Parameters
    ----------
    item : Separability
    stroke : float, optional [m]
        Length of the leg's stroke.
    """
    if not item.span > SMALLEST_SPAN_K:
        return f"hardly warmed ({item.span:.2f} K): neither A nor B; heat it more" if item.span > 0 else "no values"
    if np.isnan(item.r):
        return "one coefficient: the part has no stroke" if np.isnan(item.warm_q) else "q was 0 throughout: A only"
    where = f"warm at q = {item.warm_q * 1e3:.0f} +- {item.warm_q_spread * 1e3:.0f} mm"
    if item.r > HARDLY:
        return f"cannot be told apart, r = {item.r:.3f}: {where} only; rest hot, and cold, at other q"
    if item.r > APART:
        return f"hardly told apart, r = {item.r:.3f}: {where}; rest hot at more values of q"
    return f"told apart, r = {item.r:.2f}: {where}"


def warnings_of(check: CampaignCheck) -> tuple[str, ...]:
    """Return what the experimenter should know before fitting, one sentence each."""
    return (*_of_roles(check), *_of_runs(check), *_of_sensors(check), *_of_apart(check), *_of_weather(check))


def _of_roles(check: CampaignCheck) -> list[str]:
    """Return what is said of the roles of runs."""
    found = []
    if not check.campaign.runs_of("validation"):
        found.append('no validation run: what is identified cannot be validated; give a run role = "validation"')
    if not check.campaign.runs_of("identification"):
        found.append('no identification run: nothing can be identified; give a run role = "identification"')
    return found


def _of_runs(check: CampaignCheck) -> list[str]:
    """Return what is said of single runs."""
    found = []
    for run in check.runs:
        name, record = run.run.name, run.record
        if not record.used:
            found.append(f"{name}: no row may be used")
            continue
        if max(map(abs, run.drift)) > LARGEST_DRIFT_M:
            largest = max(map(abs, run.drift)) * 1e3
            found.append(f"{name}: the drift reaches {largest:.3g} mm: is a column in another unit, or the zero lost?")
        leg = check.campaign.leg
        if leg is not None and run.q is not None:
            low, high = leg.stroke
            slack = 0.01 * (high - low)
            if run.q[0] < low - slack or run.q[1] > high + slack:
                seen = f"{run.q[0] * 1e3:.1f} to {run.q[1] * 1e3:.1f}"
                found.append(f"{name}: q_mm runs from {seen}, outside stroke_mm [{low * 1e3:g}, {high * 1e3:g}]")
        found.extend(
            f"{name}, {step.channel}: {step.step}, {step.count} x; {step.reason}"
            for step in record.steps
            if _matters(step, record.rows)
        )
    return found


def _matters(step: CleaningStep, rows: int) -> bool:
    """Whether a step of cleaning is worth a warning of its own."""
    if step.step in ("not settled", "gap", "no drift"):
        return False
    many = step.count > 0.01 * rows
    return many if step.step in COMMON_STEPS or step.action == NOTED else True


def _of_sensors(check: CampaignCheck) -> list[str]:
    """Return what is said of the thermocouples."""
    found = []
    sensors, noise = check.campaign.sensors, check.sensor_noise
    usual = float(np.nanmedian(noise)) if np.isfinite(noise).any() else np.nan
    for k, sensor in enumerate(sensors):
        if noise[k] > 4.0 * usual:
            found.append(f"{sensor}: noise {noise[k]:.3f} K, {noise[k] / usual:.0f} times that of the other sensors")
    high = [sensor for sensor, value in zip(sensors, check.inflation, strict=True) if value > LARGEST_INFLATION]
    if high:
        which = "all sensors" if len(high) == len(sensors) else ", ".join(high)
        found.append(
            f"{which}: the others say nearly the same (variance inflation above {LARGEST_INFLATION:g}); their "
            "coefficients in one law would be large, of opposite sign and worthless: take one or two"
        )
    return found


def _of_apart(check: CampaignCheck) -> list[str]:
    """Return what is said of the coefficients."""
    items = [item for item in check.separability if item.r > APART]
    if not items:
        return []
    which = "every sensor" if len(items) == len(check.separability) else ", ".join(one.sensor for one in items)
    how = "not" if max(item.r for item in items) > HARDLY else "hardly"
    return [
        f"A and B of {which} can {how} be told apart: the leg "
        "was warm at nearly one q only (as when it is heated by the same movement each time); run it hot at fixed q "
        "over the whole stroke, and cold while moving"
    ]


def _of_weather(check: CampaignCheck) -> list[str]:
    """Return what is said of the air."""
    beams = check.campaign.beams
    if check.campaign.kind != "leg" or beams is None:
        return []
    if np.isnan(check.weather).any():
        if beams.index_compensated:
            return ["the weather is not recorded: whether the beams were compensated rightly cannot be checked"]
        return ["the weather is not recorded and the beams are not compensated: drift holds the air's index"]
    if not np.isfinite(check.weather_effect):
        return ["readings of the weather lie outside 'any air' (-40 to 100 degC, 0 to 1 humidity): check their units"]
    return []


def as_data(check: CampaignCheck) -> dict[str, Any]:
    """Return a check as plain values, units in the names; what is not known is null."""
    campaign = check.campaign
    low, high = check.weather
    data = {
        "format": FORMAT,
        "title": campaign.title,
        "kind": campaign.kind,
        "runs": [_run_data(run) for run in check.runs],
        "sensors": [
            {"name": sensor, "noise_K": noise, "slow_deviation_K": slow, "variance_inflation": inflation,
             "largest_dT_K": item.span, "r_A_B": item.r, "std_A_um_per_m_K_per_um": item.std_A,
             "std_B_um_per_m_K_per_um": item.std_B, "told_apart": told_apart(item)}
            for sensor, noise, slow, inflation, item in zip(
                campaign.sensors, check.sensor_noise, check.sensor_slow, check.inflation, check.separability,
                strict=True,
            )
        ],
        "correlation": check.correlation,
        "condition_number": check.condition,
        "cycles": [{"sensor": item.sensor, "period_min": item.period / 60.0, "amplitude_K": item.amplitude}
                   for item in cycles(check)],
        "weather": {"temperature_degC": [low[0], high[0]], "pressure_hPa": [low[1] / 100.0, high[1] / 100.0],
                    "humidity_percent": [low[2] * 100.0, high[2] * 100.0],
                    "effect_on_beams_um": check.weather_effect * 1e6},
        "warnings": list(warnings_of(check)),
    }  # fmt: skip
    found: dict[str, Any] = plain(data)
    return found


def _run_data(run: RunCheck) -> dict[str, Any]:
    """Return a run as plain values."""
    return {
        "name": run.run.name, "role": run.run.role, "cleaning": run.record.as_data(), "landings": run.landings,
        "lowest_degC": run.lowest_degC, "highest_degC": run.highest_degC, "lowest_dT_K": run.lowest_dT,
        "highest_dT_K": run.highest_dT, "drift_um": [1e6 * value for value in run.drift],
        "q_mm": None if run.q is None else [1e3 * value for value in run.q],
        "drift_noise_um": run.drift_noise * 1e6, "landing_noise_um": run.landing_noise * 1e6,
        "sensor_noise_K": run.sensor_noise,
    }  # fmt: skip


def plain(value: Any) -> Any:
    """Return a value that JSON knows: arrays as lists, what is not finite as None."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [plain(item) for item in value]
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value


def hours(check: CampaignCheck) -> FloatArray:
    """Return the duration of each run [h]."""
    return np.array([run.record.duration / 3600.0 for run in check.runs])
