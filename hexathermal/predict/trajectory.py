"""Corrected leg lengths of whole trajectories: files in, a file out, in constant memory.

The poses file has columns ``x_mm y_mm z_mm rx_deg ry_deg rz_deg`` and optionally ``time_s`` (increasing); other columns
are copied.  The temperatures file has ``<name>_degC`` for each of `hexapod.sensor_names` and optionally ``time_s``; how
its rows go with the poses is told in `hexathermal.predict.pairing`.

Six coordinates of each pose count from the machine's home: ``T_base_platform = T_base_home U X inv(O)`` with the pose
``X`` of the file and the user and object frames ``U`` and ``O`` (both the identity unless given).

Where terms of the legs' laws have states, the poses are one motion in the order of time: times are then needed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn

import numpy as np

from hexathermal.errors import (
    ArgumentError,
    FileFormatError,
    KinematicsError,
    OutOfStrokeError,
    Problem,
)
from hexathermal.kinematics.batches import where
from hexathermal.kinematics.limits import ROUNDING, travel_coordinates, travel_range
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray, Frames, coordinates_from_pose, inverse_pose, pose_from_coordinates
from hexathermal.predict.pairing import Temperatures, paired, time_hints
from hexathermal.predict.table_streams import Rows, TableStream, open_table
from hexathermal.predict.table_writing import TableWriter, check_out, written_whole
from hexathermal.predict.temperatures import active_model
from hexathermal.predict.trajectory_memory import Motion, memory_warnings, motion_of

POSE_COLUMNS = ("x_mm", "y_mm", "z_mm", "rx_deg", "ry_deg", "rz_deg")
LENGTH_COLUMNS = tuple(f"leg{i}_length_mm" for i in range(1, 7))
STROKE_COLUMNS = tuple(f"leg{i}_q_mm" for i in range(1, 7))
CORRECTED_COLUMNS = tuple(f"corrected_{name}" for name in POSE_COLUMNS)

Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class TrajectorySummary:
    """What a corrected trajectory was made of.

    Attributes
    ----------
    rows : int
    largest_correction_um : float
        Largest ``|corrected - nominal|`` of any leg in any row.
    largest_leg, largest_line : int
        Where it stands: leg from 1, and line of the poses file (row from 1 in a Parquet file).
    sensors : tuple of str
    lowest_degC, highest_degC : float
        Extremes of all temperatures in the file.
    pairing : str
        How temperatures were given to poses.
    copied, unused : tuple of str
        Columns that nobody asked for: of the poses file, copied to the results; of the temperatures file, left out.
    lowest_pose, highest_pose : tuple of float [mm, mm, mm, deg, deg, deg]
        Extremes of the six coordinates in the poses file.
    notes : tuple of str
        What looks like a mistake although every row was corrected.
    warnings : tuple of str
        What was taken for granted of a motion that the legs' law remembers.
    """

    out: Path
    rows: int
    largest_correction_um: float
    largest_leg: int
    largest_line: int
    sensors: tuple[str, ...]
    lowest_degC: float
    highest_degC: float
    pairing: str
    copied: tuple[str, ...]
    unused: tuple[str, ...]
    lowest_pose: tuple[float, ...]
    highest_pose: tuple[float, ...]
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()


@dataclass
class _Span:
    """Extremes of the coordinates met so far [mm, deg]."""

    low: FloatArray = field(default_factory=lambda: np.full(6, np.inf))
    high: FloatArray = field(default_factory=lambda: np.full(6, -np.inf))

    def see(self, numbers: FloatArray) -> None:
        """Look at the coordinates (n, 6) of the next rows."""
        self.low = np.minimum(self.low, numbers.min(axis=0))
        self.high = np.maximum(self.high, numbers.max(axis=0))

    def notes(self) -> tuple[str, ...]:
        """Return what looks like wrong units."""
        found = []
        sizes = np.maximum(np.abs(self.low), np.abs(self.high))
        if 0.0 < sizes[:3].max() < 1.0:
            found.append(f"no translation exceeds {sizes[:3].max():g} mm: were metres given? mm are expected")
        if sizes[3:].max() > 180.0:
            found.append(f"an angle is {sizes[3:].max():g} deg, more than half a turn; degrees are expected")
        return tuple(found)


@dataclass
class _Largest:
    """The largest correction met so far."""

    value: float = 0.0
    leg: int = 1
    row: int = 0

    def see(self, first: int, corrections: FloatArray) -> None:
        """Look at the corrections (n, 6) [m] of the next rows."""
        sizes = np.abs(corrections)
        row, leg = np.unravel_index(int(sizes.argmax()), sizes.shape)
        if sizes[row, leg] > self.value:
            self.value, self.leg, self.row = float(sizes[row, leg]), int(leg) + 1, first + int(row)


@dataclass(frozen=True, eq=False)
class _Job:
    """One trajectory: the machine, how coordinates are meant, and what is written."""

    hexapod: Hexapod
    poses: TableStream
    convention: str
    frames: Frames | None
    lengths_only: bool
    largest: _Largest = field(default_factory=_Largest)
    span: _Span = field(default_factory=_Span)
    motion: Motion | None = None

    def answer(self, rows: Rows, followed: Temperatures) -> dict[str, FloatArray]:
        """Return the columns of results of the next rows."""
        T = pose_from_coordinates(rows.numbers, self.convention)
        T = self.hexapod.home @ (T if self.frames is None else self.frames.machine_pose(T))
        lengths, time = self._located(rows, T, followed)
        self._within_travel(rows, T)
        self.span.see(rows.numbers)
        self.largest.see(rows.first, lengths - self.hexapod.inverse_kinematics(T))
        columns = {} if time is None else {"time_s": time}
        columns |= _named(POSE_COLUMNS, rows.numbers)
        columns |= _named(LENGTH_COLUMNS, lengths * 1000.0)
        columns |= _named(STROKE_COLUMNS, self.hexapod.strokes(lengths) * 1000.0)
        if not self.lengths_only:
            columns |= _named(CORRECTED_COLUMNS, self._corrected_coordinates(rows, lengths))
        return columns

    def _located(self, rows: Rows, T: FloatArray, followed: Temperatures) -> tuple[FloatArray, FloatArray | None]:
        """Return corrected lengths and times; what a pose cannot do is said with its line."""
        try:
            with np.errstate(over="ignore", invalid="ignore"):
                if self.motion is not None:
                    return self.motion.corrected(T, rows, followed)
                temps, time = followed.of(rows)
                return self.hexapod.corrected_leg_lengths(T, temps), time if rows.time is None else rows.time
        except KinematicsError as error:
            self._refuse(rows, error)
        except ArgumentError:
            k = next((k for k in range(len(rows)) if self._is_far(T[k])), None)
            if k is None:
                raise
            line = self.poses.line(rows.first + k)
            through = "" if self.frames is None else ", and pass through the user and object frames: check these too"
            said = f"{self.poses.path}, line {line}: {far_words(rows.numbers[k])}{through}"
            raise KinematicsError(said, index=(rows.first + k,)) from None

    def _within_travel(self, rows: Rows, T: FloatArray) -> None:
        """Refuse the first pose outside the maker's travel, which counts from home in its own convention."""
        limits, travel = self.hexapod.limits, travel_range(self.hexapod)
        if limits is None or travel is None:
            return
        x = travel_coordinates(self.hexapod, T)
        over = np.maximum(travel[:, 0] - x, x - travel[:, 1])
        rows_out = np.flatnonzero((over > ROUNDING).any(axis=1))
        if not rows_out.size:
            return
        k = int(rows_out[0])
        axis = int((over[k] / (travel[:, 1] - travel[:, 0])).argmax())
        name, unit = POSE_COLUMNS[axis].split("_")
        scale = 1000.0 if unit == "mm" else float(np.degrees(1.0))
        value, (low, high) = float(x[k, axis]), map(float, travel[axis])
        through = "" if self.frames is None else " (counted from home, behind the user and object frames)"
        raise KinematicsError(
            f"{self.poses.path}, line {self.poses.line(rows.first + k)}: outside the maker's travel: {name} is "
            f"{value * scale:.9g} {unit}{through}, allowed [{low * scale:.9g}, {high * scale:.9g}] {unit} "
            f"({limits.convention}); choose a pose closer to home, or change [limits] in the machine's file",
            value=value, lower=low, upper=high, index=(rows.first + k,),
        )  # fmt: skip

    def _is_far(self, T: FloatArray) -> bool:
        """Whether a pose is refused as no pose of this machine at all."""
        try:
            with np.errstate(over="ignore", invalid="ignore"):
                self.hexapod.inverse_kinematics(T)
        except ArgumentError:
            return True
        return False

    def _corrected_coordinates(self, rows: Rows, lengths: FloatArray) -> FloatArray:
        """Return the coordinates to send to a controller that takes poses only, see `corrected_pose`."""
        try:
            T = inverse_pose(self.hexapod.home) @ self.hexapod.forward_kinematics(lengths)
        except KinematicsError as error:
            self._refuse(rows, error)
        return coordinates_from_pose(T if self.frames is None else self.frames.user_pose(T), self.convention)

    def _refuse(self, rows: Rows, error: KinematicsError) -> NoReturn:
        """Raise an error of a block again, with the line of the file."""
        row = rows.first + error.index[0]
        text = self._out_of_stroke(error) or str(error).replace(where(error.index), "", 1)
        raise type(error)(
            f"{self.poses.path}, line {self.poses.line(row)}: {text}",
            leg=error.leg, value=error.value, lower=error.lower, upper=error.upper, index=(row,),
        ) from None  # fmt: skip

    def _out_of_stroke(self, error: KinematicsError) -> str:
        """Return a leg out of stroke in lengths and strokes; empty where the error is another or no q0 is known."""
        q0, stroke = self.hexapod.retracted_length, self.hexapod.stroke
        leg, value = error.leg, error.value
        if not isinstance(error, OutOfStrokeError) or q0 is None or stroke is None or leg is None or value is None:
            return ""
        q = float(self.hexapod.strokes(np.full(6, value))[leg - 1]) * 1e3
        low, high = (float(bound) * 1e3 for bound in stroke[leg - 1])
        side = f"{low - q:.6g} mm too short" if q < low else f"{q - high:.6g} mm too long"
        through = "" if self.frames is None else "; the pose passes through the user and object frames: check these too"
        return (
            f"leg {leg} out of stroke: length {value * 1e3:.6f} mm (q {q:.6f} mm), allowed q [{low:g}, {high:g}] mm: "
            f"{side}; choose a pose closer to home{through}"
        )


def far_words(six: FloatArray) -> str:
    """Return what is said of coordinates [mm, deg] that are no pose of the machine at all."""
    said = ", ".join(f"{name} = {value:g}" for name, value in zip(POSE_COLUMNS, six, strict=True))
    return f"the pose is far outside the machine ({said}); coordinates count from home in mm and degrees"


def _named(names: tuple[str, ...], array: FloatArray) -> dict[str, FloatArray]:
    """Return the columns of an array by name."""
    return {name: np.ascontiguousarray(array[:, k]) for k, name in enumerate(names)}


def correct_trajectory(
    hexapod: Hexapod,
    poses: str | Path,
    temps: str | Path,
    out: str | Path,
    *,
    convention: str = "fixed-xyz",
    frames: Frames | None = None,
    lengths_only: bool = False,
    overwrite: bool = False,
    progress: Progress | None = None,
) -> TrajectorySummary:
    """Write the leg lengths, strokes and poses to command for every pose of a file at the temperatures of another.

    Each row is `Hexapod.corrected_leg_lengths` of its pose and temperatures; the corrected pose is the nominal forward
    kinematics of those lengths. Files are read and written in blocks: memory does not grow with them. The result
    appears whole or not at all: it is written to ``<out>.part`` and renamed at the end.

    Parameters
    ----------
    hexapod : Hexapod
    poses, temps, out : path
        CSV, or Parquet where the name ends in ``.parquet``; columns and pairing as in the modules' descriptions. The
        folder of `out` must exist.
    convention : str
        Of the three angles, see `hexathermal.poses`.
    frames : Frames, optional
        User and object frames; coordinates in both files are then of the object in the user frame.
    lengths_only : bool
        Leave out the corrected poses.
    overwrite : bool
        Replace an existing `out`; never one of the files that are read. Links are followed, permissions kept.
    progress : callable, optional
        Called as ``progress(bytes_read, bytes_in_all)``.

    Returns
    -------
    TrajectorySummary

    Raises
    ------
    FileFormatError, TemperatureError, KinematicsError
        The header or a row is bad, out of the law's range, cannot be reached, or lies outside the maker's travel
        `Hexapod.limits`; each with the line in its file.
    ThermalModelError, ArgumentError
        No thermal law, or one with states where there are no times; a file is not there; `out` exists, is a file that
        is read, is no plain file, ends in neither ``.csv`` nor ``.parquet``, or cannot be written.
    """
    target, columns = Path(out), tuple(f"{name}_degC" for name in active_model(hexapod).sensor_names)
    source, heat = open_table(poses, POSE_COLUMNS, "poses"), open_table(temps, columns, "temperatures")
    check_out(target, (source.path, heat.path), overwrite)
    try:
        job = _Job(hexapod, source, convention, frames, lengths_only, motion=motion_of(hexapod, source, heat))
        _check_clashes(job)
        return _streamed(job, heat, target, progress)
    finally:
        source.close()
        heat.close()


def _streamed(job: _Job, heat: TableStream, out: Path, progress: Progress | None) -> TrajectorySummary:
    """Do the work, block by block."""
    source, largest = job.poses, job.largest
    followed, checked = paired(job.hexapod, source, heat)
    warnings = () if job.motion is None else memory_warnings(job.hexapod, source, heat, followed.one_row)
    with written_whole(out) as part, TableWriter(part, out, source) as writer:
        while (rows := source.next_rows()) is not None:
            writer.write(job.answer(rows, followed), rows.extras)
            if progress is not None:
                progress(source.done() + heat.done(), source.size + heat.size)
        followed.finish()
        if progress is not None:
            progress(source.size + heat.size, source.size + heat.size)
    pairing = followed.pairing + ("" if job.motion is None else job.motion.words)
    return TrajectorySummary(
        out=out, rows=source.count, largest_correction_um=largest.value * 1e6, largest_leg=largest.leg,
        largest_line=source.line(largest.row), sensors=job.hexapod.sensor_names, lowest_degC=checked.lowest,
        highest_degC=checked.highest, pairing=pairing, copied=source.header.extras, unused=heat.header.extras,
        lowest_pose=tuple(job.span.low.tolist()), highest_pose=tuple(job.span.high.tolist()),
        notes=(*job.span.notes(), *time_hints(source, heat)), warnings=warnings,
    )  # fmt: skip


def _check_clashes(job: _Job) -> None:
    """Refuse columns to be copied that bear the name of a result."""
    header = job.poses.header
    made = (*LENGTH_COLUMNS, *STROKE_COLUMNS, *(() if job.lengths_only else CORRECTED_COLUMNS))
    problems = tuple(
        Problem(header.line, header.column(name), f"column {name} would clash with a result; rename or remove it")
        for name in header.extras
        if name in made
    )
    if problems:
        raise FileFormatError(str(job.poses.path), problems)
