"""Uncertainty of a measured drift: published cases, sums, simulation."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest

from hexathermal.errors import ArgumentError
from hexathermal.learn.air import WeatherStation, refractive_index
from hexathermal.learn.campaign import BeamLayout
from hexathermal.learn.interferometer import corrected_beams
from hexathermal.learn.interferometer_uncertainty import InterferometerAccuracy, drift_uncertainty

LAYOUT = BeamLayout(0.06, (0.0, 2.0 * np.pi / 3.0, 4.0 * np.pi / 3.0), 0.8, False)
PERFECT = WeatherStation(temperature=0.0, pressure=0.0, humidity=0.0, co2=0.0, formula=0.0)
NOTHING = InterferometerAccuracy(station=PERFECT, wavelength=0.0, stability=0.0, misalignment=0.0, offset=0.0, tilt=0.0,
                                 cyclic=0.0, optics=0.0, room=0.0, noise=0.0)  # fmt: skip


def test_published_cases() -> None:
    """0.13 um of air on 0.8 m, 0.125 um of 1 mrad on 250 mm, 0.25 um of 50 mm and 5 urad."""
    station = WeatherStation(formula=0.0, co2=0.0)
    air = drift_uncertainty([0.0], LAYOUT, accuracy=replace(NOTHING, station=station))
    assert air.standard[0] == pytest.approx(0.13e-6, abs=0.005e-6)
    cosine = drift_uncertainty([0.0, 0.25], LAYOUT, accuracy=replace(NOTHING, misalignment=1e-3))
    assert cosine.standard == pytest.approx([0.0, 0.125e-6])
    abbe = drift_uncertainty([0.0], LAYOUT, accuracy=replace(NOTHING, offset=0.05, tilt=5e-6))
    assert abbe.standard == pytest.approx([0.25e-6])


def test_contributions_add_up() -> None:
    """The standard uncertainty is the root sum of squares of what is listed; a perfect instrument has none."""
    q = np.linspace(0.0, 0.25, 40)
    air = np.column_stack([np.linspace(20.0, 23.0, 40), np.full(40, 99e3), np.full(40, 0.4)])
    found = drift_uncertainty(q, LAYOUT, air)
    total = np.sqrt(sum(part**2 for part in found.contributions.values()))
    assert np.abs(found.standard - total).max() < 1e-20
    assert all((part >= 0.0).all() for part in found.contributions.values())
    assert sorted(name for name, _ in found.ranked) == sorted(found.contributions)
    assert (drift_uncertainty(q, LAYOUT, air, accuracy=NOTHING).standard == 0.0).all()


@pytest.mark.parametrize("name", [item.name for item in fields(InterferometerAccuracy) if item.type == "float"])
def test_every_parameter_counts(name: str) -> None:
    """Each parameter of the accuracy changes the uncertainty: none is accepted and then dropped."""
    other = -0.5 if name == "weather_correlation" else 7.0 * getattr(InterferometerAccuracy(), name)
    changed = replace(InterferometerAccuracy(), **{name: other})
    q = [0.0, 0.2]
    assert drift_uncertainty(q, LAYOUT, accuracy=changed).standard[1] > drift_uncertainty(q, LAYOUT).standard[1]


def test_a_constant_error_of_the_station_cancels() -> None:
    """With correlation 1 the weather adds nothing; with 0 it adds root two of one reading."""

    def air_part(r: float) -> float:
        accuracy = replace(NOTHING, station=WeatherStation(formula=0.0), weather_correlation=r)
        return float(drift_uncertainty([0.0], LAYOUT, accuracy=accuracy).standard[0])

    assert air_part(1.0) == 0.0
    assert air_part(0.0) == pytest.approx(np.sqrt(2.0) * air_part(0.5))


def test_the_air_part_is_that_of_simulated_errors() -> None:
    """Beams corrected with 20 000 wrong stations, errors independent at zero and row, scatter as the budget says."""
    generator, station, draws = np.random.default_rng(11), WeatherStation(formula=0.0), 20_000
    sigma = np.array([station.temperature, station.pressure, station.humidity, station.co2])
    (t, p, h, co2), (t0, p0, h0, co2_0) = (
        (np.array([20.0, 101325.0, 0.5, 450e-6]) + sigma * generator.standard_normal((draws, 4))).T for _ in range(2)
    )
    now, zero = refractive_index(633e-9, t, p, h, co2), refractive_index(633e-9, t0, p0, h0, co2_0)
    beams = np.array([
        corrected_beams(np.zeros(1), 0.1, a, zero_index=float(b), zero_q=0.1, dead_path=0.8)[0]
        for a, b in zip(now, zero, strict=True)
    ])  # fmt: skip
    accuracy = replace(NOTHING, station=station, weather_correlation=0.0)
    expected = drift_uncertainty([0.1], LAYOUT, accuracy=accuracy, wavelength=633e-9).standard[0]
    assert beams.std() == pytest.approx(expected, rel=0.02)


def test_recorded_weather_and_tilt_take_the_place_of_assumed_ones() -> None:
    """Optics follow the recorded air since the zero, Abbe the measured tilt; a later block takes the run's zero."""
    air = np.column_stack([[20.0, 22.0], [101325.0] * 2, [0.5] * 2])
    accuracy = replace(NOTHING, optics=50e-9, offset=1e-3, tilt=1.0)
    found = drift_uncertainty([0.0, 0.1], LAYOUT, air, tilt=[0.0, 20e-6], accuracy=accuracy)
    assert found.contributions["optics"] == pytest.approx([0.0, 100e-9])
    assert found.contributions["Abbe"] == pytest.approx([0.0, 20e-9])
    scaled = replace(NOTHING, wavelength=1e-7, optics=50e-9)
    later = drift_uncertainty([0.1], LAYOUT, air[1:], zero_q=0.0, zero_temperature_degC=20.0, accuracy=scaled)
    assert later.contributions["laser wavelength"] == pytest.approx([10e-9])
    assert later.contributions["optics"] == pytest.approx([100e-9])


def test_more_beams_average_what_is_their_own() -> None:
    """Noise (of the row and of the zero) and cyclic errors fall with the root of the number of beams; air does not."""
    assert drift_uncertainty([0.1], LAYOUT, accuracy=replace(NOTHING, noise=30e-9)).standard == pytest.approx(
        30e-9 * np.sqrt(2.0 / 3.0)
    )
    six = replace(LAYOUT, azimuths=tuple(np.arange(6) * np.pi / 3.0))
    three, more = (drift_uncertainty([0.1], layout).contributions for layout in (LAYOUT, six))
    for name, ratio in (("noise", np.sqrt(0.5)), ("cyclic error", np.sqrt(0.5)), ("air pressure", 1.0)):
        assert more[name] == pytest.approx(ratio * three[name]), name


def test_wrong_arguments_are_refused() -> None:
    """Negative uncertainties, shapes that differ, missing weather and an empty run are refused."""
    with pytest.raises(ArgumentError, match="InterferometerAccuracy: noise"):
        InterferometerAccuracy(noise=-1e-9)
    with pytest.raises(ArgumentError, match="weather_correlation"):
        InterferometerAccuracy(weather_correlation=1.5)
    with pytest.raises(ArgumentError, match="at least one row"):
        drift_uncertainty([], LAYOUT)
    with pytest.raises(ArgumentError, match=r"expected \(2, 3\)"):
        drift_uncertainty([0.0, 0.1], LAYOUT, np.zeros((3, 3)))
    with pytest.raises(ArgumentError, match="air=None"):
        drift_uncertainty([0.0], LAYOUT, [[20.0, np.nan, 0.5]])
    with pytest.raises(ArgumentError, match="tilt has shape"):
        drift_uncertainty([0.0, 0.1], LAYOUT, tilt=[0.0])
