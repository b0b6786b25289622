"""A leg by finite volumes, those of the virtual bench in long steps: 20 s, 11 runs of 4 h, landings that scatter far.

Heat, motion and room are those of `hexathermal.simulate.bench`, its drive, its surfaces and its users drawn anew; the
drift is that of a law of one or two of its thermometers' places, so nothing but noise departs from it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.bench.leg import VirtualLeg
from hexathermal.simulate.bench.parts import Drive, LegBody, Rod
from hexathermal.simulate.bench.room import Room
from hexathermal.simulate.bench.scenario import Motion, Scenario
from hexathermal.simulate.bench.thermocouples import Thermocouples
from hexathermal.simulate.hidden.benches.legs import Leg
from hexathermal.simulate.hidden.benches.noises import log_uniform, noted, remembering
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth

NAME = "finite_volume"

STEP = 20.0
ROWS = 721
TIME: FloatArray = STEP * np.arange(ROWS, dtype=np.float64)
ROLES = ("identification",) * 8 + ("validation",) * 3
BASES = ((6,), (4,), (9,), (6, 13), (5, 15), (3, 10))

FORGOTTEN = 7200.0
"""Correlation time of the thermometers' bias [s]; over 6 h it changes by 1.4 times its own size."""

FREEDOM, FARTHEST = 4.0, 8.0
"""Degrees of freedom of a landing's scatter; what lies farther out than so many times its scale is drawn again."""


def _leg(pause: float, generator: np.random.Generator) -> VirtualLeg:
    """Return the leg, its losses drawn by factors of up to 1.6, its drive so that it warms by some kelvin.

    Parameters
    ----------
    pause : float [s]
        Mean one between moves: a leg that moves seldom is one with more friction.
    """

    def about(value: float) -> float:
        """Return a value, drawn about another."""
        return value * log_uniform(1.0 / 1.6, 1.6, generator)

    body, rod, drive = LegBody(), Rod(), Drive()
    usual = Scenario()
    step = usual.increment / drive.speed
    heat = (pause + step) / (float(np.mean(usual.pause)) + step)
    return VirtualLeg(
        body=replace(body, convection=about(body.convection), motor_conductance=about(body.motor_conductance)),
        rod=replace(rod, convection=about(rod.convection)),
        drive=replace(drive, moving_power=heat * about(drive.moving_power),
                      screw_torque=heat * about(drive.screw_torque),
                      rod_share=generator.uniform(0.2, 0.5)),
    )  # fmt: skip


def _law(leg: VirtualLeg, generator: np.random.Generator) -> Leg:
    """Return the law: A of 1 to 3e-6 /K and B of 0.5 to 2e-6 /K in all, shared by its sensors."""
    base = BASES[generator.integers(len(BASES))]
    sums = (log_uniform(1e-6, 3e-6, generator), log_uniform(0.5e-6, 2e-6, generator))
    shares = [generator.dirichlet(np.full(len(base), 8.0)) for _ in sums]
    return Leg(leg.retracted_length, leg.stroke[1], base, np.concatenate([sums[k] * shares[k] for k in range(2)]))


def _level(generator: np.random.Generator) -> dict[str, float]:
    """Return the levels of noise."""
    return {
        "white_um": log_uniform(0.02, 0.06, generator),
        "landing_um": generator.uniform(0.10, 0.30),
        "slow_um": log_uniform(0.02, 0.12, generator),
        "slow_time_s": 3000.0,
        "sensor_noise_K": log_uniform(0.006, 0.02, generator),
        "sensor_bias_K": 0.05,
        "sensor_walk_6h_K": 0.07,
        "sample_s": STEP,
        "drift_resolution_um": 0.0,
        "temperature_resolution_K": 0.001,
    }


def _landings(count: int, level: dict[str, float], generator: np.random.Generator) -> FloatArray:
    """Return the scatter of landings [um]: Student's t, of the landings' standard deviation; none before any move."""
    found = generator.standard_t(FREEDOM, count)
    while (far := np.abs(found) > FARTHEST).any():
        found[far] = generator.standard_t(FREEDOM, int(far.sum()))
    found *= level["landing_um"] / np.sqrt(FREEDOM / (FREEDOM - 2.0))
    found[0] = 0.0
    return np.asarray(found)


def draw(generator: np.random.Generator) -> CampaignTruth:
    """Make a campaign in which nothing is hidden.

    Parameters
    ----------
    generator : numpy.random.Generator
    """
    shortest = log_uniform(8.0, 25.0, generator)
    scenario = Scenario(pause=(shortest, 4.0 * shortest), rest=(1200.0, 4200.0))
    leg = _leg(2.5 * shortest, generator)
    law, level, room = _law(leg, generator), _level(generator), Room(temperature=generator.uniform(19.0, 22.0))
    places = Thermocouples().places
    weights = np.column_stack([leg.weights(part, position) for _, part, position in places])
    shape = (ROWS, len(places))
    runs = []
    for k, role in enumerate(ROLES):
        commands = scenario.commands(leg.stroke, leg.drive.speed, generator, run=k, duration=float(TIME[-1]))
        motion = Motion(commands, leg.drive.speed)
        weather, q = room.weather(TIME, generator), motion.displacement(TIME)
        start = leg.at_rest(float(weather.temperature[0]), float(q[0]))
        warm = leg.warm(TIME, q, weather.temperature, start, way=motion.way(TIME))
        temperatures = warm.temperatures @ weights
        errors = level["sensor_noise_K"] * generator.standard_normal(shape)
        errors += level["sensor_bias_K"] * remembering(FORGOTTEN / STEP, shape, generator)
        noise = level["white_um"] * generator.standard_normal(ROWS)
        noise += level["slow_um"] * remembering(level["slow_time_s"] / STEP, (ROWS,), generator)
        noise += _landings(commands.times.size + 1, level, generator)[motion.landing(TIME)]
        air = np.column_stack([weather.temperature, weather.pressure, weather.humidity])
        runs.append(RunTruth(
            f"run-{k + 1:02d}", role, TIME.copy(), q, motion.since_arrival(TIME) >= scenario.settling, temperatures,
            errors, air, np.empty((ROWS, 0)), law.drift(temperatures, q), 1e-6 * noise, np.zeros(ROWS),
            np.zeros((ROWS, 3)),
        ))  # fmt: skip
    names = tuple(name for name, _, _ in places)
    return noted(CampaignTruth(
        "leg", NAME, tuple(runs), names, tuple(part for _, part, _ in places),
        np.array([position for _, _, position in places]), tuple(names[k] for k in law.base), law.coefficients,
        leg.retracted_length, leg.stroke, round(generator.uniform(0.2, 0.8), 3), True, notes=level,
    ))  # fmt: skip
