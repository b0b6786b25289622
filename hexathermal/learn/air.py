"""Index of refraction of air by Ciddor's equation, its sensitivities, and its uncertainty from a weather station.

Source: P. E. Ciddor, Applied Optics 35 (1996) 1566, with the saturation vapour pressure of IAPWS (over water: IF97;
below 0 degC over ice), as in J. A. Stone and J. H. Zimmerman, Engineering Metrology Toolbox, NIST. Temperatures are
those of ITS-90. All functions broadcast their arguments; what is not finite or lies outside `LIMITS` is refused.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError, UnknownNameError
from hexathermal.machine.thermal import ABSOLUTE_ZERO_DEGC
from hexathermal.poses import FloatArray, finite_array

RED_HELIUM_NEON = 632.991e-9
"""Vacuum wavelength of the red helium-neon laser line [m]."""

LIMITS: dict[str, tuple[float, float, float, str]] = {
    "wavelength": (300e-9, 1710e-9, 1e9, "nm"),
    "temperature": (-40.0, 100.0, 1.0, "degC"),
    "pressure": (10e3, 140e3, 1e-2, "hPa"),
    "humidity": (0.0, 1.0, 1e2, "%"),
    "co2": (0.0, 2000e-6, 1e6, "ppm"),
}
"""Lowest and highest value that is accepted (SI; degC), and how a message shows it: factor and unit.

The range of NIST's calculator, its 1700 nm a little widened. Ciddor's own, where the equation stands for 2e-8 to 5e-8,
is 300-1690 nm.
"""

_GAS_CONSTANT = 8.314472
_VAPOUR_MOLAR_MASS = 0.018015
_STANDARD_PRESSURE, _STANDARD_TEMPERATURE, _STANDARD_COMPRESSIBILITY = 101325.0, 288.15, 0.9995922115
_STANDARD_VAPOUR_DENSITY = 0.00985938
_STEP = 1e-30

PHASES = ("auto", "water", "ice")

_ASKED = {
    "wavelength": "give the vacuum wavelength in metres (633 nm is 633e-9)",
    "temperature": "give degrees Celsius",
    "pressure": "give pascals (1013.25 hPa is 101325), as measured at the beam, not reduced to sea level",
    "humidity": "give the relative humidity as a fraction (50 % is 0.5)",
    "co2": "give the mole fraction (450 ppm is 450e-6)",
}


def _checked(**values: npt.ArrayLike) -> list[FloatArray]:
    """Return arguments as finite arrays within `LIMITS`."""
    checked = []
    for name, value in values.items():
        low, high, factor, unit = LIMITS[name]
        array = finite_array(value, (), f"the air's {name}" if name != "wavelength" else name)
        outside = (array < low) | (array > high)
        if outside.any():
            place = tuple(int(k) for k in np.argwhere(outside)[0])
            at = f" at index {place}" if place else ""
            raise ArgumentError(
                f"{name} {array[place] * factor:.6g} {unit}{at} is outside {low * factor:g} to {high * factor:g} {unit}"
                f", the range of Ciddor's equation; {_ASKED[name]}"
            )
        checked.append(array)
    return checked


def saturation_vapour_pressure(temperature_degC: npt.ArrayLike, phase: str = "auto") -> FloatArray:
    """Return the pressure of water vapour in equilibrium with water or ice.

    Over water the saturation line of IAPWS-IF97 (eq. 30), over ice that of Wagner, Saul and Pruss (1994).

    Parameters
    ----------
    temperature_degC : array [degC]
    phase : str
        ``"auto"``: over ice below 0 degC; ``"water"`` and ``"ice"``: over that phase at any temperature.

    Returns
    -------
    pressure : array [Pa]

    Raises
    ------
    UnknownNameError
        The phase is none of the three.

    Examples
    --------
    >>> saturation_vapour_pressure([20.0, 0.0, -20.0]).round(2).tolist()
    [2339.21, 611.21, 103.26]
    """
    if phase not in PHASES:
        raise UnknownNameError(f"phase {phase!r} is not known; choose one of {', '.join(PHASES)}", PHASES)
    (t,) = _checked(temperature=temperature_degC)
    return np.asarray(_saturation(t, phase))


def _saturation(t: Any, phase: str) -> Any:
    """Return the saturation vapour pressure [Pa] of real or complex temperatures."""
    T = t - ABSOLUTE_ZERO_DEGC
    omega = T - 0.23855557567849 / (T - 650.17534844798)
    a = omega**2 + 1167.0521452767 * omega - 724213.16703206
    b = -17.073846940092 * omega**2 + 12020.82470247 * omega - 3232555.0322333
    c = 14.91510861353 * omega**2 - 4823.2657361591 * omega + 405113.40542057
    water = 1e6 * (2.0 * c / (-b + np.sqrt(b**2 - 4.0 * a * c))) ** 4
    theta = T / 273.16
    ice = 611.657 * np.exp(-13.928169 * (1.0 - theta**-1.5) + 34.7078238 * (1.0 - theta**-1.25))
    over_water = t.real >= 0.0 if phase == "auto" else phase == "water"
    return np.where(over_water, water, ice)


def _enhancement(t: Any, p: Any) -> Any:
    """Return the enhancement factor: moist air takes up more vapour than a vacuum does (Ciddor, appendix A)."""
    return 1.00062 + 3.14e-8 * p + 5.60e-7 * t**2


def _compressibility(t: Any, p: Any, xv: Any) -> Any:
    """Return the compressibility of moist air (BIPM 1981/91; Ciddor, appendix A)."""
    ratio = p / (t - ABSOLUTE_ZERO_DEGC)
    first = 1.58123e-6 - 2.9331e-8 * t + 1.1043e-10 * t**2 + (5.707e-6 - 2.051e-8 * t) * xv
    first = first + (1.9898e-4 - 2.376e-6 * t) * xv**2
    return 1.0 - ratio * first + ratio**2 * (1.83e-11 - 0.765e-8 * xv**2)


def _of_composition(wavelength: Any, t: Any, p: Any, xv: Any, co2: Any) -> Any:
    """Return the index less 1 of air with a mole fraction `xv` of vapour (Ciddor, eqs. 1 to 5)."""
    S = (1e-6 / wavelength) ** 2
    dry = 1e-8 * (5792105.0 / (238.0185 - S) + 167917.0 / (57.362 - S)) * (1.0 + 0.534 * (co2 - 450e-6))
    vapour = 1.022e-8 * (295.235 + 2.6422 * S - 0.032380 * S**2 + 0.004028 * S**3)
    moles = p / (_compressibility(t, p, xv) * _GAS_CONSTANT * (t - ABSOLUTE_ZERO_DEGC))
    # The molar mass of dry air, which depends on the carbon dioxide, cancels in the ratio of its densities.
    standard = _STANDARD_PRESSURE / (_STANDARD_COMPRESSIBILITY * _GAS_CONSTANT * _STANDARD_TEMPERATURE)
    vapour_density = xv * _VAPOUR_MOLAR_MASS * moles
    return (1.0 - xv) * moles / standard * dry + vapour_density / _STANDARD_VAPOUR_DENSITY * vapour


def _refractivity(wavelength: Any, t: Any, p: Any, h: Any, co2: Any) -> Any:
    """Return the index less 1 at a relative humidity."""
    xv = h * _enhancement(t, p) * _saturation(t, "auto") / p
    return _of_composition(wavelength, t, p, xv, co2)


def refractive_index(
    wavelength: npt.ArrayLike,
    temperature_degC: npt.ArrayLike,
    pressure: npt.ArrayLike,
    humidity: npt.ArrayLike,
    co2: npt.ArrayLike = 450e-6,
) -> FloatArray:
    """Return the phase index of refraction of moist air.

    Refractivities of dry air and of vapour, each times its density over the density at which it was measured
    (Ciddor 1996, eq. 5)::

        n - 1 = (rho_a / rho_axs) (n_axs - 1) + (rho_w / rho_ws) (n_ws - 1)

    The vapour's mole fraction is ``x_w = humidity f(p, t) p_sv(t) / p``, over ice below 0 degC. Where ``x_w`` exceeds 1
    (60 degC, 100 %, below 200 hPa) water boils and no such air exists; the equation is continued.

    Parameters
    ----------
    wavelength : array [m]
        In vacuum; 300 to 1710 nm (above 1690 nm an extrapolation).
    temperature_degC : array [degC]
        -40 to 100.
    pressure : array [Pa]
        At the beam, 10 to 140 kPa.
    humidity : array [1]
        Relative, 0 to 1.
    co2 : array [1]
        Mole fraction, 0 to 2000e-6.

    Returns
    -------
    index : array
        Of the arguments' common shape.

    Raises
    ------
    ArgumentError
        An argument is not finite, outside the range, or their shapes do not broadcast.

    Examples
    --------
    >>> round(float(refractive_index(633e-9, 20.0, 101325.0, 0.5)), 9)
    1.000271373
    """
    return 1.0 + np.asarray(_refractivity(*_arguments(wavelength, temperature_degC, pressure, humidity, co2)))


def _arguments(
    wavelength: npt.ArrayLike, t: npt.ArrayLike, p: npt.ArrayLike, h: npt.ArrayLike, co2: npt.ArrayLike
) -> list[FloatArray]:
    """Return checked arguments whose shapes broadcast."""
    arrays = _checked(wavelength=wavelength, temperature=t, pressure=p, humidity=h, co2=co2)
    try:
        np.broadcast_shapes(*(array.shape for array in arrays))
    except ValueError:
        shapes = ", ".join(f"{name} {array.shape}" for name, array in zip(LIMITS, arrays, strict=True))
        raise ArgumentError(f"shapes do not broadcast: {shapes}") from None
    return arrays


@dataclass(frozen=True)
class IndexSensitivity:
    """Derivatives of the index of refraction, each with the other arguments held.

    Attributes
    ----------
    temperature : array [1/K]
        At constant relative humidity, as a weather station measures it.
    pressure : array [1/Pa]
    humidity : array [1]
        For the relative humidity as a fraction.
    co2 : array [1]
        For the mole fraction.
    """

    temperature: FloatArray
    pressure: FloatArray
    humidity: FloatArray
    co2: FloatArray


def index_sensitivity(
    wavelength: npt.ArrayLike,
    temperature_degC: npt.ArrayLike,
    pressure: npt.ArrayLike,
    humidity: npt.ArrayLike,
    co2: npt.ArrayLike = 450e-6,
) -> IndexSensitivity:
    """Return the derivatives of `refractive_index`, exact to rounding.

    By the complex step ``dn/dx = Im n(x + i h) / h``, which cancels no digits. Arguments and errors are those of
    `refractive_index`; at 0 degC the derivative is that over water.

    Examples
    --------
    Per kelvin and per hectopascal, in parts per million:

    >>> slope = index_sensitivity(633e-9, 20.0, 101325.0, 0.5)
    >>> round(float(slope.temperature) * 1e6, 3), round(float(slope.pressure) * 1e8, 3)
    (-0.955, 0.268)
    """
    arguments = _arguments(wavelength, temperature_degC, pressure, humidity, co2)
    slopes = []
    for k in range(1, 5):
        moved: list[Any] = list(arguments)
        moved[k] = arguments[k] + 1j * _STEP
        slopes.append(np.asarray(_refractivity(*moved).imag / _STEP))
    return IndexSensitivity(*slopes)


@dataclass(frozen=True)
class WeatherStation:
    """Standard uncertainties (k = 1) of what the index of air is computed from.

    The defaults are half of the accuracies (k = 2) of a common environmental unit for laser interferometers: 0.2 K,
    1 hPa, 6 % relative humidity.

    Parameters
    ----------
    temperature : float [K]
    pressure : float [Pa]
    humidity : float [1]
    co2 : float [1]
        Of the assumed mole fraction in a room that people enter.
    formula : float [1]
        Of Ciddor's equation itself, for the index as it stands.
    """

    temperature: float = 0.1
    pressure: float = 50.0
    humidity: float = 0.03
    co2: float = 50e-6
    formula: float = 2e-8

    def __post_init__(self) -> None:
        refuse_negative(self)


def refuse_negative(value: Any, signed: tuple[str, ...] = ()) -> None:
    """Raise `ArgumentError` where a number of a dataclass is negative or not finite; `signed` fields are passed by."""
    for item in fields(value):
        number = getattr(value, item.name)
        if item.name in signed or not isinstance(number, float | int):
            continue
        if not (np.isfinite(number) and number >= 0.0):
            raise ArgumentError(f"{type(value).__name__}: {item.name} must be 0 or more and finite, found {number!r}")


def index_contributions(
    wavelength: npt.ArrayLike,
    temperature_degC: npt.ArrayLike,
    pressure: npt.ArrayLike,
    humidity: npt.ArrayLike,
    co2: npt.ArrayLike = 450e-6,
    *,
    station: WeatherStation | None = None,
) -> dict[str, FloatArray]:
    """Return what each quantity of the weather contributes to the standard uncertainty of the index.

    ``|dn/dx| u(x)`` for temperature, pressure, humidity and CO2, and that of the formula. Arguments and errors are
    those of `refractive_index`.

    Parameters
    ----------
    station : WeatherStation, optional

    Returns
    -------
    contributions : dict of str to array
        ``"temperature"``, ``"pressure"``, ``"humidity"``, ``"co2"``, ``"formula"``.
    """
    used = WeatherStation() if station is None else station
    slope = index_sensitivity(wavelength, temperature_degC, pressure, humidity, co2)
    names = ("temperature", "pressure", "humidity", "co2")
    found = {name: np.abs(getattr(slope, name)) * getattr(used, name) for name in names}
    found["formula"] = np.full(np.shape(slope.temperature), used.formula)
    return found


def index_uncertainty(
    wavelength: npt.ArrayLike,
    temperature_degC: npt.ArrayLike,
    pressure: npt.ArrayLike,
    humidity: npt.ArrayLike,
    co2: npt.ArrayLike = 450e-6,
    *,
    station: WeatherStation | None = None,
) -> FloatArray:
    """Return the standard uncertainty of the index: root sum of squares of `index_contributions`.

    Examples
    --------
    >>> round(float(index_uncertainty(633e-9, 20.0, 101325.0, 0.5)) * 1e6, 2)
    0.17
    """
    parts = index_contributions(wavelength, temperature_degC, pressure, humidity, co2, station=station)
    return np.asarray(np.sqrt(sum(np.square(part) for part in parts.values())))
