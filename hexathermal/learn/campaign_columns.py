"""Columns of a campaign's tables: names of the format, units, and what they become in the core."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from difflib import get_close_matches

import numpy as np

from hexathermal.learn.campaign import AIR_COLUMN, Campaign

AIR = (AIR_COLUMN, "air_pressure_hPa", "air_humidity_percent")
ALSO_INPUTS = ("q_mm", "settled", *AIR)
"""Columns of the format that a campaign may list among its inputs: they are causes that it records."""

BEAMS = ("beam1_mm", "beam2_mm", "beam3_mm")
POSE = ("x_mm", "y_mm", "z_mm", "rx_deg", "ry_deg", "rz_deg")
MEASURED_POSE = tuple(f"measured_{name}" for name in POSE)
LEG_STROKES = tuple(f"leg{leg}_q_mm" for leg in range(1, 7))
MACHINE_THERMOMETER = re.compile(r"((?:leg[1-6]|platform|base)_\w+)_degC")
"""A thermometer of a whole machine, by its column."""

SI = {"mm": (1e-3, "m"), "um": (1e-6, "m"), "deg": (np.pi / 180.0, "rad"), "degC": (1.0, "degree_Celsius"),
      "hPa": (100.0, "Pa"), "percent": (0.01, "1"), "s": (1.0, "s")}  # fmt: skip
"""Endings of column names, the factor to the core's unit, and that unit; temperatures stay degrees Celsius."""

_OTHER_UNITS = ("K", "F", "degF", "C", "degC", "mm", "m", "um", "nm", "cm", "in", "inch", "deg", "rad", "mrad", "hPa",
                "Pa", "kPa", "mbar", "bar", "percent", "ratio", "fraction", "s", "ms", "min", "h")  # fmt: skip


@dataclass(frozen=True)
class Column:
    """One column of a campaign's tables.

    Parameters
    ----------
    name : str
        The format's name.
    part : str
        What it belongs to: ``"time"``, ``"q"``, ``"settled"``, ``"temperature"``, ``"beam"``, ``"air"``, ``"drift"``,
        ``"input"``, ``"pose"``, ``"measured"`` or ``"leg_q"``.
    required : bool
        Whether a table without it is at fault.
    """

    name: str
    part: str
    required: bool = True

    @property
    def si(self) -> tuple[float, str]:
        """Factor to the core's unit, and that unit (empty where a name carries none)."""
        if self.part in ("input", "settled"):
            return 1.0, ""
        return SI[self.name.rpartition("_")[2]]


def columns_of(campaign: Campaign) -> tuple[Column, ...]:
    """Return the columns that the tables of a campaign have or may have, in the format's order."""
    return tuple(
        replace(column, required=True) if column.name in campaign.stated else column for column in _columns(campaign)
    )


def _columns(campaign: Campaign) -> tuple[Column, ...]:
    """Return the columns that the format knows of a campaign's kind, with its own thermometers and inputs."""
    heat = tuple(Column(f"{name}_degC", "temperature") for name in campaign.sensors)
    inputs = tuple(Column(item.name, "input") for item in campaign.inputs)
    taken = {column.name for column in heat}
    air = tuple(Column(name, "air", required=False) for name in AIR if name not in taken)
    time = (Column("time_s", "time"),)
    if campaign.kind == "leg":
        beams = tuple(Column(name, "beam") for name in BEAMS)
        weather = not (campaign.beams is None or campaign.beams.index_compensated)
        air = tuple(Column(column.name, "air", required=weather) for column in air)
        return (*time, Column("q_mm", "q"), Column("settled", "settled"), *heat, *beams, *air, *inputs)
    if campaign.kind == "component":
        stroke = (Column("q_mm", "q", required=False), Column("settled", "settled", required=False))
        return (*time, *inputs, *stroke, *heat, Column("drift_um", "drift"), *air)
    commanded = tuple(Column(name, "pose") for name in POSE)
    measured = tuple(Column(name, "measured") for name in MEASURED_POSE)
    strokes = tuple(Column(name, "leg_q") for name in LEG_STROKES)
    settled = (Column("settled", "settled", required=False),)
    return (*time, *commanded, *strokes, *settled, *heat, *air, *measured, *inputs)


def meant_for(name: str, others: Iterable[str]) -> str:
    """Return a hint which other column may have been meant for a missing one: another unit, other letters, or nearly.

    Examples
    --------
    >>> meant_for("beam1_mm", ["beam1_um", "note"])
    "; 'beam1_um' has another unit: beam1_mm must be in mm, convert it"
    """
    others = list(others)
    stem, _, unit = name.rpartition("_")
    if unit in SI:
        wrong = [other for other in others if _stem(other) == stem.lower() and other != name]
        if wrong:
            return f"; {wrong[0]!r} has another unit: {name} must be in {unit}, convert it"
    same = [other for other in others if other.lower() in (name.lower(), stem.lower())]
    close = same or get_close_matches(name, others, 1, 0.85)
    return f"; was {close[0]!r} meant for it? [columns] in campaign.toml maps own names" if close else ""


def _stem(name: str) -> str | None:
    """Return a column's name without its unit, in small letters; None where it ends in no unit."""
    stem, _, unit = name.rpartition("_")
    return stem.lower() if stem and unit in _OTHER_UNITS else None
