"""Signals of several runs: what a shape is in all of their rows, made at once wherever runs record the same."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from hexathermal.machine.leg_signals import LegSignals, Memory
from hexathermal.machine.leg_terms import term_columns
from hexathermal.poses import FloatArray

OF_ZERO = frozenset({"reference_degC", "middle_degC", "calibration_degC", "reference_index"})
"""Parameters of shapes that ask what the zero itself was: each run has its own."""


@dataclass(frozen=True, eq=False)
class RunAfterRun:
    """Signals of several runs, one behind the other.

    Attributes
    ----------
    runs : tuple of LegSignals
    goes_on : tuple of bool
        Whether each run follows the one before on the campaign's clock: then what a shape remembers goes on.
    """

    runs: tuple[LegSignals, ...]
    goes_on: tuple[bool, ...]

    def memories(self) -> Iterator[Memory]:
        """Give what a shape remembers in each run: a new memory, or that of the run before where it goes on."""
        memory = Memory()
        for goes_on in self.goes_on:
            memory = memory if goes_on else Memory()
            yield memory

    def behind(self, values: Sequence[FloatArray], time_constants: tuple[float, ...]) -> list[FloatArray]:
        """Return values in all rows of each run, shape (n, k), behind low passes [s], one behind the other."""
        runs = zip(self.runs, self.memories(), values, strict=True)
        return [memory.stages(signals.time, own, time_constants) for signals, memory, own in runs]

    def columns(self, shape: str, parameters: Mapping[str, Any]) -> FloatArray:
        """Return a shape's columns in all rows, run after run, shape (n, k)."""
        if self._joined is not None and not OF_ZERO & parameters.keys():
            found = term_columns(shape, self._joined, parameters, Memory(self._begins))
            if not np.isnan(found).any():  # a value that one run misses would spread to the next ones
                return found
        runs = zip(self.runs, self.memories(), strict=True)
        return np.concatenate([term_columns(shape, signals, parameters, memory) for signals, memory in runs])

    @cached_property
    def firsts(self) -> list[int]:
        """The first row of each run."""
        return [0, *np.cumsum([len(signals) for signals in self.runs[:-1]]).tolist()]

    @cached_property
    def _begins(self) -> list[int]:
        """First rows of the runs, after the first one, that begin with a new memory."""
        return [row for row, goes_on in zip(self.firsts, self.goes_on, strict=True) if row and not goes_on]

    @cached_property
    def _joined(self) -> LegSignals | None:
        """All rows as those of one run, but for the zero itself; None where runs do not record the same."""
        first = self.runs[0]
        alike = all(
            one.retracted_length == first.retracted_length and one.dT.keys() == first.dT.keys()
            and one.inputs.keys() == first.inputs.keys() for one in self.runs
        )  # fmt: skip
        if not alike:
            return None
        air, index, tilt, pressure_index = (
            _all([getattr(one, name) for one in self.runs]) for name in ("air", "index", "tilt", "pressure_index")
        )
        return LegSignals(
            np.concatenate([one.time for one in self.runs]),
            {name: np.concatenate([one.dT[name] for one in self.runs]) for name in first.dT},
            np.concatenate([one.q for one in self.runs]),
            first.retracted_length, air, index, tilt,
            {name: np.concatenate([one.inputs[name] for one in self.runs]) for name in first.inputs},
            pressure_index=pressure_index,
        )  # fmt: skip


def _all(values: Sequence[FloatArray | None]) -> FloatArray | None:
    """Return the rows of all runs; None where one has none."""
    known = [own for own in values if own is not None]
    return np.concatenate(known) if len(known) == len(values) else None


def read_by(parameters: Mapping[str, Any]) -> frozenset[str]:
    """Return the thermometers that a shape with such parameters reads."""
    own = [parameters["sensor"]] if "sensor" in parameters else []
    return frozenset(own) | frozenset(parameters.get("weights", ()))
