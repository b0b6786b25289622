"""What makes the readings themselves doubtful: units, strokes, clocks, landings that scatter as the drift does."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from hexathermal.learn.campaign import Campaign
from hexathermal.learn.check_remarks import (
    Clock,
    of_clock,
    of_fahrenheit,
    of_length,
    of_one_fahrenheit,
    of_places,
    of_pressure,
    of_rises,
    of_stroke,
)
from hexathermal.learn.diagnosis.channels import Levels
from hexathermal.learn.signals import RunRows
from hexathermal.poses import FloatArray

SCATTERED = 1.0 / 3.0
"""Scatter of landings over the RMS of the drift from which on rows of a moving rod are likely among those at rest."""

APART_K, FEWEST = 12.0, 4
"""A thermometer that is farther from the middle of so many, or more, when each run begins reads in another unit."""


def doubtful_readings(
    campaign: Campaign, rows: Sequence[RunRows], drift: FloatArray, levels: Levels
) -> tuple[str, ...]:
    """Return what `check_campaign` would warn of in the rows that are read, one sentence each.

    Parameters
    ----------
    campaign : Campaign
    rows : sequence of RunRows
        Of all runs that are read.
    drift : array, shape (w,) [m]
        In windows of the runs for identification.
    levels : Levels
        Noise of that.
    """
    clocks = [Clock(one.run.name, one.record.rows, one.record.duration, one.record.sampling) for one in rows]
    weather = [one.weather for one in rows if one.weather is not None and len(one.weather)]
    read = np.concatenate([table[:, 1] for table in weather]) if weather else np.zeros(0)
    known = read[np.isfinite(read)]
    pressure = (float(known.min()), float(known.max())) if len(known) else (math.nan, math.nan)
    return (
        *of_clock(clocks), *of_rises(_rises(rows)), *_of_strokes(campaign, rows), *of_places(campaign),
        *_of_temperatures(rows), *of_pressure(campaign, *pressure), *_of_landings(drift, levels),
    )  # fmt: skip


def _rises(rows: Sequence[RunRows]) -> dict[str, tuple[float, float]]:
    """Return by how much the middle one of all thermometers changes in each run [K], and how long that is [s]."""
    found = {}
    for one in rows:
        spans = np.array([np.ptp(values) for values in one.signals.dT.values()])
        known = spans[np.isfinite(spans)]
        found[one.run.name] = float(np.median(known)) if len(known) else 0.0, float(np.ptp(one.signals.time))
    return found


def _of_strokes(campaign: Campaign, rows: Sequence[RunRows]) -> list[str]:
    """Return that a leg is as short as no leg is, or else was where its stroke does not reach: of the farthest run."""
    if campaign.leg is None:
        return []
    if found := of_length(campaign.leg.retracted_length, campaign.leg.stroke):
        return found
    low, high = campaign.leg.stroke
    spans = {one.run.name: (float(one.signals.q.min()), float(one.signals.q.max())) for one in rows}
    odd = {name: words for name, span in spans.items() if (words := of_stroke(span, (low, high)))}
    if not odd:
        return []
    worst = max(odd, key=lambda name: max(low - spans[name][0], spans[name][1] - high))
    others = f" and {len(odd) - 1} more" if len(odd) > 1 else ""
    return [f"{worst}{others}: {odd[worst]}: is a column exchanged, or in another unit?"]


def _of_temperatures(rows: Sequence[RunRows]) -> list[str]:
    """Return what is said of temperatures that can hardly be in degrees Celsius."""
    sensors = tuple(name for name in rows[0].signals.dT if all(name in one.signals.zero_degC for one in rows))
    lowest = {one.run.name: np.array([one.signals.zero_degC[name] + one.signals.dT[name].min() for name in sensors])
              for one in rows}  # fmt: skip
    weather = [float(one.weather[:, 0].min()) for one in rows if one.weather is not None and len(one.weather)]
    air = min(weather, default=float("nan"))
    found = of_fahrenheit(sensors, list(lowest.values()), air) + of_one_fahrenheit(sensors, lowest)
    return found or _apart(rows, sensors)


def _apart(rows: Sequence[RunRows], sensors: Sequence[str]) -> list[str]:
    """Return which thermometers read far from all others when runs begin, in a part that rests in a room."""
    zeros = np.array([[one.signals.zero_degC[name] for name in sensors] for one in rows])
    if len(sensors) < FEWEST:
        return []
    usual = np.median(zeros, axis=1)[:, None]
    odd = (np.abs(zeros - usual) > APART_K).all(axis=0)
    return [
        f"{name}: {np.median(zeros[:, k]):.1f} degC when runs begin, where most others read {np.median(usual):.1f}: is "
        "it in another unit?"
        for k, name in enumerate(sensors) if odd[k]
    ]  # fmt: skip


def _of_landings(drift: FloatArray, levels: Levels) -> list[str]:
    """Return that landings scatter as the drift does."""
    size = float(np.sqrt((drift**2).mean()))
    if not levels.landing > SCATTERED * size > 0.0:
        return []
    return [
        f"landings scatter by {levels.landing * 1e6:.2g} um, {levels.landing / size:.0%} of the drift: are rows of a "
        "moving rod among them? settled is 1 only where the rod has come to rest"
    ]
