"""The room of the bench: its temperature, pressure and humidity against time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.machine.thermal import frozen
from hexathermal.poses import FloatArray
from hexathermal.simulate.bench.parts import require_finite

HOUR = 3600.0


@dataclass(frozen=True, eq=False)
class Weather:
    """Air of the room, n times.

    Attributes
    ----------
    temperature : array, shape (n,) [degC]
    pressure : array, shape (n,) [Pa]
    humidity : array, shape (n,) [1]
        Relative.
    """

    temperature: FloatArray
    pressure: FloatArray
    humidity: FloatArray

    def every(self, count: int) -> Weather:
        """Return every `count`-th time."""
        part = slice(None, None, count)
        return Weather(self.temperature[part], self.pressure[part], self.humidity[part])


@dataclass(frozen=True)
class Room:
    """How the room of the bench changes.

    Temperature is a sum of waves of fixed height and drawn phase about a level drawn for each run; so its limits hold
    by construction and are checked. Pressure is a level drawn for each run and fronts that pass.

    Attributes
    ----------
    temperature : float [degC]
        Mean. Engineering value: 20 degC.
    level : float [K]
        Largest deviation of a run's level from that mean. Engineering value.
    waves : tuple of float [K]
        Heights of the waves: the day, the building's heating, the air conditioning. Engineering value, within limits.
    periods : tuple of float [s]
        Their periods.
    deviation_limit, rate_limit : float [K], [K/s]
        What the room keeps. Source: within +-2 K, below 1 K/h (Robert et al.).
    pressure, pressure_level : float [Pa]
        Mean, and standard deviation of a run's level. Engineering value.
    front, front_time : float [Pa], [s]
        Standard deviation of a front's height, and how long it takes to pass. Engineering value: some hPa over hours.
    fronts : int
        Fronts in a run.
    humidity, humidity_level, humidity_change : float [1]
        Relative, held between 0.05 and 0.95: mean, standard deviation of a run's level, and of its change over some
        hours. Engineering value.
    """

    temperature: float = 20.0
    level: float = 0.7
    waves: tuple[float, ...] = (0.3, 0.15, 0.03)
    periods: tuple[float, ...] = (24.0 * HOUR, 3.0 * HOUR, 0.75 * HOUR)
    deviation_limit: float = 2.0
    rate_limit: float = 1.0 / HOUR
    pressure: float = 101325.0
    pressure_level: float = 800.0
    front: float = 300.0
    front_time: float = 1.5 * HOUR
    fronts: int = 2
    humidity: float = 0.45
    humidity_level: float = 0.06
    humidity_change: float = 0.03

    def __post_init__(self) -> None:
        require_finite(self, above_zero=("periods", "front_time", "pressure"), signed=("temperature",))
        if len(self.waves) != len(self.periods):
            raise ArgumentError(f"Room.waves and Room.periods differ in length: {self.waves!r}, {self.periods!r}")
        deviation = self.level + sum(self.waves)
        rate = sum(2.0 * np.pi * height / period for height, period in zip(self.waves, self.periods, strict=True))
        if deviation > self.deviation_limit or rate > self.rate_limit:
            raise ArgumentError(
                f"the room may deviate by {deviation:g} K and change by {rate * HOUR:.3g} K/h; its limits are "
                f"{self.deviation_limit:g} K and {self.rate_limit * HOUR:g} K/h; lower its waves or raise its limits"
            )

    def weather(self, time: FloatArray, generator: np.random.Generator) -> Weather:
        """Return the air at the times of one run, drawn anew.

        Parameters
        ----------
        time : array, shape (n,) [s]
        generator : numpy.random.Generator
        """
        temperature = self.temperature + self.level * generator.uniform(-1.0, 1.0) + np.zeros(time.shape)
        for height, period in zip(self.waves, self.periods, strict=True):
            temperature += height * np.sin(2.0 * np.pi * (time / period + generator.uniform()))
        pressure = self.pressure + self.pressure_level * generator.standard_normal() + np.zeros(time.shape)
        for _front in range(self.fronts):
            middle = generator.uniform(time[0], time[-1])
            pressure += self.front * generator.standard_normal() * 0.5 * np.tanh((time - middle) / self.front_time)
        swing = np.sin(2.0 * np.pi * (time / (8.0 * HOUR) + generator.uniform()))
        level = self.humidity + self.humidity_level * generator.standard_normal()
        # water stays in the air while the room warms: relative humidity falls by some 6 % of itself per kelvin
        dry = 1.0 - 0.06 * (temperature - self.temperature)
        humidity = (level + self.humidity_change * generator.standard_normal() * swing) * dry
        return Weather(frozen(temperature), frozen(pressure), frozen(np.clip(humidity, 0.05, 0.95)))
