"""A part of a machine tool: a network of lumps, heated by a spindle and perhaps a slow axis; 30 to 60 s, long runs.

``C dT/dt = -G T + g_room T_room + P(t)``: capacities ``C`` [J/K], conductances ``G`` [W/K] between lumps and to the
room, heat ``P`` [W] of the spindle's bearings and motor and of the axis. Scaled by ``sqrt(C)`` the matrix is symmetric;
its eigenvectors follow an exact recursion for sources that are constant within a row. One record runs through the
whole campaign, nights included; its runs are cut from it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.signal import lfilter

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.benches.air import Room
from hexathermal.simulate.hidden.benches.motion import Motion, carried_out
from hexathermal.simulate.hidden.benches.noises import log_uniform, noted, remembering, thermometer_errors
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth

NAME = "component"
INPUT = "spindle_speed_rpm"


@dataclass(frozen=True)
class Instruments:
    """What a part is measured with.

    Attributes
    ----------
    steps : tuple of float [s]
        From row to row, one of them.
    sensor_noise, sensor_walk_6h : (float, float) [K]
        From and to, of the thermometers' scatter from row to row, and of how far they wander in 6 h.
    rounded : float [K]
        The loggers' resolution, of half of them.
    worst : float [K]
        Scatter of one thermometer besides.
    drift_resolution : float [um]
    """

    steps: tuple[float, ...]
    sensor_noise: tuple[float, float]
    sensor_walk_6h: tuple[float, float]
    rounded: float
    worst: float
    drift_resolution: float


COARSE = Instruments((30.0, 45.0, 60.0), (0.02, 0.1), (0.005, 0.03), 0.1, 0.0, 0.1)


@dataclass(frozen=True, eq=False)
class Network:
    """Lumps that conduct heat to each other and to the room.

    Attributes
    ----------
    capacity : array, shape (m,) [J/K]
    conductance : array, shape (m, m) [W/K]
        Between lumps, symmetric, zero on the diagonal.
    to_room : array, shape (m,) [W/K]
    """

    capacity: FloatArray
    conductance: FloatArray
    to_room: FloatArray

    def temperatures(self, heat: FloatArray, room: FloatArray, step: float) -> FloatArray:
        """Return temperatures of lumps [degC], shape (n, m), from a start at the room's temperature.

        Parameters
        ----------
        heat : array, shape (n, m) [W]
            From each row to the next.
        room : array, shape (n,) [degC]
        step : float [s]
        """
        root = np.sqrt(self.capacity)
        whole = np.diag(self.conductance.sum(axis=1) + self.to_room) - self.conductance
        rates, modes = np.linalg.eigh(whole / np.outer(root, root))
        feeding = ((heat + np.outer(room - room[0], self.to_room)) / root) @ modes
        found = np.zeros_like(feeding)
        for k, rate in enumerate(rates):
            kept = np.exp(-rate * step)
            found[1:, k] = lfilter([(1.0 - kept) / rate], [1.0, -kept], feeding[:-1, k])
        return np.asarray(room[0] + (found @ modes.T) / root)


def drawn_network(generator: np.random.Generator) -> Network:
    """Return 6 to 10 lumps: a chain from the spindle's nose to the column's foot, and some contacts across.

    Lumps of 4 to 60 kJ/K are 8 to 130 kg of steel; time constants to the room come out at some minutes to several
    hours.
    """
    count = int(generator.integers(6, 11))
    capacity = np.exp(generator.uniform(np.log(4e3), np.log(6e4), count))
    conductance = np.zeros((count, count))
    for k in range(count - 1):
        conductance[k, k + 1] = log_uniform(3.0, 30.0, generator)
    for _contact in range(count // 2):
        i, j = sorted(generator.choice(count, 2, replace=False))
        conductance[i, j] += log_uniform(0.5, 6.0, generator)
    to_room = np.exp(generator.uniform(np.log(0.7), np.log(7.0), count))
    return Network(capacity, conductance + conductance.T, to_room)


def _speeds(count: int, step: float, generator: np.random.Generator) -> FloatArray:
    """Return the spindle's speed [rpm]: constant for 10 to 60 min, at rest in a third of them."""
    top = generator.choice([6000.0, 10000.0, 15000.0, 24000.0])
    found = np.zeros(count)
    now = int(generator.uniform(300.0, 1200.0) / step)
    while now < count:
        rows = int(generator.uniform(600.0, 3600.0) / step)
        if generator.uniform() > 1.0 / 3.0:
            found[now : now + rows] = np.round(generator.uniform(0.1, 1.0) * top, -2)
        now += rows
    return found


def _strokes(stroke: float, generator: np.random.Generator) -> Iterator[tuple[float, float, float]]:
    """Yield moves of a slow axis: targets anywhere, rests of 5 to 60 min."""
    while True:
        yield round(generator.uniform(0.0, stroke), 4), generator.uniform(1e-3, 5e-3), generator.uniform(300.0, 3600.0)


@dataclass(frozen=True, eq=False)
class Record:
    """The whole campaign as one record of equal steps, and where its runs lie."""

    step: float
    slices: tuple[slice, ...]
    motion: Motion
    speed: FloatArray
    air: FloatArray

    @property
    def time(self) -> FloatArray:
        """Time of each row [s]."""
        return np.arange(len(self.speed), dtype=np.float64) * self.step


def _record(steps: tuple[float, ...], stroke: float, joined: bool, generator: np.random.Generator) -> Record:
    """Return what was done and what the room did; between runs that are not joined, the machine rests."""
    step = float(generator.choice(steps))
    slices, now = [], 0
    for _run in range(int(generator.integers(6, 9))):
        rows = int(generator.uniform(8.0, 16.0) * 3600.0 / step)
        slices.append(slice(now, now + rows))
        now += rows + (0 if joined else int(generator.uniform(6.0, 14.0) * 3600.0 / step))
    now = slices[-1].stop
    speed = _speeds(now, step, generator)
    if not joined:
        for one, other in pairwise(slices):
            speed[one.stop : other.start] = 0.0
    first = round(generator.uniform(0.0, stroke), 4)
    plan = _strokes(stroke, generator) if stroke else iter(())
    room = Room(
        level=generator.uniform(20.0, 25.0),
        swing=generator.uniform(0.5, 2.0),
        coldest=generator.uniform(3.0, 7.0) * 3600.0,
        cycle=generator.uniform(0.1, 0.6),
        period=generator.uniform(900.0, 2400.0),
        duty=generator.uniform(0.25, 0.75),
        slow=generator.uniform(0.1, 0.4),
        pressure=(400.0, 2500.0),
    )
    motion = carried_out(plan, first, 600.0, now * step)
    if not joined:
        # a run begins at rest: its first row is its zero
        rests = motion.settled(np.arange(now, dtype=np.float64) * step, step)
        slices = [slice(part.start + int(rests[part].argmax()), part.stop) for part in slices]
    return Record(step, tuple(slices), motion, speed, room.air(8.0 * 3600.0, step, now, generator))


def _places(network: Network, lumps: FloatArray, room: FloatArray, generator: np.random.Generator) -> FloatArray:
    """Return temperatures under 8 to 16 thermocouples, each between two lumps, one near the air, shape (n, s)."""
    count, sensors = lumps.shape[1], int(generator.integers(8, 17))
    share = np.zeros((count, sensors))
    for k in range(sensors):
        at = k if k < count else int(generator.integers(count))
        near = np.argsort(network.conductance[at])[-2:]
        weight = generator.uniform(0.6, 1.0)
        share[at, k] = weight
        share[generator.choice(near), k] += 1.0 - weight
    found = lumps @ share[:, generator.permutation(sensors)]
    airy = int(generator.integers(sensors))
    found[:, airy] = 0.3 * found[:, airy] + 0.7 * room
    return np.asarray(found)


def _heat(record: Record, count: int, generator: np.random.Generator) -> FloatArray:
    """Return the heat of lumps [W]: bearings and motor with the spindle's speed, a ball screw with the axis's."""
    found = np.zeros((len(record.speed), count))
    turning = record.speed / record.speed.max()
    for lump, power in ((0, 1.0), (1, 2.0), (int(generator.integers(1, count)), 1.5)):
        found[:, lump] += generator.uniform(20.0, 120.0) * turning**power
    axis = record.motion.speed(record.step, len(record.speed))[0]
    found[:, count - 2] += generator.uniform(4e3, 3e4) * axis
    return found


def _base(temperatures: FloatArray, generator: np.random.Generator) -> tuple[tuple[int, ...], FloatArray]:
    """Return one or two thermocouples that warm enough to be a law's, and their C [m/K]."""
    swing = np.ptp(temperatures, axis=0)
    warm = np.flatnonzero(swing >= 0.4 * swing.max())
    base = tuple(sorted(generator.choice(warm, min(len(warm), int(generator.integers(1, 3))), replace=False).tolist()))
    return base, generator.choice([-1.0, 1.0]) * generator.uniform(5e-6, 15e-6, len(base))


def draw(generator: np.random.Generator) -> CampaignTruth:
    """Make a campaign in which nothing is hidden; ``stroke`` is (0, 0) where the part has none.

    Parameters
    ----------
    generator : numpy.random.Generator
    """
    return measured(NAME, COARSE, generator)


def measured(name: str, instruments: Instruments, generator: np.random.Generator) -> CampaignTruth:
    """Make a campaign of a bench in which nothing is hidden, measured with some instruments."""
    joined = bool(generator.integers(2))
    stroke = float(generator.integers(2)) * round(generator.uniform(0.2, 0.6), 3)
    record, network = _record(instruments.steps, stroke, joined, generator), drawn_network(generator)
    count = len(network.capacity)
    room = record.air[:, 0]
    still = network.temperatures(np.zeros((room.size, count)), room, record.step)
    warmed = network.temperatures(_heat(record, count, generator), room, record.step) - still
    lumps = still + warmed * (generator.uniform(3.0, 10.0) / warmed.max())
    temperatures = _places(network, lumps, room, generator)
    base, coefficients = _base(temperatures, generator)
    level = {
        "white_um": log_uniform(0.05, 0.3, generator),
        "landing_um": 0.0,
        "slow_um": log_uniform(0.1, 0.5, generator),
        "slow_time_s": generator.uniform(3600.0, 7200.0),
        "sensor_noise_K": log_uniform(*instruments.sensor_noise, generator),
        "sensor_bias_K": 0.03,
        "sensor_walk_6h_K": log_uniform(*instruments.sensor_walk_6h, generator),
        "sample_s": record.step,
        "drift_resolution_um": instruments.drift_resolution,
        "temperature_resolution_K": instruments.rounded * float(generator.integers(2)),
        "worst_sensor_noise_K": instruments.worst,
    }
    runs = _runs(record, temperatures, temperatures[:, base], coefficients, joined, level, generator)
    names = tuple(f"T{k + 1:02d}" for k in range(temperatures.shape[1]))
    return noted(CampaignTruth(
        "component", name, runs, names, ("",) * len(names), np.full(len(names), np.nan),
        tuple(names[k] for k in base), coefficients, 0.0, (0.0, stroke), 0.0, True, (INPUT,),
        "campaign" if joined else "run", level,
    ))  # fmt: skip


def _runs(
    record: Record,
    temperatures: FloatArray,
    base: FloatArray,
    coefficients: FloatArray,
    joined: bool,
    level: dict[str, float],
    generator: np.random.Generator,
) -> tuple[RunTruth, ...]:
    """Return the runs that are cut from the record, the last two for validation, with noise and rounding."""
    rows, sensors = temperatures.shape
    errors = thermometer_errors(level, (rows, sensors), generator)
    if level["worst_sensor_noise_K"]:
        errors[:, generator.integers(sensors)] += level["worst_sensor_noise_K"] * generator.standard_normal(rows)
    resolution = level["temperature_resolution_K"]
    if resolution:
        errors[:] = np.round((temperatures + errors) / resolution) * resolution - temperatures
    finest = 1e-6 * level["drift_resolution_um"]
    noise = generator.standard_normal((rows,)) * (1e-6 * level["white_um"])
    noise += remembering(level["slow_time_s"] / record.step, (rows,), generator) * (1e-6 * level["slow_um"])
    time, q = record.time, record.motion.at(record.time)
    settled = record.motion.settled(record.time, record.step)
    found = []
    for k, part in enumerate(record.slices):
        zero = record.slices[0].start if joined else part.start
        drift = np.asarray((base[part] - base[zero]) @ coefficients)
        count = drift.size
        role = "identification" if k < len(record.slices) - 2 else "validation"
        rounded = np.round((drift + noise[part]) / finest) * finest - drift
        begin = 0.0 if joined else time[part.start]
        found.append(RunTruth(
            f"run-{k + 1:02d}", role, time[part] - begin, q[part], settled[part], temperatures[part], errors[part],
            record.air[part], record.speed[part, None], drift, rounded, np.zeros(count), np.zeros((count, 3)),
        ))  # fmt: skip
    return tuple(found)
