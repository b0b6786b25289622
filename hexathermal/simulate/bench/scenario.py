"""Scenarios: where the controller sends the rod, and how the rod goes there.

A scenario is a list of commands.  At each of them the rod starts towards its target at the drive's speed, then rests.
Users' scenarios take turns of movement, in steps of 10 mm with pauses, and of rest (Robert et al., 5.1, fig. 4).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError
from hexathermal.machine.thermal import frozen
from hexathermal.poses import FloatArray
from hexathermal.simulate.bench.parts import require_finite


@dataclass(frozen=True, eq=False)
class Commands:
    """Where the controller sends the rod, k commands.

    Parameters
    ----------
    start : float [m]
        Where the rod rests at time 0.
    times : array, shape (k,) [s]
        When each move starts; increasing.
    targets : array, shape (k,) [m]
    duration : float [s]
        End of the run.
    """

    start: float
    times: FloatArray
    targets: FloatArray
    duration: float


@dataclass(frozen=True, eq=False)
class Motion:
    """How the rod follows its commands at a speed.

    Raises
    ------
    ArgumentError
        A command comes before the rod has reached the last target.
    """

    commands: Commands
    speed: float

    def __post_init__(self) -> None:
        commands = self.commands
        late = np.flatnonzero(self.arrivals[:-1] > commands.times[1:] + 1e-9)
        if late.size:
            k = int(late[0])
            raise ArgumentError(
                f"the command at {commands.times[k + 1]:g} s comes before the rod reaches "
                f"{commands.targets[k] * 1e3:g} mm, at {self.arrivals[k]:.1f} s with {self.speed * 1e3:g} mm/s; "
                f"leave it more time (and {late.size - 1} more such commands)"
            )

    @property
    def steps(self) -> FloatArray:
        """Moves, signed, shape (k,) [m]."""
        commands = self.commands
        return np.diff(np.concatenate([[commands.start], commands.targets]))

    @property
    def arrivals(self) -> FloatArray:
        """Times when the rod arrives, shape (k,) [s]."""
        return np.asarray(self.commands.times + np.abs(self.steps) / self.speed)

    def _corners(self, values: FloatArray, time: FloatArray) -> FloatArray:
        """Return a quantity that changes linearly while the rod moves, from its values before and after each move."""
        corners = np.column_stack([self.commands.times, self.arrivals]).ravel()
        levels = np.column_stack([values[:-1], values[1:]]).ravel()
        return np.interp(time, corners, levels) if corners.size else np.full(time.shape, values[0])

    def displacement(self, time: FloatArray) -> FloatArray:
        """Return the rod's displacement at times, shape (n,) [m]."""
        return self._corners(np.concatenate([[self.commands.start], self.commands.targets]), time)

    def way(self, time: FloatArray) -> FloatArray:
        """Return the way gone, back and forth, at times, shape (n,) [m]."""
        return self._corners(np.concatenate([[0.0], np.cumsum(np.abs(self.steps))]), time)

    def landing(self, time: FloatArray) -> npt.NDArray[np.int64]:
        """Return how many moves have begun at times, shape (n,)."""
        return np.searchsorted(self.commands.times, time, side="right")

    def since_arrival(self, time: FloatArray) -> FloatArray:
        """Return how long the rod has been at rest, shape (n,) [s]; < 0: it moves, inf: before any move."""
        return np.asarray(time - np.concatenate([[-np.inf], self.arrivals])[self.landing(time)])


@dataclass(frozen=True)
class Scenario:
    """How users move a leg.

    Attributes
    ----------
    increment : float [m]
        Length of one move. Source: 10 mm (Robert et al.).
    pause : tuple of float [s]
        Shortest and longest stabilisation pause after a move. Engineering value.
    settling : float [s]
        Rows are not settled until so long after an arrival. Source: a few seconds (Robert et al.).
    first_rest : float [s]
        At rest before the first movement. Engineering value.
    movement, rest : tuple of float [s]
        Shortest and longest phase. Engineering value.
    loads : tuple of float [1]
        Runs take these in turn: pauses are longer, and phases of movement shorter, by the inverse. Engineering value:
        users work their machines more and less.
    duration : tuple of float [s]
        Shortest and longest run, in whole half-hours. Engineering value.
    """

    increment: float = 0.010
    pause: tuple[float, float] = (8.0, 16.0)
    settling: float = 4.0
    first_rest: float = 600.0
    movement: tuple[float, float] = (4200.0, 5400.0)
    rest: tuple[float, float] = (2400.0, 4200.0)
    loads: tuple[float, ...] = (1.0, 0.3, 1.0, 0.5)
    duration: tuple[float, float] = (4.0 * 3600.0, 6.0 * 3600.0)

    def __post_init__(self) -> None:
        require_finite(self, above_zero=("increment", "movement", "rest", "loads", "duration", "pause"))
        for name in ("pause", "movement", "rest", "duration"):
            low, high = getattr(self, name)
            if low > high:
                raise ArgumentError(f"Scenario.{name} is (shortest, longest), found {(low, high)!r}")
        if max(self.loads) > 1.0:
            raise ArgumentError(f"Scenario.loads are parts of full load, above 0 and up to 1, found {self.loads!r}")
        if self.pause[0] <= self.settling:
            raise ArgumentError(
                f"Scenario.pause must be longer than settling ({self.settling:g} s), found {self.pause!r}"
            )

    def commands(
        self,
        stroke: tuple[float, float],
        speed: float,
        generator: np.random.Generator,
        *,
        run: int = 0,
        duration: float | None = None,
    ) -> Commands:
        """Return the commands of one run, drawn anew.

        Parameters
        ----------
        stroke : tuple of float [m]
        speed : float [m/s]
        generator : numpy.random.Generator
        run : int
            Number of the run, which says how hard the leg works.
        duration : float, optional [s]
            Of the run; default: drawn.
        """
        low, high = stroke
        if duration is None:
            halves = np.array(self.duration) / 1800.0
            duration = 1800.0 * float(generator.integers(np.ceil(halves[0]), np.floor(halves[1]) + 1))
        load = self.loads[run % len(self.loads)]
        place = start = float(np.round(generator.uniform(low, high), 5))
        now, times, targets = self.first_rest, list[float](), list[float]()
        while now < duration:
            stop = now + load * generator.uniform(*self.movement)
            while now < min(stop, duration):
                goal = float(np.round(generator.uniform(low, high), 5))
                for target in _increments(place, goal, self.increment):
                    pause = generator.uniform(*self.pause) / load
                    if now + abs(target - place) / speed + pause > duration:
                        return Commands(start, frozen(np.array(times)), frozen(np.array(targets)), duration)
                    times.append(now)
                    targets.append(target)
                    now += abs(target - place) / speed + pause
                    place = target
            now += generator.uniform(*self.rest)
        return Commands(start, frozen(np.array(times)), frozen(np.array(targets)), duration)


def _increments(place: float, goal: float, increment: float) -> list[float]:
    """Return the targets from one place to another, one increment apart, the last one at the goal."""
    count = max(1, int(np.ceil(abs(goal - place) / increment - 1e-9)))
    full = place + np.sign(goal - place) * increment * np.arange(1, count)
    return [*full.tolist(), goal]
