"""Corrected leg lengths of whole trajectories: files in, a file out, in constant memory.

The poses file has columns ``x_mm y_mm z_mm rx_deg ry_deg rz_deg`` and optionally ``time_s`` (increasing); other columns
are copied.  The temperatures file has ``<name>_degC`` for each of `hexapod.sensor_names` and optionally ``time_s``; how
its rows go with the poses is told in `hexathermal.predict.pairing`.

Six coordinates of each pose count from the machine's home: ``T_base_platform = T_base_home U X inv(O)`` with the pose
``X`` of the file and the user and object frames ``U`` and ``O`` (both the identity unless given).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn

import numpy as np

from hexathermal.errors import ArgumentError, FileFormatError, KinematicsError, Problem
from hexathermal.kinematics.batches import where
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray, Frames, coordinates_from_pose, inverse_pose, pose_from_coordinates
from hexathermal.predict.pairing import paired
from hexathermal.predict.table_streams import Rows, TableStream, open_table
from hexathermal.predict.table_writing import TableWriter, check_out, written_whole
from hexathermal.predict.temperatures import active_model

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

    def answer(self, rows: Rows, temps: FloatArray) -> dict[str, FloatArray]:
        """Return the columns of results of the next rows."""
        T = pose_from_coordinates(rows.numbers, self.convention)
        T = self.hexapod.home @ (T if self.frames is None else self.frames.machine_pose(T))
        lengths = self._located(rows, T, temps)
        self.largest.see(rows.first, lengths - self.hexapod.inverse_kinematics(T))
        columns = _named(POSE_COLUMNS, rows.numbers)
        columns |= _named(LENGTH_COLUMNS, lengths * 1000.0)
        columns |= _named(STROKE_COLUMNS, self.hexapod.strokes(lengths) * 1000.0)
        if not self.lengths_only:
            columns |= _named(CORRECTED_COLUMNS, self._corrected_coordinates(rows, lengths))
        return columns

    def _located(self, rows: Rows, T: FloatArray, temps: FloatArray) -> FloatArray:
        """Return corrected lengths; what a pose cannot do is said with its line."""
        try:
            with np.errstate(over="ignore", invalid="ignore"):
                return self.hexapod.corrected_leg_lengths(T, temps)
        except KinematicsError as error:
            self._refuse(rows, error)
        except ArgumentError:
            k = next(k for k in range(len(rows)) if self._is_far(T[k]))
            line = self.poses.line(rows.first + k)
            six = ", ".join(f"{name} = {value:g}" for name, value in zip(POSE_COLUMNS, rows.numbers[k], strict=True))
            raise KinematicsError(
                f"{self.poses.path}, line {line}: the pose is far outside the machine ({six}); coordinates count from "
                "home in mm and degrees", index=(rows.first + k,)
            ) from None  # fmt: skip

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
        text = str(error).replace(where(error.index), "", 1)
        raise type(error)(
            f"{self.poses.path}, line {self.poses.line(row)}: {text}",
            leg=error.leg, value=error.value, lower=error.lower, upper=error.upper, index=(row,),
        ) from None  # fmt: skip


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
        Replace an existing `out`; never one of the files that are read.
    progress : callable, optional
        Called as ``progress(bytes_read, bytes_in_all)``.

    Returns
    -------
    TrajectorySummary

    Raises
    ------
    FileFormatError, TemperatureError, KinematicsError
        The header or a row is bad, out of the law's range, or cannot be reached; each with the line in its file.
    ThermalModelError, ArgumentError
        No thermal law; a file is not there; `out` exists, is a file that is read, or cannot be written.
    """
    target, columns = Path(out), tuple(f"{name}_degC" for name in active_model(hexapod).sensor_names)
    source, heat = open_table(poses, POSE_COLUMNS, "poses"), open_table(temps, columns, "temperatures")
    check_out(target, (source.path, heat.path), overwrite)
    job = _Job(hexapod, source, convention, frames, lengths_only)
    _check_clashes(job)
    try:
        return _streamed(job, heat, target, progress)
    finally:
        source.close()
        heat.close()


def _streamed(job: _Job, heat: TableStream, out: Path, progress: Progress | None) -> TrajectorySummary:
    """Do the work, block by block."""
    source, largest = job.poses, job.largest
    followed, checked = paired(job.hexapod, source, heat)
    with written_whole(out) as part, TableWriter(part, out, source) as writer:
        while (rows := source.next_rows()) is not None:
            hot, time = followed.of(rows)
            columns = job.answer(rows, hot)
            times = rows.time if rows.time is not None else time
            writer.write(({} if times is None else {"time_s": times}) | columns, rows.extras)
            if progress is not None:
                progress(source.done() + heat.done(), source.size + heat.size)
        followed.finish()
        if progress is not None:
            progress(source.size + heat.size, source.size + heat.size)
    return TrajectorySummary(
        out=out, rows=source.count, largest_correction_um=largest.value * 1e6, largest_leg=largest.leg,
        largest_line=source.line(largest.row), sensors=job.hexapod.sensor_names, lowest_degC=checked.lowest,
        highest_degC=checked.highest, pairing=followed.pairing, copied=source.header.extras, unused=heat.header.extras,
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
