"""What is known of a leg, or of any part, from row to row: the signals that terms of its law are made of.

A controller has one row at a time, a campaign has whole runs: both are `LegSignals`, and what must be remembered
between rows (a filtered temperature, the direction of the last move) is kept in a `Memory`. Rows given one by one, in
blocks or all at once give the same values.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError
from hexathermal.poses import FloatArray

SMALLEST_MOVE = 2e-6
"""A smaller change of the displacement is the scale's noise, not a move [m]."""

WHOLE_ROW = 1e-4
"""A move that goes on by so much in a row has not ended before it [m]."""


@dataclass(frozen=True, eq=False)
class LegSignals:
    """Rows of one run, n of them, in order of time. SI units.

    Parameters
    ----------
    time : array, shape (n,) [s]
        Since the run's zero.
    dT : mapping of str to array, shape (n,) [K]
        Temperatures of the sensors, less those of the zero.
    q : array, shape (n,) [m]
        Displacement of the rod, or of a part with a stroke; zeros for one without.
    retracted_length : float [m]
        q0; 1 for a part that is no leg, whose coefficients are then lengths for a kelvin.
    air : array, shape (n,) [K]
        Air temperature less that of the zero; NaN where it is not recorded.
    index : array, shape (n,) [1]
        Index of refraction of the air less that of the zero; NaN where it is not known.
    tilt : array, shape (n, 2) [rad]
        Of the target about x and y, from the beams' differences, less that of the zero; NaN where there are no beams.
    inputs : mapping of str to array, shape (n,)
        Recorded inputs in their own units.
    zero_degC : mapping of str to float [degC]
        Temperatures of the sensors at the zero, where they are known.
    zero_index : float, optional [1]
        Index of refraction of the air at the zero, where it is known.
    pressure_index : array, shape (n,) [1]
        Index of refraction less that of the zero, were the air as warm and as humid as there; None where it is not
        known.
    zero_row : int, optional
        Of a whole run that counts from a row of its own: that row. What terms add counts from it, too.
    """

    time: FloatArray
    dT: Mapping[str, FloatArray]
    q: FloatArray
    retracted_length: float = 1.0
    air: FloatArray | None = None
    index: FloatArray | None = None
    tilt: FloatArray | None = None
    inputs: Mapping[str, FloatArray] = field(default_factory=dict)
    zero_degC: Mapping[str, float] = field(default_factory=dict)
    zero_index: float | None = None
    pressure_index: FloatArray | None = None
    zero_row: int | None = None

    def __len__(self) -> int:
        return len(self.time)

    def temperature(self, sensor: str) -> FloatArray:
        """Return a sensor's temperature less that of the zero [K]."""
        if sensor not in self.dT:
            raise ArgumentError(f"the law needs sensor {sensor!r}; there are: {', '.join(self.dT) or 'none'}")
        return self.dT[sensor]

    def counted(self, values: FloatArray) -> FloatArray:
        """Return values of all rows, shape (n,) or (n, k), less those of the zero's row where there is one."""
        return values if self.zero_row is None else values - values[self.zero_row]

    def weighted(self, weights: Mapping[str, float]) -> FloatArray:
        """Return ``sum_s w_s dT_s`` of some sensors, weights by their names [K]."""
        return np.asarray(sum(weight * self.temperature(name) for name, weight in weights.items()))

    def zero_of(self, sensor: str) -> float:
        """Return a sensor's temperature at the zero [degC]."""
        if sensor not in self.zero_degC:
            raise ArgumentError(
                f"the law needs the temperature of sensor {sensor!r} at the zero [degC]; it is not given"
            )
        return float(self.zero_degC[sensor])

    def recorded(self, name: str) -> FloatArray:
        """Return ``air``, ``index``, ``pressure_index``, ``tilt`` or a recorded input."""
        found: FloatArray | None = getattr(self, name) if name in WORDS else self.inputs.get(name)
        if found is None or np.isnan(found).all():
            raise ArgumentError(f"the law needs {WORDS.get(name, f'the recorded input {name!r}')}, which is not given")
        return found

    def air_read(self, sensor: str | None) -> FloatArray:
        """Return the air's temperature less that of the zero [K], as a sensor in it reads where one is named."""
        return self.recorded("air") if sensor is None else self.temperature(sensor)

    def span(self, ratio: float) -> FloatArray:
        """Return ``q0 + ratio q`` [m], the length that a temperature acts on; `ratio` is B / A."""
        return np.asarray(self.retracted_length + ratio * self.q)


WORDS = {"air": "the air temperature", "index": "the air's temperature, pressure and humidity",
         "pressure_index": "the air's pressure along the run", "tilt": "the interferometer's three beams"}  # fmt: skip


def listed(value: Any) -> Any:
    """Return an array or a tuple as a list, as a file gives it back; else the value."""
    return np.asarray(value).tolist() if isinstance(value, np.ndarray | tuple) else value


class Memory:
    """What a term remembers from the rows before.

    A new memory belongs to the beginning of a run.

    Parameters
    ----------
    begins : sequence of int
        Where all rows of several runs come in one call, one run behind the other: the rows at which the second and
        later ones begin, each with a new memory. Such a memory is for that call alone.
    """

    def __init__(self, begins: Sequence[int] | npt.NDArray[np.int64] = ()) -> None:
        self._kept: dict[str, Any] = {}
        self._begins = np.asarray(begins, dtype=np.int64)

    def copy(self) -> Memory:
        """Return a memory that goes its own way from here; what is kept is replaced, never changed."""
        other = Memory(self._begins)
        other._kept = dict(self._kept)
        return other

    def low_pass(
        self, key: str, time: FloatArray, values: FloatArray, time_constant: float, *, held: bool = False
    ) -> FloatArray:
        """Return values behind a first-order low pass, ``tau dy/dt = u - y``, that has rested at the first value.

        Between rows the values are taken as linear; steps of time may differ. What is a mean since the row before, as a
        speed is, is `held` since then.

        Parameters
        ----------
        key : str
            Under which the state is kept; another one for each filter of a term.
        time : array, shape (n,) [s]
        values : array, shape (n,) or (n, k)
        time_constant : float [s]
        held : bool
        """
        u = values if values.ndim == 2 else values[:, None]
        before = self._kept.get(key)
        t0, u0, y0 = (time[0], u[0], u[0]) if before is None else before
        step = self._since(time, t0) / time_constant
        decay = np.exp(-step)
        if held:
            gained = u * (1.0 - decay)[:, None]
        else:
            carried = _carried(step, decay)
            gained = u * carried[:, None]
            gained += np.concatenate([u0[None], u[:-1]]) * (1.0 - decay - carried)[:, None]
        gained[self._begins] = u[self._begins]
        y = self._accumulated(decay, gained, y0)
        self._kept[key] = (time[-1], u[-1].copy(), y[-1].copy())
        return y if values.ndim == 2 else y[:, 0]

    def speed(self, time: FloatArray, q: FloatArray) -> FloatArray:
        """Return the mean speed since the row before, unsigned; asked once more at that row's time, its own [m/s]."""
        t0, q0, v0 = self._kept.get("speed", (time[0], q[0], 0.0))
        dt, dq = self._since(time, t0), self._since(q, q0)
        found = np.where(
            dt > 0.0, np.abs(np.where(np.abs(dq) > SMALLEST_MOVE, dq, 0.0)) / np.where(dt > 0, dt, 1.0), 0.0
        )
        known = dt > 0.0
        known[self._begins] = True
        last = np.maximum.accumulate(np.where(known, np.arange(1, len(dt) + 1), 0))
        found = np.concatenate([[v0], found])[last]  # rows at the time of the one before have its speed
        self._kept["speed"] = (time[-1], q[-1], found[-1])
        return found

    def heats(self, time: FloatArray, q: FloatArray, time_constants: Iterable[float]) -> tuple[FloatArray, FloatArray]:
        """Return the speed behind low passes, once and twice behind each, and their rates, (n, 2 t) [m/s, m/s^2]."""
        speed, heats, rates = self.speed(time, q), [], []
        for tau in time_constants:
            once = self.low_pass(f"speed once {tau}", time, speed, tau, held=True)
            twice = self.low_pass(f"speed twice {tau}", time, once, tau)
            heats += [once, twice]
            rates += [(speed - once) / tau, (once - twice) / tau]
        return np.stack(heats, axis=1), np.stack(rates, axis=1)

    def first(self, key: str, values: FloatArray) -> Any:
        """Return what values (n,) or (n, k) were in their run's first row; of several runs that of each in its rows."""
        if len(self._begins):
            return np.repeat(values[[0, *self._begins]], np.diff([0, *self._begins, len(values)]), axis=0)
        return self._kept.setdefault(key, values[0].copy() if values.ndim > 1 else float(values[0]))

    def stages(self, time: FloatArray, values: FloatArray, time_constants: Iterable[float]) -> FloatArray:
        """Return values behind low passes, one behind the other; see `low_pass`."""
        for stage, time_constant in enumerate(time_constants):
            values = self.low_pass(f"stage {stage}", time, values, time_constant)
        return values

    def moves(self, q: FloatArray) -> FloatArray:
        """Return by how much the rod moved since the row before, signed, 0 where it rested [m]."""
        before = self._kept.get("moves", q[0])
        self._kept["moves"] = q[-1]
        step = self._since(q, before)
        return np.where(np.abs(step) > SMALLEST_MOVE, step, 0.0)

    def lengths(self, q: FloatArray) -> FloatArray:
        """Return how far the move that a row belongs to has gone so far, signed; 0 at rest, shape (n,) [m].

        Rows in which the rod moves one way without a rest belong to one move.
        """
        last = self._kept.get("lengths", 0.0)
        steps = self.moves(q)
        way = np.sign(np.concatenate([[last], steps]))
        gone = np.cumsum(np.concatenate([[last], steps]))
        begins = np.concatenate([[True], way[1:] != way[:-1]])
        first = np.maximum.accumulate(np.where(begins, np.arange(len(way)), 0))
        before = np.where(first > 0, gone[first - 1], 0.0)
        found = np.where(way != 0.0, gone - before, 0.0)[1:]
        self._kept["lengths"] = found[-1]
        return np.asarray(found)

    def direction(self, q: FloatArray, before: float = 0.0) -> FloatArray:
        """Return the direction of the last move, +1 or -1; `before` until the first one."""
        held = np.concatenate([[self._kept.get("direction", before)], np.sign(self.moves(q))])
        known = held != 0.0
        held[1 + self._begins], known[1 + self._begins] = before, True
        last = np.maximum.accumulate(np.where(known, np.arange(len(held)), 0))
        found = held[last][1:]
        self._kept["direction"] = found[-1]
        return np.asarray(found)

    def play(self, q: FloatArray, width: float, start: float = 0.0) -> FloatArray:
        """Return where a nut sits in its play, -1/2 to 1/2: it goes with the rod until it meets the other side.

        ``s <- clip(s + dq / width, -1/2, 1/2)``.

        Parameters
        ----------
        q : array, shape (n,) [m]
        width : float [m]
            Way of the rod in which the nut crosses its play.
        start : float
            Where it sits at first; by default in the middle.
        """
        if len(self._begins):
            return np.concatenate([Memory().play(own, width, start) for own in np.split(q, self._begins)])
        before, place = self._kept.get("play", (float(q[0]), start))
        steps = self._since(q, before) / width
        place = min(max(float(place), -0.5), 0.5)
        moving, places = np.flatnonzero(steps), [place]
        for step in steps[moving].tolist():
            place = min(max(place + step, -0.5), 0.5)
            places.append(place)
        rests = np.diff(moving, prepend=0, append=len(q))  # rows from each place on that the nut stays there
        found = np.repeat(places, rests)
        self._kept["play"] = (float(q[-1]), place)
        return found

    def relaxing(
        self, time: FloatArray, sizes: FloatArray, lengths: FloatArray, time_constant: float, name: str = ""
    ) -> FloatArray:
        """Return what decays from the end of each move, ``y <- y exp(-dt / tau) + kick``, shape (n,).

        In a row in which a move goes on its decay begins anew; in part where that row is shorter than `WHOLE_ROW`, as
        the steps of a corrected leg that follows its temperature are.

        Parameters
        ----------
        time : array, shape (n,) [s]
        sizes : array, shape (n,)
            Of the move that a row belongs to, as it is so far.
        lengths : array, shape (n,) [m]
            See `lengths`.
        time_constant : float [s]
        name : str
            Of several decays that one term remembers.
        """
        key = f"relaxing {name}"
        t0, y0, size, length = self._kept.get(key, (time[0], np.zeros(1), 0.0, 0.0))
        step = self._since(time, t0) / time_constant
        before = np.concatenate([[size], sizes[:-1]])
        gone = np.concatenate([[length], lengths[:-1]])
        anew = np.minimum(np.abs(lengths - gone) / WHOLE_ROW, 1.0)
        kicks = sizes - np.where(lengths * gone > 0.0, before * (1.0 + anew * np.expm1(-step)), 0.0)
        y = self._accumulated(np.exp(-step), kicks[:, None], y0)
        self._kept[key] = (time[-1], y[-1].copy(), sizes[-1], lengths[-1])
        return np.asarray(y[:, 0])

    def renewing(
        self, time: FloatArray, whole: FloatArray, lengths: FloatArray, time_constant: float, slid: float,
        name: str = "",
    ) -> FloatArray:  # fmt: skip
        """Return what decays at rest, and what sliding renews, shape (n,).

        ``y <- whole + (y exp(-dt / tau) - whole) exp(-|dq| / slid)``: friction's force at rest and on its way
        (Dahl, AIAA Journal 14 (1976) 1675), which creeps at rest.

        Parameters
        ----------
        time : array, shape (n,) [s]
        whole : array, shape (n,)
            What the move that a row belongs to ends at.
        lengths : array, shape (n,) [m]
            See `lengths`.
        time_constant : float [s]
        slid : float [m]
            Way that renews.
        name : str
            Of several decays that one term remembers.
        """
        key = f"renewing {name}"
        t0, y0, length = self._kept.get(key, (time[0], np.zeros(1), 0.0))
        gone = np.concatenate([[length], lengths[:-1]])
        begun = np.where(lengths * gone > 0.0, gone, 0.0)  # a move the other way begins at 0
        way = np.where(lengths != 0.0, np.abs(lengths - begun), 0.0)
        kept = np.exp(-way / slid)
        decay = np.exp(-self._since(time, t0) / time_constant)
        y = self._accumulated(decay * kept, (whole * (1.0 - kept))[:, None], y0)
        self._kept[key] = (time[-1], y[-1].copy(), lengths[-1])
        return np.asarray(y[:, 0])

    def _since(self, values: FloatArray, before: float) -> FloatArray:
        """Return each value less the one before it, 0 where a run begins, shape (n,)."""
        found = np.empty(len(values))
        found[0] = values[0] - before
        np.subtract(values[1:], values[:-1], out=found[1:])
        found[self._begins] = 0.0
        return found

    def _accumulated(self, decay: FloatArray, gained: FloatArray, start: FloatArray) -> FloatArray:
        """Return ``y_i = decay_i y_(i-1) + gained_i``, shape (n, k), ``gained_i`` alone where a run begins.

        That is a triangular system with two diagonals. `decay` (n,) and `gained` (n, k) are overwritten; `start` (k,).
        """
        gained[0] += decay[0] * start
        if len(gained) == 1:
            return gained
        from scipy.linalg.blas import dtbsv

        decay[self._begins] = 0.0
        band = np.ones((2, len(gained)), order="F")
        np.negative(decay[1:], out=band[1, :-1])
        if gained.shape[1] == 1:
            return np.asarray(dtbsv(1, band, gained[:, 0], lower=1, diag=1, overwrite_x=1))[:, None]
        return np.stack([dtbsv(1, band, column, lower=1, diag=1) for column in gained.T], axis=1)


SMALL_STEP = 1e-4
"""Steps over a time constant up to which the first terms of a series are exact."""


def _carried(step: FloatArray, decay: FloatArray) -> FloatArray:
    """Return the part of a linear piece that its end carries, ``1 - (1 - decay) / step``, decay being exp(-step).

    By its series where a step is small.
    """
    found = 1.0 - (1.0 - decay) / np.maximum(step, SMALL_STEP)
    small = np.flatnonzero(step <= SMALL_STEP)
    found[small] = step[small] / 2.0 - step[small] ** 2 / 6.0
    return np.asarray(found)
