"""What is wrong with the thermometers' data rather than with the leg, and how it is put right.

Kinds of repairs and their parameters:

``clock``: ``offset_s``, optionally ``gains_s_per_h``. The temperatures' clock runs ahead (positive) or behind, or gains
(loses) time besides since the time that rows count from: ``dT(t) := dT(t + offset + gains t)``, linear between rows;
where there is no such row, the first or the last one's. The zero moves with it: in the row in which all temperatures
are zero they stay so.
``swap``: ``first``, ``second``, optionally ``not_in`` (names of runs in which the plugs still sat right) or ``only_in``
(of the runs in which they did not; in all others they sit right). Two sensors exchange their names. Optionally
``zero_else``: names of runs whose zero was read with these plugs the other way round than the run itself, since all
runs count from one zero. What is written under a name is then ``dT + zero`` of another than it counts from:
``dT_1 := dT_2 + (zero_2 - zero_1)``.
``drift``: ``sensor``, ``rate_K_per_h``, optionally ``rates_K_per_h`` (by the name of runs with a rate of their own).
``dT := dT - rate t``.
``detached``: ``sensor``, ``weights`` (of other sensors), optionally ``from_s`` (by the name of each run concerned, the
time since its zero from which on it is detached; without it everywhere) and ``again_in`` (names of later runs in which
it sat on the part again). ``dT := sum_s w_s dT_s``.
``loose``: ``sensor``, ``share`` of the air in its reading (0 to below 1), optionally ``from_s`` and ``again_in`` as
above, ``air_above_K`` (by the name of a run in which it came loose after the zero: by how much the air was warmer
there than it) and ``air_sensor`` (one that hangs in the air, where no column tells it). ``T = (1 - share) T_part +
share T_air`` is undone: ``dT := dT + share / (1 - share) (dT - dT_air - air_above)``.

A controller has no rows of the future: it can run all of them but a clock that runs ahead or gains time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hexathermal.errors import ArgumentError, UnknownNameError
from hexathermal.machine.leg_signals import LegSignals
from hexathermal.poses import FloatArray

KINDS: dict[str, tuple[str, ...]] = {
    "clock": ("offset_s",), "swap": ("first", "second"), "drift": ("sensor", "rate_K_per_h"),
    "detached": ("sensor", "weights"), "loose": ("sensor", "share"),
}  # fmt: skip
"""Kinds of repairs and the parameters that each of them needs."""

LEAST_GAINS = -3600.0
"""What a clock that stands still gains in an hour [s]."""

OPTIONAL = {"clock": ("gains_s_per_h",), "swap": ("not_in", "only_in", "zero_else"), "drift": ("rates_K_per_h",),
            "detached": ("from_s", "again_in"),
            "loose": ("from_s", "again_in", "air_above_K", "air_sensor")}  # fmt: skip
"""What they may have besides, most of it of single runs, by their names."""


@dataclass(frozen=True)
class SensorRepair:
    """A repair of the thermometers' data.

    Parameters
    ----------
    cause : str
        Name of the catalogue, as ``"swapped-sensors"``.
    kind : str
        One of `KINDS`.
    parameters : mapping
        As the module's description tells for each kind.
    """

    cause: str
    kind: str
    parameters: Mapping[str, Any]

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise UnknownNameError(f"no repair {self.kind!r}; there are: {', '.join(KINDS)}", tuple(KINDS))
        given: dict[str, Any] = {
            key: dict(value) if isinstance(value, Mapping) else value for key, value in self.parameters.items()
        }
        known = {*KINDS[self.kind], *OPTIONAL[self.kind]}
        missing, strange = [key for key in KINDS[self.kind] if key not in given], sorted(set(given) - known)
        if missing or strange:
            wrong = f"lacks {', '.join(missing)}" if missing else f"does not know {', '.join(strange)}"
            raise ArgumentError(f"repair {self.kind!r} of {self.cause!r} {wrong}; it takes {', '.join(sorted(known))}")
        if self.kind == "detached" and (not given["weights"] or given["sensor"] in given["weights"]):
            raise ArgumentError(f"repair of {given['sensor']!r}: weights are those of other sensors, one or more")
        if self.kind == "loose" and not (isinstance(given["share"], float | int) and 0.0 <= given["share"] < 1.0):
            raise ArgumentError(f"repair of {given['sensor']!r}: share must be 0 to below 1, found {given['share']!r}")
        if self.kind == "loose" and given.get("air_sensor") == given["sensor"]:
            raise ArgumentError(f"repair of {given['sensor']!r}: air_sensor must be another sensor")
        if self.kind == "clock":
            _check_clock(given)
        for key in ("not_in", "only_in", "again_in", "zero_else"):
            if isinstance(given.get(key, ()), str):
                raise ArgumentError(f"repair {self.kind!r}: {key} holds names of runs, found one text")
            given |= {key: tuple(given[key])} if key in given else {}
        if "not_in" in given and "only_in" in given:
            raise ArgumentError(f"repair {self.kind!r} takes not_in or only_in, not both")
        if "again_in" in given and set(given["again_in"]) & set(given.get("from_s", given["again_in"])):
            raise ArgumentError(
                f"repair of {given['sensor']!r}: again_in names runs after those of from_s, others than these"
            )
        for key in ("from_s", "rates_K_per_h", "air_above_K"):
            if not isinstance(given.get(key, {}), dict):
                raise ArgumentError(f"repair {self.kind!r}: {key} is a table by the names of runs")
        object.__setattr__(self, "parameters", given)

    @property
    def sensors(self) -> tuple[str, ...]:
        """Sensors that are read; none for a clock, which concerns whichever there are."""
        p = self.parameters
        if self.kind == "detached":
            return (*(() if "from_s" not in p else (p["sensor"],)), *p["weights"])
        names = {"swap": ("first", "second"), "drift": ("sensor",), "loose": ("sensor", "air_sensor"), "clock": ()}
        return tuple(p[name] for name in names[self.kind] if name in p)

    @property
    def replaced(self) -> str | None:
        """A sensor whose own readings do not matter, in whatever run."""
        return self.parameters["sensor"] if self.kind == "detached" and "from_s" not in self.parameters else None

    @property
    def causal(self) -> bool:
        """Whether it needs no row that has not come yet."""
        return self.kind != "clock" or (self.parameters["offset_s"] <= 0.0 and self.gains <= 0.0)

    @property
    def gains(self) -> float:
        """Time that a clock gains in an hour [s/h]; 0 where it does not."""
        return float(self.parameters.get("gains_s_per_h", 0.0))


def _check_clock(given: Mapping[str, Any]) -> None:
    """Refuse a clock whose numbers are none, or that runs backwards."""
    for key in ("offset_s", "gains_s_per_h"):
        value = given.get(key, 0.0)
        if not isinstance(value, float | int | np.floating | np.integer) or not np.isfinite(value):
            raise ArgumentError(f"repair 'clock': {key} must be a finite number, found {value!r}")
    if given.get("gains_s_per_h", 0.0) <= LEAST_GAINS:
        raise ArgumentError(
            f"repair 'clock': gains_s_per_h must be above {LEAST_GAINS:g}, found {given['gains_s_per_h']:g}: a clock "
            "that loses an hour in each stands still"
        )


class RepairMemory:
    """What repairs remember from the rows before; a new one belongs to the beginning of a run."""

    def __init__(self) -> None:
        self.kept: dict[int, tuple[FloatArray, dict[str, FloatArray]]] = {}
        self.zeros: dict[int, dict[str, float]] = {}

    def copy(self) -> RepairMemory:
        """Return a memory that goes its own way from here."""
        other = RepairMemory()
        other.kept, other.zeros = dict(self.kept), dict(self.zeros)
        return other


def repaired(
    signals: LegSignals,
    repairs: Sequence[SensorRepair],
    run_name: str | None = None,
    memory: RepairMemory | None = None,
) -> LegSignals:
    """Return signals whose temperatures are put right, repair after repair.

    Parameters
    ----------
    signals : LegSignals
    repairs : sequence of SensorRepair
    run_name : str, optional
        For what is of certain runs; without it a sensor that detached in some run is taken as detached, unless it was
        fixed again, plugs that were exchanged in the end as exchanged, and a reading that drifts at the rate of the
        last run.
    memory : RepairMemory, optional
        Of the rows before, where rows come one by one or in blocks; without it the rows are a whole run.

    Raises
    ------
    ArgumentError
        A sensor is not there; or, with a memory, a repair needs rows that have not come yet.

    Examples
    --------
    >>> signals = LegSignals(np.array([0.0, 60.0]), {"a": np.array([0.0, 1.0]), "b": np.array([0.0, 3.0])}, np.zeros(2))
    >>> repaired(signals, [SensorRepair("swapped-sensors", "swap", {"first": "a", "second": "b"})]).dT["a"].tolist()
    [0.0, 3.0]
    """
    for number, repair in enumerate(repairs):
        if repair.kind == "clock":
            signals = replace(signals, dT=_clock(signals, repair, number, memory))
        elif repair.kind == "swap":
            signals = _replugged(signals, repair.parameters, run_name)
        else:
            read = signals if memory is not None else _air_of_zero_row(signals, repair, run_name)
            signals = replace(signals, dT={**signals.dT, **_AT_ONCE[repair.kind](read, repair.parameters, run_name)})
    return signals


def _replugged(signals: LegSignals, parameters: Mapping[str, Any], run: str | None) -> LegSignals:
    """Return signals in which two sensors have exchanged their names, in the rows, at the zero, or in both."""
    rows = run not in parameters.get("not_in", ()) and run in parameters.get("only_in", (run,))
    zero = rows != (run in parameters.get("zero_else", ()))
    if not rows and not zero:
        return signals
    found, first, second = dict(signals.dT), parameters["first"], parameters["second"]
    for name, other in ((first, second), (second, first)):
        read, counted = other if rows else name, other if zero else name
        found[name] = signals.temperature(read)
        if read != counted:
            found[name] = found[name] + (signals.zero_of(read) - signals.zero_of(counted))
    zeros = _swapped_zeros(signals.zero_degC, parameters) if zero else signals.zero_degC
    return replace(signals, dT=found, zero_degC=zeros)


def _swapped_zeros(zeros: Mapping[str, float], parameters: Mapping[str, Any]) -> dict[str, float]:
    """Return the temperatures of the zero with those of two sensors exchanged, as far as they are known."""
    other = {parameters["first"]: parameters["second"], parameters["second"]: parameters["first"]}
    return {other.get(name, name): value for name, value in zeros.items()}


def _without_drift(signals: LegSignals, parameters: Mapping[str, Any], run: str | None) -> dict[str, FloatArray]:
    """Return a sensor's temperature less its drift."""
    name = parameters["sensor"]
    rate = parameters.get("rates_K_per_h", {}).get(run, parameters["rate_K_per_h"])
    return {name: signals.temperature(name) - rate * signals.counted(signals.time) / 3600.0}


def _foretold(signals: LegSignals, parameters: Mapping[str, Any], run: str | None) -> dict[str, FloatArray]:
    """Return a detached sensor's temperature as the others foretell it."""
    return _from_then_on(signals, parameters, run, lambda: signals.weighted(parameters["weights"]))


def _without_air(signals: LegSignals, parameters: Mapping[str, Any], run: str | None) -> dict[str, FloatArray]:
    """Return the temperature of a sensor that reads the air in part, without it."""
    share, above = float(parameters["share"]), parameters.get("air_above_K", {}).get(run, 0.0)

    def alone() -> FloatArray:
        """Return the part's temperature less that of the zero."""
        own, air = signals.temperature(parameters["sensor"]), signals.air_read(parameters.get("air_sensor"))
        return np.asarray(own + share / (1.0 - share) * (own - air - above))

    return _from_then_on(signals, parameters, run, alone)


def _air_of_zero_row(signals: LegSignals, repair: SensorRepair, run: str | None) -> LegSignals:
    """Return a whole run whose air counts from the row from which temperatures do, where a loose sensor counts so.

    Rows before that one may not be usable, and the air goes on meanwhile.
    """
    if repair.kind != "loose" or signals.air is None or run in repair.parameters.get("air_above_K", {}):
        return signals
    row = zero_row(signals.dT)
    return signals if row is None else replace(signals, air=signals.air - signals.air[row])


def _from_then_on(
    signals: LegSignals, parameters: Mapping[str, Any], run: str | None, put_right: Callable[[], FloatArray]
) -> dict[str, FloatArray]:
    """Return a sensor's temperature, put right from the moment on that the parameters tell of this run."""
    name, starts = parameters["sensor"], parameters.get("from_s")
    if starts is None or (run is None and not parameters.get("again_in")):
        return {name: put_right()}
    late = signals.time >= starts[run] if run is not None and run in starts else np.zeros(len(signals), dtype=bool)
    return {name: np.where(late, put_right(), signals.temperature(name))} if late.any() else {}


_AT_ONCE: dict[str, Callable[[LegSignals, Mapping[str, Any], str | None], dict[str, FloatArray]]] = {
    "drift": _without_drift, "detached": _foretold, "loose": _without_air,
}  # fmt: skip


def zero_row(dT: Mapping[str, FloatArray]) -> int | None:
    """Return the first row in which all temperatures that have a value are zero; None where there is none.

    Examples
    --------
    >>> zero_row({"a": np.array([1.0, 0.0]), "b": np.array([0.0, np.nan])})
    1
    """
    if not dT:
        return None
    still = np.all([(values == 0.0) | np.isnan(values) for values in dT.values()], axis=0)
    return int(np.argmax(still)) if still.any() else None


def ahead_of(repair: SensorRepair) -> str:
    """Return in words how far a clock is ahead: ``"runs 30 s ahead"``."""
    offset, gains = float(repair.parameters["offset_s"]), repair.gains
    runs = [f"runs {offset:g} s ahead"] if offset > 0.0 else []
    return " and ".join(runs + ([f"gains {gains:g} s in an hour"] if gains > 0.0 else []))


def _clock(
    signals: LegSignals, repair: SensorRepair, number: int, memory: RepairMemory | None
) -> dict[str, FloatArray]:
    """Return all temperatures as they were `offset_s` later, and what the clock has gained."""
    offset = float(repair.parameters["offset_s"])
    read = signals.time + offset + repair.gains * signals.time / 3600.0
    if memory is not None and not repair.causal:
        raise ArgumentError(
            f"{repair.cause}: the temperatures' clock {ahead_of(repair)}, so that a row needs temperatures that "
            "come later: row by row that cannot be run; set the logger's clock, or take whole runs (predict_signals)"
        )
    time, known = signals.time, dict(signals.dT)
    if memory is not None and number in memory.kept:
        before, held = memory.kept[number]
        time = np.concatenate([before, time])
        known = {name: np.concatenate([held[name], values]) for name, values in known.items()}
    moved = {name: np.interp(read, time, values) for name, values in known.items()}
    zeros = None if memory is None else memory.zeros.get(number)
    if zeros is None:
        row = zero_row(signals.dT)
        zeros = {name: 0.0 if row is None else float(values[row]) for name, values in moved.items()}
    if memory is not None:
        memory.zeros[number] = zeros
        first = max(int(np.searchsorted(time, read[-1], side="right")) - 1, 0)
        memory.kept[number] = (time[first:].copy(), {name: values[first:].copy() for name, values in known.items()})
    return {name: values - zeros[name] for name, values in moved.items()}
