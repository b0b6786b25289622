"""The virtual bench: one leg, its room, its instruments, and the runs of a campaign.

A run is made in two stages, so that something may happen to the truth before it is recorded:

    truth = true_run(bench, plan, weather, generator)        # heat, growth, mechanics: what happens
    run   = recorded(bench, truth, generator, mounted)       # thermocouples, lasers, weather station: what is written
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError
from hexathermal.machine.thermal import frozen
from hexathermal.poses import FloatArray
from hexathermal.simulate.bench.interferometers import Interferometers, MountedInterferometers, WeatherStation
from hexathermal.simulate.bench.leg import LARGEST_STEP, LegHistory, VirtualLeg
from hexathermal.simulate.bench.mechanics import Mechanics
from hexathermal.simulate.bench.room import Room, Weather
from hexathermal.simulate.bench.scenario import Commands, Motion, Scenario
from hexathermal.simulate.bench.thermocouples import MountedThermocouples, Thermocouples

SCALE_RESOLUTION, BEAM_RESOLUTION = 1e-8, 1e-9
"""Steps in which displacement and beams are logged [m]. Engineering values."""


@dataclass(frozen=True)
class Bench:
    """All that the bench is made of; every number has a default with its source.

    Attributes
    ----------
    leg, room, thermocouples, interferometers, station, mechanics, scenario
        See their classes.
    interval : float [s]
        Between two rows of the log. Engineering value: 10 to 20 s are usual.
    """

    leg: VirtualLeg = field(default_factory=VirtualLeg)
    room: Room = field(default_factory=Room)
    thermocouples: Thermocouples = field(default_factory=Thermocouples)
    interferometers: Interferometers = field(default_factory=Interferometers)
    station: WeatherStation = field(default_factory=WeatherStation)
    mechanics: Mechanics = field(default_factory=Mechanics)
    scenario: Scenario = field(default_factory=Scenario)
    interval: float = 20.0

    def __post_init__(self) -> None:
        if not (np.isfinite(self.interval) and self.interval > 0.0):
            raise ArgumentError(f"Bench.interval must be above 0 s, found {self.interval!r}")
        for _name, part, position in self.thermocouples.places:
            self.leg.weights(part, position)


@dataclass(frozen=True, eq=False)
class Mounted:
    """The instruments of one bench with their constant errors, the same in all its runs."""

    thermocouples: MountedThermocouples
    interferometers: MountedInterferometers
    station: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class RunPlan:
    """What is to happen in a run: its name, its role, the commands, and the room where it is given.

    Attributes
    ----------
    weather : callable, optional
        From times [s] to `Weather`; default: the bench's room draws its own.
    """

    name: str
    role: str
    commands: Commands
    weather: Callable[[FloatArray], Weather] | None = None


@dataclass(frozen=True, eq=False)
class TrueRun:
    """What truly happens in a run, n rows of the log.

    Attributes
    ----------
    plan : RunPlan
    time : array, shape (n,) [s]
    q : array, shape (n,) [m]
        Displacement by the scale.
    settled : array, shape (n,), bool
    weather : Weather
    history : LegHistory
        The leg at the same rows.
    growth : array, shape (n,) [m]
        By how much heat makes the leg longer than its scale says.
    mechanical : array, shape (n,) [m]
        By how much mechanics does.
    """

    plan: RunPlan
    time: FloatArray
    q: FloatArray
    settled: npt.NDArray[np.bool_]
    weather: Weather
    history: LegHistory
    growth: FloatArray
    mechanical: FloatArray


@dataclass(frozen=True, eq=False)
class BenchRun:
    """What is written of a run, n rows, s thermocouples.

    Attributes
    ----------
    name, role : str
    time : array, shape (n,) [s]
    q : array, shape (n,) [m]
    settled : array, shape (n,), bool
    temperatures : array, shape (n, s) [degC]
    beams : array, shape (n, 3) [m]
    weather : Weather
        By the weather station.
    truth : TrueRun
        Never written into a campaign.
    """

    name: str
    role: str
    time: FloatArray
    q: FloatArray
    settled: npt.NDArray[np.bool_]
    temperatures: FloatArray
    beams: FloatArray
    weather: Weather
    truth: TrueRun

    def drift(self) -> FloatArray:
        """Return the measured drift, ``mean(beams) - (q - q[0])``, shape (n,) [m]; meaningless where not settled."""
        return np.asarray(self.beams.mean(axis=1) - (self.q - self.q[0]))


def mounted(bench: Bench, seed: int) -> Mounted:
    """Return the instruments of the bench that a seed stands for."""
    generator = np.random.default_rng([seed, 0])
    return Mounted(
        bench.thermocouples.mounted(generator),
        bench.interferometers.mounted(generator),
        bench.station.errors(generator),
    )


def roles(identification: int, validation: int) -> tuple[str, ...]:
    """Return the roles of a campaign's runs: first those to identify a law, then those to validate it."""
    return ("identification",) * identification + ("validation",) * validation


def planned_runs(
    bench: Bench, seed: int, *, identification: int = 8, validation: int = 3, duration: float | None = None
) -> tuple[RunPlan, ...]:
    """Return the plan of a campaign: runs to identify a law, and runs to validate it.

    Parameters
    ----------
    bench : Bench
    seed : int
    identification, validation : int
    duration : float, optional [s]
        Of each run; default: drawn for each.

    Raises
    ------
    ArgumentError
        There would be no run, or a run would be shorter than its first rest.
    """
    if identification < 0 or validation < 0 or identification + validation < 1:
        raise ArgumentError(f"a campaign needs at least one run, found {identification} + {validation}")
    if duration is not None and not bench.scenario.first_rest < duration < np.inf:
        raise ArgumentError(
            f"a run of {duration / 3600.0:g} h ends before its first movement; the rod rests for "
            f"{bench.scenario.first_rest / 3600.0:.3g} h first"
        )
    plans = []
    for k, role in enumerate(roles(identification, validation)):
        number = k if role == "identification" else k - identification
        commands = bench.scenario.commands(
            bench.leg.stroke, bench.leg.drive.speed, np.random.default_rng([seed, 1, k]), run=number, duration=duration
        )
        plans.append(RunPlan(f"run-{k + 1:02d}", role, commands))
    return tuple(plans)


def true_run(bench: Bench, plan: RunPlan, generator: np.random.Generator) -> TrueRun:
    """Return what truly happens in a run: the leg starts at rest, in equilibrium with its room.

    The scale reads true at the bench's mean room temperature, the leg holding its place.
    """
    leg = bench.leg
    motion = Motion(plan.commands, leg.drive.speed)
    rows = int(plan.commands.duration / bench.interval + 1e-9) + 1
    parts = int(np.ceil(bench.interval / LARGEST_STEP - 1e-9))
    fine: FloatArray = np.arange((rows - 1) * parts + 1, dtype=np.float64) * (bench.interval / parts)
    weather = bench.room.weather(fine, generator) if plan.weather is None else plan.weather(fine)
    q = motion.displacement(fine)
    start = leg.at_rest(float(weather.temperature[0]), float(q[0]))
    history = leg.warm(fine, q, weather.temperature, start, way=motion.way(fine)).every(parts)
    reference = leg.at_rest(bench.room.temperature, float(np.mean(leg.stroke)))
    time = history.time
    since = motion.since_arrival(time)
    held = history.q + bench.mechanics.servo * generator.standard_normal(time.size)
    return TrueRun(
        plan, time, frozen(held), since >= bench.scenario.settling, weather.every(parts), history,
        frozen(history.growth(reference)), frozen(bench.mechanics.error(motion, time, generator)),
    )  # fmt: skip


def recorded(bench: Bench, truth: TrueRun, instruments: Mounted, generator: np.random.Generator) -> BenchRun:
    """Return what the instruments write of a run."""
    time, weather = truth.time, truth.weather
    surfaces = instruments.thermocouples.surfaces(truth.history)
    temperatures = instruments.thermocouples.read(time, surfaces, weather.temperature, generator)
    station = bench.station.read(weather, instruments.station, generator)
    drift = truth.growth + truth.mechanical
    paths = instruments.interferometers.paths(time, truth.q, drift, generator)
    beams = instruments.interferometers.read(time, paths, weather, station, ~truth.settled, generator)
    return BenchRun(
        truth.plan.name, truth.plan.role, time, _logged(truth.q, SCALE_RESOLUTION), truth.settled, temperatures,
        _logged(beams, BEAM_RESOLUTION), station, truth,
    )  # fmt: skip


def _logged(values: FloatArray, resolution: float) -> FloatArray:
    """Return values in whole steps of a resolution."""
    return frozen(np.round(values / resolution) * resolution)


def simulate_bench(
    bench: Bench | None = None, seed: int = 1, plans: tuple[RunPlan, ...] | None = None
) -> Iterator[BenchRun]:
    """Simulate a campaign, one run after the other.

    Parameters
    ----------
    bench : Bench, optional
        Default: the published bench.
    seed : int
        Of all that is drawn. The same seed makes the same campaign.
    plans : tuple of RunPlan, optional
        Default: `planned_runs`, 8 runs to identify and 3 to validate.

    Yields
    ------
    BenchRun

    Examples
    --------
    >>> bench = Bench()
    >>> (run,) = simulate_bench(bench, 1, planned_runs(bench, 1, identification=1, validation=0, duration=3600.0))
    >>> run.time.size, run.temperatures.shape, run.beams.shape
    (181, (181, 17), (181, 3))
    """
    bench = Bench() if bench is None else bench
    instruments = mounted(bench, seed)
    for k, plan in enumerate(planned_runs(bench, seed) if plans is None else plans):
        truth = true_run(bench, plan, np.random.default_rng([seed, 2, k]))
        yield recorded(bench, truth, instruments, np.random.default_rng([seed, 3, k]))
