"""How well a drift is known that was measured with several interferometer beams: a budget for every row.

Linear propagation (GUM) of labelled, independent sources. With the path in air ``L = dead_path + q``, the displacement
``D = q - q_0`` and ``b`` beams::

    u^2 = L^2 c^2 sum (dn/dx u_x)^2 + D^2 (u_n^2 + u_w^2) + (L u_s)^2 + (D theta^2 / 2)^2
          + (h eps)^2 + (a^2 + 2 s^2) / b + (k dT)^2                                                             (2)

``c^2 = 2 (1 - r)``: a drift is the difference of two rows, and what the weather station does wrong in both alike
(correlation ``r``) cancels. Every source is a parameter of `InterferometerAccuracy`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError
from hexathermal.learn.air import RED_HELIUM_NEON, WeatherStation, index_contributions, refuse_negative
from hexathermal.learn.campaign import BeamLayout
from hexathermal.machine.thermal import frozen
from hexathermal.poses import FloatArray, as_array, finite_array

STANDARD_AIR = (20.0, 101325.0, 0.5)
"""Air temperature [degC], pressure [Pa] and relative humidity [1] where none were recorded."""


@dataclass(frozen=True)
class InterferometerAccuracy:
    """Standard uncertainties (k = 1) of an interferometer with several beams.

    Where a source is said, the figure is of that class of instruments; the others are engineering values.

    Parameters
    ----------
    station : WeatherStation
        Of the weather; half of 0.2 K, 1 hPa, 6 % (environmental unit of a laser interferometer).
    weather_correlation : float [1]
        Correlation ``r`` of the station's errors between a row and the zero, -1 to 1. At 0.5 a difference is as
        uncertain as one reading; 1 for a constant error, 0 for errors that change within the run.
    wavelength : float [1]
        Relative, of the laser in vacuum; scales the displacement. Laser interferometers: 0.02 to 0.1 ppm.
    stability : float [1]
        Relative change of the wavelength within a run; acts on the whole path.
    misalignment : float [rad]
        Angle between beam and motion; its whole cosine effect ``D theta^2 / 2`` counts as standard uncertainty.
    offset : float [m]
        Distance of the beams' mean from the leg's axis (Abbe); the radius for a single beam.
    tilt : float [rad]
        Tilt of the platform where it was not measured.
    cyclic : float [m]
        Height of the error that repeats with the fringe, of one beam. Heterodyne interferometers: 1 to 5 nm.
    optics : float [m/K]
        Zero drift of the optics with the air, common to the beams. Tens to hundreds of nm/K (Rerucha 2024).
    room : float [K]
        Change of the air's temperature where it was not recorded.
    noise : float [m]
        Of one beam's reading, at rest.
    """

    station: WeatherStation = field(default_factory=WeatherStation)
    weather_correlation: float = 0.5
    wavelength: float = 5e-8
    stability: float = 1e-8
    misalignment: float = 1e-3
    offset: float = 1e-3
    tilt: float = 5e-6
    cyclic: float = 3e-9
    optics: float = 50e-9
    room: float = 1.0
    noise: float = 15e-9

    def __post_init__(self) -> None:
        if not -1.0 <= self.weather_correlation <= 1.0:
            raise ArgumentError(f"weather_correlation must be within -1 and 1, found {self.weather_correlation!r}")
        refuse_negative(self, signed=("weather_correlation",))


@dataclass(frozen=True, eq=False)
class DriftUncertainty:
    """Standard uncertainty of a measured drift, row by row.

    Attributes
    ----------
    standard : array, shape (n,) [m]
        Root sum of squares of the contributions.
    contributions : mapping of str to array, shape (n,) [m]
        By source, not negative.
    """

    standard: FloatArray
    contributions: Mapping[str, FloatArray]

    @property
    def ranked(self) -> tuple[tuple[str, float], ...]:
        """Sources and their root mean square over the rows [m], the largest first."""
        sizes = {name: float(np.sqrt(np.mean(np.square(part)))) for name, part in self.contributions.items()}
        return tuple(sorted(sizes.items(), key=lambda item: -item[1]))


def drift_uncertainty(
    q: npt.ArrayLike,
    layout: BeamLayout,
    air: npt.ArrayLike | None = None,
    *,
    zero_q: float | None = None,
    zero_temperature_degC: float | None = None,
    tilt: npt.ArrayLike | None = None,
    accuracy: InterferometerAccuracy | None = None,
    wavelength: float = RED_HELIUM_NEON,
    co2: float = 450e-6,
) -> DriftUncertainty:
    """Return the standard uncertainty of a measured drift by eq. 2 of this module, and what each source adds.

    The same holds whether the laser's electronics or `corrected_beams` applied the index: both used a weather station.

    Parameters
    ----------
    q : array, shape (n,) [m]
    layout : BeamLayout
    air : array, shape (n, 3), optional
        Air temperature [degC], pressure [Pa] and relative humidity [1]. None: `STANDARD_AIR`, and the optics see a
        change of ``accuracy.room``.
    zero_q, zero_temperature_degC : float, optional
        Displacement and air temperature of the zero; by default those of the first row.
    tilt : array, shape (n,), optional [rad]
        Measured tilt since the zero (``hypot(tilt_x, tilt_y)``), in place of ``accuracy.tilt``.
    accuracy : InterferometerAccuracy, optional
    wavelength, co2 : float [m], [1]

    Returns
    -------
    uncertainty : DriftUncertainty

    Raises
    ------
    ArgumentError
        Shapes differ, a value is not finite, the weather is outside the range of Ciddor's equation, or no row.

    Examples
    --------
    >>> layout = BeamLayout(radius=0.06, azimuths=(0.0, 2.1, 4.2), dead_path=0.8, index_compensated=True)
    >>> found = drift_uncertainty([0.0, 0.0], layout)
    >>> [(name, round(1e6 * size, 2)) for name, size in found.ranked[:2]]
    [('air pressure', 0.11), ('air temperature', 0.08)]
    """
    used = InterferometerAccuracy() if accuracy is None else accuracy
    rod = finite_array(q, (), "q")
    if rod.ndim != 1 or rod.size == 0:
        raise ArgumentError(f"q has shape {rod.shape}; expected (n,) with at least one row")
    weather = _weather(air, rod.size)
    start = weather[0, 0] if zero_temperature_degC is None else zero_temperature_degC
    warming = np.full(rod.shape, used.room) if air is None else weather[:, 0] - start
    moved, path = rod - (rod[0] if zero_q is None else zero_q), layout.dead_path + rod
    turned = np.full(rod.shape, used.tilt) if tilt is None else _same_rows(tilt, rod.size, "tilt")
    index = index_contributions(wavelength, weather[:, 0], weather[:, 1], weather[:, 2], co2, station=used.station)
    parts = _parts(used, len(layout.azimuths), index, path, moved, turned, warming)
    contributions = {name: frozen(np.abs(part)) for name, part in parts.items()}
    standard = np.sqrt(sum(np.square(part) for part in contributions.values()))
    return DriftUncertainty(frozen(np.asarray(standard)), MappingProxyType(contributions))


def _parts(
    used: InterferometerAccuracy,
    beams: int,
    index: dict[str, FloatArray],
    path: FloatArray,
    moved: FloatArray,
    turned: FloatArray,
    warming: FloatArray,
) -> dict[str, FloatArray]:
    """Return the terms of eq. 2, signed, by source."""
    cancelling, own = np.sqrt(2.0 * (1.0 - used.weather_correlation)), np.ones(path.shape) / np.sqrt(beams)
    return {
        "air temperature": path * index["temperature"] * cancelling,
        "air pressure": path * index["pressure"] * cancelling,
        "air humidity": path * index["humidity"] * cancelling,
        "carbon dioxide": path * index["co2"] * cancelling,
        "index formula": moved * index["formula"],
        "laser wavelength": moved * used.wavelength,
        "laser stability": path * used.stability,
        "cosine": 0.5 * moved * used.misalignment**2,
        "Abbe": used.offset * turned,
        "cyclic error": used.cyclic * own,
        "optics": used.optics * warming,
        "noise": np.sqrt(2.0) * used.noise * own,
    }


def _weather(air: npt.ArrayLike | None, rows: int) -> FloatArray:
    """Return the weather of every row, shape (n, 3)."""
    if air is None:
        return np.tile(np.array(STANDARD_AIR), (rows, 1))
    weather = as_array(air, "air")
    if weather.shape != (rows, 3):
        raise ArgumentError(f"air has shape {weather.shape}; expected ({rows}, 3), one row for each of q")
    if not np.isfinite(weather).all():
        raise ArgumentError(
            "air holds values that are not finite; leave those rows out, or give air=None for standard air"
        )
    return weather


def _same_rows(values: npt.ArrayLike, rows: int, what: str) -> FloatArray:
    """Return finite values, one for each row."""
    array = finite_array(values, (), what)
    if array.shape != (rows,):
        raise ArgumentError(f"{what} has shape {array.shape}; expected ({rows},), one for each row of q")
    return array
