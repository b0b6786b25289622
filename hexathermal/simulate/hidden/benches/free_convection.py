"""A leg that cools as still air lets it, the more than in proportion the warmer it is: 5 to 60 s, 10 runs of 5 h.

Body and rod are two chains of cells that conduct, and exchange heat where the rod is inside the body, wherever it is,

``c dT/dt = k A T'' + g (T_other - T) + P / dx - s (h |T - T_air|^(1/4) + r) (T - T_air)``

per metre: free convection of a horizontal cylinder, ``h = 1.32 D^(-1/4)`` W m^-2 K^-5/4 (Holman, Heat Transfer, table
7-2), and radiation ``r = 4 eps sigma T^3``. So no sum of exponentials tells how it warms. Steps of `SUBSTEP` are short
against a cell's own time, so that Euler's rule does.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.benches.air import Room
from hexathermal.simulate.hidden.benches.legs import Leg, drawn_leg
from hexathermal.simulate.hidden.benches.motion import Motion, carried_out
from hexathermal.simulate.hidden.benches.noises import log_uniform, noted, remembering, thermometer_errors
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth

NAME = "free_convection"

SUBSTEP = 5.0
SUBSTEPS = 3601
STEPS = (5.0, 10.0, 15.0, 30.0, 60.0)
"""Rows are so far apart [s]."""

ROLES = ("identification",) * 8 + ("validation",) * 2
BODY, ROD = 12, 5
BASES = ((5,), (7,), (9,), (4, 13), (6, 14))
CELLS, ROD_CELLS = 18, 6
FREE = 1.32
"""Free convection of a horizontal cylinder of 1 m in still air [W m^-7/4 K^-5/4]."""

RADIATION = 4.0 * 5.67e-8 * 293.0**3
"""Of a black body near 20 degC [W m^-2 K^-1]."""


@dataclass(frozen=True)
class Chain:
    """A tube or a rod.

    Attributes
    ----------
    cell : float [m]
        Length of a cell.
    capacity : float [J/(m K)]
    conduction : float [W m/K]
        Conductivity times section.
    surface : float [m]
        Circumference.
    diameter : float [m]
    emissivity : float
    """

    cell: float
    capacity: float
    conduction: float
    surface: float
    diameter: float
    emissivity: float

    def gained(self, T: FloatArray, air: FloatArray) -> FloatArray:
        """Return the heat that cells gain from their neighbours and the air, shape (r, m) [W/m].

        Parameters
        ----------
        T : array, shape (r, m) [degC]
        air : array, shape (r, 1) [degC]
        """
        flow = np.diff(T, axis=1) * self.conduction / self.cell**2
        found = np.zeros_like(T)
        found[:, :-1] += flow
        found[:, 1:] -= flow
        above = T - air
        loss = FREE * (np.abs(above) / self.diameter) ** 0.25 + self.emissivity * RADIATION
        return np.asarray(found - self.surface * loss * above)


@dataclass(frozen=True, eq=False)
class Heat:
    """What warms the leg.

    Attributes
    ----------
    motor, friction : float [W]
        Of the motor while the rod moves, and of the nut at full speed.
    rod_share : float
        Part of the friction that goes into the rod.
    contact : float [W/(m K)]
        Between rod and body, where one is inside the other.
    nut : float [m]
        From the lower joint, rod retracted.
    """

    motor: float
    friction: float
    rod_share: float
    contact: float
    nut: float


def warmed(
    body: Chain, rod: Chain, heat: Heat, speed: FloatArray, place: FloatArray, air: FloatArray, start: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return temperatures of body and rod, shape (n + 1, r, cells) each [degC], of r runs side by side.

    Parameters
    ----------
    speed, place : array, shape (n, r)
        Over the largest, 0 to 1; and displacement [m]; within each substep.
    air : array, shape (n, r) [degC]
    start : array, shape (r,) [degC]
        Of all cells.
    """
    count, runs = speed.shape
    tubes = np.empty((count + 1, runs, CELLS))
    rods = np.empty((count + 1, runs, ROD_CELLS))
    tubes[0], rods[0] = start[:, None], start[:, None]
    along, row = rod.cell * (np.arange(ROD_CELLS) + 0.5), np.arange(runs)[:, None]
    ends = body.cell * CELLS
    for k in range(count):
        T, R, warm = tubes[k], rods[k], air[k][:, None]
        gained, taken = body.gained(T, warm), rod.gained(R, warm)
        # the nut sits at the rod's inner end and goes with it
        at = heat.nut + place[k][:, None] + along
        inside = at < ends
        beside = np.minimum((at / body.cell).astype(np.int64), CELLS - 1)
        flow = heat.contact * inside * (R - T[row, beside])
        taken = taken - flow
        np.add.at(gained, (row, beside), flow * rod.cell / body.cell)
        rubbed = heat.friction * speed[k]
        gained[:, 0] += heat.motor * (speed[k] > 0.0) / body.cell
        gained[row[:, 0], beside[:, 0]] += (1.0 - heat.rod_share) * rubbed / body.cell
        taken[:, 0] += heat.rod_share * rubbed / rod.cell
        tubes[k + 1] = T + SUBSTEP * gained / body.capacity
        rods[k + 1] = R + SUBSTEP * taken / rod.capacity
    return tubes, rods


def _plan(stroke: float, generator: np.random.Generator) -> Iterator[tuple[float, float, float]]:
    """Yield sessions between two drawn ends, by a drawn number of stations there and back, with rests behind each."""
    while True:
        low, high = np.sort(generator.uniform(0.0, stroke, 2))
        stations = np.linspace(low, high, int(generator.integers(2, 9)))
        speed, rest = log_uniform(1e-3, 8e-3, generator), log_uniform(15.0, 500.0, generator)
        for _turn in range(generator.integers(1, 5)):
            for place in (*stations, *stations[::-1]):
                yield round(float(place), 5), speed, rest * generator.uniform(0.7, 1.4)
        yield round(float(generator.uniform(0.0, stroke)), 5), speed, log_uniform(300.0, 3000.0, generator)


def _levels(generator: np.random.Generator) -> dict[str, float]:
    """Return levels of noise: even noise of rows, landings that scatter, and a slow one of hours in a third of all."""
    slow = generator.uniform() < 1.0 / 3.0
    return {
        "white_um": log_uniform(0.02, 0.12, generator),
        "landing_um": log_uniform(0.03, 0.2, generator),
        "slow_um": log_uniform(0.03, 0.12, generator) if slow else 0.0,
        "slow_time_s": log_uniform(3600.0, 14400.0, generator) if slow else 0.0,
        "sensor_noise_K": log_uniform(0.005, 0.05, generator),
        "sensor_bias_K": log_uniform(0.02, 0.15, generator),
        "sensor_walk_6h_K": log_uniform(0.01, 0.04, generator),
        "sample_s": float(generator.choice(STEPS)),
        "drift_resolution_um": 0.0,
        "temperature_resolution_K": 0.0,
    }


def _leg_and_heat(leg: Leg, generator: np.random.Generator) -> tuple[Chain, Chain, Heat]:
    """Return a tube and a rod of steel, and what warms them by some kelvin."""
    length = leg.retracted_length - 0.05
    tube, bar = log_uniform(0.9e-3, 2e-3, generator), log_uniform(0.3e-3, 0.8e-3, generator)
    emissivity = generator.uniform(0.1, 0.8)
    body = Chain(length / CELLS, 3.6e6 * tube, 45.0 * tube, generator.uniform(0.2, 0.35), 0.09, emissivity)
    rod = Chain((leg.stroke + 0.12) / ROD_CELLS, 3.6e6 * bar, 45.0 * bar, 0.09, 0.03, emissivity)
    heat = Heat(
        motor=log_uniform(6.0, 20.0, generator), friction=log_uniform(8.0, 30.0, generator),
        rod_share=generator.uniform(0.2, 0.5), contact=log_uniform(1.0, 6.0, generator),
        nut=leg.retracted_length - leg.stroke - generator.uniform(0.09, 0.12),
    )  # fmt: skip
    return body, rod, heat


def _room(generator: np.random.Generator) -> Room:
    """Return a room."""
    return Room(
        level=generator.uniform(19.0, 24.0),
        swing=generator.uniform(0.2, 1.2),
        coldest=3600.0 * generator.uniform(3.0, 7.0),
        cycle=generator.uniform(0.02, 0.25),
        period=generator.uniform(700.0, 2200.0),
        duty=generator.uniform(0.3, 0.7),
        slow=generator.uniform(0.05, 0.3),
    )


def draw(generator: np.random.Generator) -> CampaignTruth:
    """Make a campaign in which nothing is hidden.

    Parameters
    ----------
    generator : numpy.random.Generator
    """
    leg, level, room = drawn_leg(BASES, generator), _levels(generator), _room(generator)
    body, rod, heat = _leg_and_heat(leg, generator)
    length = SUBSTEP * (SUBSTEPS - 1)
    motions, airs = [], []
    for _day in ROLES:
        first = round(generator.uniform(0.0, leg.stroke), 4)
        motions.append(carried_out(_plan(leg.stroke, generator), first, generator.uniform(120.0, 900.0), length))
        airs.append(room.air(3600.0 * generator.uniform(5.0, 17.0), SUBSTEP, SUBSTEPS, generator))
    going = [motion.speed(SUBSTEP, SUBSTEPS - 1) for motion in motions]
    fastest = max(float(speed.max()) for speed, _place in going)
    warm = np.column_stack([air[:-1, 0] for air in airs])
    start = warm[0] + generator.uniform(-0.2, 0.6, len(ROLES))
    tubes, rods = warmed(body, rod, heat, np.column_stack([speed for speed, _ in going]) / fastest,
                         np.column_stack([place for _, place in going]), warm, start)  # fmt: skip
    spots = np.linspace(0.03, leg.retracted_length - 0.08, BODY) + generator.uniform(-0.008, 0.008, BODY)
    far = np.linspace(0.35, 1.0, ROD) * rod.cell * (ROD_CELLS - 0.5)
    each = round(level["sample_s"] / SUBSTEP)
    runs = []
    for k, (motion, air) in enumerate(zip(motions, airs, strict=True)):
        on_body = _between(tubes[::each, k], body.cell, spots)
        on_rod = _between(rods[::each, k], rod.cell, far)
        runs.append(_run(k, leg, motion, np.column_stack([on_body, on_rod]), air[::each], level, generator))
    names = tuple(f"T{k + 1:02d}" for k in range(BODY + ROD))
    places = np.concatenate([spots, heat.nut + far]).round(4)
    return noted(CampaignTruth(
        "leg", NAME, tuple(runs), names, ("body",) * BODY + ("rod",) * ROD, places,
        tuple(names[k] for k in leg.base), leg.coefficients, leg.retracted_length, (0.0, leg.stroke),
        round(generator.uniform(0.05, 0.4), 3), True, notes=level,
    ))  # fmt: skip


def _between(cells: FloatArray, cell: float, places: Sequence[float] | FloatArray) -> FloatArray:
    """Return temperatures at places of a chain, linear between the middles of its cells, shape (n, s)."""
    at = np.clip(np.asarray(places) / cell - 0.5, 0.0, cells.shape[1] - 1.0)
    low = np.minimum(at.astype(np.int64), cells.shape[1] - 2)
    return np.asarray(cells[:, low] + (at - low) * (cells[:, low + 1] - cells[:, low]))


def _run(
    k: int, leg: Leg, motion: Motion, temperatures: FloatArray, air: FloatArray, level: dict[str, float],
    generator: np.random.Generator,
) -> RunTruth:  # fmt: skip
    """Return one run with the noise of its instruments."""
    rows, step = len(temperatures), level["sample_s"]
    time = step * np.arange(rows, dtype=np.float64)
    q = motion.at(time)
    # noise of rows is even, as that of a counter, of the standard deviation that is stated
    noise = level["white_um"] * generator.uniform(-np.sqrt(3.0), np.sqrt(3.0), rows)
    noise += level["landing_um"] * generator.standard_normal(len(motion.place))[motion.rest(time)]
    if level["slow_um"] > 0.0:
        noise += level["slow_um"] * remembering(level["slow_time_s"] / step, (rows,), generator)
    errors = thermometer_errors(level, temperatures.shape, generator)
    return RunTruth(
        f"run-{k + 1:02d}", ROLES[k], time, q, motion.settled(time, 3.0), temperatures, errors, air,
        np.empty((rows, 0)), leg.drift(temperatures, q), 1e-6 * noise, np.zeros(rows), np.zeros((rows, 3)),
    )  # fmt: skip
