"""The next experiment on a machine: poses and temperatures by which candidates separate most.

A run is a scenario (which parts warm by how much) and m poses, each measured at its part of the warming.  Chosen is
what makes the worst separation of any two candidates, each being the true one, largest (`separation`; a maximin form of
the T-optimal design of Atkinson and Fedorov, Biometrika 62, 1975, with the law refitted and rivals at their best):

    max over scenario, poses   min over i != j   E log p(y | i) / p(y | j)           i true

where what is measured already counts too.  Scenarios are ranked by random poses; in the best ones poses are exchanged,
one slot after the other, for the best of a pool within all limits, until none gains (Fedorov's exchange).  Where
columns depend on the order of the rows (backlash), the order is searched in the end.  The separation that is promised
is that of the plan as it is written, computed anew.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError
from hexathermal.kinematics.sampled_poses import reachable_coordinates
from hexathermal.learn.machine_diagnosis.candidate import Candidate
from hexathermal.learn.machine_diagnosis.causes import all_candidates
from hexathermal.learn.machine_diagnosis.circumstances import missing_channels
from hexathermal.learn.machine_diagnosis.exchange import (
    LEVELS,
    Design,
    Maker,
    Problem,
    course_of,
    exchanged,
    order_matters,
    reordered,
    slots_of,
)
from hexathermal.learn.machine_diagnosis.observability import (
    TWICE,
    limits_of,
    mean_square_at,
    one_of_each,
    shapes_of,
    usual_size,
)
from hexathermal.learn.machine_diagnosis.scenarios import Scenario, checked, usual_scenarios
from hexathermal.learn.machine_diagnosis.separation import FREE_FRAME, Noise
from hexathermal.learn.machine_diagnosis.tables import Levels
from hexathermal.learn.machine_diagnosis.view import MachineView, planned_view
from hexathermal.machine.thermal import frozen
from hexathermal.poses import FloatArray, pose_from_coordinates

POOL = 60
"""Poses within all limits among which slots choose."""

TRIED, TRIALS, DRAWS = 3, 6, 20
"""Scenarios whose poses are exchanged; random designs by which each scenario is ranked; those compared with."""

SLOTS = 40
INTERVAL_S = 120.0
"""Between two rows of a plan."""

AS_GOOD = 0.03
"""Part of the best worth that an earlier, simpler scenario may lack."""


@dataclass(frozen=True)
class Promise:
    """What a plan is to bring for one candidate, being true, and its rival: mean log evidence without and with it.

    `rival` is ``"nothing"`` where a single candidate is asked for.
    """

    true: str
    rival: str
    before: float
    after: float


@dataclass(frozen=True, eq=False)
class MachineExperiment:
    """Runs to measure next.

    Attributes
    ----------
    scenarios : tuple of Scenario
        Of each run.
    view : MachineView
        Poses and temperatures of all runs as planned.
    coordinates : array, shape (n, 6) [mm, deg]
        Commanded, from home, in order.
    wanted : tuple of str
        Candidates that it separates.
    promises : tuple of Promise
        Of each two of them; the least first.
    random : float
        Least separation that as many random poses and scenarios bring, mean over `DRAWS`.
    words : str
    """

    scenarios: tuple[Scenario, ...]
    view: MachineView
    coordinates: FloatArray
    wanted: tuple[str, ...]
    promises: tuple[Promise, ...]
    random: float
    words: str

    @property
    def separation(self) -> float:
        """The least mean log evidence between any two of them with the plan."""
        return min(one.after for one in self.promises)


def next_experiment(
    view: MachineView, candidates: Sequence[Candidate], noise: Noise, *, slots: int = SLOTS, runs: int = 1,
    scenarios: Sequence[Scenario] | None = None, amplitudes: Mapping[str, FloatArray] | None = None,
    strength: float | None = None, laws: str = "kept", make: Maker = all_candidates,
    levels: Levels = FREE_FRAME, pool: int = POOL, seed: int = 1,
) -> MachineExperiment:  # fmt: skip
    """Return the runs that separate candidates most, beside the rows that are there.

    Parameters
    ----------
    view : MachineView
        Of what is measured: its rows count as known, its machine is planned for.
    candidates : sequence of Candidate
        To be told apart; one of each cause and target. A single one is told from nothing.
    noise : Noise
    slots : int
        Poses of each run.
    runs : int
    scenarios : sequence of Scenario, optional
        Default: `usual_scenarios`.
    amplitudes : mapping of str to array (k,), optional
        Parameters of candidates, by `Candidate.called`, where they are known.
    strength : float, optional
        RMS of the effect over the noise, over the six coordinates of the rows that are there, where parameters are
        not known; default: twice the limit of detection there.  At most the usual size counts.
    laws : str
        ``"kept"`` or ``"refit"``, see `hexathermal.learn.machine_diagnosis.law_columns.law_columns`.
    make : function
        From a view to its candidates.
    levels : Levels
        Sizes of what disturbs each run beside the noise; default: the measuring frame alone, free in each.
    pool : int
        Poses among which slots choose, drawn at random within stroke, cones and travel.
    seed : int

    Raises
    ------
    ArgumentError
        A number is out of range, or no scenario shows one of the candidates.
    KinematicsError
        The machine can hardly leave its home.
    """
    _refuse_numbers(slots, runs, pool, strength)
    wanted = one_of_each(candidates)
    sizes, known = _known(view, wanted, noise, amplitudes or {}, strength, laws, levels)
    problem = Problem(wanted, sizes, make, laws, noise, levels, known)
    generator = np.random.default_rng(seed)
    six = reachable_coordinates(view.hexapod, pool, generator)
    planner = _Planner(problem, view, six, checked(usual_scenarios() if scenarios is None else scenarios), slots)
    planner.refuse_unseen()
    found: list[Design] = []
    rest = problem
    for _run in range(runs):
        found.append(planner.best(rest, generator))
        rows = planner.plan(found[-1].scenario, found[-1].chosen)
        rest = replace(rest, known=rest.known + rest.information(rows))
    return _told(problem, planner, found, generator)


class _Planner:
    """A pool of poses under all scenarios, and the designs made of it."""

    def __init__(
        self, problem: Problem, view: MachineView, six: FloatArray, ways: tuple[Scenario, ...], slots: int
    ) -> None:
        self.problem, self.view, self.six, self.ways, self.size = problem, view, six, ways, slots
        self.poses = pose_from_coordinates(six, hexapod=view.hexapod)
        self.slots = {way.name: slots_of(problem, self._pool(way), len(six), slots) for way in ways}

    def _rows(self, way: Scenario, which: npt.NDArray[np.int64], course: FloatArray, **more: Any) -> MachineView:
        """Return planned rows: poses of the pool at parts of the warming."""
        dT, plates, air = way.temperatures(course, len(self.view.sensors))
        for k, sensor in enumerate(self.view.plate_sensors):
            if sensor is None:
                plates[:, k] = np.nan
        known = np.isfinite(self.view.air).any()
        return planned_view(
            self.view.hexapod, self.poses[which], dT, plates=plates, air=air if known else None,
            sensors=self.view.sensors, plate_sensors=self.view.plate_sensors, **more,
        )  # fmt: skip

    def _pool(self, way: Scenario) -> MachineView:
        """Return all poses of the pool at each level of warming."""
        n = len(self.six)
        levels = np.repeat(np.arange(LEVELS), n)
        return self._rows(way, np.tile(np.arange(n), LEVELS), levels / (LEVELS - 1.0), run=levels)

    def plan(self, way: Scenario, chosen: npt.NDArray[np.int64]) -> MachineView:
        """Return the rows of one run."""
        return self._rows(way, chosen, course_of(len(chosen)), time=INTERVAL_S * np.arange(len(chosen)))

    def refuse_unseen(self) -> None:
        """Refuse candidates that neither the rows that are there nor any scenario shows."""
        K = len(self.problem.scale)
        seen = np.diagonal(self.problem.known)[-K:].copy()
        for slots in self.slots.values():
            seen = seen + np.einsum("lnii->i", slots.tables)[-K:]
        lost = [
            one.called for one, own in zip(self.problem.wanted, self.problem.places, strict=True)
            if not (seen[own] > 0.0).any()
        ]  # fmt: skip
        if lost:
            missing = "; ".join(missing_channels(self.view)) or "add a scenario that warms its part"
            raise ArgumentError(f"no scenario shows {', '.join(lost)}: {missing}")

    def chance(self, generator: np.random.Generator) -> npt.NDArray[np.int64]:
        """Return random poses for the slots of a run."""
        return generator.integers(len(self.six), size=self.size)

    def best(self, problem: Problem, generator: np.random.Generator) -> Design:
        """Return the best scenario and poses of one run that were found."""
        trials = [self.chance(generator) for _trial in range(TRIALS)]
        ranked = []
        for way in self.ways:
            slots = self.slots[way.name]
            worth = problem.worth(slots.freed(np.array([slots.run(one) for one in trials])), slots.sd)
            ranked.append((float(worth.mean()), way, trials[int(worth.argmax())]))
        # sorting is stable: of equals the earlier
        ranked.sort(key=lambda item: -item[0])
        found = [self._improved(problem, way, start, generator) for _mean, way, start in ranked[:TRIED]]
        top = max(design.worth for design in found)
        good = [design for design in found if design.worth >= top - AS_GOOD * abs(top)]
        return min(good, key=lambda design: self.ways.index(design.scenario))

    def _improved(
        self, problem: Problem, way: Scenario, start: npt.NDArray[np.int64], generator: np.random.Generator
    ) -> Design:
        """Return the best poses of a scenario from a start, worth as they are when planned."""
        slots = self.slots[way.name]
        design = exchanged(problem, slots, way, start, generator)
        view = self.plan(way, design.chosen)
        if order_matters(problem, view, self.plan(way, design.chosen[::-1])):
            return reordered(problem, design, slots.sd, partial(self.plan, way), generator)
        return replace(design, worth=float(problem.worth(problem.information(view), slots.sd)))

    def random(self, runs: int, generator: np.random.Generator) -> float:
        """Return the least separation that random scenarios and poses bring, on average over draws."""
        sums = []
        for _draw in range(DRAWS):
            total = np.zeros_like(self.problem.known)
            for _run in range(runs):
                way = self.ways[int(generator.integers(len(self.ways)))]
                total = total + self.problem.information(self.plan(way, self.chance(generator)))
            sums.append(total)
        return float(self.problem.least(np.array(sums), self.sd).mean())

    @property
    def sd(self) -> FloatArray:
        """Standard deviations of the law's coefficients."""
        return next(iter(self.slots.values())).sd


def _refuse_numbers(slots: int, runs: int, pool: int, strength: float | None) -> None:
    """Refuse numbers that make no plan."""
    for name, value, least in (("slots", slots, 2), ("runs", runs, 1), ("pool", pool, 2)):
        if value < least:
            raise ArgumentError(f"a plan needs {name} of at least {least}, found {value!r}")
    if strength is not None and not (np.isfinite(strength) and strength > 0.0):
        raise ArgumentError(f"strength is an effect over the noise, above 0; found {strength!r}")


def _known(
    view: MachineView, wanted: tuple[Candidate, ...], noise: Noise, amplitudes: Mapping[str, FloatArray],
    strength: float | None, laws: str, levels: Levels,
) -> tuple[tuple[FloatArray, ...], FloatArray]:  # fmt: skip
    """Return the mean squares of amplitudes, and what the rows that are there tell."""
    shapes = shapes_of(view, wanted, noise, laws, levels)
    limits = limits_of(wanted, shapes)
    sizes = []
    for k, one in enumerate(wanted):
        usual = np.square(usual_size(one))
        if one.called in amplitudes:
            given = np.asarray(amplitudes[one.called], dtype=np.float64).reshape(-1)
            if given.shape != usual.shape or not np.isfinite(given).all():
                raise ArgumentError(f"{one.called} has {len(usual)} parameters ({', '.join(one.names)}), found {given}")
            sizes.append(np.outer(given, given))
        elif one.mean.any():
            sizes.append(np.diag(usual))
        else:
            asked = TWICE * limits[k].strength if strength is None else strength
            sizes.append(np.diag(usual))
            if np.isfinite(asked):
                sizes[-1] = np.minimum(mean_square_at(shapes, k, asked), sizes[-1])
    return tuple(sizes), shapes.information.M


def _told(
    problem: Problem, planner: _Planner, found: list[Design], generator: np.random.Generator
) -> MachineExperiment:  # fmt: skip
    """Return the experiment of designs, one a run, with what it promises."""
    six = np.concatenate([planner.six[design.chosen] for design in found])
    views = [planner.plan(design.scenario, design.chosen) for design in found]
    plan = joined(views)
    total = sum((problem.information(view) for view in views), np.zeros_like(problem.known))
    before, after = (problem.separations(M, planner.sd) for M in (np.zeros_like(total), total))
    random = planner.random(len(found), generator)
    names = tuple(one.called for one in problem.wanted)
    c = len(names)
    promises = [
        Promise(names[i], names[j] if c > 1 else "nothing", float(before[i, j]), float(after[i, j]))
        for i in range(c) for j in range(c) if i != j or c == 1
    ]  # fmt: skip
    promises.sort(key=lambda one: one.after)
    steps = "; then ".join(
        f"{design.scenario.words}, and measure {len(design.chosen)} poses on the way" for design in found
    )
    rivals = " from ".join(names) if c == 2 else f"{', '.join(names)} from {'each other' if c > 1 else 'nothing'}"
    least = promises[0]
    words = (
        f"{steps[0].upper()}{steps[1:]}: tells {rivals} with a log evidence of {least.after:.1f} or more on average "
        f"({least.before:.1f} without it; random poses and scenarios: {random:.1f})"
    )
    return MachineExperiment(
        tuple(design.scenario for design in found),
        plan,
        frozen(six),
        names,
        tuple(promises),
        random,
        words,
    )


def joined(views: Sequence[MachineView]) -> MachineView:
    """Return the rows of planned views, each a run of its own, as one view."""
    first = views[0]
    whole: dict[str, Any] = {
        name: frozen(np.concatenate([getattr(view, name) for view in views]))
        for name in ("poses", "q", "dT", "plates", "air", "time")
    }
    run = np.concatenate([np.full(len(view), k) for k, view in enumerate(views)])
    return replace(first, run=run, runs=tuple(f"run-{k + 1}" for k in range(len(views))), **whole)
