"""What ``hexathermal budget`` is asked: numbers from words, temperatures from words or a file, all in SI units."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray, Frames, pose_from_coordinates
from hexathermal.show.options import number, numbers

if TYPE_CHECKING:
    from hexathermal.predict.sources import Sources

COORDINATES = {"x": "x_mm", "y": "y_mm", "z": "z_mm", "rx": "rx_deg", "ry": "ry_deg", "rz": "rz_deg"}

LARGEST_ROWS = 100_000
"""Of a table."""


@dataclass(frozen=True)
class Grid:
    """One span of a map: a coordinate's name, low, high [mm or deg] and count."""

    name: str
    low: float
    high: float
    count: int

    @property
    def values(self) -> FloatArray:
        """Values from low to high."""
        return np.linspace(self.low, self.high, self.count)


def grid(text: str) -> Grid:
    """Return a span from ``x=-50:50:11``."""
    name, _, rest = text.partition("=")
    words = rest.split(":")
    if name not in COORDINATES or len(words) != 3:
        raise argparse.ArgumentTypeError(
            f"{text!r} is no span of a grid; write NAME=LOW:HIGH:COUNT with one of {', '.join(COORDINATES)}, "
            "such as x=-50:50:11"
        )
    if not (words[2].isascii() and words[2].isdigit() and 1 <= int(words[2]) <= 1000):
        raise argparse.ArgumentTypeError(f"count {words[2]!r} of {text!r} must be a whole number from 1 to 1000")
    return Grid(COORDINATES[name], number(words[0]), number(words[1]), int(words[2]))


def probability(text: str) -> float:
    """Return a coverage probability."""
    value = number(text)
    if not 0.0 < value < 1.0:
        raise argparse.ArgumentTypeError(f"{text!r} is no probability between 0 and 1, such as 0.95")
    return value


def percent(text: str) -> float:
    """Return a percentage above 0."""
    value = number(text)
    if not 0.0 < value <= 100.0:
        raise argparse.ArgumentTypeError(f"{text!r} is no percentage above 0 and up to 100, such as 5")
    return value


def draws(text: str) -> int:
    """Return a number of draws."""
    if not (text.isascii() and text.isdigit() and len(text) <= 9 and int(text) > 0):
        raise argparse.ArgumentTypeError(f"{text!r} is no whole number of draws, such as 4000000")
    return int(text)


@dataclass(frozen=True, eq=False)
class Request:
    """One question for a budget, in SI units.

    Attributes
    ----------
    pose : array, shape (4, 4) [m]
    temps : array, shape (N, n) [degC]
    time_s : array, shape (N,), or None
    plates : Plates, or list of them, one a row of `temps`
    settings : dict
        Further keywords of `error_budget`.
    scenario : str
        What the temperatures are, where they were not given.
    heat : Path or None
        The file of the temperatures.
    """

    hexapod: Hexapod
    coordinates: tuple[float, ...]
    convention: str
    pose: FloatArray
    temps: FloatArray
    time_s: FloatArray | None
    plates: Any
    air_degC: Any
    sources: Sources
    probability: float
    settings: dict[str, Any]
    scenario: str = ""
    heat: Path | None = None

    @property
    def many(self) -> bool:
        """Whether there are several sets of temperatures."""
        return len(self.temps) > 1


def requested(
    hexapod: Hexapod,
    six: tuple[float, ...],
    words: list[str] | None,
    *,
    day: bool,
    seed: int,
    frames: Frames,
    frame: str,
    at_tool: tuple[float, ...] | None,
    gradients: dict[str, tuple[float, ...] | None],
    plate_temps: list[float] | None,
    air: float | None,
    convention: str,
    sources: Path | None,
    without: tuple[str, ...],
    correction: bool,
    probability: float,
) -> Request:
    """Return the question that the command line asks."""
    from hexathermal.predict.budget_defaults import default_sources
    from hexathermal.predict.budget_files import read_sources
    from hexathermal.predict.budget_plates import PARTS, Plates, blind_plates

    blind = blind_plates(hexapod)
    slopes = {f"{part}_gradient": gradients[part] or (0.0, 0.0, 0.0) for part in ("platform", "base")}
    given = {} if plate_temps is None else {
        f"{part}_degC": value for part, value in zip(PARTS, plate_temps, strict=True) if part in blind
    }  # fmt: skip
    if plate_temps is not None and not given:
        raise ArgumentError(
            "--plate-temps: the machine has no plate with a law and without a thermometer; leave it out"
        )
    plates: Any = Plates(**given, **slopes)  # type: ignore[arg-type]
    scenario, time_s = "", None
    air_degC: Any = air
    if day:
        if plate_temps is not None or gradients["leg"] is not None or air is not None:
            raise ArgumentError("--day brings its own temperatures; leave --plate-temps, --leg-gradient and --air out")
        temps, time_s, plates, air_degC = _simulated_day(hexapod, seed, slopes)
        scenario = f"simulated day, seed {seed}"
    else:
        temps, time_s = _temperatures(hexapod, words or [], gradients["leg"])
    stated = plates[0] if isinstance(plates, list) else plates
    known = read_sources(sources, hexapod, stated) if sources else default_sources(hexapod, stated)
    chosen = known.without(*without)
    settings = {"frame": frame, "frames": frames, "at_tool": at_tool, "correction": correction}
    return Request(
        hexapod, six, convention, pose_from_coordinates(six, convention, hexapod), temps, time_s, plates, air_degC,
        chosen, probability, settings, scenario, None if day else _file_in(words or []),
    )  # fmt: skip


def _temperatures(
    hexapod: Hexapod, words: list[str], slope: tuple[float, ...] | None
) -> tuple[FloatArray, FloatArray | None]:
    """Return temperatures (N, n) and times from words or a file."""
    names = hexapod.sensor_names
    if (file := _file_in(words)) is not None:
        if slope is not None:
            raise ArgumentError("--leg-gradient goes with one temperature, not with a file")
        return table(file, tuple(f"{name}_degC" for name in names), "temperatures")
    count = len([part for word in words for part in word.split(",") if part])
    if count not in (1, len(names)):
        raise ArgumentError(
            f"--temps takes one temperature, {len(names)} of them ({', '.join(names)}), or a file; found {count}"
        )
    values = numbers(words, count, "--temps", "degC")
    if slope is None:
        return np.broadcast_to(np.array(values), (1, len(names))).copy(), None
    if count != 1:
        raise ArgumentError("--leg-gradient goes with one temperature, the legs' mean")
    from hexathermal.predict.budget_maps import graded_temperatures

    return graded_temperatures(hexapod, values[0], slope)[None], None


def _file_in(words: list[str]) -> Path | None:
    """Return the file that a single word names, None where words are numbers."""
    if len(words) != 1:
        return None
    try:
        return None if [float(part) for part in words[0].split(",") if part] else Path(words[0])
    except ValueError:
        return Path(words[0])


def path_with_temperatures(
    hexapod: Hexapod, poses: Path, temps: Path
) -> tuple[FloatArray, FloatArray | None, FloatArray, str]:
    """Return coordinates (n, 6) [mm, deg] of a path, its times, its temperatures (n, s) [degC], and how they pair up.

    Temperatures belong to poses as `hexathermal.predict.pairing` says, as in a trajectory that is corrected.
    """
    from hexathermal.predict.pairing import paired
    from hexathermal.predict.table_streams import open_table
    from hexathermal.predict.trajectory import POSE_COLUMNS

    source = open_table(poses, POSE_COLUMNS, "poses")
    heat = open_table(temps, tuple(f"{name}_degC" for name in hexapod.sensor_names), "temperatures")
    coordinates, times, found = list[FloatArray](), list[FloatArray](), list[FloatArray]()
    try:
        followed, _checked = paired(hexapod, source, heat)
        while (rows := source.next_rows()) is not None:
            refuse_many(poses, source.count)
            hot, time = followed.of(rows)
            coordinates.append(rows.numbers)
            found.append(np.broadcast_to(hot, (len(rows), hot.shape[-1])))
            times += [one for one in (rows.time, time) if one is not None]
        followed.finish()
    finally:
        source.close()
        heat.close()
    return (
        np.concatenate(coordinates),
        np.concatenate(times) if times else None,
        np.concatenate(found),
        followed.pairing,
    )


def table(file: Path, columns: tuple[str, ...], what: str) -> tuple[FloatArray, FloatArray | None]:
    """Return columns of a file, and its times where it has some."""
    from hexathermal.predict.table_streams import open_table

    stream = open_table(file, columns, what)
    try:
        blocks, times = [], []
        while (rows := stream.next_rows()) is not None:
            blocks.append(rows.numbers)
            if rows.time is not None:
                times.append(rows.time)
            refuse_many(file, stream.count)
    finally:
        stream.close()
    return np.concatenate(blocks), np.concatenate(times) if times else None


def refuse_many(file: Path, count: int) -> None:
    """Refuse more rows than a budget is made of in a sensible time."""
    if count > LARGEST_ROWS:
        raise ArgumentError(f"{file} has more than {LARGEST_ROWS} rows; give every tenth")


def _simulated_day(
    hexapod: Hexapod, seed: int, slopes: dict[str, tuple[float, ...]]
) -> tuple[FloatArray, FloatArray, list[Any], FloatArray]:
    """Return readings, times, plates and air of a simulated day, every tenth minute."""
    from hexathermal.predict.budget_plates import Plates, blind_plates
    from hexathermal.simulate.day import WorkingDay, day_temperatures, readings, reference_degC, sensor_truth

    day, generator = WorkingDay(), np.random.default_rng(seed)
    truth = day_temperatures(day, reference_degC(hexapod), generator)
    read = readings(hexapod, sensor_truth(hexapod, truth), day, generator)[::10]
    plates = [
        Plates(**{f"{part}_degC": float(getattr(truth, part)[k]) for part in blind_plates(hexapod)}, **slopes)  # type: ignore[arg-type]
        for k in range(0, len(truth.time), 10)
    ]
    return read, truth.time[::10], plates, truth.room[::10]
