"""What the numbers of a check mean, in words: warnings, what can be told apart; and plain data."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from hexathermal.learn.campaign import LegDimensions
from hexathermal.learn.check import CampaignCheck, RunCheck
from hexathermal.learn.check_cycles import cycles
from hexathermal.learn.check_remarks import (
    Clock,
    of_clock,
    of_collinearity,
    of_fahrenheit,
    of_length,
    of_noise,
    of_one_fahrenheit,
    of_places,
    of_pressure,
    of_roles,
    of_stroke,
)
from hexathermal.learn.check_sums import Separability
from hexathermal.learn.cleaning import is_lost
from hexathermal.learn.cleaning_record import NOTED, CleaningStep
from hexathermal.poses import FloatArray

FORMAT = "hexathermal-check/1"

APART, HARDLY = 0.97, 0.99
"""Cosine between ``q0 dT`` and ``q dT``: up to the first `A` and `B` are told apart, beyond the second not."""

SMALLEST_SPAN_K = 0.5
"""Temperatures that rise by less teach next to nothing."""

SMALLEST_SPAN_M, SMALLEST_SHARE = 1e-5, 0.01
"""A rod that moves by more than the first, and by less than this share of the stroke, moves in another unit."""

LARGEST_DRIFT_M = 1e-3
COMMON_STEPS = ("spike", "beam spike", "drift spike")


def told_apart(item: Separability, stroke: float | None = None) -> str:
    """Return in words whether the data can tell `A` and `B` of a sensor apart, and what to measure where they cannot.

    Parameters
    ----------
    item : Separability
    stroke : float, optional [m]
        Length of the leg's stroke.
    """
    if not item.span > SMALLEST_SPAN_K:
        if item.span > 0.0:
            return f"hardly warmed ({item.span:.2f} K): neither A nor B; heat it more"
        return "reads one temperature throughout: neither A nor B" if item.span == 0.0 else "no values"
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
    campaign = check.campaign
    clocks = [Clock(run.run.name, run.record.rows, run.record.duration, run.record.sampling) for run in check.runs]
    lowest = {run.run.name: run.lowest_degC for run in check.runs}
    return (*of_roles(campaign), *of_clock(clocks), *_of_leg(campaign.leg), *of_places(campaign), *_of_runs(check),
            *_of_stroke(check), *_of_warmth(check.separability),
            *of_noise(campaign.sensors, check.sensor_noise), *of_collinearity(campaign.sensors, check.inflation),
            *_of_apart(check), *_of_weather(check), *of_pressure(campaign, *check.weather[:, 1].tolist()),
            *of_fahrenheit(campaign.sensors, list(lowest.values()), float(check.weather[0, 0])),
            *of_one_fahrenheit(campaign.sensors, lowest))  # fmt: skip


def _of_leg(leg: LegDimensions | None) -> list[str]:
    """Return what is said of a leg's dimensions."""
    return [] if leg is None else of_length(leg.retracted_length, leg.stroke)


def _of_runs(check: CampaignCheck) -> list[str]:
    """Return what is said of single runs; what is the same of several, once."""
    said: dict[str, list[str]] = {}
    for run in check.runs:
        for words in _of_run(check, run):
            said.setdefault(words, []).append(run.run.name)
    whole = len(check.runs)
    return [("every run" if len(runs) == whole > 1 else ", ".join(runs)) + words for words, runs in said.items()]


def _of_run(check: CampaignCheck, run: RunCheck) -> Iterator[str]:
    """Yield what is said of a run, behind its name."""
    record = run.record
    if not record.used:
        yield f": no row may be used: {record.why_rows}"
        return
    if is_lost(record):
        yield (
            f": cleaning left only {record.used} of {record.rows} rows, identify and validate refuse it: "
            f"{record.why_rows}"
        )
    if max(map(abs, run.drift)) > LARGEST_DRIFT_M:
        largest = max(map(abs, run.drift)) * 1e3
        yield f": the drift reaches {largest:.3g} mm: is a column in another unit, or the zero lost?"
    leg = check.campaign.leg
    if leg is not None and (off := of_stroke(run.q, leg.stroke)):
        yield f": {off}"
    for step in record.steps:
        if _matters(step, record.rows):
            yield f", {step.channel}: {step.step}, {step.count} x; {step.reason}"


def _of_stroke(check: CampaignCheck) -> list[str]:
    """Return what is said of displacements that cover next to nothing of the stroke."""
    spans = [run.q for run in check.runs if run.q is not None]
    if check.campaign.leg is None or not spans:
        return []
    low, high = min(q[0] for q in spans), max(q[1] for q in spans)
    stroke = check.campaign.leg.stroke[1] - check.campaign.leg.stroke[0]
    if not SMALLEST_SPAN_M < high - low < SMALLEST_SHARE * stroke:
        return []
    return [
        f"q_mm covers {(high - low) * 1e3:.3g} mm in all runs together, the stroke is {stroke * 1e3:g} mm: are q_mm "
        "and the beams in metres?"
    ]


def _of_warmth(items: Sequence[Separability]) -> list[str]:
    """Return what is said where no thermometer warmed, or hardly."""
    spans = [item.span for item in items if np.isfinite(item.span)]
    if not spans or max(spans) > SMALLEST_SPAN_K:
        return []
    if max(spans) > 0.0:
        return [f"no thermometer rises or falls by more than {max(spans):.2f} K: a law learns next to nothing; "
                "heat the part by some kelvins"]  # fmt: skip
    return [
        "no thermometer changes at all: no law can be identified from this campaign, nor one judged; heat the part by "
        "some kelvins, and look whether the loggers run"
    ]


def _matters(step: CleaningStep, rows: int) -> bool:
    """Whether a step of cleaning is worth a warning of its own."""
    if step.step in ("not settled", "gap", "no drift"):
        return False
    many = step.count > 0.01 * rows
    return many if step.step in COMMON_STEPS or step.action == NOTED else True


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
    if check.campaign.kind != "leg" or beams is None or not any(run.record.used for run in check.runs):
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
        "cycles": [{"sensor": item.sensor, "period_min": item.period / 60.0, "amplitude_K": item.amplitude,
                    "input": item.input or None}
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
