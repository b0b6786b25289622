"""Three interferometers beside the leg: what they count through the air of their tubes, and what the laser shows."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError
from hexathermal.machine.thermal import frozen
from hexathermal.poses import FloatArray
from hexathermal.simulate.bench.parts import require_finite
from hexathermal.simulate.bench.room import Weather
from hexathermal.simulate.bench.thermocouples import slow_process
from hexathermal.simulate.day import lagged


def index_of_air(
    wavelength: float, temperature_degC: npt.ArrayLike, pressure: npt.ArrayLike, humidity: npt.ArrayLike
) -> FloatArray:
    """Return the index of refraction of air with 450 ppm of carbon dioxide.

    Edlen's equation as updated by Birch and Downs (Metrologia 30, 155 and 31, 315), with the vapour term of Stone
    and Zimmerman (NIST) and Magnus' vapour pressure (Sonntag's constants). Within 1e-8 of Ciddor's
    equation at 10 to 30 degC and 800 to 1100 hPa.

    Parameters
    ----------
    wavelength : float [m]
        In vacuum.
    temperature_degC : array [degC]
    pressure : array [Pa]
    humidity : array [1]
        Relative, 0 to 1.

    Examples
    --------
    >>> n = index_of_air(632.99e-9, 20.0, 101325.0, 0.5)
    >>> print(f"{1e6 * (n - 1.0):.2f} ppm")
    271.38 ppm
    """
    t, p = np.asarray(temperature_degC, dtype=np.float64), np.asarray(pressure, dtype=np.float64)
    square = (1e-6 / wavelength) ** 2
    standard = 1e-8 * (8342.54 + 2406147.0 / (130.0 - square) + 15998.0 / (38.9 - square))
    compressed = (1.0 + 1e-8 * (0.601 - 0.00972 * t) * p) / (1.0 + 0.003661 * t)
    vapour = np.asarray(humidity) * 611.2 * np.exp(17.62 * t / (243.12 + t))
    wet = 1e-10 * (292.75 / (t + 273.15)) * (3.7345 - 0.0401 * square) * vapour
    return np.asarray(1.0 + p * standard * compressed / 96095.43 - wet)


@dataclass(frozen=True)
class WeatherStation:
    """What the weather station reads beside the tubes.

    Attributes
    ----------
    temperature_noise, pressure_noise, humidity_noise : float [K], [Pa], [1]
        Standard deviation of a reading; humidity is never read below 0 or above 1. Engineering value.
    temperature_offset, pressure_offset, humidity_offset : float [K], [Pa], [1]
        Standard deviation of its constant errors. Source: 0.2 K, 1 hPa, 6 % are the limits of a compensation unit.
    """

    temperature_noise: float = 0.01
    pressure_noise: float = 3.0
    humidity_noise: float = 0.003
    temperature_offset: float = 0.1
    pressure_offset: float = 50.0
    humidity_offset: float = 0.03

    def __post_init__(self) -> None:
        require_finite(self)

    def errors(self, generator: np.random.Generator) -> tuple[float, float, float]:
        """Return one station's constant errors: temperature [K], pressure [Pa], humidity [1]."""
        found = generator.standard_normal(3) * (self.temperature_offset, self.pressure_offset, self.humidity_offset)
        return (float(found[0]), float(found[1]), float(found[2]))

    def read(self, weather: Weather, errors: tuple[float, float, float], generator: np.random.Generator) -> Weather:
        """Return what it reads of the room's air."""
        noise = generator.standard_normal((3, weather.temperature.size))
        humidity = weather.humidity + errors[2] + self.humidity_noise * noise[2]
        return Weather(
            frozen(weather.temperature + errors[0] + self.temperature_noise * noise[0]),
            frozen(weather.pressure + errors[1] + self.pressure_noise * noise[1]),
            frozen(np.clip(humidity, 0.0, 1.0)),
        )


@dataclass(frozen=True)
class Interferometers:
    """Three beams in steel tubes about the leg, from heads near the upper joint to reflectors near the lower one.

    With the true index ``n`` of the tubes' air, the path ``P = dead_path + q + growth`` and, at the first row, the
    index ``n0`` and the path ``P0``, the laser counts the change of ``n P``. What it shows:

        index_compensated:      D = n P / n_s - n0 P0 / n_s0       (n_s: from the weather station, for the whole path)
        not index_compensated:  D = (n P - n0 P0) / n_s0           (the wavelength is set once, at the first row)

    Attributes
    ----------
    radius, radius_error : float [m]
        Of the beams about the leg's axis, and the standard deviation of each one's place. Engineering value.
    azimuths : tuple of float [rad]
        Source: 120 degrees apart (Robert et al.).
    dead_path : float [m]
        Path from the interferometer's zero to the reflector at ``q = 0``. Engineering value.
    index_compensated : bool
        Whether the laser's electronics apply the weather station's index.
    wavelength : float [m]
        In vacuum. Source: helium-neon.
    noise : float [m]
        Standard deviation of a settled reading. Engineering value.
    vibration : float [m]
        The same while the rod moves and shortly after. Engineering value: readings are useless then.
    cyclic : float [m]
        Height of the error that repeats every half wavelength. Source: 1 to 5 nm.
    laser_drift, laser_time : float [1], [s]
        Standard deviation of the laser's relative frequency, and how fast it changes. Source: 0.02 to 0.1 ppm.
    optics : float [m/K]
        Standard deviation of each head's zero drift with the room. Source: tens to hundreds of nm/K (Rerucha 2024).
    tube_lag : float [s]
        The tubes' air follows the room that much later. Engineering value: steel tubes of 1 mm.
    turbulence : float [1]
        Standard deviation of each tube's index from reading to reading. Engineering value.
    misalignment : float [rad]
        Standard deviation of each beam's angle to the motion; its cosine shortens displacements. Engineering value.
    tilt_with_q, tilt_slow, tilt_time : float [rad/m], [rad], [s]
        Standard deviation of the platform's tilt: per displacement (straightness), and slow. Engineering value.
    """

    radius: float = 0.060
    radius_error: float = 0.0002
    azimuths: tuple[float, ...] = (0.0, 2.0 * pi / 3.0, 4.0 * pi / 3.0)
    dead_path: float = 0.750
    index_compensated: bool = True
    wavelength: float = 632.99e-9
    noise: float = 15e-9
    vibration: float = 1.5e-6
    cyclic: float = 2e-9
    laser_drift: float = 0.02e-6
    laser_time: float = 7200.0
    optics: float = 50e-9
    tube_lag: float = 300.0
    turbulence: float = 0.01e-6
    misalignment: float = 0.15e-3
    tilt_with_q: float = 20e-6
    tilt_slow: float = 2e-6
    tilt_time: float = 3600.0

    def __post_init__(self) -> None:
        require_finite(self, above_zero=("wavelength", "laser_time", "tilt_time", "tube_lag"), signed=("azimuths",))
        if len(self.azimuths) != 3:
            raise ArgumentError(f"the bench has three beams, found {len(self.azimuths)} azimuths")

    def mounted(self, generator: np.random.Generator) -> MountedInterferometers:
        """Return the interferometers as they are on one bench, their constant errors drawn."""
        normal = generator.standard_normal
        return MountedInterferometers(
            self,
            frozen(self.radius + self.radius_error * normal(3)),
            frozen(self.optics * normal(3)),
            frozen(self.misalignment * normal(3)),
            frozen(self.tilt_with_q * normal(2)),
        )


@dataclass(frozen=True, eq=False)
class MountedInterferometers:
    """Interferometers with their constant errors.

    Attributes
    ----------
    kind : Interferometers
    radii : array, shape (3,) [m]
    optics : array, shape (3,) [m/K]
    angles : array, shape (3,) [rad]
    tilt_with_q : array, shape (2,) [rad/m]
    """

    kind: Interferometers
    radii: FloatArray
    optics: FloatArray
    angles: FloatArray
    tilt_with_q: FloatArray

    def paths(
        self, time: FloatArray, displacement: FloatArray, drift: FloatArray, generator: np.random.Generator
    ) -> FloatArray:
        """Return the geometrical paths of the beams, shape (n, 3) [m].

        Parameters
        ----------
        time : array, shape (n,) [s]
        displacement, drift : array, shape (n,) [m]
            What the scale reads, and by how much the leg is longer than that.
        """
        kind = self.kind
        tilt = np.outer(displacement - displacement[0], self.tilt_with_q)
        tilt += kind.tilt_slow * slow_process(time, kind.tilt_time, 2, generator)
        azimuths = np.array(kind.azimuths)
        lever = np.stack([np.cos(azimuths), np.sin(azimuths)]) * self.radii
        moved = (displacement + drift)[:, None] * np.cos(self.angles)
        return np.asarray(kind.dead_path + moved + tilt @ lever)

    def read(
        self, time: FloatArray, paths: FloatArray, room: Weather, station: Weather, moving: npt.NDArray[np.bool_],
        generator: np.random.Generator,
    ) -> FloatArray:  # fmt: skip
        """Return what the laser shows, zero at the first row, shape (n, 3) [m].

        Parameters
        ----------
        time : array, shape (n,) [s]
        paths : array, shape (n, 3) [m]
        room : Weather
            True air of the room; that of the tubes follows it.
        station : Weather
            What the weather station reads.
        moving : array, shape (n,), bool
            The rod moves or has not settled.
        """
        kind = self.kind
        tube = lagged(room.temperature, float(time[1] - time[0]), kind.tube_lag) if time.size > 1 else room.temperature
        true = index_of_air(kind.wavelength, tube, room.pressure, room.humidity)[:, None]
        true = true + kind.turbulence * generator.standard_normal(paths.shape)
        true *= 1.0 - kind.laser_drift * slow_process(time, kind.laser_time, 1, generator)
        optical = true * paths
        known = index_of_air(kind.wavelength, station.temperature, station.pressure, station.humidity)[:, None]
        scaled = optical / (known if kind.index_compensated else known[0])
        scaled += np.outer(room.temperature - room.temperature[0], self.optics)
        scaled += kind.cyclic * np.sin(4.0 * pi * optical / kind.wavelength)
        scaled += np.where(moving, kind.vibration, kind.noise)[:, None] * generator.standard_normal(paths.shape)
        return frozen(scaled - scaled[0])
