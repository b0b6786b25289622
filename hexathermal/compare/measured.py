"""What a campaign's run gives to the virtual bench, and what it is held against.

All rows, those while moving too, say where the rod was and how warm the room: they drive the bench. Settled and cleaned
rows (`hexathermal.learn.cleaning`) say what was measured; they are brought into windows of `WINDOW`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from hexathermal.errors import DataError
from hexathermal.learn.campaign import Block, Campaign, RunFile, joined
from hexathermal.learn.campaign_dataset import read_run
from hexathermal.learn.cleaning import usable_blocks
from hexathermal.learn.cleaning_channels import SMALLEST_MOVE_M
from hexathermal.learn.cleaning_rules import codes_in
from hexathermal.poses import FloatArray

if TYPE_CHECKING:
    import xarray as xr

STEP = 20.0
"""Step of time of the simulation [s], a longer one for runs with rarer rows."""

WINDOW = 900.0
"""Length of a window [s]: short beside the warming of a leg, long beside a landing."""

MOST_WINDOWS, MOST_STEPS = 48, 8000
"""Windows and steps of a run; longer runs take longer ones."""

LONGEST_GAP = 900.0
"""Displacement and room are interpolated over gaps of rows up to this [s]; a run with a longer one is left out."""

FASTEST_S = 0.5
"""A short run whose rows come faster than that may be in minutes, or in hours."""

FEWEST_WINDOWS = 3
"""Windows that a run needs to be compared."""

SLOPE_SPREAD = 0.010
"""A window says how drift depends on `q` where its rows spread by so much (standard deviation) [m]."""

SLOPE_LANDINGS = 6
"""And where it holds so many landings."""


@dataclass(frozen=True, eq=False)
class Windows:
    """Windows of the settled rows, w of them; rows of a window follow each other.

    Attributes
    ----------
    first : array, shape (w,), int
        First row of each window.
    count : array, shape (w,), int
        Rows of each.
    time : array, shape (w,) [s]
    landings : array, shape (w, l)
        Part of each window's rows that belong to each landing.
    centred : array, shape (n,) [m]
        `q` of each row less its window's mean.
    spread : array, shape (w,) [m^2]
        Mean of its square; 0 where the window says nothing of the slope.
    """

    first: npt.NDArray[np.int64]
    count: npt.NDArray[np.int64]
    time: FloatArray
    landings: FloatArray
    centred: FloatArray
    spread: FloatArray

    def mean(self, values: FloatArray) -> FloatArray:
        """Return means over the windows, along the first axis."""
        shape = (-1,) + (1,) * (values.ndim - 1)
        return np.asarray(np.add.reduceat(values, self.first, axis=0) / self.count.reshape(shape))

    def slope(self, values: FloatArray) -> FloatArray:
        """Return how values (n,) or (n, k) depend on `q` in each window; 0 where the window does not say."""
        shape = (-1,) + (1,) * (values.ndim - 1)
        found = self.mean(values * self.centred.reshape(shape))
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.spread.reshape(shape) > 0.0, found / self.spread.reshape(shape), 0.0)


@dataclass(frozen=True, eq=False)
class MeasuredRun:
    """A run: its motion and room step by step, its settled rows, and these in windows.

    Attributes
    ----------
    name, role : str
    step : float [s]
    q, way, air : array, shape (k,)
        Mean displacement [m], way gone [m] and mean air temperature [degC] of each step.
    way_doubt : float [1]
        Standard deviation of the way's error, as a part of it, see `_ways`.
    start_q, start_air : float [m], [degC]
        Of the first row.
    time, row_q, row_air : array, shape (n,)
        Of the settled rows: time since the run's first row [s], displacement [m], rise of the air [K].
    rises : array, shape (n, s) [K]
        Of the compared thermocouples, NaN where a value was rejected.
    drift : array, shape (n,) [m]
    windows : Windows
    landing_scatter : float [m]
        Standard deviation of the drift from landing to landing within a window.
    row_noise : array, shape (s,) [K]
        Standard deviation of one reading, from row to row.
    course : array, shape (4, r)
        Of all rows: time [s], displacement [m], way [m], air temperature [degC].
    lowest_degC : array, shape (s,)
        Lowest reading of each compared thermocouple, as recorded; NaN without any.
    """

    name: str
    role: str
    step: float
    q: FloatArray
    way: FloatArray
    air: FloatArray
    way_doubt: float
    start_q: float
    start_air: float
    time: FloatArray
    row_q: FloatArray
    row_air: FloatArray
    rises: FloatArray
    drift: FloatArray
    windows: Windows
    landing_scatter: float
    row_noise: FloatArray
    course: FloatArray
    lowest_degC: FloatArray


def measured_run(campaign: Campaign, run: RunFile, sensors: tuple[int, ...]) -> MeasuredRun | str:
    """Return a run as the bench needs it, or why it cannot be compared.

    Parameters
    ----------
    campaign : Campaign
        Of kind ``"leg"``.
    run : RunFile
    sensors : tuple of int
        Thermocouples that are compared.

    Raises
    ------
    DataError
        The room's temperature is not recorded.
    CampaignError
        The table is at fault.
    """
    data = read_run(campaign, run)
    time, q, air = _course(campaign, run, data)
    refused = _too_few(data) if time.size < 3 else _gap(time, data)
    if refused:
        return f"run {run.name} is not compared: {refused}"
    blocks = list(usable_blocks(campaign, run))
    rows = joined(blocks) if blocks else None
    lasts = 0.0 if rows is None else float(np.ptp(rows.time))
    if rows is None or rows.q is None or lasts < FEWEST_WINDOWS * WINDOW:
        return (
            f"run {run.name} is not compared: its usable rows last {lasts / 60.0:.3g} min, and at least "
            f"{FEWEST_WINDOWS * WINDOW / 60.0:.0f} min are needed{_hurried(time)}"
        )
    step = max(STEP, float(np.median(np.diff(time))), float(time[-1] - time[0]) / MOST_STEPS)
    windows = _windows(rows)
    if len(windows.time) < FEWEST_WINDOWS:
        return f"run {run.name} is not compared: it has fewer than {FEWEST_WINDOWS} windows with enough rows"
    way, doubt = _ways(q)
    edges = time[0] + step * np.arange(int(np.ceil((time[-1] - time[0]) / step)) + 1)
    rises, names = rows.dT[:, list(sensors)], [campaign.sensors[k] for k in sensors]
    return MeasuredRun(
        run.name, run.role, step, _means(time, q, edges), np.diff(np.interp(edges, time, way)),
        _means(time, air, edges), doubt, float(q[0]), float(air[0]), rows.time, rows.q,
        np.interp(rows.time, time, air) - air[0], rises, rows.drift, windows,
        _scatter(rows, windows), _row_noise(rises, rows.time),
        np.array([time, q, way, air]), _lowest(data["temperature"].sel(thermocouple=names).values),
    )  # fmt: skip


def _too_few(data: xr.Dataset) -> str:
    """Return why a run has too few rows to drive the bench, in words."""
    columns = {"time": "time_s", "q": "q_mm", "air_temperature": "air_temperature_degC"}
    empty = [column for name, column in columns.items() if not np.isfinite(data[name].values).any()]
    if empty:
        return f"{' and '.join(empty)} {'has' if len(empty) == 1 else 'have'} no value in any row"
    return "it has fewer than three rows with displacement and air temperature"


def _gap(time: FloatArray, data: xr.Dataset) -> str:
    """Return what is said of a run whose motion or room is not known for long; empty where it is."""
    steps = np.diff(time)
    gap, where = float(steps.max()), float(time[int(steps.argmax())])
    if gap <= LONGEST_GAP:
        return ""
    slow = float(np.median(steps))
    if slow > LONGEST_GAP:
        return (
            f"a row comes every {slow / 60.0:.0f} min, at most {LONGEST_GAP / 60.0:.0f} min are allowed: is time_s in "
            "milliseconds?"
        )
    recorded = np.asarray(data["time"].values, dtype=np.float64)
    recorded = recorded[np.isfinite(recorded)] - recorded[np.isfinite(recorded)][:1]
    silent = not ((recorded > where) & (recorded < where + gap)).any()
    what = "no row is recorded" if silent else "displacement or air temperature is missing"
    return (
        f"{what} for {gap / 60.0:.0f} min after {where / 3600.0:.2f} h; what the motor did then is not known (at most "
        f"{LONGEST_GAP / 60.0:.0f} min)"
    )


def _hurried(time: FloatArray) -> str:
    """Return a question about the unit of the time of rows that come faster than any logger of temperatures."""
    fast = float(np.median(np.diff(time)))
    if fast > FASTEST_S:
        return ""
    return f"; a row comes every {fast:.2g} s: is time_s in {'minutes' if fast > FASTEST_S / 60.0 else 'hours'}?"


def _lowest(degC: FloatArray) -> FloatArray:
    """Return the lowest reading of each thermocouple, shape (n, s) to (s,) [degC]; codes of missing values are none."""
    read = np.array([np.where(codes_in(column, temperatures=True), np.nan, column) for column in degC.T])
    return np.asarray(np.fmin.reduce(read, axis=1))


def _course(campaign: Campaign, run: RunFile, data: xr.Dataset) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return time since the first row, displacement and air temperature of all rows that have them."""
    if "air_temperature" not in data:
        raise DataError(
            f"run {run.name} of {campaign.file} has no column air_temperature_degC: the bench cannot be driven by a "
            "room that is not known"
        )
    time, q, air = (np.asarray(data[name].values, dtype=np.float64) for name in ("time", "q", "air_temperature"))
    first = time[np.isfinite(time)][:1]
    good = np.isfinite(time) & np.isfinite(q) & np.isfinite(air)
    time, places = np.unique(time[good], return_index=True)
    return time - (first[0] if first.size else 0.0), q[good][places], air[good][places]


def _ways(q: FloatArray) -> tuple[FloatArray, float]:
    """Return the way gone up to each row, and the standard deviation of its error as a part of it.

    A turn between two rows hides way: the least is what the rows show; the most, that the rod kept the pace of the
    rows before and after through the turn. Their mean is taken; what the scale's noise moves does not count.
    """
    step = np.diff(q)
    least = np.where(np.abs(step) > SMALLEST_MOVE_M, np.abs(step), 0.0)
    most = least.copy()
    turn = (least[1:-1] > 0.0) & (least[:-2] > 0.0) & (least[2:] > 0.0) & (step[:-2] * step[2:] < 0.0)
    pace = 0.5 * (least[:-2] + least[2:])
    most[1:-1][turn] = np.maximum(least[1:-1], pace)[turn]
    whole = np.cumsum(0.5 * (least + most))
    between = float((most - least).sum())
    doubt = between / np.sqrt(12.0) / whole[-1] if whole[-1] > 0.0 else 0.0
    return np.concatenate([[0.0], whole]), doubt


def _means(time: FloatArray, values: FloatArray, edges: FloatArray) -> FloatArray:
    """Return means between edges of a course that is linear between rows."""
    inside = np.union1d(time, edges)
    course = np.interp(inside, time, values)
    whole = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(inside) * (course[1:] + course[:-1]))])
    return np.asarray(np.diff(np.interp(edges, inside, whole)) / np.diff(edges))


def _windows(rows: Block) -> Windows:
    """Return the windows of a run's usable rows; those with fewer than three rows join the one before."""
    length = max(WINDOW, float(np.ptp(rows.time)) / MOST_WINDOWS)
    number = np.floor((rows.time - rows.time[0]) / length).astype(int)
    first = np.flatnonzero(np.diff(number, prepend=-1))
    count = np.diff(np.append(first, len(number)))
    while len(first) > 1 and (few := np.flatnonzero(count < 3)).size:
        first = np.delete(first, max(int(few[0]), 1))
        count = np.diff(np.append(first, len(number)))
    q = np.asarray(rows.q)
    window = np.repeat(np.arange(len(first)), count)
    centred = q - (np.add.reduceat(q, first) / count)[window]
    spread = np.add.reduceat(centred**2, first) / count
    landing = rows.landing - rows.landing.min()
    landings = np.zeros((len(first), int(landing.max()) + 1))
    np.add.at(landings, (window, landing), 1.0 / count[window])
    says = (spread > SLOPE_SPREAD**2) & ((landings > 0.0).sum(axis=1) >= SLOPE_LANDINGS)
    time = np.add.reduceat(rows.time, first) / count
    return Windows(first, count, time, landings, centred, np.where(says, spread, 0.0))


def _scatter(rows: Block, windows: Windows) -> float:
    """Return the scatter of the drift from landing to landing, what is linear in `q` and in time taken out."""
    squares, free = 0.0, 0
    landing = rows.landing
    for first, count, spread in zip(windows.first, windows.count, windows.spread, strict=True):
        if spread <= 0.0:
            continue
        part = slice(first, first + count)
        _names, place, size = np.unique(landing[part], return_inverse=True, return_counts=True)
        sums = [np.bincount(place, value[part]) / size for value in (rows.drift, np.asarray(rows.q), rows.time)]
        X = np.column_stack([np.ones(len(size)), sums[1] - sums[1].mean(), sums[2] - sums[2].mean()])
        rest = sums[0] - X @ np.linalg.lstsq(X, sums[0], rcond=None)[0]
        squares += float(rest @ rest)
        free += len(size) - 3
    return float(np.sqrt(squares / free)) if free > 0 else 0.2e-6


def near_rows(time: FloatArray) -> npt.NDArray[np.bool_]:
    """Return which rows follow the one before without a pause, shape (n - 1,)."""
    step = np.diff(time)
    return np.asarray(step < 2.0 * np.median(step))


def _row_noise(rises: FloatArray, time: FloatArray) -> FloatArray:
    """Return the standard deviation of single readings, from differences between neighbouring rows."""
    step = np.diff(rises, axis=0)[near_rows(time)]
    with np.errstate(invalid="ignore"):
        squares = np.array([np.mean(column[np.isfinite(column)] ** 2) if np.isfinite(column).any() else 0.0
                            for column in step.T])  # fmt: skip
    return np.sqrt(0.5 * squares)
