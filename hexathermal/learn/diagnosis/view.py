"""A campaign as the diagnosis sees it: windows of landings, smoothed temperatures, and the columns of shapes."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, TypeVar, cast

import numpy as np

from hexathermal.learn.diagnosis.channels import Channel
from hexathermal.learn.diagnosis.pieces import Pieces, Pooled, going_on, mean_signals, pieces_of, pooled
from hexathermal.learn.diagnosis.run_after_run import RunAfterRun, read_by
from hexathermal.learn.diagnosis.smoothing import SMOOTHED_S, bands, noise_left, smoothed, smoothed_air
from hexathermal.learn.diagnosis.smoothing_times import smoothed_each, smoothing_times
from hexathermal.learn.signals import RunRows, follows_on
from hexathermal.machine.leg_signals import LegSignals, Memory
from hexathermal.poses import FloatArray

UNMOVED = ("pieces", "pooled", "channel", "time", "q", "goes_on", "travelled")
"""What of a view no temperature enters."""

LEAST_MOVE = 1e-4
"""A rod whose places differ by less stands still [m]."""

Made = TypeVar("Made")


@dataclass(frozen=True, eq=False)
class View:
    """Runs as the diagnosis sees them.

    Attributes
    ----------
    runs : tuple of RunRows
    sensors, base : tuple of str
        All thermometers; those of the law.
    kind : str
        ``"leg"`` or ``"component"``.
    zeroed_by_run, smooths : bool
        Whether each run counts from its own first row; whether temperatures are smoothed.
    dead_path : float [m]
        Of the interferometer; 0 where it is not stated.
    positions : mapping of str to float [m]
        Of the thermometers whose places are stated.
    order : tuple of str
        Names of all runs of the campaign, those for validation too, in the order in which they were made.
    erring : array, shape (2 s,), optional [1/K]
        ``[A .. B ..]`` of the law's thermometers whose slow errors are what wanders in the drift, as their length does.
    floor : array, shape (n,), optional [m]
        Least noise of each window; by default none.
    placed : bool
        Whether the law of a component reads the displacement, as a leg's does.
    """

    runs: tuple[RunRows, ...]
    sensors: tuple[str, ...]
    base: tuple[str, ...]
    kind: str
    zeroed_by_run: bool = True
    dead_path: float = 0.0
    positions: Mapping[str, float] = field(default_factory=dict)
    order: tuple[str, ...] = ()
    smooths: bool = True
    erring: FloatArray | None = None
    floor: FloatArray | None = None
    placed: bool = False

    @property
    def stroked(self) -> bool:
        """Whether the law has two coefficients a sensor, that of a length and that of the displacement."""
        return self.kind == "leg" or self.placed

    @cached_property
    def as_recorded(self) -> View:
        """The same runs with temperatures as they were recorded: smoothing takes what is quicker than their noise."""
        return replace(self, smooths=False)

    @cached_property
    def pieces(self) -> tuple[Pieces, ...]:
        """Windows of each run."""
        return tuple(pieces_of(rows) for rows in self.runs)

    @cached_property
    def pooled(self) -> Pooled:
        """Windows of all runs."""
        return pooled(self.pieces, [len(rows.signals.time) for rows in self.runs])

    @cached_property
    def signals(self) -> tuple[LegSignals, ...]:
        """Signals of each run with temperatures that, where smoothed, count from the smoothed first usable row."""
        if not self.smooths:
            return tuple(rows.signals for rows in self.runs)
        found = []
        for rows, piece in zip(self.runs, self.pieces, strict=True):
            signals, dT = rows.signals, self._smoothed(rows.signals, piece, self.sensors)
            found.append(replace(signals, dT=dT, air=smoothed_air(signals)))
        return tuple(found)

    @cached_property
    def airs(self) -> list[FloatArray] | None:
        """The air's temperature in all rows of each run, shape (n,) each [K]; None where a run does not record it."""
        found = [signals.air for signals in self.signals if signals.air is not None]
        return found if len(found) == len(self.signals) else None

    def _smoothed(self, signals: LegSignals, piece: Pieces, sensors: Iterable[str]) -> dict[str, FloatArray]:
        """Return the smoothed temperatures of some sensors in all rows of a run [K]."""
        read = {name: signals.dT[name] for name in sensors}
        table = smoothed_each(signals.time, read, self.smoothing)
        zero = table[piece.used[0]] if self.zeroed_by_run else 0.0
        return dict(zip(read, (table - zero).T, strict=True))

    @cached_property
    def smoothing(self) -> dict[str, float]:
        """Over how long the readings of each thermometer are smoothed [s]: those of the law's longer, if noisy."""
        return dict.fromkeys(self.sensors, SMOOTHED_S) | smoothing_times(self.runs, self.base)

    @cached_property
    def goes_on(self) -> tuple[bool, ...]:
        """Whether each run follows the one before on the campaign's clock."""
        zero = "run" if self.zeroed_by_run else "campaign"
        before = [None, *(rows.signals for rows in self.runs[:-1])]
        return tuple(follows_on(zero, one, rows.signals) for one, rows in zip(before, self.runs, strict=True))

    @cached_property
    def sampling(self) -> float:
        """Time from row to row, the middle one of the first run [s]."""
        return float(np.median(np.diff(self.signals[0].time)))

    def noise_left(self, sensor: str) -> float:
        """Return what smoothing leaves of the white noise of a reading at rest, RMS; 1 where nothing is smoothed."""
        pairs, over = list(zip(self.runs, self.pieces, strict=True)), self.smoothing[sensor]
        found = [noise_left(one.signals.time, over)[piece.used] for one, piece in pairs]
        return float(np.sqrt((np.concatenate(found) ** 2).mean()))

    def tables(self, sensors: Sequence[str]) -> list[FloatArray]:
        """Return the smoothed temperatures of some sensors in all rows of each run, shape (n, s)."""
        return [np.column_stack([signals.dT[name] for name in sensors]) for signals in self.signals]

    @cached_property
    def channel(self) -> Channel:
        """The measured drift in windows."""
        parts = []
        for k, (rows, piece) in enumerate(zip(self.runs, self.pieces, strict=True)):
            time, w = piece.means(rows.signals.time), len(piece.edges)
            start = np.arange(w) == 0
            fresh = np.concatenate([[True], piece.landing[1:] != piece.landing[:-1]])
            step = np.diff(time, prepend=time[:1])
            parts.append((piece.means(rows.drift), start, fresh, step, piece.rows, np.full(w, k)))
        y, start, fresh, step, count, run = (np.concatenate(items) for items in zip(*parts, strict=True))
        has = bool((fresh & ~start).any()) and (self.moves or self.kind != "leg")
        tied = self.zeroed_by_run and self.kind == "leg"  # of a part thermometers' first rows are most of an offset
        return Channel(y, start, fresh, step, count, run, has, tied, self.zeroed_by_run, self._shown, self.floor, tied)

    @property
    def _shown(self) -> FloatArray | None:
        """How much of what wanders windows show, about 1, shape (n,): ``sqrt(sum (A q0 + B q)^2)`` over its mean."""
        if self.erring is None:
            return None
        A, B = self.erring.reshape(2, -1)
        size = np.linalg.norm(self.length * A + self.q[:, None] * B, axis=1)
        return np.asarray(size / size.mean())

    def windows(self, values: Iterable[FloatArray]) -> FloatArray:
        """Return means over windows of rows' values, run after run, shape (n, k)."""
        return self.pooled.means(np.concatenate(list(values)))

    def windows_zeroed(self, values: Iterable[FloatArray]) -> FloatArray:
        """Return means over windows of rows' values, run after run, less those of the zero, shape (n, k)."""
        return self._zeroed(np.concatenate(list(values)))

    def _zeroed(self, rows: FloatArray) -> FloatArray:
        """Return means over windows of values in all rows, less those of the zero, shape (n, k)."""
        return self.pooled.means(rows, zeroed=self.zeroed_by_run)

    def columns(self, shape: str, parameters: Mapping[str, Any]) -> FloatArray:
        """Return a shape's columns in windows, less their value at each run's zero, shape (n, k).

        Where runs follow one another on the campaign's clock, what the shape remembers goes on.
        """
        if "ratio" not in parameters:
            return self._kept("rows", shape, parameters, lambda *own: self._zeroed(self.rows.columns(*own)))
        # a shape with a ratio is a length times what knows no ratio, and every stage of a diagnosis has its own ratio
        both = self._kept("lengths", shape, {**parameters, "ratio": 0.0}, self._lengths)
        k = both.shape[1] // 2
        return np.asarray(both[:, :k] + parameters["ratio"] * both[:, k:])

    def once(self, key: tuple[Hashable, ...], made: Callable[[], Made], reads: Iterable[str] | None = None) -> Made:
        """Return what was made before under a key, or make it: most of what stages of a diagnosis ask for is alike.

        `reads` are the thermometers that enter it, by default all of them.
        """
        if key not in self._made:
            self._made[key] = made(), frozenset(self.sensors if reads is None else reads)
        return cast("Made", self._made[key][0])

    @cached_property
    def _made(self) -> dict[tuple[Hashable, ...], tuple[object, frozenset[str]]]:
        """What `once` keeps, and the thermometers that enter it."""
        return {}

    def mended(self, runs: tuple[RunRows, ...], sensors: Iterable[str]) -> View:
        """Return the view of runs whose `sensors` alone were mended: what reads none of these is not made again."""
        other, changed = replace(self, runs=runs), frozenset(sensors)
        kept = {key: item for key, item in self._made.items() if not item[1] & changed}
        unmoved = {name: self.__dict__[name] for name in UNMOVED if name in self.__dict__}
        other.__dict__.update(unmoved, _made=kept)
        if self.smooths and "signals" in self.__dict__:
            other.__dict__["smoothing"] = self.smoothing | smoothing_times(runs, [s for s in self.base if s in changed])
            again = zip(self.signals, runs, self.pieces, strict=True)
            other.__dict__["signals"] = tuple(
                replace(rows.signals, dT={**before.dT, **other._smoothed(rows.signals, piece, changed)},
                        air=smoothed_air(rows.signals) if rows.air_sensor in changed else before.air)
                for before, rows, piece in again
            )  # fmt: skip
        return other

    def _kept(
        self, how: str, shape: str, parameters: Mapping[str, Any], made: Callable[[str, Mapping[str, Any]], FloatArray]
    ) -> FloatArray:
        """Return columns of a shape that were made before, or make them."""
        found = self.once(
            (how, shape, repr(sorted(parameters.items()))), lambda: made(shape, parameters), read_by(parameters)
        )
        found.flags.writeable = False
        return found

    @cached_property
    def rows(self) -> RunAfterRun:
        """Signals of all runs."""
        return RunAfterRun(self.signals, self.goes_on)

    def starts(self, time_constant: float) -> FloatArray:
        """Return what stays of a state that had not come to rest before a run: ``exp(-t / tau)`` less that at the zero.

        One column for each run that begins anew, shape (n, r).
        """
        rows = []
        for signals, goes_on, memory in zip(self.signals, self.goes_on, self.rows.memories(), strict=True):
            apart = np.zeros(len(signals.time))
            apart[0] = not goes_on
            late = memory.low_pass("apart", signals.time, apart, time_constant)
            rows.append(late - memory.first("apart at first", late))
        begun = np.cumsum(~np.array(self.goes_on))[self.channel.run]
        return np.asarray(self.windows_zeroed(rows) * (begun[:, None] == np.unique(begun)))

    def _lengths(self, shape: str, parameters: Mapping[str, Any]) -> FloatArray:
        """Return a shape's columns for the retracted length, then for the displacement, shape (n, 2 k)."""
        rows = self.rows.columns(shape, parameters)
        return self._zeroed(np.concatenate([rows, rows * self._stroke], axis=1))

    @cached_property
    def _stroke(self) -> FloatArray:
        """The displacement of all rows over the retracted length, shape (n, 1)."""
        return np.concatenate([one.q / one.retracted_length for one in self.signals])[:, None]

    @cached_property
    def travelled(self) -> tuple[FloatArray, FloatArray]:
        """The way gone since the first run's begin in windows, and that at each window's zero, shape (n,) [m]."""
        ways = (np.cumsum(np.abs(Memory().moves(signals.q))) for signals in self.signals)
        return going_on(ways, self.pieces, zeroed_by_run=self.zeroed_by_run)

    def weather(self, column: int, late: Sequence[float]) -> FloatArray | None:
        """Return a column of the weather behind low passes, less its value at the zero, shape (n, k).

        Parameters
        ----------
        column : int
            1 for the pressure, 2 for the humidity.
        late : sequence of float [s]
            Time constants; 0 for at once.
        """
        found = []
        for rows, signals, memory in zip(self.runs, self.signals, self.rows.memories(), strict=True):
            if rows.weather is None or np.isnan(rows.weather[:, column]).any():
                return None
            values = smoothed(signals.time, rows.weather[:, [column]])[:, 0]
            found.append(np.column_stack([
                memory.low_pass(f"late {tau}", signals.time, values, tau) if tau > 0.0 else values for tau in late
            ]))  # fmt: skip
        first = 0.0 if self.zeroed_by_run else found[0][self.pieces[0].used[0]]
        return self.windows_zeroed([own - first for own in found])

    def quick_columns(self, shape: str, parameters: Mapping[str, Any]) -> FloatArray:
        """Return the columns of a shape that remembers its first values at most, made from windows, shape (n, k)."""
        return self._kept("windows", shape, parameters, self._quick_columns)

    def _quick_columns(self, shape: str, parameters: Mapping[str, Any]) -> FloatArray:
        """Return a shape's columns, made of windows."""
        found = self._from_zero.columns(shape, parameters)
        if not self.zeroed_by_run:
            return found
        zeros = self._from_zero.firsts
        return np.asarray(np.delete(found, zeros, axis=0) - found[zeros][self.channel.run])

    @cached_property
    def windowed(self) -> tuple[LegSignals, ...]:
        """Signals of each run, one row a window: enough for shapes without a memory."""
        return tuple(mean_signals(signals, piece) for signals, piece in zip(self.signals, self.pieces, strict=True))

    @cached_property
    def _from_zero(self) -> RunAfterRun:
        """The same, behind the row of the zero where each run has its own."""
        runs = zip(self.signals, self.pieces, strict=True)
        return RunAfterRun(tuple(mean_signals(*own, zeroed=self.zeroed_by_run) for own in runs), self.goes_on)

    @cached_property
    def time(self) -> FloatArray:
        """Time of each window since its run's first row [s]."""
        return self.windows(signals.time for signals in self.signals)[:, 0]

    @cached_property
    def q(self) -> FloatArray:
        """Displacement in each window [m]."""
        return self.windows(signals.q for signals in self.signals)[:, 0]

    @property
    def length(self) -> float:
        """Retracted length q0 [m]; 1 for a component."""
        return self.runs[0].signals.retracted_length

    @cached_property
    def moves(self) -> bool:
        """Whether the rod moves, in a run where each counts from its own place."""
        places = [piece.means(signals.q) for signals, piece in zip(self.signals, self.pieces, strict=True)]
        return any(bool(np.ptp(own) > LEAST_MOVE) for own in (places if self.zeroed_by_run else [self.q]))

    @property
    def indexed(self) -> bool:
        """Whether beams measure, in air of which the index is known."""
        return self.kind == "leg" and self.weathered

    @property
    def weathered(self) -> bool:
        """Whether the weather tells the index of air in all runs."""
        return all(rows.signals.index is not None for rows in self.runs)

    def temperatures(self, sensor: str) -> FloatArray:
        """Return a sensor's smoothed temperature in windows [K]."""
        return self.once(
            ("means", sensor), lambda: self.windows(one.dT[sensor] for one in self.signals)[:, 0], [sensor]
        )

    def degC(self, sensor: str) -> tuple[FloatArray, FloatArray] | None:
        """Return a sensor's temperature in windows and at the zero of each, shape (n,) [degC]; None if not known."""
        if any(sensor not in rows.signals.zero_degC for rows in self.runs):
            return None
        zeros = np.array([rows.signals.zero_degC[sensor] for rows in self.runs])[self.channel.run]
        return zeros + self.temperatures(sensor), zeros

    def recorded(self, sensor: str) -> FloatArray:
        """Return a sensor's temperature as recorded, in windows [K]."""
        return self.windows_zeroed([rows.signals.dT[sensor] for rows in self.runs])[:, 0]

    def span(self, ratio: float) -> FloatArray:
        """Return ``q0 + ratio q`` in windows [m]; q0 is 1 for a component."""
        return np.asarray(self.length + ratio * self.q)

    @cached_property
    def base_columns(self) -> FloatArray:
        """``q0 dT_s`` and ``q dT_s`` of the law's sensors (``dT_s`` where it reads no place), shape (n, p)."""
        return self.base_of([self.temperatures(name) for name in self.base])

    def quick(self, sensor: str) -> FloatArray:
        """Return what smoothing takes from a sensor's temperature at three lengths, in windows, shape (n, 3) [K].

        It is noise of readings and quick warming; smoothing is symmetric in time and knows no lag.
        """
        return self.once(("quick", sensor), lambda: self.windows_zeroed(self.bands(sensor)), [sensor])

    def bands(self, sensor: str) -> list[FloatArray]:
        """Return what `quick` takes the means of, in all rows of each run, shape (n, 3) [K]."""
        key, own = ("bands", sensor), [rows.signals for rows in self.runs]
        return self.once(key, lambda: [bands(one.time, one.dT[sensor]) for one in own], [sensor])

    @cached_property
    def taken_back(self) -> FloatArray:
        """Return steps where cleaning took back the step of a beam, shape (n, k): it may have been tilt, or less."""
        found = [self.step_at(k, step.time) for k, rows in enumerate(self.runs) for step in rows.record.beam_steps]
        table = np.array(found, dtype=float).reshape(-1, len(self.channel)).T
        return np.asarray(table[:, np.ptp(table, axis=0) > 0.0])

    def step_at(self, k: int, moment: float) -> FloatArray:
        """Return a step of the zero in run k, at a time since its table's first row [s], shape (n,)."""
        return self.step_from(k, float(self.runs[k].signals.time[0]) + moment)

    def step_from(self, k: int, time: float) -> FloatArray:
        """Return a step of the zero in run k from a time of its rows on [s], shape (n,); in one window, a share."""
        run = self.channel.run
        found = ((run > k) & (not self.zeroed_by_run)).astype(np.float64)
        found[run == k] = self.pieces[k].means((self.runs[k].signals.time >= time).astype(np.float64))
        return found

    def base_of(self, temperatures: Sequence[FloatArray]) -> FloatArray:
        """Return the law's columns of temperatures in windows."""
        table = np.column_stack(temperatures)
        if not self.stroked:
            return table
        return np.concatenate([self.length * table, self.q[:, None] * table], axis=1)
