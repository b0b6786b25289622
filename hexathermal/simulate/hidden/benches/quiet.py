"""A leg in a laboratory with almost no noise: 5 s, 8 runs of 3 h, full strokes to drawn targets, long rests.

Every thermocouple answers every source of heat like a chain of thermal resistances and capacities (a Foster network),

``T_s(t) = T_room,s(t) + sum_j K_j sum_m w_sjm (P_j * exp(-t / tau_m) / tau_m)(t)``,  ``w_sjm ~ exp(-d_sj / delta_m)``,

with the distance ``d`` between them and the depth ``delta_m = sqrt(D tau_m)`` that heat reaches within ``tau_m``: near
a source answers come fast and slow, far from it slow and small. Sources: the motor, the nut's heat in zones of the
body, and in the rod's end.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.signal import lfilter

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.benches.air import Room
from hexathermal.simulate.hidden.benches.legs import Leg, drawn_leg
from hexathermal.simulate.hidden.benches.motion import Motion, carried_out
from hexathermal.simulate.hidden.benches.noises import log_uniform, noted
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth

NAME = "quiet"

STEP = 5.0
ROWS = 2161
TIME: FloatArray = STEP * np.arange(ROWS, dtype=np.float64)
ROLES = ("identification",) * 6 + ("validation",) * 2
BODY, ROD, ZONES = 8, 4, 4
BASES = ((3,), (4,), (2, 9), (3, 10))
TIMES = (240.0, 900.0, 2700.0, 7200.0)
"""Time constants ``tau_m`` [s] of the network."""

WHITE_UM = 0.02


def lagged(source: FloatArray, time_constant: float, first: float = 0.0) -> FloatArray:
    """Return a source passed through a first-order lag of unit gain, exact for values constant within a row."""
    kept = np.exp(-STEP / time_constant)
    return first + np.asarray(lfilter([0.0, 1.0 - kept], [1.0, -kept], source - first, axis=0))


def _plan(stroke: float, speed: float, generator: np.random.Generator) -> Iterator[tuple[float, float, float]]:
    """Yield full strokes to drawn targets: some alone, some in rows of up to 8, with rests of 4 to 25 min."""
    while True:
        for _stroke in range(generator.integers(0, 8)):
            yield round(generator.uniform(0.0, stroke), 5), speed, generator.uniform(1.0, 4.0)
        yield round(generator.uniform(0.0, stroke), 5), speed, log_uniform(240.0, 1500.0, generator)


def _sources(leg: Leg, motion: Motion) -> FloatArray:
    """Return heat of the motor, of the zones of the body, and of the rod's end, shape (n, 2 + ZONES)."""
    speed, place = motion.speed(1.0, ROWS * int(STEP))
    zones = np.linspace(0.0, leg.stroke, ZONES)
    hats = np.maximum(0.0, 1.0 - np.abs(place[:, None] - zones) / (zones[1] - zones[0]))
    motor = (speed > 0.0).astype(np.float64)
    whole = np.column_stack([motor, speed[:, None] * hats, speed])
    return np.asarray(whole.reshape(ROWS, int(STEP), -1).mean(axis=1))


def _weights(leg: Leg, places: FloatArray, nut: float, diffusivity: float) -> FloatArray:
    """Return ``w_sjm``, shape (len(TIMES), 2 + ZONES, sensors)."""
    at = np.concatenate([[0.0], nut + np.linspace(0.0, leg.stroke, ZONES), [nut]])
    distance = np.abs(at[:, None] - places)
    # heat of the rod's end reaches the body by the nut's zones; the body's reaches the rod through the guide
    distance[-1, :BODY] = np.inf
    distance[:-1, BODY:] += 0.08
    depth = np.sqrt(diffusivity * np.array(TIMES))
    share = np.array([0.1, 0.2, 0.3, 0.4])
    return np.asarray(share[:, None, None] * np.exp(-distance / depth[:, None, None]))


def draw(generator: np.random.Generator) -> CampaignTruth:
    """Make a campaign in which nothing is hidden.

    Parameters
    ----------
    generator : numpy.random.Generator
    """
    leg = drawn_leg(BASES, generator)
    nut = leg.retracted_length - leg.stroke - 0.08
    body = np.linspace(0.025, leg.retracted_length - 0.07, BODY).round(4)
    places = np.concatenate([body, leg.retracted_length - np.array([0.045, 0.033, 0.021, 0.009])])
    weights = _weights(leg, places, nut, log_uniform(3e-6, 1.2e-5, generator))
    room = Room(
        level=20.0,
        swing=generator.uniform(0.1, 0.5),
        coldest=6.0 * 3600.0,
        cycle=generator.uniform(0.01, 0.05),
        period=generator.uniform(900.0, 2000.0),
        duty=0.5,
        slow=generator.uniform(0.05, 0.2),
        slow_time=7200.0,
    )
    slow = generator.uniform(1500.0, 5000.0, BODY + ROD)
    quick = generator.uniform(0.1, 0.4)
    speed = log_uniform(2e-3, 6e-3, generator)
    motions, airs, answers = [], [], []
    for day in range(len(ROLES)):
        first = round(generator.uniform(0.0, leg.stroke), 4)
        motion = carried_out(_plan(leg.stroke, speed, generator), first, generator.uniform(300.0, 900.0), TIME[-1])
        air = room.air(86400.0 * day + 3600.0 * generator.uniform(7.0, 18.0), STEP, ROWS, generator)
        sources = _sources(leg, motion)
        warmth = np.stack([lagged(sources, tau) for tau in TIMES])
        answers.append([
            np.einsum("mnj,mjs->ns", warmth[:, :, :1], weights[:, :1]),
            np.einsum("mnj,mjs->ns", warmth[:, :, 1:], weights[:, 1:]),
        ])  # fmt: skip
        motions.append(motion)
        airs.append(air)
    largest = np.max([[part[:, :BODY].max() for part in answer] for answer in answers], axis=0)
    heat = np.array([generator.uniform(1.5, 5.0), generator.uniform(1.5, 5.0)]) / largest
    runs = []
    for k, (motion, air, answer) in enumerate(zip(motions, airs, answers, strict=True)):
        start = air[0, 0] + 0.1 * generator.standard_normal()
        near = np.column_stack([lagged(air[:, 0], tau, start) for tau in slow])
        around = quick * lagged(air[:, 0], 300.0, start)[:, None] + (1.0 - quick) * near
        temperatures = around + heat[0] * answer[0] + heat[1] * answer[1]
        runs.append(_run(k, leg, motion, temperatures, air, generator))
    names = tuple(f"T{k + 1:02d}" for k in range(BODY + ROD))
    level = {"white_um": WHITE_UM, "landing_um": 0.0, "slow_um": 0.0, "slow_time_s": 0.0, "sensor_noise_K": 0.0,
             "sensor_bias_K": 0.0, "sensor_walk_6h_K": 0.0, "sample_s": STEP, "drift_resolution_um": 0.0,
             "temperature_resolution_K": 1e-5}  # fmt: skip
    return noted(CampaignTruth(
        "leg", NAME, tuple(runs), names, ("body",) * BODY + ("rod",) * ROD, places,
        tuple(names[k] for k in leg.base), leg.coefficients, leg.retracted_length, (0.0, leg.stroke),
        round(generator.uniform(0.05, 0.3), 3), True, notes=level,
    ))  # fmt: skip


def _run(
    k: int, leg: Leg, motion: Motion, temperatures: FloatArray, air: FloatArray, generator: np.random.Generator
) -> RunTruth:
    """Return one run; only the displacement has noise."""
    q = motion.at(TIME)
    noise = 1e-6 * WHITE_UM * generator.standard_normal((ROWS,))
    return RunTruth(
        f"run-{k + 1:02d}", ROLES[k], TIME.copy(), q, motion.settled(TIME, 3.0), temperatures,
        np.zeros_like(temperatures), air, np.empty((ROWS, 0)), leg.drift(temperatures, q), noise, np.zeros(ROWS),
        np.zeros((ROWS, 3)),
    )  # fmt: skip
