"""A leg in a workshop with poor instruments: 60 s, 11 runs of 8 h, heavy tails, spikes, wandering thermometers, gaps.

Heat spreads from where it enters as from an instant source in a bar with insulated ends and losses at its side: the
kernel, with images in the ends (Carslaw and Jaeger, Conduction of Heat in Solids, sections 10.3 and 10.10),

``G(x, x', t) = exp(-beta t) / sqrt(4 pi D t) sum_i exp(-(x - x'_i)^2 / (4 D t))``,  ``x'_i = 2 i l +- x'``,

is convolved with the heat of the motor and of the nut, whose way along the body is cut into pieces.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields

import numpy as np
import numpy.typing as npt
from scipy.signal import fftconvolve, lfilter

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.benches.air import Room
from hexathermal.simulate.hidden.benches.legs import Leg, drawn_leg
from hexathermal.simulate.hidden.benches.motion import Motion, carried_out
from hexathermal.simulate.hidden.benches.noises import log_uniform, noted, remembering
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth

NAME = "rough"

STEP = 60.0
ROWS = 481
TIME: FloatArray = STEP * np.arange(ROWS, dtype=np.float64)
ROLES = ("identification",) * 8 + ("validation",) * 3
BODY, ROD, PIECES = 13, 4, 10
BASES = ((4,), (6,), (8,), (4, 13), (6, 14), (2, 11))
WIDTH = 0.035
"""Width [m] over which heat enters; ``G`` starts as a bell of this width."""

FADED = 6.0 * 3600.0
"""Correlation time [s] of the thermometers' errors that wander."""


def kernel(places: FloatArray, sources: FloatArray, length: float, diffusivity: float, loss: float) -> FloatArray:
    """Return the rise at places, k rows after one row of heat at sources, shape (n, sources, places) [1/m].

    Parameters
    ----------
    places, sources : array [m]
        In a bar of `length` [m].
    diffusivity : float [m^2/s]
    loss : float [1/s]
    """
    # heat enters during the row before: its age is half a row at the first
    age = (TIME + 0.5 * STEP)[:, None, None]
    spread = 2.0 * (2.0 * diffusivity * age + WIDTH**2)
    total = np.zeros((ROWS, len(sources), len(places)))
    for image in range(-2, 3):
        for sign in (1.0, -1.0):
            total += np.exp(-((places - (2.0 * image * length + sign * sources)[:, None]) ** 2) / spread)
    return np.asarray(total * np.exp(-loss * age) / np.sqrt(np.pi * spread))


def heated(heat: FloatArray, answers: FloatArray) -> FloatArray:
    """Return the sum of all sources' answers at the rows, shape (n, places); heat of a row is felt at the next."""
    whole = fftconvolve(heat[:, :, None], answers, axes=0)[: ROWS - 1].sum(axis=1)
    return np.concatenate([np.zeros((1, answers.shape[2])), whole])


def _plan(stroke: float, first: float, generator: np.random.Generator) -> Iterator[tuple[float, float, float]]:
    """Yield moves: a random walk in steps of 5 to 40 mm held within the stroke, busy and idle hours."""
    now = first
    while True:
        pause = log_uniform(30.0, 400.0, generator)
        for _move in range(generator.integers(5, 40)):
            now += generator.choice([-1.0, 1.0]) * generator.choice([0.005, 0.010, 0.020, 0.040])
            # reflected at the ends of the stroke
            now = round(stroke - abs(stroke - abs(now)), 6)
            yield now, 2e-3, pause * generator.uniform(0.5, 2.0)
        yield now + (1e-3 if now < 0.5 * stroke else -1e-3), 2e-3, log_uniform(300.0, 3600.0, generator)


def _room(generator: np.random.Generator) -> Room:
    """Return a workshop's air."""
    return Room(
        level=generator.uniform(18.0, 25.0),
        swing=generator.uniform(0.8, 2.5),
        coldest=generator.uniform(4.0, 7.0) * 3600.0,
        cycle=generator.uniform(0.1, 0.5),
        period=generator.uniform(1200.0, 3000.0),
        duty=generator.uniform(0.3, 0.7),
        slow=generator.uniform(0.1, 0.5),
    )


def _heat(leg: Leg, motion: Motion) -> tuple[FloatArray, FloatArray]:
    """Return the motor's heat, shape (n, 1), and the nut's in pieces of its way, shape (n, PIECES)."""
    per_row = 20
    speed, place = motion.speed(STEP / per_row, ROWS * per_row)
    piece = np.minimum((place / leg.stroke * PIECES).astype(np.int64), PIECES - 1)
    nut = np.zeros((ROWS, PIECES))
    np.add.at(nut, (np.arange(speed.size) // per_row, piece), speed / per_row)
    return 0.15 + (speed > 0.0).reshape(ROWS, per_row).mean(axis=1)[:, None], nut


def _surroundings(air: FloatArray, loss: float, start: float, slopes: FloatArray) -> FloatArray:
    """Return what the room alone would make of the thermocouples' places, shape (n, s) [degC]."""
    rates = loss * slopes
    found = np.empty((ROWS, slopes.size))
    for k, rate in enumerate(rates):
        kept = np.exp(-rate * STEP)
        found[:, k] = start + lfilter([0.0, 1.0 - kept], [1.0, -kept], air - start)
    return found


def draw(generator: np.random.Generator) -> CampaignTruth:
    """Make a campaign in which nothing is hidden.

    Parameters
    ----------
    generator : numpy.random.Generator
    """
    leg, room = drawn_leg(BASES, generator), _room(generator)
    nut = leg.retracted_length - leg.stroke - 0.07
    length = leg.retracted_length - 0.04
    diffusivity, loss = log_uniform(3e-6, 1.2e-5, generator), 1.0 / generator.uniform(3000.0, 7000.0)
    spacing = (length - 0.04) / BODY
    body = (0.02 + spacing * (np.arange(BODY) + generator.uniform(0.1, 0.9, BODY))).round(4)
    rod = (leg.retracted_length - nut - np.array([0.035, 0.026, 0.017, 0.008])).round(4)
    pieces = nut + leg.stroke * (np.arange(PIECES) + 0.5) / PIECES
    of_motor = kernel(body, np.array([0.0]), length, diffusivity, loss)
    of_nut = kernel(body, pieces, length, diffusivity, loss)
    in_rod = kernel(rod, np.array([0.0]), leg.retracted_length - nut, 1.2e-5, loss)
    slopes = generator.uniform(0.8, 1.3, BODY + ROD)
    motions, airs, answers = [], [], []
    for day in range(len(ROLES)):
        first = round(generator.uniform(0.0, leg.stroke), 4)
        motion = carried_out(_plan(leg.stroke, first, generator), first, generator.uniform(300.0, 1200.0), TIME[-1])
        motor, friction = _heat(leg, motion)
        rods = 0.5 * heated(friction.sum(axis=1, keepdims=True), in_rod)
        motions.append(motion)
        airs.append(room.air(86400.0 * day + 3600.0 * generator.uniform(6.0, 14.0), STEP, ROWS, generator))
        answers.append((heated(motor, of_motor), np.column_stack([heated(friction, of_nut), rods])))
    powers = [
        generator.uniform(2.0, 7.0) / max(float(answer[k][:, :BODY].max()) for answer in answers) for k in range(2)
    ]
    level = _level(generator)
    noisy = int(generator.choice([k for k in range(BODY + ROD) if k not in leg.base]))
    runs, usual = [], []
    for k, (motion, air, (motor_rise, rise)) in enumerate(zip(motions, airs, answers, strict=True)):
        temperatures = _surroundings(air[:, 0], loss, air[0, 0] + generator.normal(0.0, 0.2), slopes)
        temperatures[:, :BODY] += powers[0] * motor_rise
        # the body warms the rod through the guide, late and in part
        late = lfilter([0.0, 0.03], [1.0, -0.97], motor_rise[:, -3:].mean(axis=1))
        temperatures[:, BODY:] += 0.5 * powers[0] * late[:, None]
        temperatures += powers[1] * rise
        run, fair = _recorded(_run(k, leg, motion, temperatures, air, noisy, level, generator), generator)
        runs.append(run)
        usual.append(fair)
    names = tuple(f"T{k + 1:02d}" for k in range(BODY + ROD))
    return noted(CampaignTruth(
        "leg", NAME, tuple(runs), names, ("body",) * BODY + ("rod",) * ROD, np.concatenate([body, nut + rod]),
        tuple(names[k] for k in leg.base), leg.coefficients, leg.retracted_length, (0.0, leg.stroke),
        round(generator.uniform(0.1, 0.6), 3), True, notes={**level, "noisy_sensor": names[noisy]},
    ), usual)  # fmt: skip


def _level(generator: np.random.Generator) -> dict[str, float]:
    """Return the levels of noise."""
    return {
        "white_um": log_uniform(0.03, 0.10, generator),
        "landing_um": log_uniform(0.08, 0.25, generator),
        "slow_um": 0.1,
        "slow_time_s": 3600.0,
        "sensor_noise_K": log_uniform(0.02, 0.06, generator),
        "sensor_bias_K": 0.1,
        "sensor_walk_6h_K": 0.1,
        "noisy_sensor_K": generator.uniform(0.1, 0.3),
        "sample_s": STEP,
        "drift_resolution_um": 0.0,
        "temperature_resolution_K": 0.01,
    }


def _run(
    k: int,
    leg: Leg,
    motion: Motion,
    temperatures: FloatArray,
    air: FloatArray,
    noisy: int,
    level: dict[str, float],
    generator: np.random.Generator,
) -> RunTruth:
    """Return one run with its instruments' usual noise, every row of it."""
    q, shape = motion.at(TIME), temperatures.shape
    errors = level["sensor_noise_K"] * generator.standard_normal(shape)
    errors[:, noisy] += level["noisy_sensor_K"] * generator.standard_normal((ROWS,))
    errors += level["sensor_bias_K"] * remembering(FADED / STEP, shape, generator)
    # Student's t with 3 degrees of freedom, scaled to unit variance
    scatter = level["landing_um"] * generator.standard_t(3.0, len(motion.place)) / np.sqrt(3.0)
    noise = level["white_um"] * generator.standard_normal((ROWS,)) + scatter[motion.rest(TIME)]
    noise = noise + level["slow_um"] * remembering(level["slow_time_s"] / STEP, (ROWS,), generator)
    return RunTruth(
        f"run-{k + 1:02d}", ROLES[k], TIME.copy(), q, motion.settled(TIME, 8.0), temperatures, errors, air,
        np.empty((ROWS, 0)), leg.drift(temperatures, q), 1e-6 * noise, np.zeros(ROWS), np.zeros((ROWS, 3)),
    )  # fmt: skip


def _recorded(run: RunTruth, generator: np.random.Generator) -> tuple[RunTruth, npt.NDArray[np.bool_]]:
    """Return a run with spikes, readings rounded to 0.01 K and rows missing, and its rows without a spike of drift."""
    noise, errors = run.noise.copy(), run.sensor_errors.copy()
    spiked = np.zeros(ROWS, dtype=bool)
    spiked[generator.integers(5, ROWS, generator.integers(0, 4))] = True
    noise[spiked] += generator.choice([-1e-6, 1e-6], spiked.sum()) * np.exp(generator.uniform(1.0, 3.5, spiked.sum()))
    for _spike in range(generator.integers(0, 6)):
        errors[generator.integers(5, ROWS), generator.integers(BODY + ROD)] += generator.choice([-1.0, 1.0]) * (
            log_uniform(1.0, 8.0, generator)
        )
    errors = np.round(run.temperatures + errors, 2) - run.temperatures
    kept = generator.uniform(size=ROWS) > 0.004
    for _gap in range(generator.integers(0, 3)):
        begin = int(generator.integers(10, ROWS - 20))
        kept[begin : begin + int(generator.integers(2, 12))] = False
    kept[0] = True
    whole = run.changed(noise=noise, sensor_errors=errors)
    cut = {item.name: getattr(whole, item.name)[kept] for item in fields(whole) if item.name not in ("name", "role")}
    return whole.changed(**cut), ~spiked[kept]
