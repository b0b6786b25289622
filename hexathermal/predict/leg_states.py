"""Six legs whose laws remember the rows before: corrected lengths and drift, row after row.

Lag, stored heat, creep and the direction of the last move have states; rows come one by one, as a controller has them,
or in blocks, as a file has them, and give the same. A leg begins at rest at the temperatures of its first row.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError, HexathermalError, KinematicsError, ThermalModelError
from hexathermal.kinematics.batches import where
from hexathermal.kinematics.forward import checked_lengths
from hexathermal.kinematics.inverse import poses_of
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.leg_states import LARGEST_JUMP, LegMemory
from hexathermal.machine.thermal import TemperaturesLike
from hexathermal.poses import FloatArray, PoseLike, as_array
from hexathermal.predict.balance import balanced
from hexathermal.predict.correction import base_warm, check_strokes, since_reference, with_added
from hexathermal.predict.leg_drift import added_drift, machine_memories
from hexathermal.predict.motion_rows import MotionRows, motion_rows
from hexathermal.predict.temperatures import active_model, check_temperatures, temperature_array

Inputs: TypeAlias = Mapping[str, npt.ArrayLike]
"""Recorded inputs by name, one value a row, in their own units."""


class LegControllers:
    """Corrected leg lengths of a machine in the order of time.

    Parameters
    ----------
    hexapod : Hexapod
        With a thermal law.

    Examples
    --------
    >>> import hexathermal as ht
    >>> from hexathermal.predict.leg_states import LegControllers
    >>> hexapod = ht.load_hexapod("reference")
    >>> controllers = LegControllers(hexapod)
    >>> lengths = controllers.corrected_leg_lengths(hexapod.home, [22.0] * 6, 0.0)
    >>> bool((lengths == hexapod.corrected_leg_lengths(hexapod.home, [22.0] * 6)).all())      # no terms, no memory
    True
    """

    def __init__(self, hexapod: Hexapod) -> None:
        active_model(hexapod)
        self.hexapod = hexapod
        self._memories = machine_memories(hexapod)
        self._time = -np.inf
        self._told: FloatArray | None = None

    def corrected_leg_lengths(
        self, pose: PoseLike, temps: TemperaturesLike, time: npt.ArrayLike, *, inputs: Inputs | None = None,
        remember: bool = True, between: tuple[npt.ArrayLike, TemperaturesLike] | None = None,
    ) -> FloatArray:  # fmt: skip
        """Return the leg lengths to command in the next row, or the next rows.

        Parameters
        ----------
        pose : SE3 or array, shape (4, 4) or (n, 4, 4) [m]
        temps : array, shape (s,) or (n, s) [degC], or mapping
        time : float or array, shape (n,) [s]
            From any origin, never decreasing.
        inputs : mapping, optional
            Recorded inputs that a term reads.
        remember : bool
            Whether the machine goes there. False: what was commanded, or reached, is told to `leg_drift`, and rows
            `between` to `stay`.
        between : arrays, shape (u,) [s] and (u, s) [degC], optional
            Times, never decreasing, and temperatures of rows before and between these, in which the legs are told
            nothing new: they stay as the row before told them, before the first of all as that one tells them. Not
            with `inputs`.

        Returns
        -------
        array, shape (6,) or (n, 6) [m]

        Raises
        ------
        ArgumentError
            Time runs backwards, or shapes do not fit; otherwise as `Hexapod.corrected_leg_lengths`.
        TemperatureError
            A temperature, also of rows `between`, is out of the laws' range; the index is that among its own rows.
        """
        poses, readings = poses_of(pose), temperature_array(self.hexapod, temps)
        single = poses.ndim == 2
        when = self._rows(time, poses.shape[:-2], "poses")
        rows = self._merged(when, _each_row(readings, len(when)), between, inputs)
        lengths, memories = self._solved(poses[None] if single else poses, rows, _values(inputs, len(when)))
        if remember:
            self._memories, self._time, self._told = memories, float(rows.time[-1]), lengths[-1]
        return lengths[0] if single else lengths

    def leg_drift(
        self, lengths: npt.ArrayLike, temps: TemperaturesLike, time: npt.ArrayLike, *, inputs: Inputs | None = None
    ) -> FloatArray:
        """Return how much longer each warm leg is than it was told to be in the next row or rows, and remember them.

        Parameters as `corrected_leg_lengths`; lengths : array, shape (6,) or (n, 6) [m], commanded.

        Returns
        -------
        array, shape (6,) or (n, 6) [m]
        """
        told, drift, _expansions = self._next(lengths, temps, time, inputs)
        return drift.reshape(told.shape)

    def stay(self, temps: TemperaturesLike, time: npt.ArrayLike) -> None:
        """Remember rows in which the legs are told nothing new.

        Parameters
        ----------
        temps : array, shape (s,) or (n, s) [degC], or mapping
        time : float or array, shape (n,) [s]

        Raises
        ------
        ArgumentError
            The legs were told nothing yet; otherwise as `leg_drift`.
        """
        if self._told is None:
            raise ArgumentError("the legs were told nothing yet: rows before the first pose go with it, as `between`")
        when = np.atleast_1d(as_array(time, "time"))
        self.leg_drift(np.tile(self._told, (len(when), 1)), temps, when)

    def predicted_pose(
        self, lengths: npt.ArrayLike, temps: TemperaturesLike, time: npt.ArrayLike, *, inputs: Inputs | None = None
    ) -> FloatArray:
        """Return where the platform really stands in the next row or rows, and remember them.

        As `Hexapod.predicted_pose`, with the terms that depend on the rows before.

        Parameters as `leg_drift`.

        Returns
        -------
        array, shape (4, 4) or (n, 4, 4) [m]

        Raises
        ------
        ArgumentError, OutOfStrokeError
            As `leg_drift`; a commanded length is out of stroke. Rows that are refused are not remembered.
        """
        before = self._memories, self._time, self._told
        try:
            told, drift, expansions = self._next(lengths, temps, time, inputs)
            rows, lead = np.array(np.atleast_2d(told)), told.shape[:-1]
            check_strokes(self.hexapod, rows, lead)
            return balanced(self.hexapod, rows + drift, rows, expansions, lead).reshape(*lead, 4, 4)
        except HexathermalError:
            self._memories, self._time, self._told = before
            raise

    def _next(
        self, lengths: npt.ArrayLike, temps: TemperaturesLike, time: npt.ArrayLike, inputs: Inputs | None
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return commanded lengths as given, drift (n, 6) and expansions (n, 2) of the next rows, and remember them."""
        told, readings = checked_lengths(lengths), temperature_array(self.hexapod, temps)
        when = self._rows(time, told.shape[:-1], "lengths")
        rows, hot = np.atleast_2d(told), _each_row(readings, len(when))
        warm, expansions = base_warm(self.hexapod, rows, hot)
        memories = [memory.copy() for memory in self._memories]
        dT = since_reference(self.hexapod, hot, rows.shape[:-1])
        drift = warm - rows + added_drift(self.hexapod, rows, dT, when, memories, _values(inputs, len(rows)))
        self._memories, self._time, self._told = memories, float(when[-1]), rows[-1]
        return told, drift, expansions

    def _merged(
        self, when: FloatArray, hot: FloatArray, between: tuple[npt.ArrayLike, TemperaturesLike] | None,
        inputs: Inputs | None,
    ) -> MotionRows:  # fmt: skip
        """Return the rows of poses, and checked ones between them."""
        if between is None:
            return motion_rows(when, hot)
        if inputs:
            raise ArgumentError("rows between poses have no recorded inputs: give a pose for each row, or no inputs")
        times = np.atleast_1d(as_array(between[0], "time of the rows between"))
        if not len(times):
            return motion_rows(when, hot)
        readings = temperature_array(self.hexapod, between[1])
        check_temperatures(self.hexapod, readings)
        try:
            times = self._rows(times, times.shape, "rows between")
        except ArgumentError as error:
            raise ArgumentError(f"rows between: {error}") from None
        return motion_rows(when, hot, (times, _each_row(readings, len(times))))

    def _rows(self, time: npt.ArrayLike, lead: tuple[int, ...], what: str) -> FloatArray:
        """Return checked times of the next rows."""
        if len(lead) > 1 or lead == (0,):
            raise ArgumentError(f"{what} with leading shape {lead} are no rows in the order of time; give one, or (n,)")
        count = lead[0] if lead else 1
        when = np.atleast_1d(as_array(time, "time"))
        if when.shape != (count,):
            raise ArgumentError(f"time has shape {when.shape}; expected {count} values, one for each row")
        if not np.isfinite(when).all() or (np.diff(when, prepend=self._time) < 0.0).any():
            raise ArgumentError(f"time must be finite and never decrease; the last row was at {self._time:g} s")
        return when

    def _solved(
        self, poses: FloatArray, rows: MotionRows, inputs: Mapping[str, FloatArray]
    ) -> tuple[FloatArray, list[LegMemory]]:
        """Return corrected lengths (n, 6) of rows, and the memories behind them.

        Where the lengths of many rows do not settle together (a reversal within the scale's noise), halves are taken.
        """
        memories, hot = self._memories, rows.hot[rows.own]
        whole = since_reference(self.hexapod, rows.hot, (len(rows.time),))

        def added(told: FloatArray, _dT: FloatArray) -> FloatArray:
            nonlocal memories
            memories = [memory.copy() for memory in self._memories]
            stood = told
            if not rows.alone:
                before = told[:1] if self._told is None else self._told[None]  # what comes first was no motion
                stood = np.concatenate([before, told])[rows.stand + 1]
            return added_drift(self.hexapod, stood, whole, rows.time, memories, inputs)[rows.own]

        try:
            lengths = with_added(self.hexapod, poses, hot, added, LARGEST_JUMP if len(rows) == 1 else 0.0)
        except ThermalModelError:
            if len(rows) == 1:
                raise
            return self._halves(poses, rows, inputs)
        added(lengths, whole)  # remember what is commanded: the last step went on from what was tried
        return lengths, memories

    def _halves(
        self, poses: FloatArray, rows: MotionRows, inputs: Mapping[str, FloatArray]
    ) -> tuple[FloatArray, list[LegMemory]]:
        """Return what `_solved` returns, from the two halves of the rows."""
        before, middle, parts = (self._memories, self._told), len(rows) // 2, []
        try:
            for part in (slice(0, middle), slice(middle, len(rows))):
                own = {name: values[part] for name, values in inputs.items()}
                lengths, self._memories = self._solved(poses[part], rows.part(part.start, part.stop), own)
                self._told = lengths[-1]
                parts.append(lengths)
            return np.concatenate(parts), self._memories
        except KinematicsError as error:
            index = (error.index[0] + part.start, *error.index[1:])
            raise type(error)(
                str(error).replace(where(error.index), where(index), 1),
                leg=error.leg, value=error.value, lower=error.lower, upper=error.upper, index=index,
            ) from None  # fmt: skip
        finally:
            self._memories, self._told = before


def leg_controllers(hexapod: Hexapod) -> LegControllers:
    """Return what gives corrected lengths row after row, for a machine whose legs' laws have states.

    Raises
    ------
    ThermalModelError
        The machine has no thermal law.
    """
    return LegControllers(hexapod)


def _each_row(readings: FloatArray, count: int) -> FloatArray:
    """Return temperatures (n, s) of rows, from one set for all or one for each."""
    if readings.ndim > 2 or (readings.ndim == 2 and len(readings) != count):
        raise ArgumentError(
            f"temps has shape {readings.shape}; expected ({readings.shape[-1]},), or one set for each of {count} rows"
        )
    return np.ascontiguousarray(np.broadcast_to(readings, (count, readings.shape[-1])))


def _values(inputs: Inputs | None, count: int) -> dict[str, FloatArray]:
    """Return recorded inputs as arrays (n,)."""
    found = {name: np.atleast_1d(as_array(values, name)) for name, values in (inputs or {}).items()}
    for name, values in found.items():
        if values.shape != (count,):
            raise ArgumentError(f"input {name} has shape {values.shape}; expected {count} values, one for each row")
    return found
