"""Scenarios given as tables: `time_s` and `q_mm`, and the room's air where it is given."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hexathermal.errors import FileFormatError, Problem
from hexathermal.machine.thermal import frozen
from hexathermal.poses import FloatArray
from hexathermal.predict.table_streams import TableStream, open_table
from hexathermal.simulate.bench.bench import Bench, RunPlan
from hexathermal.simulate.bench.room import Weather
from hexathermal.simulate.bench.scenario import Commands

ROOM_COLUMNS = ("air_temperature_degC", "air_pressure_hPa", "air_humidity_percent")
LIMITS = {"air_temperature_degC": (-40.0, 100.0), "air_pressure_hPa": (100.0, 1400.0),
          "air_humidity_percent": (0.0, 100.0)}  # fmt: skip
"""What a room column may hold."""

LONGEST_RUN_H = 240.0
"""Hours of a run: every row of the log is held in memory."""


@dataclass(frozen=True, eq=False)
class GivenScenario:
    """A scenario from a table.

    Attributes
    ----------
    commands : Commands
        The first row says where the rod rests; each further row whose `q_mm` differs starts a move at its time; the
        last row's time ends the run.
    room : mapping of column to array
        Of the room's columns that the table has, at the rows' times.
    times : array, shape (n,) [s]
        Of the rows, counted from the first.
    """

    commands: Commands
    room: dict[str, FloatArray]
    times: FloatArray

    def weather(self, bench: Bench, generator: np.random.Generator, time: FloatArray) -> Weather:
        """Return the air at times: as given, linear between rows; drawn where the table does not say."""
        drawn = bench.room.weather(time, generator)

        def of(column: str, scale: float, other: FloatArray) -> FloatArray:
            given = self.room.get(column)
            return other if given is None else frozen(np.interp(time, self.times, given) * scale)

        return Weather(
            of(ROOM_COLUMNS[0], 1.0, drawn.temperature), of(ROOM_COLUMNS[1], 100.0, drawn.pressure),
            of(ROOM_COLUMNS[2], 0.01, drawn.humidity),
        )  # fmt: skip

    def plan(self, bench: Bench, name: str, role: str, seed: tuple[int, ...]) -> RunPlan:
        """Return the plan of a run that follows the table; what it does not say of the air is drawn from `seed`."""
        return RunPlan(name, role, self.commands, lambda time: self.weather(bench, np.random.default_rng(seed), time))


def given_plans(
    tables: tuple[GivenScenario, ...], roles: tuple[str, ...], bench: Bench, seed: int
) -> tuple[RunPlan, ...]:
    """Return a plan for each role; the runs take the tables in turn."""
    return tuple(
        tables[k % len(tables)].plan(bench, f"run-{k + 1:02d}", role, (seed, 4, k)) for k, role in enumerate(roles)
    )


def read_scenario(path: str | Path, bench: Bench) -> GivenScenario:
    """Read a scenario from a CSV or Parquet table.

    Parameters
    ----------
    path : str or Path
        Columns `time_s` (increasing) and `q_mm`, and any of `air_temperature_degC`, `air_pressure_hPa`,
        `air_humidity_percent`.
    bench : Bench
        Its stroke and speed say what can be done.

    Raises
    ------
    ArgumentError
        There is no such file.
    FileFormatError
        A column is missing, or a value is out of range, or a move starts before the last one has ended; every such row
        is listed (the first twenty).
    """
    file = Path(path)
    found = open_table(file, ("time_s", "q_mm"), "scenario").header.names
    room = tuple(name for name in ROOM_COLUMNS if name in found)
    stream = open_table(file, ("q_mm", *room), "scenario")
    blocks = []
    while (rows := stream.next_rows()) is not None:
        blocks.append(np.column_stack([np.asarray(rows.time), rows.numbers]))
    table = np.concatenate(blocks)
    problems = _problems(table, room, bench, stream)
    if problems:
        raise FileFormatError(str(file), tuple(problems[:20]))
    times = table[:, 0] - table[0, 0]
    q = np.round(table[:, 1] * 1e-3, 12)
    moves = np.flatnonzero(np.diff(q) != 0.0) + 1
    commands = Commands(float(q[0]), frozen(times[moves]), frozen(q[moves]), float(times[-1]))
    return GivenScenario(commands, {name: frozen(table[:, 2 + k]) for k, name in enumerate(room)}, frozen(times))


def _problems(table: FloatArray, room: tuple[str, ...], bench: Bench, stream: TableStream) -> list[Problem]:
    """Return what is wrong with the rows of a scenario, in their order."""
    low, high = (edge * 1e3 for edge in bench.leg.stroke)
    limits = {"q_mm": (low, high)} | {name: LIMITS[name] for name in room}
    problems = []
    for k, (name, (least, most)) in enumerate(limits.items(), start=1):
        column = stream.header.column(name)
        for row in np.flatnonzero((table[:, k] < least) | (table[:, k] > most))[:20]:
            text = f"{name} is {table[row, k]:g}, expected {least:g} to {most:g}"
            problems.append(Problem(stream.line(int(row)), column, text))
    time, q, speed = table[:, 0], table[:, 1] * 1e-3, bench.leg.drive.speed
    hours = (time[-1] - time[0]) / 3600.0
    if len(table) < 2 or hours > LONGEST_RUN_H or hours * 3600.0 < bench.interval:
        text = (
            f"the scenario lasts {hours:g} h in {len(table)} rows; expected two rows or more, at least one interval of "
        )
        text += f"the log ({bench.interval:g} s) and at most {LONGEST_RUN_H:g} h"
        problems.append(Problem(stream.line(len(table) - 1), 1, text))
    moves = np.flatnonzero(np.diff(q) != 0.0) + 1
    needed = np.abs(q[moves] - q[moves - 1]) / speed
    for k in np.flatnonzero(time[moves[:-1]] + needed[:-1] > time[moves[1:]] + 1e-9)[:20]:
        text = (
            f"a move starts at {time[moves[k + 1]]:g} s, before the last one (to {q[moves[k]] * 1e3:g} mm) has ended: "
        )
        text += f"it takes {needed[k]:.1f} s at {speed * 1e3:g} mm/s"
        problems.append(Problem(stream.line(int(moves[k + 1])), stream.header.column("time_s"), text))
    return sorted(problems, key=lambda problem: (problem.line, problem.column))
