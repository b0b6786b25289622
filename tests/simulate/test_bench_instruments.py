"""Room, scenario, thermocouples and interferometers of the bench do what their parameters say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hexathermal.errors import ArgumentError
from hexathermal.learn.air import refractive_index
from hexathermal.simulate.bench.interferometers import Interferometers, WeatherStation, index_of_air
from hexathermal.simulate.bench.mechanics import Mechanics
from hexathermal.simulate.bench.room import HOUR, Room, Weather
from hexathermal.simulate.bench.scenario import Commands, Motion, Scenario
from hexathermal.simulate.bench.thermocouples import Thermocouples, slow_process

STROKE, SPEED = (0.0, 0.25), 0.002
SILENT = Interferometers(
    radius_error=0.0, noise=0.0, vibration=0.0, cyclic=0.0, laser_drift=0.0, optics=0.0, tube_lag=1e-3, turbulence=0.0,
    misalignment=0.0, tilt_with_q=0.0, tilt_slow=0.0,
)  # fmt: skip


def still_air(n: int, temperature: float = 20.0) -> Weather:
    return Weather(np.full(n, temperature), np.full(n, 101325.0), np.full(n, 0.5))


@given(seed=st.integers(0, 10_000))
@settings(max_examples=40)
def test_the_room_keeps_within_its_limits(seed: int) -> None:
    """Every room stays within 2 K of 20 degC and changes by less than 1 K/h; the air is air."""
    time = np.arange(0.0, 6.0 * HOUR, 10.0)
    weather = Room().weather(time, np.random.default_rng(seed))
    assert np.abs(weather.temperature - 20.0).max() <= 2.0
    assert np.abs(np.diff(weather.temperature)).max() / 10.0 * HOUR < 1.0
    assert (weather.pressure > 9e4).all()
    assert (weather.pressure < 1.1e5).all()
    assert ((weather.humidity > 0.0) & (weather.humidity < 1.0)).all()


def test_pressure_fronts_pass() -> None:
    """Over a hundred rooms pressure changes by some hPa within a run, as fronts do."""
    time = np.arange(0.0, 6.0 * HOUR, 60.0)
    spans = [np.ptp(Room().weather(time, np.random.default_rng(seed)).pressure) for seed in range(100)]
    assert 100.0 < np.median(spans) < 800.0
    assert np.max(spans) > 500.0


def test_a_room_beyond_its_limits_is_refused() -> None:
    """Waves that would break 2 K or 1 K/h are an error that says by how much."""
    with pytest.raises(ArgumentError, match=r"may deviate by 2\.48 K.*lower its waves"):
        Room(level=2.0)
    with pytest.raises(ArgumentError, match="K/h"):
        Room(waves=(0.5,), periods=(1800.0,))
    with pytest.raises(ArgumentError, match="differ in length"):
        Room(waves=(0.5,))


@given(seed=st.integers(0, 10_000), run=st.integers(0, 5))
@settings(max_examples=30)
def test_scenarios_move_in_steps_of_ten_millimetres(seed: int, run: int) -> None:
    """No move is longer than 10 mm, all stay in the stroke, each is followed by a pause; phases of rest are long."""
    scenario = Scenario()
    commands = scenario.commands(STROKE, SPEED, np.random.default_rng(seed), run=run)
    motion = Motion(commands, SPEED)
    assert np.abs(motion.steps).max() <= 0.010 + 1e-12
    assert ((commands.targets >= 0.0) & (commands.targets <= 0.25)).all()
    pauses = commands.times[1:] - motion.arrivals[:-1]
    assert pauses.min() >= scenario.pause[0]
    assert pauses.max() >= scenario.rest[0]
    assert commands.times[0] == scenario.first_rest
    assert motion.arrivals[-1] <= commands.duration
    assert 4.0 * HOUR <= commands.duration <= 6.0 * HOUR


def test_motion_takes_its_time() -> None:
    """A move of 10 mm at 2 mm/s takes 5 s; rows are unsettled from its start until some seconds after its end."""
    motion = Motion(Commands(0.1, np.array([10.0, 30.0]), np.array([0.11, 0.09]), 60.0), SPEED)
    time = np.array([0.0, 10.0, 12.5, 15.0, 20.0, 35.0, 40.0, 60.0])
    assert motion.displacement(time) == pytest.approx([0.1, 0.1, 0.105, 0.11, 0.11, 0.1, 0.09, 0.09])
    assert motion.way(time) == pytest.approx([0.0, 0.0, 0.005, 0.01, 0.01, 0.02, 0.03, 0.03])
    assert motion.since_arrival(time)[1:5] == pytest.approx([-5.0, -2.5, 0.0, 5.0])
    assert np.isposinf(motion.since_arrival(time)[0])
    assert motion.landing(time).tolist() == [0, 1, 1, 1, 1, 2, 2, 2]


def test_a_command_too_soon_is_refused() -> None:
    """The rod is not asked to be in two places: the error says when it would arrive."""
    with pytest.raises(ArgumentError, match=r"command at 12 s comes before the rod reaches 110 mm, at 15\.0 s"):
        Motion(Commands(0.1, np.array([10.0, 12.0]), np.array([0.11, 0.09]), 60.0), SPEED)


def test_landings_scatter_with_heavy_tails_within_the_preload() -> None:
    """Scatter has the parameter's size, more outliers than a normal one, and none beyond the limit; none at first."""
    n = 20_000
    commands = Commands(0.1, np.arange(1, n + 1) * 20.0, 0.1 + 0.01 * (np.arange(1, n + 1) % 2), 20.0 * n + 20.0)
    mechanics = Mechanics(settling=0.0, scale_error=0.0)
    found = mechanics.error(Motion(commands, SPEED), np.arange(n) * 20.0 + 19.0, np.random.default_rng(1))
    assert found[0] == 0.0
    assert np.abs(found).max() <= mechanics.limit
    deviation = found.std()
    assert 0.1e-6 < deviation < 0.15e-6
    assert np.mean(np.abs(found) > 3.0 * deviation) > 3.0 * 0.0027


def test_settling_creeps_back_after_a_move() -> None:
    """What a landing leaves behind decays with its time constant."""
    mechanics = Mechanics(scatter=0.0, scale_error=0.0)
    motion = Motion(Commands(0.1, np.array([10.0]), np.array([0.11]), 100.0), SPEED)
    found = mechanics.error(motion, np.array([5.0, 15.0, 30.0, 45.0]), np.random.default_rng(2))
    assert found[0] == 0.0
    assert found[1] != 0.0
    assert found[2:] / found[1] == pytest.approx(np.exp([-1.0, -2.0]))


def test_thermocouples_read_what_they_say() -> None:
    """Noise, gain, contact error and slow bias of many readings have the sizes of their parameters."""
    kind = Thermocouples()
    mounted = kind.mounted(np.random.default_rng(3))
    n = 4000
    time = np.arange(n) * 20.0
    surfaces = np.full((n, 17), 24.0)
    read = mounted.read(time, surfaces, np.full(n, 20.0), np.random.default_rng(4))
    assert np.diff(read, axis=0).std() / np.sqrt(2.0) == pytest.approx(kind.noise, rel=0.05)
    steady = replace(kind, noise=0.0, bias=0.0, cold_junction=0.0).mounted(np.random.default_rng(3))
    first = steady.read(time, surfaces, np.full(n, 20.0), np.random.default_rng(4))[0]
    wanted = 20.0 + steady.offset + steady.gain * (1.0 - steady.contact_error) * 4.0
    assert first == pytest.approx(wanted, abs=0.0005 + 1e-12)
    assert len(kind.places) == 17
    assert [part for _name, part, _position in kind.places].count("body") == 14


def test_slow_bias_forgets_itself() -> None:
    """The slow process has unit variance, and its correlation falls as exp(-t/tau), whatever the step."""
    found = slow_process(np.arange(4000) * 20.0, 200.0, 200, np.random.default_rng(5))
    assert found.std() == pytest.approx(1.0, abs=0.03)
    assert np.mean(found[10:] * found[:-10]) == pytest.approx(np.exp(-1.0), abs=0.03)


def test_index_of_air_has_the_published_sensitivities() -> None:
    """At 633 nm, 20 degC, 1013.25 hPa, 50 %: -0.955 ppm/K, 0.268 ppm/hPa, -0.0085 ppm/%."""
    at = (632.99e-9, 20.0, 101325.0, 0.5)
    n = index_of_air(*at)
    assert (index_of_air(at[0], 20.5, *at[2:]) - index_of_air(at[0], 19.5, *at[2:])) * 1e6 == pytest.approx(
        -0.955, abs=0.006
    )
    assert (index_of_air(*at[:2], 101425.0, at[3]) - n) * 1e6 == pytest.approx(0.268, abs=0.001)
    assert (index_of_air(*at[:3], 0.51) - n) * 1e6 == pytest.approx(-0.0085, abs=0.0002)


def test_index_of_air_agrees_with_an_independent_equation() -> None:
    """Birch and Downs here and Ciddor on the learning side differ by less than 1e-8, 10 to 30 degC, any weather."""
    temperature, pressure, humidity = np.meshgrid(
        np.linspace(10.0, 30.0, 9), np.linspace(8e4, 1.1e5, 7), np.linspace(0.0, 1.0, 5)
    )
    difference = index_of_air(632.99e-9, temperature, pressure, humidity) - refractive_index(
        632.99e-9, temperature, pressure, humidity
    )
    assert np.abs(difference).max() < 1e-8


def test_compensated_beams_do_not_see_the_weather() -> None:
    """With a perfect station the laser shows the geometrical change alone, for any pressure, humidity and motion."""
    generator = np.random.default_rng(6)
    n = 200
    time = np.arange(n) * 20.0
    weather = Weather(np.full(n, 21.0), 1e5 + 500.0 * generator.normal(size=n), generator.uniform(0.3, 0.6, n))
    mounted = SILENT.mounted(generator)
    moved = 0.1 + 0.05 * np.sin(time / 500.0)
    paths = mounted.paths(time, moved, np.zeros(n), generator)
    shown = mounted.read(time, paths, weather, weather, np.zeros(n, dtype=bool), generator)
    assert np.abs(shown - (moved - moved[0])[:, None]).max() < 1e-14


def test_uncompensated_beams_see_the_whole_path() -> None:
    """A front of 10 hPa on 0.85 m of path shows 2.28 um: dead path and displacement both count."""
    time = np.array([0.0, 20.0])
    kind = replace(SILENT, index_compensated=False)
    mounted = kind.mounted(np.random.default_rng(7))
    weather = Weather(np.full(2, 20.0), np.array([101325.0, 102325.0]), np.full(2, 0.5))
    paths = mounted.paths(time, np.full(2, 0.1), np.zeros(2), np.random.default_rng(7))
    shown = mounted.read(time, paths, weather, weather, np.zeros(2, dtype=bool), np.random.default_rng(7))
    assert shown[1] * 1e6 == pytest.approx([0.268 * 10.0 * 0.85] * 3, abs=0.01)


def test_the_mean_of_three_beams_does_not_see_tilt() -> None:
    """Tilt moves each beam and leaves the mean of three equal radii at 120 degrees alone."""
    kind = replace(SILENT, tilt_slow=20e-6)
    mounted = kind.mounted(np.random.default_rng(8))
    time = np.arange(100) * 20.0
    paths = mounted.paths(time, np.full(100, 0.1), np.zeros(100), np.random.default_rng(8))
    assert np.ptp(paths, axis=0).min() > 0.5e-6
    assert np.ptp(paths.mean(axis=1)) < 1e-15


def test_head_optics_follow_the_room() -> None:
    """A room 1 K warmer shifts each head by its own drift."""
    kind = replace(SILENT, optics=50e-9, tube_lag=1e-3)
    mounted = kind.mounted(np.random.default_rng(9))
    time = np.array([0.0, 20.0, 40.0])
    weather = Weather(np.array([20.0, 21.0, 21.0]), np.full(3, 1e5), np.full(3, 0.5))
    shown = mounted.read(
        time, np.full((3, 3), 0.8), weather, weather, np.zeros(3, dtype=bool), np.random.default_rng(9)
    )
    assert shown[2] == pytest.approx(mounted.optics, abs=1e-14)
    assert len(set(mounted.optics)) == 3


def test_the_station_is_wrong_by_what_it_says() -> None:
    """Constant errors and noise of the weather station have the sizes of their parameters."""
    station = WeatherStation()
    read = station.read(still_air(5000), (0.2, 100.0, -0.02), np.random.default_rng(10))
    assert read.temperature.mean() == pytest.approx(20.2, abs=0.001)
    assert read.pressure.std() == pytest.approx(station.pressure_noise, rel=0.05)
    assert read.humidity.mean() == pytest.approx(0.48, abs=0.001)
