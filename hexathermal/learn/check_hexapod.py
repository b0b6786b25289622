"""What a metrologist asks of a campaign of a whole machine: noise, ranges, likeness, what can be told apart.

A deviation is what was measured less what was commanded. Its noise is blind to trends, as that of thermometers; where
a pose was held over neighbouring rows it is that of the measurement, from pose to pose the machine's errors are in it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hexathermal.errors import HexathermalError
from hexathermal.learn.campaign import Campaign, RunFile
from hexathermal.learn.campaign_dataset import read_run
from hexathermal.learn.check_remarks import (
    Clock,
    of_clock,
    of_fahrenheit,
    of_noise,
    of_roles,
)
from hexathermal.learn.check_sums import PairSums, collinearity
from hexathermal.learn.cleaning_rules import TO_SIGMA, codes_in, noise_of
from hexathermal.learn.hexapod_data import AXES, coded, hexapod_rows
from hexathermal.learn.hexapod_fit import model_of
from hexathermal.learn.hexapod_model import hexapod_equations
from hexathermal.learn.hexapod_observability import Observability, observability
from hexathermal.poses import FloatArray

SAME_POSE = 1e-6
"""Commanded coordinates [m, rad] that differ by less are the same pose."""

FEWEST_ROWS = 10
"""Rows that a noise is taken from."""

LEAST_NOISE = 1e-9
"""Noise [m, rad] that what can be told apart is reckoned with at least."""

FAR = 5e-3
"""Deviations [m, rad] beyond this are no drift of a machine."""

SMALLEST_SPAN_K = 0.5
"""Temperatures that change by less teach next to nothing."""

Progress = Callable[[int, int, str], None]


@dataclass(frozen=True, eq=False)
class HexapodRunCheck:
    """What is seen in one run; n usable rows, s thermometers.

    Attributes
    ----------
    run : RunFile
    rows : int
        Of the table.
    left_out : dict of str to int
        Reasons and numbers of rows.
    clock : Clock
    poses : int
        Different commanded poses.
    time : array, shape (n,) [s]
        Since the run's first row.
    heat : array, shape (n, s) [degC]
        NaN where there is no reading.
    deviation : array, shape (n, 6) [m, rad]
        Measured less commanded coordinates.
    sensor_noise : array, shape (s,) [K]
    noise, scatter : array, shape (6,) [m, rad]
        Of the deviation where the pose was held, and from pose to pose; NaN where there are too few rows.
    """

    run: RunFile
    rows: int
    left_out: dict[str, int]
    clock: Clock
    poses: int
    time: FloatArray
    heat: FloatArray
    deviation: FloatArray
    sensor_noise: FloatArray
    noise: FloatArray
    scatter: FloatArray


@dataclass(frozen=True, eq=False)
class HexapodCheck:
    """What is seen in a campaign of a whole machine.

    Attributes
    ----------
    campaign : Campaign
    runs : tuple of HexapodRunCheck
    sensor_noise, sensor_slow : array, shape (s,) [K]
        As of `hexathermal.learn.check.CampaignCheck`.
    lowest_degC, highest_degC, largest_dT : array, shape (s,) [degC, degC, K]
        `largest_dT` from the first usable row of the campaign or of each run, as `zero` says.
    correlation : array, shape (s, s)
    inflation : array, shape (s,)
    condition : float
    noise, scatter : array, shape (6,) [m, rad]
        Over all runs.
    observability : Observability or None
        What the poses and temperatures of the runs for identification tell of the laws of six legs and two plates.
    why_not : str
        Why there is none.
    """

    campaign: Campaign
    runs: tuple[HexapodRunCheck, ...]
    sensor_noise: FloatArray
    sensor_slow: FloatArray
    lowest_degC: FloatArray
    highest_degC: FloatArray
    largest_dT: FloatArray
    correlation: FloatArray
    inflation: FloatArray
    condition: float
    noise: FloatArray
    scatter: FloatArray
    observability: Observability | None
    why_not: str


def check_hexapod_campaign(campaign: Campaign, progress: Progress | None = None) -> HexapodCheck:
    """Return what is seen in the usable rows of a campaign of kind ``"hexapod"``.

    Parameters
    ----------
    campaign : Campaign
    progress : callable, optional
        Called as ``progress(done, total, label)``.

    Raises
    ------
    CampaignError
        A table is at fault.
    """
    runs, sums, spans = list[HexapodRunCheck](), list[PairSums](), list[FloatArray]()
    zero: FloatArray | None = None
    for k, run in enumerate(campaign.runs):
        if progress is not None:
            progress(k, len(campaign.runs), f"checking {run.name}")
        one = _run_check(campaign, run)
        runs.append(one)
        if not len(one.time):
            continue
        if zero is None or campaign.zero == "run":
            zero = _first(one.heat)
        total = PairSums(len(campaign.sensors))
        total.add_heat(one.heat - zero)
        sums.append(total)
        spans.append(_extreme(np.abs(one.heat - zero), np.fmax))
    s = len(campaign.sensors)
    noise = _together([one.sensor_noise for one in runs], s)
    correlation, inflation, condition, slow = collinearity(sums, noise)
    coordinates, scatter = _together([one.noise for one in runs], 6), _together([one.scatter for one in runs], 6)
    if progress is not None:
        progress(0, 0, "what can be told apart (the first time compiles)")
    seen, why_not = _told_apart(campaign, np.fmin(coordinates, scatter))
    heat, largest = (
        np.concatenate([one.heat for one in runs]),
        _extreme(np.array(spans).reshape(len(spans), s), np.fmax),
    )
    return HexapodCheck(
        campaign, tuple(runs), noise, slow, _extreme(heat, np.fmin), _extreme(heat, np.fmax), largest, correlation,
        inflation, condition, coordinates, scatter, seen, why_not,
    )  # fmt: skip


def _run_check(campaign: Campaign, run: RunFile) -> HexapodRunCheck:
    """Return what is seen in one run."""
    data = read_run(campaign, run)
    time = data["time"].values
    n, s = len(time), len(campaign.sensors)
    heat = data["temperature"].values if "temperature" in data else np.full((n, s), np.nan)
    heat = np.where(codes_in(heat, True), np.nan, heat)
    commanded = np.column_stack([data[axis].values for axis in AXES])
    measured = np.column_stack([data[f"measured_{axis}"].values for axis in AXES])
    good, left_out = np.ones(n, dtype=bool), dict[str, int]()
    for reason, bad in (
        ("not settled", data["settled"].values != 1.0 if "settled" in data else ~good),
        ("no measured pose", ~np.isfinite(measured).all(axis=1) | coded(data, "measured_")),
        ("no time, commanded pose or displacement", ~(np.isfinite(commanded).all(axis=1) & np.isfinite(time)
                                                      & np.isfinite(data["leg_q"].values).all(axis=1))
         | coded(data, "") | coded(data, "leg")),
    ):  # fmt: skip
        if (good & bad).any():
            left_out[reason] = int((good & bad).sum())
        good &= ~bad
    begun = float(np.nanmin(time)) if np.isfinite(time).any() else 0.0
    time, heat, commanded = time[good] - begun, heat[good], commanded[good]
    deviation = measured[good] - commanded
    noise, scatter = _noises(commanded, deviation)
    clock = Clock(run.name, n, float(np.ptp(time)) if len(time) else 0.0,
                  float(np.median(np.diff(time))) if len(time) > 1 else np.nan)  # fmt: skip
    poses = len(np.unique(np.round(commanded / SAME_POSE), axis=0)) if len(time) else 0
    quiet = noise_of(heat) if len(time) > 2 else np.full(s, np.nan)
    return HexapodRunCheck(run, n, left_out, clock, poses, time, heat, deviation, quiet, noise, scatter)


def _noises(commanded: FloatArray, deviation: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the noise of the deviation where the pose was held over three rows, and where it was not."""
    unknown = np.full(6, np.nan)
    if len(commanded) < 3:
        return unknown, unknown
    still = np.asarray((np.abs(np.diff(commanded, axis=0)) < SAME_POSE).all(axis=1))
    held = still[1:] & still[:-1]
    found = []
    for which in (held, np.logical_not(held)):
        rows = np.flatnonzero(which)
        if len(rows) < FEWEST_ROWS:
            found.append(unknown)
            continue
        # three rows each, one behind the other: the middle of every three is one bend
        bends = np.stack([deviation[rows], deviation[rows + 1], deviation[rows + 2]], axis=1)
        found.append(np.array([_noise_of_threes(bends[:, :, axis]) for axis in range(6)]))
    return found[0], found[1]


def _noise_of_threes(threes: FloatArray) -> float:
    """Return the noise of values taken three in a row, shape (n, 3), by the rule of `noise_of`."""
    bend = np.abs(threes[:, 1] - 0.5 * (threes[:, 0] + threes[:, 2]))
    return float(TO_SIGMA * np.median(bend) / np.sqrt(1.5))


def _first(heat: FloatArray) -> FloatArray:
    """Return the first reading of each thermometer."""
    rows = np.argmax(np.isfinite(heat), axis=0)
    return np.asarray(heat[rows, np.arange(heat.shape[1])])


def _extreme(values: FloatArray, which: np.ufunc) -> FloatArray:
    """Return the lowest or highest of each column, NaN where there is none."""
    return np.asarray(which.reduce(values, axis=0, initial=np.nan))


def _together(parts: list[FloatArray], size: int) -> FloatArray:
    """Return the root mean square of the runs' noises; NaN where no run knows it."""
    squares = np.square(np.array(parts).reshape(len(parts), size))
    count = np.isfinite(squares).sum(axis=0)
    return np.sqrt(np.where(count > 0, np.nansum(squares, axis=0) / np.maximum(count, 1), np.nan))


def _told_apart(campaign: Campaign, noise: FloatArray) -> tuple[Observability | None, str]:
    """Return what the runs for identification tell of the laws, one a leg; or why it cannot be said."""
    try:
        rows = hexapod_rows(campaign, "identification")
        used = np.where(np.isfinite(noise), np.maximum(noise, LEAST_NOISE), LEAST_NOISE)
        plates = tuple(None if recorded else 0.0 for recorded in rows.recorded_plates)
        model = model_of("leg-specific", rows.sensors, rows.sensors, common=False, plates=(plates[0], plates[1]))
        return observability(hexapod_equations(rows, used, 0.0).S, model), ""
    except HexathermalError as error:
        return None, str(error)


def hexapod_warnings(check: HexapodCheck) -> tuple[str, ...]:
    """Return what the experimenter should know before fitting, one sentence each."""
    campaign = check.campaign
    found = of_roles(campaign) + of_clock([one.clock for one in check.runs])
    for one in check.runs:
        why = "; ".join(f"{count} rows: {reason}" for reason, count in one.left_out.items())
        if not len(one.time):
            found.append(f"{one.run.name}: no row may be used: {why}")
            continue
        if len(one.time) < 0.1 * one.rows:
            found.append(f"{one.run.name}: only {len(one.time)} of {one.rows} rows may be used: {why}")
        largest = np.abs(one.deviation).max(axis=0)
        far = [f"{axis} {value * 1e3:.3g} {'mm' if k < 3 else 'mrad'}"
               for k, (axis, value) in enumerate(zip(AXES, largest, strict=True)) if value > FAR]  # fmt: skip
        if far:
            found.append(
                f"{one.run.name}: measured and commanded poses differ by up to {', '.join(far)}: another frame, order "
                "of rotations or unit?"
            )
    dead = [name for name, value in zip(campaign.sensors, check.highest_degC, strict=True) if np.isnan(value)]
    if dead:
        found.append(f"{', '.join(dead)}: not one reading in the whole campaign")
    cold = [name for name, span in zip(campaign.sensors, check.largest_dT, strict=True) if span < SMALLEST_SPAN_K]
    if cold:
        found.append(f"{', '.join(cold)}: changes by less than {SMALLEST_SPAN_K:g} K: its coefficients cannot be found")
    found += of_noise(campaign.sensors, check.sensor_noise)
    found += of_fahrenheit(campaign.sensors, [check.lowest_degC], float("nan"))
    if check.observability is not None:
        lost = [one.name for one in check.observability.coefficients if one.moved and not one.told_apart]
        if lost:
            some = ", ".join(lost[:4]) + (", ..." if len(lost) > 4 else "")
            found.append(
                f"{len(lost)} of {len(check.observability.coefficients)} coefficients cannot be told apart from the "
                f"rest ({some}): measure hot, and cold, at poses with long and with short legs, and warm the legs "
                "differently"
            )
    if check.why_not:
        found.append(f"what can be told apart cannot be said: {check.why_not}")
    return tuple(found)
