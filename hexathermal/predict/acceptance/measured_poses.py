"""Measured and commanded poses of an acceptance test, read from a table."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from hexathermal.errors import ArgumentError, FileFormatError, Problem
from hexathermal.poses import FloatArray, Frames, pose_from_coordinates
from hexathermal.predict.table_streams import TableStream, open_table
from hexathermal.predict.trajectory import POSE_COLUMNS

MEASURED_COLUMNS = tuple(f"measured_{name}" for name in POSE_COLUMNS)
LABELS = ("pose", "group", "cycle")
UNCERTAINTIES = ("u_position_um", "u_rotation_urad")

LARGEST = 1e9
"""Size of any number of the table, in its own unit."""

MOST_PROBLEMS = 20
"""Of the rows are listed; a file that is wrong throughout would fill the screen."""


@dataclass(frozen=True, eq=False)
class MeasuredPoses:
    """Commanded and measured poses, row by row, in the axes and about the point that were asked for.

    Attributes
    ----------
    path : Path
    commanded, measured : array, shape (n, 4, 4) [m]
    poses, groups : tuple of str
        Name of the commanded pose and of the group of visits that a row belongs to; groups are empty texts where the
        file names none.
    time : array, shape (n,) [s], or None
    temperatures : dict of str to array, shape (n,) [degC]
    u_position, u_rotation : array, shape (n,) [m], [rad], or None
        Standard uncertainty of each measured coordinate, of the point that is judged: turns carry a tool along.
    turns : bool
        Whether rotations were measured; otherwise the measured poses carry the commanded rotations.
    unused : tuple of str
        Columns of the file that are not used.
    convention : str
        Of the angles of the file.
    """

    path: Path
    commanded: FloatArray
    measured: FloatArray
    poses: tuple[str, ...]
    groups: tuple[str, ...]
    time: FloatArray | None
    temperatures: dict[str, FloatArray]
    u_position: FloatArray | None
    u_rotation: FloatArray | None
    turns: bool
    unused: tuple[str, ...]
    convention: str = "fixed-xyz"

    def __len__(self) -> int:
        return len(self.poses)

    @property
    def pose_names(self) -> tuple[str, ...]:
        """Names of the commanded poses, in the order of the file."""
        return tuple(self._places)

    @property
    def group_names(self) -> tuple[str, ...]:
        """Names of the groups, in the order of the file."""
        return tuple(dict.fromkeys(self.groups))

    def groups_of(self, pose: str) -> tuple[str, ...]:
        """Return the names of the groups in which a pose was visited, in the order of the file."""
        return tuple(self._places.get(pose, {}))

    def rows(self, pose: str, group: str | None = None) -> Any:
        """Return the numbers of the rows of a pose, of one group or of all."""
        groups = self._places.get(pose, {})
        if group is not None:
            return groups.get(group, np.zeros(0, dtype=np.intp))
        return np.sort(np.concatenate([np.zeros(0, dtype=np.intp), *groups.values()]))

    @cached_property
    def _places(self) -> dict[str, dict[str, Any]]:
        """Rows by pose and group, in the order of the file."""
        found: dict[str, dict[str, list[int]]] = {}
        for row, (pose, group) in enumerate(zip(self.poses, self.groups, strict=True)):
            found.setdefault(pose, {}).setdefault(group, []).append(row)
        return {
            pose: {group: np.array(rows, dtype=np.intp) for group, rows in groups.items()}
            for pose, groups in found.items()
        }


def read_measured_poses(path: str | Path, convention: str = "fixed-xyz", frames: Frames | None = None) -> MeasuredPoses:
    """Return the poses of a table: columns as in a campaign of kind ``hexapod``.

    Commanded ``x_mm .. rz_deg`` and measured ``measured_x_mm .. measured_rz_deg``; optional ``pose``, ``group`` and
    ``cycle`` (any text), ``time_s``, ``u_position_um``, ``u_rotation_urad`` and temperatures ``<name>_degC``.  Without
    ``pose``, rows with the same command are one pose.  The three measured angles may be left out together.

    Parameters
    ----------
    path : str or Path
        CSV, or Parquet where the name ends in ``.parquet`` or ``.pq``.
    convention : str
        Rotation convention of the angles, see `hexathermal.poses`.
    frames : Frames, optional
        User and object frame: poses become those of the object seen in the user frame.

    Raises
    ------
    ArgumentError, UnknownNameError
        There is no such file, or no such convention; or the object is away from the point that was measured, and turns
        (or, beside that of positions, their uncertainty) were not.
    FileFormatError
        Lists what is wrong with line and column.
    """
    wanted, turns = _wanted(path)
    arm = 0.0 if frames is None else float(np.linalg.norm(frames.object[:3])) * 1e-3
    _check_arm(path, arm, wanted, turns)
    numbers, times, labels, stream = _read(path, wanted)
    column = dict(zip(wanted, numbers.T, strict=True))
    commands = numbers[:, :6]
    answers = np.column_stack([column.get(name, commands[:, k]) for k, name in enumerate(MEASURED_COLUMNS)])
    poses = labels.get("pose") or _named(commands)
    groups = labels.get("group") or [""] * len(poses)
    problems = [*_contradictions(stream, poses, commands), *_doubles(stream, poses, groups, labels.get("cycle"))]
    problems += [*_not_positive(stream, column), *_too_large(stream, column)]
    if problems:
        raise _all_of(stream, problems)
    commanded, measured = (pose_from_coordinates(six, convention) for six in (commands, answers))
    if frames is not None:
        commanded, measured = frames.user_pose(commanded), frames.user_pose(measured)
    u_position, u_rotation = (None if (u := column.get(name)) is None else u * 1e-6 for name in UNCERTAINTIES)
    if arm and u_position is not None and u_rotation is not None:
        u_position = np.hypot(u_position, arm * u_rotation)
    return MeasuredPoses(
        path=stream.path,
        commanded=commanded,
        measured=measured,
        poses=tuple(poses),
        groups=tuple(groups),
        time=times,
        temperatures={name.removesuffix("_degC"): column[name] for name in wanted if name.endswith("_degC")},
        u_position=u_position,
        u_rotation=u_rotation,
        turns=turns,
        unused=tuple(name for name in stream.header.extras if name not in LABELS),
        convention=convention,
    )


def _wanted(path: str | Path) -> tuple[tuple[str, ...], bool]:
    """Return the columns that are read as numbers, and whether rotations were measured."""
    shifts, angles = MEASURED_COLUMNS[:3], MEASURED_COLUMNS[3:]
    stream = open_table(path, (*POSE_COLUMNS, *shifts), "measured poses")
    stream.close()
    extras = stream.header.extras
    turns = any(name in extras for name in angles)
    optional = [name for name in extras if name in UNCERTAINTIES or name.endswith("_degC")]
    return (*POSE_COLUMNS, *shifts, *(angles if turns else ()), *optional), turns


def _check_arm(path: str | Path, arm: float, wanted: tuple[str, ...], turns: bool) -> None:
    """Refuse to tell of a point away from that which was measured, where what turns do to it is not known."""
    position, rotation = UNCERTAINTIES
    if arm and not turns:
        raise ArgumentError(
            f"{path}: the object is {arm * 1e3:g} mm away from the point that was measured, and turns that were not "
            "measured move it; add measured_rx_deg, measured_ry_deg and measured_rz_deg, or measure the object itself"
        )
    if arm and position in wanted and rotation not in wanted:
        raise ArgumentError(
            f"{path}: the object is {arm * 1e3:g} mm away from the point that was measured, and is as uncertain as "
            f"turns make it; add the column {rotation} beside {position}"
        )


def _read(
    path: str | Path, wanted: tuple[str, ...]
) -> tuple[FloatArray, FloatArray | None, dict[str, list[str]], TableStream]:
    """Return numbers (n, k), times, labels by name, and the stream that knows lines."""
    stream = open_table(path, wanted, "measured poses")
    blocks, times, problems = [], [], []
    texts: dict[str, list[str]] = {name: [] for name in LABELS if name in stream.header.extras}
    while (rows := stream.next_rows()) is not None:
        blocks.append(rows.numbers)
        if rows.time is not None:
            times.append(rows.time)
        for name, extra in zip(stream.header.extras, rows.extras, strict=True):
            if name in texts:
                texts[name] += [_text(value) for value in extra.to_pylist()]
    for name, words in texts.items():
        for row, word in enumerate(words):
            if not word:
                problems.append(_at(stream, row, name, f"{name} is missing, expected a name or a number"))
    if problems:
        raise _all_of(stream, problems)
    return np.concatenate(blocks), np.concatenate(times) if times else None, texts, stream


def _text(value: Any) -> str:
    """Return a label as text; a number of a Parquet file without a point that says nothing."""
    if value is None:
        return ""
    whole = isinstance(value, float) and value.is_integer()
    return str(int(value) if whole else value).strip()


def _named(commands: FloatArray) -> list[str]:
    """Return names P1, P2 .. of equal commands, in the order of the file."""
    names: dict[tuple[float, ...], str] = {}
    return [names.setdefault(tuple(six), f"P{len(names) + 1}") for six in commands.tolist()]


def _contradictions(stream: TableStream, poses: list[str], commands: FloatArray) -> Iterator[Problem]:
    """Return rows whose command differs from that of the first row of the same pose."""
    first: dict[str, int] = {}
    for row, pose in enumerate(poses):
        other = first.setdefault(pose, row)
        differs = np.flatnonzero(commands[row] != commands[other])
        if differs.size:
            name = POSE_COLUMNS[differs[0]]
            found, before = float(commands[row, differs[0]]), float(commands[other, differs[0]])
            message = f"{name} of pose {pose!r} is {found!r}, but {before!r} on line {stream.line(other)}"
            yield _at(stream, row, name, f"{message}: a pose has one command")


def _doubles(stream: TableStream, poses: list[str], groups: list[str], cycles: list[str] | None) -> Iterator[Problem]:
    """Return rows that repeat pose, group and cycle of an earlier one."""
    if cycles is None:
        return
    seen: dict[tuple[str, str, str], int] = {}
    for row, place in enumerate(zip(poses, groups, cycles, strict=True)):
        other = seen.setdefault(place, row)
        if other != row:
            where = f"pose {place[0]!r}" + (f", group {place[1]!r}" if place[1] else "") + f", cycle {place[2]!r}"
            yield _at(stream, row, "cycle", f"{where} is there already, on line {stream.line(other)}")


def _not_positive(stream: TableStream, column: dict[str, FloatArray]) -> Iterator[Problem]:
    """Return rows whose uncertainty is not above 0."""
    for name in UNCERTAINTIES:
        for row in np.flatnonzero(column.get(name, np.ones(1)) <= 0.0):
            found = float(column[name][row])
            yield _at(stream, int(row), name, f"{name} is {found!r}, expected above 0: no measurement is exact")


def _too_large(stream: TableStream, column: dict[str, FloatArray]) -> Iterator[Problem]:
    """Return rows with a coordinate that no machine has."""
    for name, values in column.items():
        for row in np.flatnonzero(np.abs(values) > LARGEST):
            yield _at(stream, int(row), name, f"{name} is {float(values[row])!r}, expected within +-{LARGEST:g}")


def _at(stream: TableStream, row: int, name: str, message: str) -> Problem:
    """Return a problem of a field."""
    return Problem(stream.line(row), stream.header.column(name), message)


def _all_of(stream: TableStream, problems: list[Problem]) -> FileFormatError:
    """Return the error that lists problems, the first of many."""
    listed = sorted(problems, key=lambda problem: (problem.line, problem.column))
    if len(listed) > MOST_PROBLEMS:
        last = listed[MOST_PROBLEMS - 1]
        more = Problem(last.line, last.column, f"{len(listed) - MOST_PROBLEMS + 1} more fields are wrong from here on")
        listed = [*listed[: MOST_PROBLEMS - 1], more]
    return FileFormatError(str(stream.path), tuple(listed))
