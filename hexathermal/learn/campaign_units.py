"""Values that can only be in another unit than their column's name says: found in some of the rows, evenly taken.

A few odd readings do not matter: limits are held against quantiles and medians, and missing codes are left out.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from hexathermal.learn.air import LIMITS
from hexathermal.learn.campaign import Campaign
from hexathermal.learn.campaign_columns import AIR, BEAMS, MEASURED_POSE, POSE, Column
from hexathermal.learn.cleaning_rules import codes_in
from hexathermal.poses import FloatArray

MOST_ROWS = 4096
"""Rows of a run that are looked at; of longer runs every second, fourth, ... row."""

FEWEST_NUMBERS = 2

KELVIN = 200.0
"""A thermometer that never reads less [degC] reads kelvins."""

SMALLEST_MOVE = 0.1
"""Movements [mm or deg] that are compared are larger."""

FEWEST_MOVES = 5
"""A column that leaps less often beside one that rests has lost count and has not moved."""

LARGEST_FACTOR = 5.0
"""Two columns of one movement differ by no more than this factor."""

STROKES_OFF = 10.0
"""So many strokes beyond the stroke a displacement cannot be."""

SHARE_OFF = 0.1
"""Share of a column's readings that may lie where no weather is; they are cleaned."""

WEATHER_UNITS = {
    "air_pressure_hPa": ("hPa", (("pascals", 10e3, 140e3), ("kilopascals", 50.0, 115.0), ("bar", 0.5, 1.15),
                                 ("inches of mercury", 20.0, 34.0), ("pounds per square inch", 9.0, 17.0))),
    "air_humidity_percent": ("percent", (("a fraction", 0.05, 1.0),)),
    "air_temperature_degC": ("degC", (("kelvins", KELVIN, 400.0),)),
}  # fmt: skip
"""Of each column of the weather: its unit, and others with the range in which the weather stands in them."""


class Sample:
    """Some rows of a run, evenly, in constant memory."""

    def __init__(self, columns: int) -> None:
        self._rows = np.zeros((0, columns))
        self._stride, self._next = 1, 0

    def add(self, numbers: FloatArray) -> None:
        """Look at the next rows."""
        taken = numbers[self._next :: self._stride]
        self._next += len(taken) * self._stride - len(numbers)
        self._rows = np.concatenate([self._rows, taken])
        while len(self._rows) > MOST_ROWS:
            if len(self._rows) % 2:
                self._next += self._stride
            self._rows = self._rows[::2]
            self._stride *= 2

    @property
    def rows(self) -> FloatArray:
        """The rows that were kept, shape (n, columns)."""
        return self._rows


@dataclass(frozen=True)
class UnitFault:
    """Columns, by their place among those of the run, and what is wrong with their unit."""

    columns: tuple[int, ...]
    message: str


def unit_faults(campaign: Campaign, columns: tuple[Column, ...], sample: Sample) -> Iterator[UnitFault]:
    """Give what is wrong with the units of a run, columns with the same fault together."""
    names = [column.name for column in columns]
    rows = sample.rows
    values = {name: _known(rows[:, k], columns[k]) for k, name in enumerate(names)}
    kelvins = tuple(k for k, name in enumerate(names) if name.endswith("_degC") and _in_kelvins(values[name]))
    if kelvins:
        yield UnitFault(kelvins, _kelvin_message([names[k] for k in kelvins], [values[names[k]] for k in kelvins]))
    for k, column in enumerate(columns):
        if column.name in AIR and k not in kelvins and "unusual-weather" not in campaign.accepted:
            message = _of_weather(column.name, values[column.name])
            if message:
                yield UnitFault((k,), message)
    pairs = [("q_mm", beam) for beam in BEAMS] if campaign.kind == "leg" else []
    pairs += list(zip(POSE, MEASURED_POSE, strict=True)) if campaign.kind == "hexapod" else []
    found = False
    for one, other in pairs:
        if one in names and other in names:
            message = _of_movement(one, rows[:, names.index(one)], other, rows[:, names.index(other)])
            if message:
                found = True
                yield UnitFault((names.index(other),), message)
    if campaign.leg is not None and "q_mm" in names and not found:
        message = _of_stroke(values["q_mm"], campaign.leg.stroke)
        if message:
            yield UnitFault((names.index("q_mm"),), message)


def _known(values: FloatArray, column: Column) -> FloatArray:
    """Return the numbers of a column without missing ones and codes; kelvins are no codes."""
    heat = column.name.endswith("_degC") and column.part != "input"
    return values[np.isfinite(values) & ~codes_in(values, heat)]


def _in_kelvins(values: FloatArray) -> bool:
    """Whether temperatures can only be kelvins."""
    return values.size >= FEWEST_NUMBERS and float(np.quantile(values, 0.05)) > KELVIN


def _kelvin_message(names: list[str], values: list[FloatArray]) -> str:
    """Return what is said of columns that hold kelvins."""
    low, high = min(float(one.min()) for one in values), max(float(one.max()) for one in values)
    which = names[0] if len(names) == 1 else f"{len(names)} columns, {names[0]} to {names[-1]},"
    verb = "reads" if len(names) == 1 else "read"
    return f"{which} {verb} {low:g} to {high:g}: kelvins? expected degrees Celsius"


def _of_weather(name: str, values: FloatArray) -> str:
    """Return what is wrong with readings of the weather, or nothing."""
    if values.size < FEWEST_NUMBERS:
        return ""
    low, high, factor, _unit = LIMITS[name.split("_")[1]]
    low, high = low * factor, high * factor
    unit, others = WEATHER_UNITS[name]
    median = float(np.median(values))
    off = (values < low) | (values > high)
    # a sensor near 0 or 100 % may read a little beyond: no other unit
    wrong = off.mean() > SHARE_OFF and not (unit == "percent" and -5.0 < median < 110.0)
    seen = float(np.median(values[off])) if wrong else median
    meant = [words for words, least, most in others if least <= seen <= most]
    if unit == "percent":
        wrong = wrong or bool(meant and float(np.quantile(values, 0.98)) <= 1.0)
    else:
        wrong = wrong or bool(meant)
    if not wrong:
        return ""
    guess = f"{meant[0]}? " if meant else ""
    advice = "convert it" if meant else f"expected {low:g} to {high:g}"
    if off.mean() <= SHARE_OFF:
        advice += ', or, if it is so, write accept = ["unusual-weather"] in [cleaning] of campaign.toml'
    return f"{name} reads {seen:g}: {guess}the column is in {unit}; {advice}"


def _of_movement(one: str, moved: FloatArray, other: str, seen: FloatArray) -> str:
    """Return what is wrong where two columns of one movement do not move alike, or nothing."""
    good = np.isfinite(moved) & np.isfinite(seen) & ~codes_in(moved, False) & ~codes_in(seen, False)
    moved, seen = moved[good], seen[good]
    if len(moved) < FEWEST_NUMBERS:
        return ""
    lags = {1, max(1, len(moved) // 4)}
    steps = np.concatenate([moved[lag:] - moved[:-lag] for lag in lags])
    answers = np.concatenate([seen[lag:] - seen[:-lag] for lag in lags])
    large, answer = (float(np.quantile(np.abs(values), 0.9)) for values in (steps, answers))
    if max(large, answer) <= SMALLEST_MOVE:
        return ""
    if large <= SMALLEST_MOVE and (np.abs(np.diff(seen)) > SMALLEST_MOVE).sum() < FEWEST_MOVES:
        return ""  # it lost count once or twice
    if large > 0.0:
        far = np.abs(steps) >= 0.5 * large
        answer = float(np.median(answers[far] / steps[far])) * large
    spans = [float(np.ptp(np.quantile(values, [0.005, 0.995]))) for values in (seen, moved)]
    unit = one.rpartition("_")[2]
    if abs(answer) > LARGEST_FACTOR * large or LARGEST_FACTOR * abs(answer) < large:
        if spans[0] <= 1e-3 * SMALLEST_MOVE:
            return f"{other} does not move while {one} moves over {spans[1]:g} {unit}: no signal, or another column"
        return (
            f"{other} moves over {spans[0]:g} while {one} moves over {spans[1]:g}: one of them is in another unit, "
            f"both must be in {unit}"
        )
    if answer < 0.0:
        return f"{other} moves against {one}: it falls where {one} rises; turn its sign"
    return ""


def _of_stroke(q: FloatArray, stroke: tuple[float, float]) -> str:
    """Return what is wrong with displacements that lie far beyond the stroke [m], or nothing."""
    if q.size < FEWEST_NUMBERS:
        return ""
    low, high = stroke[0] * 1e3, stroke[1] * 1e3
    slack = STROKES_OFF * (high - low)
    least, most = (float(value) for value in np.quantile(q, [0.05, 0.95]))
    if least > low - slack and most < high + slack:
        return ""
    return (
        f"q_mm runs from {least:g} to {most:g}, many times beyond stroke_mm [{low:g}, {high:g}]: micrometres? q_mm and "
        "the beams must be in mm"
    )
