"""Temperatures of a machine's sensors: from what users hold to checked arrays."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NoReturn

import numpy as np

from hexathermal.errors import ArgumentError, TemperatureError, ThermalModelError
from hexathermal.kinematics.batches import where
from hexathermal.kinematics.inverse import plain
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.thermal import ABSOLUTE_ZERO_DEGC, TemperaturesLike, ThermalModel
from hexathermal.poses import FloatArray, as_array


def active_model(hexapod: Hexapod) -> ThermalModel:
    """Return the machine's thermal model, or say that compensation is not active."""
    if hexapod.thermal is None:
        raise ThermalModelError(
            f"thermal compensation is not active: machine {hexapod.name!r} has no thermal law. Add [thermal] to its "
            "hexapod.toml, or use inverse_kinematics for nominal lengths"
        )
    return hexapod.thermal


def temperature_array(hexapod: Hexapod, temps: TemperaturesLike) -> FloatArray:
    """Return temperatures as a contiguous array (..., n) in the order of `hexapod.sensor_names`, shape checked only.

    Parameters
    ----------
    temps : array, shape (..., n) [degC], or mapping of sensor name to values
        A mapping must name exactly the machine's sensors; its values broadcast against each other.

    Raises
    ------
    TemperatureError
        A sensor of a mapping is missing or unknown.
    ArgumentError
        Wrong shape.
    ThermalModelError
        The machine has no thermal law.
    """
    names = active_model(hexapod).sensor_names
    temps = _by_label(temps)
    if isinstance(temps, Mapping):
        missing = [name for name in names if name not in temps]
        if missing:
            raise TemperatureError(
                f"temperature of sensor {missing[0]} is missing ({len(missing)} of {len(names)} are); "
                f"needed: {', '.join(names)}; given: {', '.join(map(str, temps)) or 'none'}",
                sensor=missing[0],
            )
        extra = [str(name) for name in temps if name not in names]
        if extra:
            raise TemperatureError(
                f"sensor {extra[0]} is not one of the machine's: {', '.join(names)}", sensor=extra[0]
            )
        columns = [as_array(temps[name], f"temperature of {name}") for name in names]
        try:
            array = np.stack(np.broadcast_arrays(*columns), axis=-1)
        except ValueError:
            shapes = ", ".join(f"{name} {column.shape}" for name, column in zip(names, columns, strict=True))
            raise ArgumentError(f"temperatures of different sensors do not broadcast: {shapes}") from None
    else:
        array = as_array(temps, "temps")
    if array.ndim < 1 or array.shape[-1] != len(names):
        raise ArgumentError(
            f"temps has shape {array.shape}; expected (..., {len(names)}) in degC, in the order {', '.join(names)}"
        )
    return array if plain(array) else np.array(array, dtype=np.float64, order="C")


def _by_label(temps: Any) -> Any:
    """Return a table or series with labels as a mapping of them: labels count, not the order of columns."""
    if isinstance(temps, Mapping) or not hasattr(temps, "keys"):
        return temps
    return {str(name): temps[name] for name in temps.keys()}  # noqa: SIM118 - a table iterates otherwise


def check_temperatures(hexapod: Hexapod, temps: FloatArray) -> None:
    """Raise for the first temperature that is not a number, impossible, or outside the law's range."""
    low, high = active_model(hexapod).valid_degC
    good = (temps >= low) & (temps <= high)
    if not good.all():
        index = tuple(int(k) for k in np.argwhere(~good)[0])
        refuse_temperatures(hexapod, temps[index[:-1]], index[:-1])


def refuse_temperatures(hexapod: Hexapod, temps: FloatArray, index: tuple[int, ...] = ()) -> NoReturn:
    """Raise for one set of temperatures that a loop refused, naming the sensor."""
    model = active_model(hexapod)
    low, high = model.valid_degC
    k = int(np.argmin((temps >= low) & (temps <= high)))
    name, value = model.sensor_names[k], float(temps[k])
    raise TemperatureError(
        f"temperature of sensor {name}{where(index)} {fault(value, low, high)}",
        sensor=name, value=value, lower=low, upper=high, index=index,
    )  # fmt: skip


def check_stated(hexapod: Hexapod, value: float, what: str) -> None:
    """Raise for a temperature that somebody states, of a plate or of the air, by the limits of those that are read.

    Parameters
    ----------
    hexapod : Hexapod
    value : float [degC]
    what : str
        Whose it is, for the message.

    Raises
    ------
    TemperatureError
        It is impossible, or outside the law's range.
    """
    low, high = active_model(hexapod).valid_degC
    if said := fault(value, low, high):
        raise TemperatureError(f"temperature of the {what} {said}", value=value, lower=low, upper=high)


def fault(value: float, low: float, high: float, limits: str = "the law's range of validity") -> str:
    """Return what is wrong with a temperature [degC], in words; nothing where it lies within the limits.

    Examples
    --------
    >>> fault(294.0, 0.0, 50.0)
    "is 294 degC, outside the law's range of validity [0, 50] degC; was it given in kelvin?"
    """
    if np.isnan(value):
        return "is NaN: no reading"
    if not np.isfinite(value) or value < ABSOLUTE_ZERO_DEGC:
        return f"is {value:g} degC, which is impossible"
    if low <= value <= high:
        return ""
    kelvin = "; was it given in kelvin?" if low <= value + ABSOLUTE_ZERO_DEGC <= high else ""
    return f"is {value:g} degC, outside {limits} [{low:g}, {high:g}] degC{kelvin}"
