"""A leg whose thermocouples answer by transfer functions with dead time: 10 to 20 s, 11 runs of 4 to 6 h, long rests.

Every thermocouple answers the motor, the nut and the room each by a rational transfer function of a few real poles and
one zero, behind a dead time (Ljung, System Identification, chapter 4; first order with dead time is its simplest),

``G(s) = K exp(-theta s) (1 + zeta s) / prod_m (1 + tau_m s)``,

whose dead time grows with the distance from where the heat enters, and whose recursion for a source that is constant
from row to row is exact, dead times within a row included (Astrom and Wittenmark, Computer-Controlled Systems,
section 2.3). The nut passes the thermocouples of the body: its heat counts the less for one the farther away it is.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.benches.legs import Leg
from hexathermal.simulate.hidden.benches.motion import Motion, carried_out
from hexathermal.simulate.hidden.benches.noises import log_uniform, noted, remembering, thermometer_errors, walk
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth

NAME = "held_out"

HOUR = 3600.0
ROLES = ("identification",) * 8 + ("validation",) * 3
BODY, ROD = 12, 5
BASES = range(2, 11)
PER_ROW = 10
"""Moments within a row at which speed and place are taken."""

SETTLING = 3.0
"""A row is settled so long [s] after a move."""

SPREAD = (1.0 / 6.0, 1.0, 6.0)
"""Correlation times of the three processes whose sum is the slow noise, over the middle one."""


@dataclass(frozen=True)
class Transfer:
    """A transfer function of unit gain with real poles, one zero and a dead time.

    Attributes
    ----------
    times : tuple of float [s]
        ``tau_m``, all different, at least two.
    zero : float [s]
        ``zeta``.
    delay : float [s]
        ``theta``.
    """

    times: tuple[float, ...]
    zero: float
    delay: float

    @property
    def weights(self) -> FloatArray:
        """Parts ``c_m`` of the poles: a unit step is answered by ``1 - sum_m c_m exp(-(t - theta) / tau_m)``."""
        tau = np.array(self.times)
        apart = tau[:, None] - tau + np.eye(tau.size)
        return np.asarray(tau ** (tau.size - 2) * (tau - self.zero) / apart.prod(axis=1))

    def answer(self, source: FloatArray, step: float) -> FloatArray:
        """Return the answer at the rows to a source that is constant from each row to the next, and 0 before.

        Parameters
        ----------
        source : array, shape (n,)
        step : float [s]
        """
        rows, part = divmod(self.delay / step, 1.0)
        whole = np.concatenate([np.zeros(int(rows)), source])[: source.size]
        found = np.zeros(source.size)
        for tau, weight in zip(self.times, self.weights, strict=True):
            kept, late = np.exp(-step / tau), np.exp(-(1.0 - part) * step / tau)
            found += weight * lfilter([0.0, 1.0 - late, late - kept], [1.0, -kept], whole)
        return found


@dataclass(frozen=True, eq=False)
class Stations:
    """Where thermocouples sit, and how they answer.

    Attributes
    ----------
    places : array, shape (17,) [m]
        From the lower joint, rod retracted.
    nut : float [m]
        Where the nut's heat enters the body, rod retracted.
    reach : (float, float) [m]
        Within which the motor's and the nut's heat falls to 1/e.
    motor, friction, room : tuple of Transfer
        Of each thermocouple.
    """

    places: FloatArray
    nut: float
    reach: tuple[float, float]
    motor: tuple[Transfer, ...]
    friction: tuple[Transfer, ...]
    room: tuple[Transfer, ...]

    def rises(self, motion: Motion, rows: int, step: float) -> FloatArray:
        """Return the answers to unit motor heat and to unit friction, shape (2, n, 17)."""
        speed, place = motion.speed(step / PER_ROW, rows * PER_ROW)
        running = 0.2 + 0.8 * (speed > 0.0).reshape(rows, PER_ROW).mean(axis=1)
        found = np.empty((2, rows, BODY + ROD))
        for k, x in enumerate(self.places):
            found[0, :, k] = np.exp(-x / self.reach[0]) * self.motor[k].answer(running, step)
            # the rod carries its thermocouples along: for them the nut stays where it is
            away = np.abs(x - self.nut - (place if k < BODY else 0.0))
            heat = (speed * np.exp(-away / self.reach[1])).reshape(rows, PER_ROW).mean(axis=1)
            found[1, :, k] = self.friction[k].answer(heat, step)
        return found

    def surroundings(self, air: FloatArray, leftover: float, step: float) -> FloatArray:
        """Return what the room, and heat left over from before, make of the thermocouples, shape (n, 17) [degC]."""
        time = step * np.arange(air.size)
        found = np.empty((air.size, BODY + ROD))
        for k, x in enumerate(self.places):
            left = leftover * np.exp(-x / self.reach[0]) * np.exp(-time / max(self.room[k].times))
            found[:, k] = air[0] + self.room[k].answer(air - air[0], step) + left
        return found


def _stations(leg: Leg, generator: np.random.Generator) -> Stations:
    """Return thermocouples of a leg; poles of one cause lie far from each other."""
    body = np.linspace(0.03, leg.retracted_length - 0.075, BODY) + generator.uniform(-0.006, 0.006, BODY)
    rod = leg.retracted_length - np.array([0.052, 0.042, 0.031, 0.021, 0.010])
    places = np.concatenate([body, rod]).round(4)
    nut = leg.retracted_length - leg.stroke - generator.uniform(0.07, 0.10)
    slowness = generator.uniform(300.0, 900.0)
    quick, middle, slow = (generator.uniform(*edges) for edges in ((60.0, 240.0), (500.0, 1000.0), (2800.0, 6000.0)))
    lag = generator.uniform(300.0, 900.0)
    motor, friction, room = [], [], []
    for k, x in enumerate(places):
        far = abs(x - nut - (0.5 * leg.stroke if k < BODY else 0.0))
        own = slow * generator.uniform(0.9, 1.1) * (1.0 if k < BODY else 0.8)
        motor.append(Transfer((lag / 3.0, middle * (1.0 + x / 0.5), own), 0.5 * lag / 3.0, slowness * x))
        friction.append(Transfer((quick, middle * (1.0 + far / 0.5), own), 0.2 * middle, 0.7 * slowness * far))
        room.append(Transfer((quick, own), own * generator.uniform(0.1, 0.3), generator.uniform(0.0, 30.0)))
    reach = (generator.uniform(0.15, 0.35), generator.uniform(0.06, 0.15))
    return Stations(places, nut, reach, tuple(motor), tuple(friction), tuple(room))


def _drawn_leg(generator: np.random.Generator) -> Leg:
    """Return a leg with a law of one thermocouple."""
    length = generator.uniform(0.400, 0.650)
    stroke = generator.uniform(0.180, min(0.280, length - 0.180))
    A, B = log_uniform(1e-6, 3e-6, generator), log_uniform(0.5e-6, 2e-6, generator)
    return Leg(round(length, 4), round(stroke, 4), (int(generator.choice(BASES)),), np.array([A, B]))


@dataclass(frozen=True)
class Weather:
    """A room that is warmed by the sun, slowly, and by people, from when they come until they leave.

    Attributes
    ----------
    level, sun, people : float [degC], [K], [K]
    noon : float [s]
        Time of day when the sun warms most.
    come, leave, slow : float [s]
        Working hours, and the room's own time constant.
    dew : float [degC]
        Dew point.
    """

    level: float
    sun: float
    people: float
    noon: float
    come: float
    leave: float
    slow: float
    dew: float

    def air(self, begin: float, step: float, rows: int, generator: np.random.Generator) -> FloatArray:
        """Return temperature [degC], pressure [Pa] and relative humidity [1], shape (n, 3); `begin` [s] of the day."""
        time = begin + step * np.arange(rows)
        turn = 2.0 * np.pi * (time - self.noon) / 86400.0
        # mornings warm faster than evenings cool
        warm = self.level + self.sun * np.cos(turn - 0.5 * np.sin(turn + 0.8))
        came = -np.expm1(-np.maximum(time - self.come, 0.0) / self.slow)
        left = -np.expm1(-np.maximum(time - self.leave, 0.0) / self.slow)
        warm = warm + self.people * (came - left)
        for opened in generator.uniform(begin, time[-1], generator.poisson(3.0)):
            since = np.maximum(time - opened, 0.0)
            warm -= generator.uniform(0.05, 0.4) * since / 300.0 * np.exp(1.0 - since / 300.0)
        warm = warm + generator.uniform(0.02, 0.08) * remembering(2400.0 / step, (rows,), generator)
        pressure = generator.uniform(98500.0, 102500.0) + generator.uniform(30.0, 90.0) * walk(
            HOUR / step, (rows,), generator
        )
        for passes in generator.uniform(begin, time[-1], generator.poisson(0.7)):
            height = generator.choice([-1.0, 1.0]) * log_uniform(80.0, 600.0, generator)
            pressure += 0.5 * height * np.tanh((time - passes) / generator.uniform(900.0, 3600.0))
        dew = self.dew + 0.3 * walk(HOUR / step, (rows,), generator)
        return np.column_stack([warm, pressure, _vapour(dew) / _vapour(warm)])


def _vapour(temperature: FloatArray) -> FloatArray:
    """Return the pressure of saturated vapour [Pa] at a temperature [degC], by Magnus' formula (WMO coefficients)."""
    return np.asarray(611.2 * np.exp(17.62 * temperature / (243.12 + temperature)))


def _weather(generator: np.random.Generator) -> Weather:
    """Return a room."""
    return Weather(
        level=generator.uniform(19.0, 23.0),
        sun=generator.uniform(0.1, 0.8),
        people=generator.uniform(0.1, 0.8),
        noon=HOUR * generator.uniform(13.0, 16.0),
        come=HOUR * generator.uniform(6.5, 9.0),
        leave=HOUR * generator.uniform(15.5, 19.0),
        slow=generator.uniform(1500.0, 5400.0),
        dew=generator.uniform(3.0, 11.0),
    )


def _plan(stroke: float, first: float, generator: np.random.Generator) -> Iterator[tuple[float, float, float]]:
    """Yield blocks of moves, of 10 mm or longer, each with its usual pause; behind some an hour's rest."""
    now, sign = first, 1.0
    while True:
        speed, pause = log_uniform(1e-3, 6e-3, generator), log_uniform(5.0, 1200.0, generator)
        short = generator.uniform() < 0.55
        left = log_uniform(600.0, 4500.0, generator)
        while left > 0.0:
            before, rest = now, float(np.clip(pause * generator.uniform(0.6, 1.6), 5.0, 1200.0))
            if short:
                sign = sign if 0.0 <= now + 0.010 * sign <= stroke else -sign
                now = round(now + 0.010 * sign, 6)
            else:
                now = round(generator.uniform(0.0, stroke), 4)
            left -= rest + abs(now - before) / speed
            yield now, speed, rest
        if generator.uniform() < 0.3:
            now = round(generator.uniform(0.0, stroke), 4)
            yield now, speed, generator.uniform(0.85, 1.15) * HOUR


def _levels(generator: np.random.Generator) -> dict[str, float]:
    """Return levels of noise; slow noise in half of all campaigns."""
    slow = generator.uniform() < 0.5
    return {
        "white_um": log_uniform(0.02, 0.10, generator),
        "landing_um": log_uniform(0.05, 0.25, generator),
        "slow_um": log_uniform(0.02, 0.06, generator) if slow else 0.0,
        "slow_time_s": log_uniform(900.0, 2700.0, generator) if slow else 0.0,
        "sensor_noise_K": log_uniform(0.01, 0.06, generator),
        "sensor_bias_K": log_uniform(0.03, 0.2, generator),
        # 20 to 50 mK over a run, be it of 4 h or of 6 h
        "sensor_walk_6h_K": log_uniform(0.0245, 0.05, generator),
        "sample_s": float(generator.integers(10, 21)),
        "drift_resolution_um": 0.0,
        "temperature_resolution_K": 0.0,
    }


def draw(generator: np.random.Generator) -> CampaignTruth:
    """Make a campaign in which nothing is hidden.

    Parameters
    ----------
    generator : numpy.random.Generator
    """
    leg, weather, level = _drawn_leg(generator), _weather(generator), _levels(generator)
    stations, step = _stations(leg, generator), level["sample_s"]
    motions, airs, answers = [], [], []
    for _day in range(len(ROLES)):
        rows = int(generator.uniform(4.0, 6.0) * HOUR / step)
        first = round(generator.uniform(0.0, leg.stroke), 4)
        plan = _plan(leg.stroke, first, generator)
        motions.append(carried_out(plan, first, generator.uniform(120.0, 900.0), step * (rows - 1)))
        airs.append(weather.air(HOUR * generator.uniform(5.0, 16.0), step, rows, generator))
        answers.append(stations.rises(motions[-1], rows, step))
    largest = np.max([answer[:, :, :BODY].max(axis=(1, 2)) for answer in answers], axis=0)
    heat = np.array([generator.uniform(2.0, 6.0), generator.uniform(1.5, 5.0)]) / largest
    bias = level["sensor_bias_K"] * generator.standard_normal(BODY + ROD)
    runs = []
    for k, (motion, air, answer) in enumerate(zip(motions, airs, answers, strict=True)):
        temperatures = stations.surroundings(air[:, 0], generator.uniform(-0.2, 0.5), step)
        temperatures += np.einsum("c,cns->ns", heat, answer)
        runs.append(_run(k, leg, motion, temperatures, air, bias, level, generator))
    names = tuple(f"T{k + 1:02d}" for k in range(BODY + ROD))
    return noted(CampaignTruth(
        "leg", NAME, tuple(runs), names, ("body",) * BODY + ("rod",) * ROD, stations.places,
        tuple(names[k] for k in leg.base), leg.coefficients, leg.retracted_length, (0.0, leg.stroke),
        round(generator.uniform(0.1, 0.5), 3), True, notes=level,
    ))  # fmt: skip


def _run(
    k: int,
    leg: Leg,
    motion: Motion,
    temperatures: FloatArray,
    air: FloatArray,
    bias: FloatArray,
    level: dict[str, float],
    generator: np.random.Generator,
) -> RunTruth:
    """Return one run with the noise of its instruments; `bias` [K] of the thermometers is the same in all."""
    rows = len(temperatures)
    time = level["sample_s"] * np.arange(rows, dtype=np.float64)
    q = motion.at(time)
    errors = bias + thermometer_errors({**level, "sensor_bias_K": 0.0}, temperatures.shape, generator)
    # Laplace's law of scale b has the variance 2 b^2
    scatter = generator.laplace(0.0, level["landing_um"] / np.sqrt(2.0), len(motion.place))
    noise = level["white_um"] * generator.standard_normal(rows) + scatter[motion.rest(time)]
    if level["slow_um"] > 0.0:
        noise += level["slow_um"] * slow_noise(level["slow_time_s"] / level["sample_s"], rows, generator)
    return RunTruth(
        f"run-{k + 1:02d}", ROLES[k], time, q, motion.settled(time, SETTLING), temperatures, errors, air,
        np.empty((rows, 0)), leg.drift(temperatures, q), 1e-6 * noise, np.zeros(rows), np.zeros((rows, 3)),
    )  # fmt: skip


def slow_noise(forgotten: float, rows: int, generator: np.random.Generator) -> FloatArray:
    """Return noise of unit variance with a spectrum of about 1/f over two decades.

    The sum of three Ornstein-Uhlenbeck processes of equal variance, correlation times `SPREAD` times `forgotten` rows.
    """
    parts = [remembering(ratio * forgotten, (rows,), generator) for ratio in SPREAD]
    return np.asarray(np.sum(parts, axis=0) / np.sqrt(len(SPREAD)))
