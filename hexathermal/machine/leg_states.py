"""What the terms of a law add to a drift, and a controller that is given one row after the other.

Each term of a law has a memory of its own. Terms of the bench (its frame, the interferometer) join what a campaign
measures, but are no property of the leg: a machine does not carry them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.machine.leg_repairs import RepairMemory, SensorRepair, ahead_of
from hexathermal.machine.leg_signals import LegSignals, Memory
from hexathermal.machine.leg_terms import BY_MOTION, WEIGHED, LegTerm
from hexathermal.poses import FloatArray

STATELESS = ("temperature", "expansion", "square", "cube", "bend", "position", "periodic", "wave")
"""Shapes that follow from the displacement and temperatures of one row alone."""

OWN_ZERO = ("position", "periodic", "wave", "square", "bend")
"""Shapes that may count from the run's first displacement; on a machine from the retracted leg."""

OF_PLACE = ("position", "periodic", "wave", "direction", "relaxation", "stored-heat", "air-index", BY_MOTION)
"""Shapes that read the displacement, or may, of a part whose own law does not."""

BENCH_SHAPES = ("room", "air-index", "tilt", "time")
BENCH_CAUSES = ("frame-expansion", "air-refraction", "abbe-tilt", "zero-drift", "zero-jump")
"""What belongs to the bench and its interferometer, not to the leg."""

MOST_STEPS = 40
LARGEST_JUMP = 1e-4
"""What a jump of the drift at a reversal may leave of a corrected length, where no length solves the equation [m]."""

LENGTH_STEP = 1e-15
"""A corrected length that moves by less than this is the solution [m]."""


def of_bench(term: LegTerm) -> bool:
    """Whether a term tells of the bench, not of the leg."""
    return term.cause in BENCH_CAUSES or term.shape in BENCH_SHAPES


def of_leg(terms: Iterable[LegTerm]) -> tuple[LegTerm, ...]:
    """Return the terms that a leg carries elsewhere, without those of the bench.

    From which side the bench's runs began says nothing of other runs.
    """
    return tuple(
        replace(term, parameters={name: value for name, value in term.parameters.items() if name != "approach"})
        for term in terms
        if not of_bench(term)
    )


def stateless(term: LegTerm) -> bool:
    """Whether a term follows from the displacement and temperatures of one row alone."""
    return term.shape in STATELESS


def sensors_of(terms: Sequence[LegTerm]) -> tuple[str, ...]:
    """Return the sensors that terms read, each once; where weights stand for one's temperature, those alone."""
    own = [str(term.parameters["sensor"]) for term in terms if "sensor" in term.parameters and not _told(term)]
    return tuple(dict.fromkeys([*own, *(name for term in terms for name in term.parameters.get("weights", ()))]))


def _told(term: LegTerm) -> bool:
    """Whether a term takes what sensors tell by weights for a temperature."""
    return term.shape in WEIGHED and "weights" in term.parameters


class LegMemory:
    """What a law remembers of the rows before: a memory for each of its terms, and that of the repairs.

    A new one belongs to the beginning of a run.

    Parameters
    ----------
    terms : sequence of LegTerm
    """

    def __init__(self, terms: Sequence[LegTerm] = ()) -> None:
        self.terms = tuple(Memory() for _term in terms)
        self.repairs = RepairMemory()

    def copy(self) -> LegMemory:
        """Return a memory that goes its own way from here."""
        other = LegMemory()
        other.terms = tuple(memory.copy() for memory in self.terms)
        other.repairs = self.repairs.copy()
        return other

    def count_from_retracted(self, terms: Sequence[LegTerm], signals: LegSignals) -> None:
        """Let terms that count from the first displacement count from the retracted leg."""
        if not any(term.shape in OWN_ZERO for term in terms):
            return
        start = replace(signals, time=signals.time[:1], q=np.zeros(1), dT={s: np.zeros(1) for s in signals.dT})
        for term, memory in zip(terms, self.terms, strict=True):
            if term.shape in OWN_ZERO:
                term.columns(start, memory)


def terms_columns(terms: Sequence[LegTerm], signals: LegSignals, memory: LegMemory | None = None) -> FloatArray:
    """Return what the amplitudes of all terms multiply, shape (n, k)."""
    memory = LegMemory(terms) if memory is None else memory
    parts = [term.columns(signals, own) for term, own in zip(terms, memory.terms, strict=True)]
    return np.concatenate([np.zeros((len(signals), 0)), *parts], axis=1)


def terms_drift(terms: Sequence[LegTerm], signals: LegSignals, memory: LegMemory | None = None) -> FloatArray:
    """Return what all terms add to the drift, shape (n,) [m]."""
    memory = LegMemory(terms) if memory is None else memory
    parts = [term.drift(signals, own) for term, own in zip(terms, memory.terms, strict=True)]
    return np.asarray(sum(parts, np.zeros(len(signals))))


Drift = Callable[[LegSignals, LegMemory], FloatArray]
"""From rows and the memory of the rows before to the drift [m]."""


class LegController:
    """A leg's law, given one row after the other: what a controller runs.

    The same rows all at once give the same drift. A row that is refused leaves no trace.

    Parameters
    ----------
    drift : callable
        From signals and a `LegMemory` to the drift.
    sensors : sequence of str
        That are read.
    terms, repairs : sequences of LegTerm and SensorRepair
    retracted_length : float [m]
    stroked : bool
        Whether the law itself reads the displacement.
    reference_degC : mapping of str to float, or float, optional
        Temperatures that the law counts from; without it those of the first row.
    """

    def __init__(
        self, drift: Drift, sensors: Sequence[str], terms: Sequence[LegTerm], repairs: Sequence[SensorRepair],
        retracted_length: float, stroked: bool, reference_degC: Mapping[str, float] | float | None = None,
    ) -> None:  # fmt: skip
        for repair in repairs:
            if not repair.causal:
                raise ArgumentError(
                    f"{repair.cause}: the temperatures' clock {ahead_of(repair)}, so that "
                    "a controller would need temperatures that come later; set the logger's clock and remove the repair"
                )
        self.sensors, self.retracted_length = tuple(sensors), float(retracted_length)
        self._reads_q = stroked or any(term.shape in OF_PLACE for term in terms)
        self._law, self._memory = drift, LegMemory(terms)
        self._reference: dict[str, float] | None = None
        if isinstance(reference_degC, Mapping):
            self._reference = self._checked(reference_degC)
        elif reference_degC is not None:
            self._reference = dict.fromkeys(self.sensors, float(reference_degC))
        self._zero: LegSignals | None = None
        self._last: LegSignals | None = None
        self._drift = 0.0

    @property
    def drift(self) -> float:
        """Drift of the last row [m]."""
        return self._drift

    def update(
        self, time: float, temperatures: Mapping[str, float], q: float | None = None, *, air: float | None = None,
        index: float | None = None, tilt: Sequence[float] | None = None, inputs: Mapping[str, float] | None = None,
        pressure_index: float | None = None,
    ) -> float:  # fmt: skip
        """Take the next row and return its drift [m].

        Parameters
        ----------
        time : float [s]
            From any origin, never decreasing.
        temperatures : mapping of str to float [degC]
            Of `sensors`; others are passed over.
        q : float [m]
            Displacement of the rod or of the part; may be left out where neither the law nor its terms read it.
        air : float, optional [degC]
        index : float, optional
            Index of refraction of the air.
        tilt : two floats, optional [rad]
        inputs : mapping of str to float, optional
            Recorded inputs in their own units.
        pressure_index : float, optional
            Index of refraction at this pressure, were the air as warm and as humid as in the first row.

        Raises
        ------
        ArgumentError
            A value is missing or no number, or time runs backwards.
        """
        if q is None and self._reads_q:
            raise ArgumentError("this law needs the displacement q [m] in every row; a part without a stroke has q=0.0")
        row = self._row(time, temperatures, 0.0 if q is None else q, air, index, tilt, inputs, pressure_index)
        memory = self._memory.copy()
        found = float(self._law(row, memory)[0])
        if self._zero is None:
            self._keep_zero(time, temperatures, air, index, tilt, pressure_index)
        self._memory, self._last, self._drift = memory, row, found
        return found

    def corrected_length(
        self, commanded: float, time: float | None = None, temperatures: Mapping[str, float] | None = None, *,
        air: float | None = None, index: float | None = None, tilt: Sequence[float] | None = None,
        inputs: Mapping[str, float] | None = None, pressure_index: float | None = None,
    ) -> float:  # fmt: skip
        """Return the length to command so that the leg is truly `commanded` long: ``c + drift(c) = commanded`` [m].

        Without time and temperatures it is that of the last row; with them that of a row to come, which `update` is
        then given with the displacement that was reached. Nothing is remembered of it.

        Raises
        ------
        ArgumentError
            There is no row yet, or no length solves the equation.
        """
        if time is None or temperatures is None:
            if self._last is None:
                raise ArgumentError("the controller has no row yet: call update first, or give time and temperatures")
            row = self._last
        else:
            row = self._row(time, temperatures, 0.0, air, index, tilt, inputs, pressure_index)

        def drift(length: float) -> float:
            there = replace(row, q=np.array([length - self.retracted_length]))
            return float(self._law(there, self._memory.copy())[0])

        return solved_length(commanded, drift)

    def _row(
        self, time: float, temperatures: Mapping[str, float], q: float, air: float | None, index: float | None,
        tilt: Sequence[float] | None, inputs: Mapping[str, float] | None, pressure_index: float | None,
    ) -> LegSignals:  # fmt: skip
        """Return one row as signals that count from the zero."""
        degC, zero = self._checked(temperatures), self._zero
        start = time if zero is None else zero.time[0]
        last = 0.0 if self._last is None else self._last.time[0]
        if not np.isfinite(time) or not np.isfinite(q) or time - start < last:
            raise ArgumentError(f"a row needs finite time and q, and time never decreases; found {time:g} s, {q:g} m")
        reference = degC if zero is None else {name: float(value[0]) for name, value in zero.dT.items()}
        reference = reference if self._reference is None else self._reference

        def since(name: str, value: float | Sequence[float] | None) -> FloatArray | None:
            if value is None:
                return None
            first = None if zero is None else getattr(zero, name)
            now = np.asarray([value], dtype=np.float64)
            return now - (now if first is None else first)

        values = {name: np.array([float(value)]) for name, value in (inputs or {}).items()}
        return LegSignals(
            np.array([time - start]), {name: np.array([degC[name] - reference[name]]) for name in self.sensors},
            np.array([float(q)]), self.retracted_length, since("air", air), since("index", index), since("tilt", tilt),
            values, {name: reference[name] for name in self.sensors},
            index if zero is None or zero.index is None else float(zero.index[0]),
            since("pressure_index", pressure_index),
        )  # fmt: skip

    def _keep_zero(
        self, time: float, temperatures: Mapping[str, float], air: float | None, index: float | None,
        tilt: Sequence[float] | None, pressure_index: float | None,
    ) -> None:  # fmt: skip
        """Keep the first row, which later ones count from."""
        degC = {name: np.array([value]) for name, value in self._checked(temperatures).items()}
        first_air, first_index, first_tilt, first_pressure = (
            None if value is None else np.asarray([value], dtype=np.float64)
            for value in (air, index, tilt, pressure_index)
        )
        self._zero = LegSignals(
            np.array([float(time)]), degC, np.zeros(1), self.retracted_length, first_air, first_index, first_tilt,
            pressure_index=first_pressure,
        )  # fmt: skip

    def _checked(self, temperatures: Mapping[str, float]) -> dict[str, float]:
        """Return the temperatures of the sensors that are read."""
        for name in self.sensors:
            if name not in temperatures:
                raise ArgumentError(
                    f"temperature of sensor {name} is missing; needed: {', '.join(self.sensors)}; given: "
                    f"{', '.join(map(str, temperatures)) or 'none'}"
                )
            if not np.isfinite(temperatures[name]):
                raise ArgumentError(f"temperature of sensor {name} is {temperatures[name]}: no reading")
        return {name: float(temperatures[name]) for name in self.sensors}


def solved_length(wanted: float, drift: Callable[[float], float]) -> float:
    """Return the length c with ``c + drift(c) = wanted``, where the drift varies little with the length.

    Where the drift jumps (a reversal within the scale's noise) and no length solves the equation, the nearest one met.

    Examples
    --------
    >>> round(solved_length(1.0, lambda length: 1e-5 * length), 12)
    0.9999900001
    """
    length, best, least = float(wanted), float(wanted), np.inf
    for _step in range(MOST_STEPS):
        wrong = wanted - (length + drift(length))
        if abs(wrong) < least:
            best, least = length, abs(wrong)
        if abs(wrong) <= LENGTH_STEP:
            break
        length = length + wrong
    if not least <= LARGEST_JUMP:
        raise ArgumentError(f"no length solves c + drift(c) = {wanted:g} m: the drift is no small part of the length")
    return best
