"""A working day's temperatures: room, legs and plates of a machine that works for a shift and then rests.

Every part is one lump of first order, ``tau dT/dt = T_around - T + rise``, stepped exactly for inputs that stay
constant within a step.  Numbers are named, each with its source: *derived* from a published measurement, or an
*engineering value* where nobody has published one.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray
from hexathermal.predict.temperatures import active_model

HOUR_S = 3600.0
NIGHT_H = 24.0
"""The machine stands idle this long before the day begins, so that its parts follow the room as they would."""


@dataclass(frozen=True)
class WorkingDay:
    """How the day goes.

    Attributes
    ----------
    step_s : float [s]
    start_h, shift_h, break_after_h, break_h, rest_h : float [h]
        Clock time of the first movement, length of the shift, when its break begins and how long it is, rest after it.
    room_above_K : float [K]
        Mean of the room above the machine's reference temperature.
    room_swing_K, room_coldest_h : float [K], [h]
        Half the room's daily swing, and the clock time when it is coldest. Engineering value: a workshop with
        heating, slower than 1 K/h.
    heat_W, heat_spread : float [W], [1]
        Mean heat of motor and friction in a moving leg, and how differently the legs are loaded. Derived: a drift of
        7.81 um at 600 mm + 250 mm (Robert et al.) asks for 5.3 K, which is 1 to 3 W.
    rise_K_per_W : float [K/W]
        Steady rise of a leg. Derived: 5.3 K at 2 W.
    leg_time_constant_s, leg_spread : float [s], [1]
        Derived: ``rho c A / (h P)`` of an 80/60 mm tube of Invar in still air, h = 8 W/m2K; legs differ a little.
    platform_time_constant_s, base_time_constant_s : float [s]
        Engineering value: plates are thicker than tubes.
    platform_share, base_share : float
        Part of the legs' warmth above the room that reaches the plate. Engineering value.
    sensor_noise_K, sensor_gain : float [K], [1]
        Standard deviations of a thermometer's noise and gain error. Engineering value (6 to 14 mK are seen on machine
        tools) and the 0.4 % of a class 1 thermocouple.
    law_uncertainty : float [1]
        Relative standard deviation of each true coefficient A and B about the law that the controller knows.
        Engineering value; 0 makes the law exact.
    """

    step_s: float = 60.0
    start_h: float = 8.0
    shift_h: float = 8.0
    break_after_h: float = 4.0
    break_h: float = 0.5
    rest_h: float = 4.0
    room_above_K: float = 0.0
    room_swing_K: float = 2.0
    room_coldest_h: float = 3.0
    heat_W: float = 2.0
    heat_spread: float = 0.15
    rise_K_per_W: float = 2.65
    leg_time_constant_s: float = 4560.0
    leg_spread: float = 0.05
    platform_time_constant_s: float = 7200.0
    base_time_constant_s: float = 14400.0
    platform_share: float = 0.3
    base_share: float = 0.15
    sensor_noise_K: float = 0.010
    sensor_gain: float = 0.004
    law_uncertainty: float = 0.03

    def __post_init__(self) -> None:
        signed = ("room_above_K", "start_h", "room_coldest_h")
        for item in fields(self):
            value = getattr(self, item.name)
            if not np.isfinite(value) or (value < 0.0 and item.name not in signed):
                raise ArgumentError(f"{item.name} must be a finite number >= 0, found {value!r}")
        for name in ("step_s", "shift_h", "leg_time_constant_s", "platform_time_constant_s", "base_time_constant_s"):
            if not getattr(self, name) > 0.0:
                raise ArgumentError(f"{name} must be above 0, found {getattr(self, name)!r}")
        if not self.leg_spread < 1.0 or not self.heat_spread < 1.0:
            raise ArgumentError("leg_spread and heat_spread are parts of the mean, below 1")
        if not self.law_uncertainty < 1.0:
            raise ArgumentError(f"law_uncertainty is a part of A and B, below 1, found {self.law_uncertainty!r}")


@dataclass(frozen=True, eq=False)
class DayTemperatures:
    """True temperatures of the parts, one row a step.

    Attributes
    ----------
    time : array, shape (n,) [s]
        From the first movement.
    working : array, shape (n,), bool
    room, platform, base : array, shape (n,) [degC]
    legs : array, shape (n, 6) [degC]
    """

    time: FloatArray
    working: npt.NDArray[np.bool_]
    room: FloatArray
    legs: FloatArray
    platform: FloatArray
    base: FloatArray


def reference_degC(hexapod: Hexapod) -> float:
    """Return the mean reference temperature of a machine's sensors [degC]."""
    return float(np.mean(active_model(hexapod).reference_temperature_degC))


def lagged(around: FloatArray, step_s: float, time_constant_s: npt.ArrayLike) -> FloatArray:
    """Return the temperature of lumps of first order.

    ``T[k+1] = T[k] + (1 - exp(-step/tau)) (around[k] - T[k])``, ``T[0] = around[0]``: exact where `around` stays
    constant within a step.

    Parameters
    ----------
    around : array, shape (n, ...) [degC]
        What the lumps approach: surroundings and rise.
    step_s : float [s]
    time_constant_s : float or array, shape (...) [s]

    Returns
    -------
    array, shape (n, ...) [degC]

    Examples
    --------
    >>> warm = lagged(np.array([20.0, 21.0, 21.0]), 60.0, 60.0)       # one time constant after the first step
    >>> bool(abs(warm[2] - (21 - np.exp(-1))) < 1e-12)
    True
    """
    gain = 1.0 - np.exp(-step_s / np.asarray(time_constant_s, dtype=np.float64))
    out = np.empty_like(around)
    out[0] = around[0]
    for k in range(len(around) - 1):
        out[k + 1] = out[k] + gain * (around[k] - out[k])
    return out


def day_temperatures(day: WorkingDay, reference: float, generator: np.random.Generator) -> DayTemperatures:
    """Return the true temperatures of a day.

    Parameters
    ----------
    day : WorkingDay
    reference : float [degC]
        The machine's reference temperature, about which the room swings.
    generator : numpy Generator
        Draws how the legs differ: uniform in ``1 +- spread``, mean 1.
    """
    count = round((day.shift_h + day.rest_h) * HOUR_S / day.step_s) + 1
    night = round(NIGHT_H * HOUR_S / day.step_s)
    time: FloatArray = np.asarray((np.arange(count + night) - night) * day.step_s, dtype=np.float64)
    hours = time / HOUR_S
    pause = (hours >= day.break_after_h) & (hours < day.break_after_h + day.break_h)
    working = (hours >= 0.0) & (hours < day.shift_h) & ~pause
    swing = -np.cos(2.0 * np.pi * (day.start_h + hours - day.room_coldest_h) / 24.0)
    room: FloatArray = reference + day.room_above_K + day.room_swing_K * np.asarray(swing, dtype=np.float64)
    heat = day.heat_W * _spread(day.heat_spread, generator)
    slow = day.leg_time_constant_s * _spread(day.leg_spread, generator)
    legs = lagged(room[:, None] + working[:, None] * heat * day.rise_K_per_W, day.step_s, slow)
    warmth = legs.mean(axis=1) - room
    platform = lagged(room + day.platform_share * warmth, day.step_s, day.platform_time_constant_s)
    base = lagged(room + day.base_share * warmth, day.step_s, day.base_time_constant_s)
    rows = slice(night, None)
    return DayTemperatures(time[rows], working[rows], room[rows], legs[rows], platform[rows], base[rows])


def _spread(spread: float, generator: np.random.Generator) -> FloatArray:
    """Return six factors about 1, whose mean is 1."""
    factors = 1.0 + spread * generator.uniform(-1.0, 1.0, 6)
    return np.asarray(factors / factors.mean())


def sensor_truth(hexapod: Hexapod, temperatures: DayTemperatures) -> FloatArray:
    """Return the true temperatures at the sensors, shape (n, s) [degC], in the order of `sensor_names`.

    Columns are those of the record: where plugs are exchanged, a leg's temperature stands under another leg's name.
    """
    model = active_model(hexapod)
    truth = np.empty((len(temperatures.time), len(model.sensor_names)))
    for leg, own in enumerate(model.columns_of_leg):
        truth[:, own] = temperatures.legs[:, leg, None]
    first = sum(len(law.sensors) for law in model.legs)
    for plate, values in ((model.platform, temperatures.platform), (model.base, temperatures.base)):
        if plate is not None and plate.sensor is not None:
            truth[:, first] = values
            first += 1
    return truth


def readings(hexapod: Hexapod, truth: FloatArray, day: WorkingDay, generator: np.random.Generator) -> FloatArray:
    """Return what the thermometers say of true temperatures.

    ``reading = T_ref + (1 + g) (T - T_ref) + noise``, with one gain error ``g`` for each sensor and fresh noise.

    Parameters
    ----------
    truth : array, shape (n, s) [degC]
        See `sensor_truth`.
    """
    reference = np.asarray(active_model(hexapod).reference_temperature_degC)
    gain = 1.0 + day.sensor_gain * generator.standard_normal(truth.shape[1])
    noise = day.sensor_noise_K * generator.standard_normal(truth.shape)
    return np.asarray(reference + gain * (truth - reference) + noise)
