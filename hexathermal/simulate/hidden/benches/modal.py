"""A leg whose heat is solved by cosine modes: 15 s, 12 runs of 6 h, steps of 10 mm and long strokes.

Body and rod are bars of length ``l`` with insulated ends in a room that takes heat from their sides,

``dT/dt = D d2T/dx2 - beta (T - T_room) + s(x, t)``,  ``T(x, t) = sum_n a_n(t) cos(n pi x / l)``,

so that every mode follows ``da_n/dt = -(D (n pi / l)^2 + beta) a_n + s_n(t)`` (Carslaw and Jaeger, Conduction of Heat
in Solids, section 3), which is solved exactly for sources that are constant within a row. The motor heats the body's
foot; friction heats the body about the nut, which moves with the rod, and the rod's lower end.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.benches.air import Room
from hexathermal.simulate.hidden.benches.legs import Leg, drawn_leg
from hexathermal.simulate.hidden.benches.motion import Motion, carried_out
from hexathermal.simulate.hidden.benches.noises import log_uniform, noted, thermometer_errors
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth

NAME = "modal"

STEP = 15.0
ROWS = 1441
TIME: FloatArray = STEP * np.arange(ROWS, dtype=np.float64)
MODES = 24
WIDTH = 0.02
"""Width [m] over which heat enters; the modes that are left out see less than 1 % of it."""

ROLES = ("identification",) * 9 + ("validation",) * 3
BASES = ((5,), (6,), (7,), (3, 12), (4, 14), (6, 15))
"""Choices of the law's thermocouples, one or an upper and a lower one (as Robert et al. found best)."""

PER_ROW = 15
"""Moments within a row at which the nut's heat is taken."""


@dataclass(frozen=True)
class Bar:
    """A bar with insulated ends and losses at its side.

    Attributes
    ----------
    length : float [m]
    diffusivity : float [m^2/s]
    loss : float [1/s]
        ``beta``: how fast its sides take the temperature of what surrounds them.
    """

    length: float
    diffusivity: float
    loss: float

    @property
    def waves(self) -> FloatArray:
        """Wave numbers ``n pi / l`` [1/m] of the modes."""
        return np.arange(MODES, dtype=np.float64) * (np.pi / self.length)

    def source(self, place: FloatArray, width: float) -> FloatArray:
        """Return what a unit source, a bell of `width` [m] at `place`, feeds into modes, shape (..., MODES) [1/m]."""
        share = np.where(np.arange(MODES) == 0, 1.0, 2.0) / self.length
        bell = np.exp(-0.5 * (self.waves * width) ** 2)
        return np.asarray(np.cos(np.multiply.outer(place, self.waves)) * share * bell)

    def modes(self, feeding: FloatArray, first: FloatArray) -> FloatArray:
        """Return amplitudes [K] of all modes at the rows, shape (n, MODES).

        Parameters
        ----------
        feeding : array, shape (n, MODES) [K/s]
            From each row to the next.
        first : array, shape (MODES,) [K]
        """
        rates = self.diffusivity * self.waves**2 + self.loss
        kept = np.exp(-rates * STEP)
        gained = feeding * -np.expm1(-rates * STEP) / rates
        found = np.empty_like(feeding)
        found[0] = first
        for n in range(MODES):
            found[1:, n], _ = lfilter([1.0], [1.0, -kept[n]], gained[:-1, n], zi=[kept[n] * first[n]])
        return found

    def shapes(self, places: FloatArray) -> FloatArray:
        """Return the modes at places, shape (MODES, s)."""
        return np.asarray(np.cos(np.multiply.outer(self.waves, places)))


@dataclass(frozen=True, eq=False)
class Heated:
    """A leg with its heat.

    Attributes
    ----------
    leg : Leg
    body, rod : Bar
    body_places, rod_places : array [m]
        Of the thermocouples, each in its own bar.
    nut : float [m]
        Where the rod's lower end is in the body, rod retracted.
    contact : float [1]
        Part of what surrounds the rod's side within the body that is the body.
    motor_time : float [s]
        The motor's own time constant.
    holding : float [1]
        Motor heat at rest, over that at full speed.
    friction_share : float [1]
        Part of the friction heat that goes into the rod.
    fan : float [1]
        How much more of the air conditioning's cycle the upper end feels than the lower.
    """

    leg: Leg
    body: Bar
    rod: Bar
    body_places: FloatArray
    rod_places: FloatArray
    nut: float
    contact: float
    motor_time: float
    holding: float
    friction_share: float
    fan: float

    def responses(self, motion: Motion, room: FloatArray, leftover: FloatArray) -> FloatArray:
        """Return the answer to the room, to unit motor heat and to unit friction, shape (3, n, 17) [K]."""
        speed, place = motion.speed(STEP / PER_ROW, ROWS * PER_ROW)
        running = (speed > 0.0).reshape(ROWS, PER_ROW).mean(axis=1)
        kept = np.exp(-STEP / self.motor_time)
        motor = lfilter([1.0 - kept], [1.0, -kept], self.holding + (1.0 - self.holding) * running)
        moving = np.flatnonzero(speed)
        friction = np.zeros((ROWS, MODES))
        heat = self.body.source(self.nut + place[moving], WIDTH) * (speed[moving, None] / PER_ROW)
        np.add.at(friction, moving // PER_ROW, heat)
        body, none = self.body, np.zeros(MODES)
        feed_room = np.zeros((ROWS, MODES))
        feed_room[:, 0] = body.loss * room
        feed_room[:, 1] = -body.loss * self.fan * (room - room.mean())
        first = np.zeros(MODES)
        first[0], first[1:4] = room[0] + leftover[0], leftover[1:]
        bodies = (
            body.modes(feed_room, first),
            body.modes(motor[:, None] * body.source(np.array(0.0), WIDTH), none),
            body.modes((1.0 - self.friction_share) * friction, none),
        )
        q = motion.at(TIME)
        speeds = speed.reshape(ROWS, PER_ROW).mean(axis=1)
        return np.stack([self._with_rod(k, modes, q, room, speeds) for k, modes in enumerate(bodies)])

    def _with_rod(self, k: int, modes: FloatArray, q: FloatArray, room: FloatArray, speed: FloatArray) -> FloatArray:
        """Return body's and rod's thermocouples for one of the three causes; the rod sits in body and room."""
        within = np.linspace(self.nut, self.body.length, 7)
        about = (modes @ self.body.shapes(within)).mean(axis=1)
        share = self.contact * (1.0 - 0.6 * q / self.leg.stroke)
        around = share * about + (1.0 - share) * (room if k == 0 else 0.0)
        feeding = np.zeros((ROWS, MODES))
        feeding[:, 0] = self.rod.loss * around
        if k == 2:
            feeding += self.friction_share * speed[:, None] * self.rod.source(np.array(0.0), WIDTH)
        first = np.zeros(MODES)
        first[0] = around[0]
        rods = self.rod.modes(feeding, first)
        return np.column_stack([modes @ self.body.shapes(self.body_places), rods @ self.rod.shapes(self.rod_places)])


def plan(stroke: float, first: float, generator: np.random.Generator) -> Iterator[tuple[float, float, float]]:
    """Yield moves without end: sweeps in steps of 10 mm, long strokes, and rests of up to half an hour."""
    now = first
    while True:
        speed = log_uniform(1e-3, 5e-3, generator)
        if generator.uniform() < 0.6:
            pause = log_uniform(8.0, 75.0, generator)
            for _sweep in range(generator.integers(1, 4)):
                up = now < 0.5 * stroke
                goal = generator.uniform(0.6, 1.0) * stroke if up else generator.uniform(0.0, 0.4) * stroke
                for _stop in range(int(abs(goal - now) / 0.010)):
                    now = round(now + (0.010 if up else -0.010), 6)
                    yield now, speed, pause * generator.uniform(0.7, 1.4)
        else:
            pause = log_uniform(4.0, 300.0, generator)
            for _stroke in range(generator.integers(2, 14)):
                low, high = (0.6, 1.0) if now < 0.5 * stroke else (0.0, 0.4)
                now = round(generator.uniform(low, high) * stroke, 6)
                yield now, speed, pause * generator.uniform(0.5, 2.0)
        now = round(min(max(now + generator.uniform(-0.02, 0.02), 0.0), stroke), 6)
        yield now, speed, log_uniform(120.0, 1800.0, generator)


def _heated(generator: np.random.Generator) -> Heated:
    """Return a leg of drawn size and materials, Invar to steel, in still to moving air."""
    leg = drawn_leg(BASES, generator)
    nut = leg.retracted_length - leg.stroke - generator.uniform(0.06, 0.10)
    length = leg.retracted_length - 0.040
    diffusivity = log_uniform(2.5e-6, 1.3e-5, generator)
    loss = 1.0 / generator.uniform(2500.0, 6000.0)
    body_places = np.linspace(0.02, length - 0.02, 13) + generator.uniform(-0.005, 0.005, 13)
    rod_length = leg.retracted_length - nut
    rod_places = rod_length - np.array([0.034, 0.025, 0.016, 0.007])
    return Heated(
        leg,
        Bar(length, diffusivity, loss),
        Bar(rod_length, log_uniform(3e-6, 1.3e-5, generator), loss * generator.uniform(1.0, 2.0)),
        body_places.round(4),
        rod_places.round(4),
        nut,
        contact=generator.uniform(0.4, 0.8),
        motor_time=generator.uniform(300.0, 1500.0),
        holding=generator.uniform(0.1, 0.4),
        friction_share=generator.uniform(0.25, 0.5),
        fan=generator.uniform(0.0, 0.4),
    )


def draw(generator: np.random.Generator, roles: Sequence[str] = ROLES) -> CampaignTruth:
    """Make a campaign in which nothing is hidden.

    Parameters
    ----------
    generator : numpy.random.Generator
    roles : sequence of str
        What each run is for.
    """
    heated = _heated(generator)
    leg = heated.leg
    room = Room(
        level=generator.uniform(19.0, 22.0),
        swing=generator.uniform(0.2, 0.9),
        coldest=generator.uniform(4.0, 7.0) * 3600.0,
        cycle=generator.uniform(0.03, 0.25),
        period=generator.uniform(600.0, 1700.0),
        duty=generator.uniform(0.3, 0.7),
        slow=generator.uniform(0.05, 0.25),
    )
    level = {
        "white_um": log_uniform(0.02, 0.10, generator),
        "landing_um": log_uniform(0.05, 0.25, generator),
        "slow_um": 0.0,
        "slow_time_s": 0.0,
        "sensor_noise_K": log_uniform(0.01, 0.05, generator),
        "sensor_bias_K": 0.03,
        "sensor_walk_6h_K": log_uniform(0.005, 0.03, generator),
        "sample_s": STEP,
        "drift_resolution_um": 0.0,
        "temperature_resolution_K": 0.0,
    }
    motions, airs, answers = [], [], []
    for day in range(len(roles)):
        first = round(generator.uniform(0.0, leg.stroke), 4)
        motion = carried_out(plan(leg.stroke, first, generator), first, generator.uniform(120.0, 900.0), TIME[-1])
        air = room.air(86400.0 * day + generator.uniform(6.0, 15.0) * 3600.0, STEP, ROWS, generator)
        leftover = generator.normal(0.0, (0.15, 0.08, 0.05, 0.03))
        motions.append(motion)
        airs.append(air)
        answers.append(heated.responses(motion, air[:, 0], leftover))
    largest = np.max([answer[:, :, :13].max(axis=(1, 2)) for answer in answers], axis=0)
    heat = np.array([1.0, generator.uniform(2.5, 8.0) / largest[1], generator.uniform(2.0, 6.0) / largest[2]])
    runs = [
        _run(k, roles[k], leg, motions[k], np.einsum("c,cns->ns", heat, answers[k]), airs[k], level, generator)
        for k in range(len(roles))
    ]
    names = tuple(f"T{k + 1:02d}" for k in range(17))
    places = np.concatenate([heated.body_places, heated.nut + heated.rod_places])
    return noted(CampaignTruth(
        "leg", NAME, tuple(runs), names, ("body",) * 13 + ("rod",) * 4, places, tuple(names[k] for k in leg.base),
        leg.coefficients, leg.retracted_length, (0.0, leg.stroke), round(generator.uniform(0.1, 0.5), 3), True,
        notes=level,
    ))  # fmt: skip


def _run(
    k: int,
    role: str,
    leg: Leg,
    motion: Motion,
    temperatures: FloatArray,
    air: FloatArray,
    level: dict[str, float],
    generator: np.random.Generator,
) -> RunTruth:
    """Return one run with the noise of its instruments."""
    rows, sensors = temperatures.shape
    q = motion.at(TIME)
    errors = thermometer_errors(level, (rows, sensors), generator)
    scatter = level["landing_um"] * generator.standard_normal(len(motion.place))
    noise = 1e-6 * (scatter[motion.rest(TIME)] + level["white_um"] * generator.standard_normal(rows))
    return RunTruth(
        f"run-{k + 1:02d}", role, TIME.copy(), q, motion.settled(TIME, 4.0), temperatures, errors, air,
        np.empty((rows, 0)), leg.drift(temperatures, q), noise, np.zeros(rows), np.zeros((rows, 3)),
    )  # fmt: skip
