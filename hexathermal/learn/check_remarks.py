"""What is said of any campaign before a fit, in words: roles, clocks, units, noise and likeness of thermometers."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from hexathermal.learn.campaign import Campaign
from hexathermal.learn.copied_runs import repeated_words
from hexathermal.poses import FloatArray

LARGEST_INFLATION = 30.0
"""Variance inflation from which a sensor says what the others say."""

LEAST_NOISE_K = 1e-3
"""Noise of a thermometer that is never too much."""

HOUR_S, YEAR_S = 3600.0, 365.25 * 86400.0

SLOWEST_H = 1.0
"""A row after more hours than that is not of a bench's clock in seconds;"""

SHORTEST_S, FEWEST_ROWS, FASTEST_HZ = 60.0, 100, 5.0
"""nor is a run shorter than this with more rows, and more in a second, than a thermometer has to say."""

FAHRENHEIT = (50.0, 100.0)
"""A room [degC] that is never colder is one in degrees Fahrenheit."""

ROOMS_K = 5.0
"""What is in degrees Fahrenheit is so near to what the others read."""

SLACK = 0.01
"""A rod may be seen outside its stroke by so much of it."""

LEAST_LENGTH, LONGEST_M = 0.5, 20.0
"""A leg is longer than this part of its stroke, which it holds when it is retracted, and shorter than a hall."""

NEAR_JOINT = 0.01
"""Places that are all nearer to the lower joint than this part of a leg are in metres."""

LONGEST_SHORT_S, LEAST_RISE_K = 900.0, 0.5
"""Runs in which temperatures change by so much last longer than this."""

MERCURY, SEA_HPA, SCALE_M = (700.0, 790.0), 1013.25, 8200.0
"""Pressures [hPa] of a place 2 to 3 km above the sea, or, in millimetres of mercury, of most laboratories; the mean
pressure at the sea, and the height over which it falls to 1/e."""


def of_stroke(seen: tuple[float, float] | None, stroke: tuple[float, float] | None) -> str:
    """Return that a rod was where its stroke [m] does not reach; empty where it was not, or nothing is known."""
    if seen is None or stroke is None:
        return ""
    slack = SLACK * (stroke[1] - stroke[0])
    if seen[0] >= stroke[0] - slack and seen[1] <= stroke[1] + slack:
        return ""
    return (
        f"q_mm runs from {seen[0] * 1e3:.1f} to {seen[1] * 1e3:.1f}, outside stroke_mm [{stroke[0] * 1e3:g}, "
        f"{stroke[1] * 1e3:g}]"
    )


def of_length(retracted: float | None, stroke: tuple[float, float] | None) -> list[str]:
    """Return that a leg's retracted length [m] hardly goes with its stroke [m]; nothing of a part without them."""
    if retracted is None or stroke is None or LEAST_LENGTH * (stroke[1] - stroke[0]) <= retracted <= LONGEST_M:
        return []
    return [
        f"q0_mm is {retracted * 1e3:g}, the stroke {(stroke[1] - stroke[0]) * 1e3:g} mm: is q0_mm in another unit? It "
        "is the length from joint to joint with the rod retracted, in mm"
    ]


def of_places(campaign: Campaign) -> list[str]:
    """Return that thermocouples sit so near to the lower joint of a leg as places in metres do."""
    places = [one.position for one in campaign.thermocouples if one.position is not None]
    if campaign.leg is None or len(places) < 2 or not 0.0 < max(places) < NEAR_JOINT * campaign.leg.retracted_length:
        return []
    return [
        f"all thermocouples sit within {max(places) * 1e3:.3g} mm of the lower joint centre, on a leg of "
        f"{campaign.leg.retracted_length * 1e3:g} mm: is position_mm in metres?"
    ]


def of_pressure(campaign: Campaign, lowest: float, highest: float) -> list[str]:
    """Return that pressures [Pa], NaN where none is read, may be in millimetres of mercury, unless it is accepted."""
    read = (lowest + highest) / 200.0
    if not MERCURY[0] < read < MERCURY[1] or "unusual-weather" in campaign.accepted:
        return []
    height = SCALE_M * math.log(SEA_HPA / read)
    return [
        f"air_pressure_hPa reads {read:.0f} hPa, that of {round(height, -2):.0f} m above the sea: is it in millimetres "
        "of mercury? "
        'Convert it, or, if it is so, write accept = ["unusual-weather"] in [cleaning] of campaign.toml'
    ]


@dataclass(frozen=True)
class Clock:
    """Rows, duration [s] and median step in time [s] of a run."""

    run: str
    rows: int
    duration: float
    sampling: float


def of_roles(campaign: Campaign) -> list[str]:
    """Return what is said of the roles of runs."""
    found = []
    if not campaign.runs_of("validation"):
        found.append('no validation run: what is identified cannot be validated; give a run role = "validation"')
    if not campaign.runs_of("identification"):
        found.append('no identification run: nothing can be identified; give a run role = "identification"')
    return found + repeated_words(campaign)


def of_clock(clocks: list[Clock]) -> list[str]:
    """Return what is said of runs whose time can hardly be in seconds."""
    kinds: tuple[tuple[str, Callable[[Clock], float], float], ...] = (
        ("one row every {:.3g} h: is time_s in milliseconds?", lambda one: one.sampling / HOUR_S, SLOWEST_H),
        ("a duration of {:.3g} years: is time_s in milliseconds?", lambda one: one.duration / YEAR_S, 1.0),
        ("{:.3g} rows a second over the whole run: is time_s in hours or minutes?", _short_rate, FASTEST_HZ),
    )
    found, said = list[str](), set[str]()
    for words, value, limit in kinds:
        odd = [one for one in clocks if value(one) > limit and one.run not in said]
        said |= {one.run for one in odd}
        if odd:
            which = "every run" if len(odd) == len(clocks) > 1 else ", ".join(one.run for one in odd)
            found.append(f"{which}: {words.format(max(map(value, odd)))}")
    return found


def of_rises(rises: Mapping[str, tuple[float, float]]) -> list[str]:
    """Return that runs are as short as no warming is; `rises` of temperatures [K] and durations [s], by run."""
    warm = {run: (rise, duration) for run, (rise, duration) in rises.items() if rise > LEAST_RISE_K}
    if not warm or max(duration for _rise, duration in rises.values()) > LONGEST_SHORT_S:
        return []
    run, (rise, duration) = max(warm.items(), key=lambda item: item[1][0])
    return [f"temperatures change by {rise:.1f} K in {duration / 60.0:.0f} min ({run}): is time_s in minutes?"]


def _short_rate(one: Clock) -> float:
    """Return the rows a second of a run that is short and has many rows; 0 of any other."""
    short = 0.0 < one.duration < SHORTEST_S and one.rows > FEWEST_ROWS
    return one.rows / one.duration if short else 0.0


def of_fahrenheit(sensors: tuple[str, ...], lowest: list[FloatArray], air: float) -> list[str]:
    """Return what is said of temperatures that look like degrees Fahrenheit: a room of 50 to 100 degC."""
    if not lowest or not sensors:
        return []
    with np.errstate(all="ignore"):
        low = np.fmin.reduce(lowest)
    warm = [sensor for sensor, value in zip(sensors, low, strict=True) if FAHRENHEIT[0] < value < FAHRENHEIT[1]]
    found = []
    if warm and len(warm) >= 0.5 * np.isfinite(low).sum():
        least = float(np.nanmin(low))
        found.append(
            f"{listed(warm, sensors)}: never below {least:.0f} degC in any run: degrees Fahrenheit? "
            "The columns are in degrees Celsius"
        )
    if FAHRENHEIT[0] < air < FAHRENHEIT[1]:
        found.append(f"air_temperature_degC: never below {air:.0f} degC: degrees Fahrenheit?")
    return found


def of_one_fahrenheit(sensors: tuple[str, ...], lowest: Mapping[str, FloatArray]) -> list[str]:
    """Return what is said of single runs or thermometers that read what the others read, in degrees Fahrenheit.

    `lowest` are the lowest temperatures [degC] of each sensor, by run.
    """
    table = np.array([*lowest.values()]).reshape(-1, len(sensors))
    with np.errstate(invalid="ignore"):
        warm = (table > FAHRENHEIT[0]) & (table < FAHRENHEIT[1])
        room = table[np.isfinite(table) & ~warm]
        usual = float(np.median(room)) if room.size else np.nan
        odd = warm & (np.abs((table - 32.0) / 1.8 - usual) < ROOMS_K)
    runs = list(lowest)
    columns = [name for name, own in zip(sensors, odd.T, strict=True) if own.all()]
    found = [
        f"{name}: never below {float(np.nanmin(table[:, sensors.index(name)])):.0f} degC, where the others read "
        f"{usual:.0f}: degrees Fahrenheit?"
        for name in columns
    ]
    for run, own, low in zip(runs, odd, table, strict=True):
        names = [name for name, one in zip(sensors, own, strict=True) if one and name not in columns]
        if names:
            found.append(
                f"{run}: {listed(names, sensors)} never below {float(np.nanmin(low[own])):.0f} degC, where it is "
                f"{usual:.0f} elsewhere: degrees Fahrenheit in this run?"
            )
    return found


def listed(some: list[str], everything: tuple[str, ...]) -> str:
    """Return names, or that it is all sensors."""
    return "all sensors" if len(some) == len(everything) > 1 else ", ".join(some)


def of_noise(sensors: tuple[str, ...], noise: FloatArray) -> list[str]:
    """Return what is said of thermometers that are much noisier than the others."""
    found = []
    usual = float(np.nanmedian(noise)) if np.isfinite(noise).any() else np.nan
    for k, sensor in enumerate(sensors):
        if not noise[k] > LEAST_NOISE_K:
            continue
        if usual > 0.0 and noise[k] > 4.0 * usual:
            found.append(f"{sensor}: noise {noise[k]:.3f} K, {noise[k] / usual:.0f} times that of the other sensors")
        # noise below half a step of a channel's resolution reads 0: only the channels that show some can be compared
        shown = [value for j, value in enumerate(noise) if j != k and value > 0.0]
        if usual == 0.0 and noise[k] > 4.0 * min(shown, default=0.0):
            found.append(f"{sensor}: noise {noise[k]:.3f} K, most other sensors show none")
    return found


def of_collinearity(sensors: tuple[str, ...], inflation: FloatArray) -> list[str]:
    """Return what is said of thermometers that say nearly the same."""
    found = []
    high = [sensor for sensor, value in zip(sensors, inflation, strict=True) if value > LARGEST_INFLATION]
    if high:
        found.append(
            f"{listed(high, sensors)}: the others say nearly the same (variance inflation above "
            f"{LARGEST_INFLATION:g}); their coefficients in one law would be large, of opposite sign and worthless: "
            "take one or two"
        )
    return found
