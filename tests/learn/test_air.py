"""Index of refraction of air: published values, independent equations, derivatives, limits."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hexathermal.errors import ArgumentError, UnknownNameError
from hexathermal.learn.air import (
    LIMITS,
    WeatherStation,
    index_contributions,
    index_sensitivity,
    index_uncertainty,
    refractive_index,
    saturation_vapour_pressure,
)
from hexathermal.poses import FloatArray

NIST = 1e-8
"""Agreement asked of values from NIST's calculator, which shows nine decimals."""

WEATHER = st.tuples(
    st.floats(321e-9, 1701e-9), st.floats(-20.0, 60.0), st.floats(300e2, 1400e2), st.floats(0.0, 1.0),
    st.floats(300e-6, 600e-6),
)  # fmt: skip
TABLES: dict[str, tuple[tuple[Any, Any, Any, Any], list[float]]] = {
    "wavelength": (
        (np.array([321.456, 500, 600.1234, 633.0, 700, 1000.987, 1500.8, 1700.0]) * 1e-9, 20.0, 101325.0, 0.5),
        [1.000283543, 1.000273781, 1.000271818, 1.000271373, 1.000270657, 1.000269038, 1.00026819, 1.000268041],
    ),
    "temperature": (
        (633e-9, [-20.0, 0.0, 20.0, 26.7982, 40.123, 60.45], 101325.0, 0.5),
        [1.00031489, 1.000291647, 1.000271373, 1.000264994, 1.000253031, 1.000235516],
    ),
    "pressure": (
        (633e-9, 20.0, [10e3, 50.123e3, 100.1234e3, 140e3], 0.5),
        [1.000026385, 1.000133999, 1.000268148, 1.000375169],
    ),
    "humidity": (
        (633e-9, 20.0, 101325.0, [0.0, 0.20123, 0.4, 0.509876, 0.7, 0.907432, 1.0]),
        [1.0002718, 1.000271627, 1.000271458, 1.000271364, 1.000271203, 1.000271027, 1.000270949],
    ),
}
"""Read off NIST's Engineering Metrology Toolbox (450 ppm of CO2), one quantity changed at a time."""


@pytest.mark.parametrize("changed", TABLES)
def test_values_of_nist_are_met(changed: str) -> None:
    """NIST's values from 321 to 1700 nm, -20 to 60 degC, 100 to 1400 hPa, 0 to 100 % are met within 1e-8."""
    where, expected = TABLES[changed]
    assert np.abs(refractive_index(*where) - expected).max() < NIST


def test_table_of_ciddor_is_met() -> None:
    """Ciddor 1996, table 1: dry air, 450 ppm, 633 nm; (n - 1) 1e8 to the printed digit."""
    index = refractive_index(633e-9, [20, 20, 20, 10, 30], [80e3, 100e3, 120e3, 100e3, 100e3], 0.0)
    assert ((index - 1.0) * 1e8).round(1).tolist() == [21458.0, 26824.4, 32191.6, 27774.7, 25937.2]


def test_saturation_pressures_of_iapws_are_met() -> None:
    """IAPWS-IF97, table 35 (300 K), the triple point, and the boiling point within 0.02 K."""
    assert saturation_vapour_pressure(300.0 - 273.15) == pytest.approx(3536.58941, rel=1e-8)
    assert saturation_vapour_pressure(0.01) == pytest.approx(611.657, rel=1e-5)
    assert saturation_vapour_pressure(0.01, "ice") == pytest.approx(611.657, rel=1e-9)
    assert saturation_vapour_pressure(99.974) == pytest.approx(101325.0, rel=1e-4)


def test_vapour_below_freezing_is_over_ice() -> None:
    """Below 0 degC less vapour stands over ice than over water; at the triple point both are the same."""
    cold = np.linspace(-40.0, -0.1, 50)
    ice, water = saturation_vapour_pressure(cold), saturation_vapour_pressure(cold, "water")
    assert (ice < water).all()
    assert (ice == saturation_vapour_pressure(cold, "ice")).all()
    assert saturation_vapour_pressure(0.0) == saturation_vapour_pressure(0.0, "water")
    with pytest.raises(UnknownNameError, match="auto, water, ice"):
        saturation_vapour_pressure(0.0, "snow")


def _as_ciddor_wrote(wavelength: float, t: float, p: float, h: float, co2: float) -> float:
    """Ciddor's text of 1996: Giacomo's vapour pressures, and the vapour's density at 1333 Pa from its own Z."""
    T, S, R = t + 273.15, (1e-6 / wavelength) ** 2, 8.314510
    over_water = np.exp(1.2378847e-5 * T**2 - 1.9121316e-2 * T + 33.93711047 - 6343.1645 / T)
    vapour = h * (over_water if t >= 0.0 else 10.0 ** (-2663.5 / T + 12.537))
    xw = (1.00062 + 3.14e-8 * p + 5.6e-7 * t**2) * vapour / p

    def moles(t: float, p: float, x: float) -> float:
        T = t + 273.15
        a = 1.58123e-6 - 2.9331e-8 * t + 1.1043e-10 * t**2
        b, c = 5.707e-6 - 2.051e-8 * t, 1.9898e-4 - 2.376e-6 * t
        z = 1.0 - p / T * (a + b * x + c * x**2) + (p / T) ** 2 * (1.83e-11 - 0.765e-8 * x**2)
        return float(p / (z * R * T))

    dry = (5792105.0 / (238.0185 - S) + 167917.0 / (57.362 - S)) * 1e-8 * (1.0 + 0.534 * (co2 - 450e-6))
    wet = 1.022e-8 * (295.235 + 2.6422 * S - 0.03238 * S**2 + 0.004028 * S**3)
    here = moles(t, p, xw)
    return float(
        1.0 + (1.0 - xw) * here / moles(15.0, 101325.0, 0.0) * dry + xw * here / moles(20.0, 1333.0, 1.0) * wet
    )


@settings(deadline=None)
@given(WEATHER)
def test_the_variants_of_the_equation_agree(weather: tuple[float, ...]) -> None:
    """Ciddor's own vapour pressures and constants move the index by less than 1e-9 anywhere in the range."""
    assert abs(float(refractive_index(*weather)) - _as_ciddor_wrote(*weather)) < 1e-9


def _edlen(wavelength: float, t: FloatArray, p: FloatArray, h: FloatArray) -> FloatArray:
    """Edlen's equation as modified by Birch and Downs (Metrologia 31 (1994) 315), at 450 ppm of CO2."""
    S = (1e-6 / wavelength) ** 2
    standard = 1e-8 * (8342.54 + 2406147.0 / (130.0 - S) + 15998.0 / (38.9 - S))
    dry = p * standard / 96095.43 * (1.0 + 1e-8 * (0.601 - 0.00972 * t) * p) / (1.0 + 0.003661 * t)
    return 1.0 + dry - h * saturation_vapour_pressure(t) * (3.7345 - 0.0401 * S) * 1e-10


@pytest.mark.parametrize("wavelength", [543e-9, 633e-9])
def test_edlens_equation_agrees_in_a_laboratory(wavelength: float) -> None:
    """Birch and Downs' modified Edlen equation, fitted to other data, stays within 2e-8 at 15 to 25 degC."""
    t, p, h = np.meshgrid(np.linspace(15, 25, 6), np.linspace(900e2, 1100e2, 6), np.linspace(0.0, 0.7, 6))
    assert np.abs(refractive_index(wavelength, t, p, h) - _edlen(wavelength, t, p, h)).max() < 2e-8


@settings(deadline=None)
@given(WEATHER)
def test_derivatives_are_those_of_the_index(weather: tuple[float, ...]) -> None:
    """Each derivative equals a central difference of the index, away from 0 degC and from the ends of a range."""
    w, t, p, h, co2 = weather
    t, h = (t if abs(t) > 0.02 else 1.0), min(max(h, 0.01), 0.99)
    p = min(p, 1399e2)
    slope = index_sensitivity(w, t, p, h, co2)
    steps = {"temperature": 0.01, "pressure": 10.0, "humidity": 0.01, "co2": 1e-4}
    for k, (name, step) in enumerate(steps.items(), start=1):
        low, high = [w, t, p, h, co2], [w, t, p, h, co2]
        low[k], high[k] = low[k] - step, high[k] + step
        difference = (float(refractive_index(*high)) - float(refractive_index(*low))) / (2.0 * step)
        # Rounding of n (2.2e-16 each) over the step, and the curvature that a central difference leaves.
        assert getattr(slope, name) == pytest.approx(difference, rel=1e-5, abs=3e-16 / step), name


def test_published_sensitivities() -> None:
    """633 nm, 20 degC, 101325 Pa, 50 %: -0.955 ppm/K, 0.268 ppm/hPa, -0.0085 ppm/%, 0.014 ppm per 100 ppm of CO2."""
    slope = index_sensitivity(633e-9, 20.0, 101325.0, 0.5)
    assert round(float(slope.temperature) * 1e6, 3) == -0.955
    assert round(float(slope.pressure) * 1e8, 3) == 0.268
    assert float(slope.humidity) * 1e4 == pytest.approx(-0.0085, abs=5e-5)
    assert float(slope.co2) * 1e2 == pytest.approx(0.014, abs=5e-4)


def test_constant_humidity_is_not_constant_vapour() -> None:
    """Holding the vapour in place of the relative humidity changes the slope with temperature by 2.7 %."""
    vapour = 0.5 * saturation_vapour_pressure(20.0)
    t = np.array([19.99, 20.01])
    held = np.diff(refractive_index(633e-9, t, 101325.0, vapour / saturation_vapour_pressure(t)))[0] / 0.02
    ratio = float(index_sensitivity(633e-9, 20.0, 101325.0, 0.5).temperature) / held
    assert 1.0 - 1.0 / ratio == pytest.approx(0.027, abs=1e-3)


def test_the_station_gives_0_17_ppm() -> None:
    """Accuracies of 0.2 K, 1 hPa and 6 % (k = 2) make 0.17 ppm, most of it pressure."""
    assert float(index_uncertainty(633e-9, 20.0, 101325.0, 0.5)) == pytest.approx(0.17e-6, abs=0.005e-6)
    parts = index_contributions(633e-9, 20.0, 101325.0, 0.5)
    assert max(parts, key=lambda name: float(parts[name])) == "pressure"


def test_the_uncertainty_is_that_of_drawn_weather() -> None:
    """The spread of the index over 40 000 drawn readings is the propagated uncertainty."""
    generator, station = np.random.default_rng(3), WeatherStation(formula=0.0)
    t, p, h, co2 = (
        mean + sigma * generator.standard_normal(40_000)
        for mean, sigma in (
            (20.0, station.temperature), (101325.0, station.pressure), (0.5, station.humidity), (450e-6, station.co2),
        )
    )  # fmt: skip
    spread = refractive_index(633e-9, t, p, h, co2).std()
    assert spread == pytest.approx(float(index_uncertainty(633e-9, 20.0, 101325.0, 0.5, station=station)), rel=0.015)


def test_arguments_broadcast() -> None:
    """A column of temperatures and a row of pressures make a table, each entry that of its own weather."""
    t, p = np.array([[10.0], [20.0]]), np.array([90e3, 100e3, 110e3])
    table = refractive_index(633e-9, t, p, 0.4)
    assert table.shape == (2, 3)
    assert table[1, 2] == refractive_index(633e-9, 20.0, 110e3, 0.4)
    assert index_uncertainty(633e-9, t, p, 0.4).shape == (2, 3)


@pytest.mark.parametrize(
    ("name", "wrong", "shown"),
    [
        ("wavelength", 633.0, "300 to 1710 nm"),
        ("wavelength", 10.6e-6, "300 to 1710 nm"),
        ("temperature", 293.15, "-40 to 100 degC"),
        ("pressure", 1013.25, "100 to 1400 hPa"),
        ("humidity", 50.0, "0 to 100 %"),
        ("humidity", -0.01, "0 to 100 %"),
        ("co2", 450.0, "0 to 2000 ppm"),
    ],
)
def test_values_out_of_range_are_refused(name: str, wrong: float, shown: str) -> None:
    """A wrong unit is refused with the range and the unit that is asked for; also inside an array."""
    values: dict[str, Any] = dict(zip(LIMITS, (633e-9, 20.0, 101325.0, 0.5, 450e-6), strict=True))
    values[name] = [values[name], wrong]
    with pytest.raises(ArgumentError, match=shown) as refused:
        refractive_index(*values.values())
    assert str(refused.value).startswith(name)


def test_missing_values_and_shapes_are_refused() -> None:
    """What is not a number, and shapes that do not fit, are refused by name."""
    with pytest.raises(ArgumentError, match="pressure holds nan"):
        refractive_index(633e-9, [20.0, 20.0], [np.nan, 1e5], 0.5)
    with pytest.raises(ArgumentError, match="do not broadcast"):
        refractive_index(633e-9, [20.0, 20.0], [1e5, 1e5, 1e5], 0.5)
    with pytest.raises(ArgumentError, match="WeatherStation: pressure"):
        WeatherStation(pressure=-1.0)
