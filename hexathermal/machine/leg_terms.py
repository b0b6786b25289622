"""Terms that extend the law of a leg: their shapes, the only place where these equations stand.

The base law is ``drift = sum_s A_s q0 dT_s + B_s q dT_s``. A term adds ``sum_k a_k shape_k``: its shape is made of the
leg's signals by a function of this module, its amplitudes ``a_k`` are identified. Shapes with a state (lag, stored
heat, creep, direction) are causal: they know no row that has not come yet, so that a controller can run them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from hexathermal.errors import ArgumentError, UnknownNameError
from hexathermal.machine.leg_signals import WHOLE_ROW, LegSignals, Memory, listed
from hexathermal.machine.thermal import frozen, refreeze
from hexathermal.poses import FloatArray

Shape = Callable[[LegSignals, Mapping[str, Any], Memory], FloatArray]
"""From signals, parameters and the memory of the rows before to columns, shape (n, k)."""

PRESSURE, WARMTH = "pressure", "temperature"
WEATHERS = (PRESSURE, WARMTH)
"""Of the weather, what alone an ``air-index`` may have left out."""

INDEX_PER_K = -9.5e-7
"""Change of the index of air with its temperature at 20 degC, 1013.25 hPa and 50 % humidity [1/K] (Ciddor, Applied
Optics 35 (1996) 1566); 3 % more at 15, 2 % less at 25 degC."""


@dataclass(frozen=True, eq=False)
class LegTerm:
    """A term of a leg's law.

    Parameters
    ----------
    cause : str
        Name of the catalogue, as ``"thermal-lag"``.
    shape : str
        One of `SHAPES`.
    parameters : mapping
        Of the shape: names of sensors and inputs, time constants [s], lengths [m].
    amplitudes : array, shape (k,)
        In metres for a unit of each column.
    covariance : array, shape (k, k)
    """

    cause: str
    shape: str
    parameters: Mapping[str, Any]
    amplitudes: FloatArray
    covariance: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))

    def __post_init__(self) -> None:
        shape_named(self.shape)
        amplitudes = np.atleast_1d(np.asarray(self.amplitudes, dtype=np.float64))
        covariance = np.asarray(self.covariance, dtype=np.float64)
        k = len(amplitudes)
        covariance = covariance if covariance.size else np.zeros((k, k))
        if covariance.shape != (k, k):
            raise ArgumentError(f"term {self.cause!r}: covariance has shape {covariance.shape}, expected ({k}, {k})")
        object.__setattr__(self, "parameters", {key: listed(value) for key, value in self.parameters.items()})
        object.__setattr__(self, "amplitudes", frozen(amplitudes))
        object.__setattr__(self, "covariance", frozen(covariance))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, LegTerm):
            return NotImplemented
        return (
            (self.cause, self.shape, self.parameters) == (other.cause, other.shape, other.parameters)
            and np.array_equal(self.amplitudes, other.amplitudes)
            and np.array_equal(self.covariance, other.covariance)
        )

    __hash__ = None  # type: ignore[assignment]

    def __setstate__(self, state: dict[str, Any]) -> None:
        refreeze(self, state)

    def reading(self, other: Mapping[str, str]) -> LegTerm:
        """Return the term that reads other sensors, by the names of those that it reads now; the rest stay."""
        own = dict(self.parameters)
        if "sensor" in own:
            own["sensor"] = other.get(own["sensor"], own["sensor"])
        if "weights" in own:
            own["weights"] = {other.get(name, name): weight for name, weight in own["weights"].items()}
        return replace(self, parameters=own)

    def columns(self, signals: LegSignals, memory: Memory | None = None) -> FloatArray:
        """Return what the amplitudes multiply, shape (n, k)."""
        return term_columns(self.shape, signals, self.parameters, memory)

    def drift(self, signals: LegSignals, memory: Memory | None = None) -> FloatArray:
        """Return what the term adds to the drift, shape (n,) [m].

        Parameters
        ----------
        signals : LegSignals
        memory : Memory, optional
            Of the rows before; a new one where the rows begin a run.
        """
        return np.asarray(self.columns(signals, memory) @ self.amplitudes)


def term_columns(
    shape: str, signals: LegSignals, parameters: Mapping[str, Any], memory: Memory | None = None
) -> FloatArray:
    """Return the columns of a shape, shape (n, k)."""
    columns = shape_named(shape)(signals, parameters, Memory() if memory is None else memory)
    return columns if columns.ndim == 2 else columns[:, None]


def shape_named(name: str) -> Shape:
    """Return a shape by its name."""
    if name not in SHAPES:
        raise UnknownNameError(f"no shape {name!r}; there are: {', '.join(SHAPES)}", tuple(SHAPES))
    return SHAPES[name]


MOTION, BY_MOTION = "motion", "lead-by-motion"
"""The source of heat that no input records, and the shape that reads a thermometer and changes with it alone."""

WEIGHED = ("temperature", "square")
"""Shapes that may take, by ``weights``, what several sensors tell for what one does."""


def _weights(parameters: Mapping[str, Any]) -> Mapping[str, float]:
    """Return the weights of the sensors that a shape of `WEIGHED` reads."""
    weights: Mapping[str, float] = parameters.get("weights", {parameters["sensor"]: 1.0})
    return weights


def _equal_stages(parameters: Mapping[str, Any]) -> tuple[float, ...]:
    """Return the time constants of ``order`` equal low passes that have ``time_constant_s`` together [s]."""
    order = int(parameters.get("order", 1))
    return (parameters["time_constant_s"] / order,) * order


def lag(signals: LegSignals, parameters: Mapping[str, Any], memory: Memory) -> FloatArray:
    """Return ``(q0 + ratio q) (low_pass(dT) - dT)``: what follows a thermometer late (early, where negative) [m K].

    With ``order`` 2 the low pass is two equal stages of half the time constant each.
    """
    dT = signals.temperature(parameters["sensor"])
    behind = memory.stages(signals.time, dT, _equal_stages(parameters))
    return signals.span(parameters["ratio"]) * (behind - dT)


def lead(signals: LegSignals, parameters: Mapping[str, Any], memory: Memory) -> FloatArray:
    """Return ``(q0 + ratio q)`` times ``dT - low_pass(dT)`` and ``dT - low_pass(low_pass(dT))``, shape (n, 2) [m K].

    First and second rate of the temperature, as far as past rows tell them: what a thermometer shows late.
    """
    dT, tau = signals.temperature(parameters["sensor"]), parameters["time_constant_s"]
    once = memory.low_pass("once", signals.time, dT, tau)
    twice = memory.low_pass("twice", signals.time, once, tau)
    return np.stack([dT - once, dT - twice], axis=1) * signals.span(parameters["ratio"])[:, None]


SLOWLY_S = 600.0
"""The rate of what motion does not explain is that behind a low pass of so long."""


def lead_by_motion(signals: LegSignals, parameters: Mapping[str, Any], memory: Memory) -> FloatArray:
    """Return ``(q0 + ratio q) tau dT/dt``, the rate as motion explains it: what a noisy thermometer shows late [m K].

    Of heat of motion ``sum_k once_k lp_k(v) + twice_k lp_k(lp_k(v))``, v the speed, lp_k low passes of
    ``heat_times_s``, the rate is known without noise; of what is left, that of two low passes of `SLOWLY_S`.
    """
    heats, rates = memory.heats(signals.time, signals.q, parameters["heat_times_s"])
    weights = np.stack([parameters["once"], parameters["twice"]], axis=1).ravel()
    left = signals.temperature(parameters["sensor"]) - heats @ weights
    once = memory.low_pass("left once", signals.time, left, SLOWLY_S)
    slow = (once - memory.low_pass("left twice", signals.time, once, SLOWLY_S)) / SLOWLY_S
    rate = rates @ weights + slow
    return np.asarray(signals.span(parameters["ratio"]) * parameters["time_constant_s"] * rate)


def foretold(signals: LegSignals, parameters: Mapping[str, Any], memory: Memory) -> FloatArray:
    """Return ``(q0 + ratio q) sum_s w_s (dT_s - low_pass(dT_s))``: what a late thermometer lacks, as others tell [m K].

    ``weights`` holds w by the other sensors' names; with ``order`` 2 the low pass is two equal stages.
    """
    now = signals.weighted(parameters["weights"])
    behind = memory.stages(signals.time, now, _equal_stages(parameters))
    return np.asarray(signals.span(parameters["ratio"]) * (now - behind))


def temperature(signals: LegSignals, parameters: Mapping[str, Any], memory: Memory) -> FloatArray:
    """Return ``(q0 + ratio q) dT`` of another sensor [m K].

    With ``weights``, of sensors by name, dT is ``sum_s w_s dT_s``: what it should read, as it and the others tell.
    """
    return np.asarray(signals.span(parameters["ratio"]) * signals.weighted(_weights(parameters)))


def expansion(signals: LegSignals, parameters: Mapping[str, Any], memory: Memory) -> FloatArray:
    """Return ``q0 dT`` and ``q dT`` of another sensor, shape (n, 2) [m K]: its own pair of the paper's eq. (4)."""
    dT = signals.temperature(parameters["sensor"])
    return np.stack([signals.retracted_length * dT, signals.q * dT], axis=1)


def stored_heat(signals: LegSignals, parameters: Mapping[str, Any], memory: Memory) -> FloatArray:
    """Return heat of motion, or of a recorded input, behind a low pass, ``low_pass(|u|^power)``; ``|0|^0`` is 0.

    ``source`` is ``"motion"`` (u: speed in m/s, the mean since the row before) or an input's name. With
    ``source_time_constant_s`` it is behind another low pass before: what is rubbed warms first, then what expands;
    ``source_share`` of it is that of what is rubbed itself. Rows may be as far apart as they like where the power is 1;
    the square of a mean speed is less than the mean of squares, the more of a row the rod rests, and power 0, heat as
    long as anything moves, takes a row for all of its time: such a law wants rows as it was identified with.
    """
    source = parameters["source"]
    u = memory.speed(signals.time, signals.q) if source == MOTION else np.abs(signals.recorded(source))
    heat = np.sign(u) * u ** parameters.get("power", 1)
    return _heat_left(signals, heat, parameters, memory)


def _heat_left(signals: LegSignals, heat: FloatArray, parameters: Mapping[str, Any], memory: Memory) -> FloatArray:
    """Return heat behind a low pass, less its first value, times the length it acts on where that is stated."""
    tau, before = parameters["time_constant_s"], parameters.get("source_time_constant_s", 0.0)
    mean = parameters["source"] == MOTION
    given = memory.low_pass("source", signals.time, heat, before, held=mean) if before > 0.0 else heat
    stored = memory.low_pass("heat", signals.time, given, tau, held=mean and before <= 0.0) if tau > 0.0 else given
    own = parameters.get("source_share", 0.0)
    stored = (1.0 - own) * stored + own * given if own > 0.0 else stored
    left = stored - memory.first("heat at first", stored)
    return np.asarray(left * signals.span(parameters["ratio"]) if "ratio" in parameters else left)


def square(signals: LegSignals, parameters: Mapping[str, Any], memory: Memory) -> FloatArray:
    """Return ``(q0 + ratio q) (u^2 - u0^2)``, u the temperature from ``reference_degC``, u0 that of the zero [m K^2].

    Without a reference it is the zero itself: ``(q0 + ratio q) dT^2``. With ``weights``, of sensors by name, it is the
    sum of their squares so weighted: a part whose places are unlike bends most where it is hottest. See `_calibrated`
    for ``calibration_degC``.
    """
    reference, calibration = parameters.get("reference_degC"), parameters.get("calibration_degC")
    total, strain = np.zeros(len(signals)), 0.0
    for name, weight in _weights(parameters).items():
        dT = signals.temperature(name)
        u0 = 0.0 if reference is None else signals.zero_of(name) - reference
        total = total + weight * dT * (dT + 2.0 * u0)
        if calibration is not None:
            strain += weight * (u0**2 - (calibration - signals.zero_of(name) + u0) ** 2)
    found = signals.span(parameters["ratio"]) * total
    return np.asarray(found if calibration is None else found + _calibrated(signals, parameters, memory, strain))


def cube(signals: LegSignals, parameters: Mapping[str, Any], memory: Memory) -> FloatArray:
    """Return ``(q0 + ratio q) dT^3``: expansion whose slope changes alike above and below the zero [m K^3]."""
    rise = signals.temperature(parameters["sensor"])
    return np.asarray(signals.span(parameters["ratio"]) * (rise * rise * rise))  # a power is not odd to the last bit


def bend(signals: LegSignals, parameters: Mapping[str, Any], memory: Memory) -> FloatArray:
    """Return ``2 w^2 (q0 + ratio q) (ln cosh(u / w) - ln cosh(u0 / w))``: a square near its middle, straight far off.

    u is the temperature from ``middle_degC``, u0 that of the zero, w ``width_K``; its unit is m K^2. See `_calibrated`
    for ``calibration_degC``.
    """
    width, middle = parameters["width_K"], parameters["middle_degC"]
    u0 = signals.zero_of(parameters["sensor"]) - middle
    x = np.append(signals.temperature(parameters["sensor"]) + u0, [parameters.get("calibration_degC", middle) - middle,
                                                                 u0]) / width  # fmt: skip
    curve = 2.0 * width**2 * np.logaddexp(x, -x)
    found = signals.span(parameters["ratio"]) * (curve[:-2] - curve[-1])
    if "calibration_degC" not in parameters:
        return np.asarray(found)
    return np.asarray(found + _calibrated(signals, parameters, memory, float(curve[-1] - curve[-2])))


def _calibrated(signals: LegSignals, parameters: Mapping[str, Any], memory: Memory, strain: float) -> FloatArray:
    """Return ``ratio (q - q_0) strain``: a stroke right at ``calibration_degC`` is wrong already at the zero."""
    return np.asarray(parameters["ratio"] * (signals.q - memory.first("q", signals.q)) * strain)


def room(signals: LegSignals, parameters: Mapping[str, Any], memory: Memory) -> FloatArray:
    """Return the temperature of the air, or of a sensor in it, behind a low pass, less its first value [K].

    With ``order`` 2 the low pass is two equal stages of half the time constant each.
    """
    air = signals.air_read(parameters.get("sensor"))
    behind = memory.stages(signals.time, air, _equal_stages(parameters)) if parameters["time_constant_s"] > 0.0 else air
    return np.asarray(behind - memory.first("air at first", behind))


def air_index(signals: LegSignals, parameters: Mapping[str, Any], memory: Memory) -> FloatArray:
    """Return ``(path + stroke_share q) (n - n_0)``: how an index that was not applied shortens what is read [m].

    With ``reference_index`` the laser took that index for the air's, so that its scale is wrong already at the zero:
    ``+ stroke_share (q - q_0) (n_0 - reference_index)``. With ``weather = "pressure"`` that alone was not applied: n is
    that of air as warm and as humid as at the zero; with ``"temperature"`` its temperature alone, by
    `INDEX_PER_K`. With ``time_constant_s`` the air along the beams follows
    that at the station behind a low pass: a tube, an enclosure.
    """
    share = parameters["stroke_share"]
    weather = parameters.get("weather", PRESSURE)
    if weather not in WEATHERS:
        known = " or ".join(map(repr, WEATHERS))
        raise ArgumentError(f"weather of 'air-index' is {known} or left out, found {weather!r}")
    if "weather" not in parameters:
        change = signals.recorded("index")
    else:
        change = INDEX_PER_K * signals.recorded("air") if weather == WARMTH else signals.recorded("pressure_index")
    if parameters.get("time_constant_s", 0.0) > 0.0:
        change = memory.low_pass("air", signals.time, change, parameters["time_constant_s"])
    found = (parameters["path_m"] + share * signals.q) * change
    if "reference_index" in parameters:
        if signals.zero_index is None:
            raise ArgumentError("the law needs the index of refraction of the air at the zero, which is not given")
        moved = signals.q - memory.first("q", signals.q)
        found = found + share * moved * (signals.zero_index - parameters["reference_index"])
    return np.asarray(found)


def tilt(signals: LegSignals, parameters: Mapping[str, Any], memory: Memory) -> FloatArray:
    """Return the tilts about x and y, from the beams' differences [rad]."""
    return signals.recorded("tilt")


def direction(signals: LegSignals, parameters: Mapping[str, Any], memory: Memory) -> FloatArray:
    """Return half the direction of the last move: the amplitude is the whole step at a reversal [1].

    With ``play_m`` the step is not at once: a reversal takes that way of the rod until it is whole. ``approach`` is the
    direction from which the first position was reached, -1 to 1, where it is known; the column counts from there.
    """
    before = 0.5 * float(parameters.get("approach", 0.0))
    if "play_m" in parameters:
        return memory.play(signals.q, parameters["play_m"], before) - before
    return np.asarray(0.5 * memory.direction(signals.q, 2.0 * before) - before)


def periodic(signals: LegSignals, parameters: Mapping[str, Any], memory: Memory) -> FloatArray:
    """Return sine and cosine of ``2 pi q / pitch``, less their first values [1]."""
    phase = 2.0 * np.pi * signals.q / parameters["pitch_m"]
    waves = np.stack([np.sin(phase), np.cos(phase)], axis=1)
    return np.asarray(waves - memory.first("waves", waves))


def wave(signals: LegSignals, parameters: Mapping[str, Any], memory: Memory) -> FloatArray:
    """Return ``cos(2 pi (q - origin) / pitch)`` less its first value [1]: a wave of which one phase is known."""
    found = np.cos(2.0 * np.pi * (signals.q - parameters["origin_m"]) / parameters["pitch_m"])
    return np.asarray(found - memory.first("wave", found))


def position(signals: LegSignals, parameters: Mapping[str, Any], memory: Memory) -> FloatArray:
    """Return the displacement less its first value [m]."""
    return np.asarray(signals.q - memory.first("q", signals.q))


PER_DECADE = 2
"""Exponentials that stand for a decade of a broad relaxation."""


def relaxation(signals: LegSignals, parameters: Mapping[str, Any], memory: Memory) -> FloatArray:
    """Return what decays after each move [1].

    ``kick`` is ``"direction"`` (one for each move, signed), ``"move"`` (one for each move) or ``"step"`` (the length
    of the move, signed, in units of 10 mm). Rows in which the rod moves one way without a rest are one move. With
    ``saturation_m`` a move shorter than this kicks less, ``1 - exp(-length / saturation)`` of it. With ``decades``
    above 0 it is the mean of exponentials evenly in log time from the time constant on over so many decades: creep
    that goes with the logarithm of time. Where it is ``renewed`` (1), a move wipes out what earlier ones left, as
    sliding does, so that after each the same relaxes; lengths of moves do not matter then but for the saturation.
    ``"begin"`` is one kick, at the beginning of the run: the column counts from there.
    """
    tau, decades = parameters["time_constant_s"], parameters.get("decades", 0.0)
    times = tau * np.logspace(0.0, decades, 1 + round(PER_DECADE * decades))
    if parameters["kick"] == "begin":
        since = signals.time - memory.first("begin", signals.time)
        return np.asarray(np.mean([np.expm1(-since / one) for one in times], axis=0))
    lengths = memory.lengths(signals.q)
    way = np.sign(lengths)
    if parameters.get("renewed", 0.0):
        whole = np.abs(way) if parameters["kick"] == "move" else way
        slid = parameters.get("saturation_m", WHOLE_ROW)
        return np.asarray(np.mean([memory.renewing(signals.time, whole, lengths, one, slid, f"{k}")
                                   for k, one in enumerate(times)], axis=0))  # fmt: skip
    sizes = {"direction": way, "move": np.abs(way), "step": lengths / 0.01}[parameters["kick"]]
    if "saturation_m" in parameters:
        sizes = sizes * -np.expm1(-np.abs(lengths) / parameters["saturation_m"])
    return np.asarray(
        np.mean([memory.relaxing(signals.time, sizes, lengths, one, f"{k}") for k, one in enumerate(times)], axis=0)
    )


def time(signals: LegSignals, parameters: Mapping[str, Any], memory: Memory) -> FloatArray:
    """Return the time since the run's zero [h]."""
    return signals.time / 3600.0


SHAPES: dict[str, Shape] = {
    "lag": lag, "lead": lead, BY_MOTION: lead_by_motion, "foretold": foretold, "temperature": temperature,
    "expansion": expansion,
    "stored-heat": stored_heat, "square": square, "cube": cube, "bend": bend, "room": room,
    "air-index": air_index, "tilt": tilt, "direction": direction, "periodic": periodic, "wave": wave,
    "position": position, "relaxation": relaxation, "time": time,
}  # fmt: skip
"""Shapes of terms by name."""
