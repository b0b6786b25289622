"""A pool of poses under all scenarios, and the best designs that are made of it, run after run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError, UnknownNameError
from hexathermal.learn.diagnosis.causes import catalogue as leg_catalogue
from hexathermal.learn.machine_diagnosis.candidate import Candidate
from hexathermal.learn.machine_diagnosis.causes import catalogue
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
from hexathermal.learn.machine_diagnosis.scenarios import Scenario
from hexathermal.learn.machine_diagnosis.single_leg import single_leg_candidates
from hexathermal.learn.machine_diagnosis.view import MachineView, planned_view
from hexathermal.machine.thermal import frozen
from hexathermal.poses import FloatArray, pose_from_coordinates

TRIED, TRIALS, DRAWS = 4, 6, 20
"""Scenarios whose poses are exchanged; random designs by which each scenario is ranked; those compared with."""

INTERVAL_S = 120.0
"""Between two rows of a plan."""

AS_GOOD = 0.03
"""Part of the best worth that an earlier, simpler scenario may lack."""


class Planner:
    """A pool of poses under all scenarios, and the designs made of it.

    Parameters
    ----------
    problem : Problem
    view : MachineView
        Of what is measured.
    six : array, shape (N, 6) [mm, deg]
        The pool.
    ways : tuple of Scenario
    slots : int
        Poses of each run.
    """

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

    def designs(self, runs: int, generator: np.random.Generator) -> list[Design]:
        """Return the designs of runs, each beside what is known and the ones before."""
        found: list[Design] = []
        rest = self.problem
        for _run in range(runs):
            found.append(self.best(rest, generator))
            rows = self.plan(found[-1].scenario, found[-1].chosen)
            rest = replace(rest, known=rest.known + rest.information(rows))
        return found

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
        if order_matters(problem, view):
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


def maker_of(wanted: Sequence[Candidate]) -> Maker:
    """Return what makes the candidates of some causes: the machine's catalogue, and that of a single leg.

    Raises
    ------
    UnknownNameError
        A cause is in neither.
    """
    own, legs = catalogue(), leg_catalogue()
    causes = list(dict.fromkeys(one.cause for one in wanted))
    unknown = [cause for cause in causes if cause not in own and cause not in legs]
    if unknown:
        names = tuple(sorted({*own, *legs}))
        raise UnknownNameError(f"there is no cause {unknown[0]!r} to plan for; there are {', '.join(names)}", names)
    single = any(cause not in own for cause in causes)

    def make(view: MachineView) -> list[Candidate]:
        """Give the candidates of a view."""
        found = [one for cause in causes if cause in own for one in own[cause].candidates(view)]
        return [*found, *single_leg_candidates(view)] if single else found

    return make


def joined(views: Sequence[MachineView]) -> MachineView:
    """Return the rows of planned views, each a run of its own, as one view."""
    first = views[0]
    whole: dict[str, Any] = {
        name: frozen(np.concatenate([getattr(view, name) for view in views]))
        for name in ("poses", "q", "dT", "plates", "air", "time")
    }
    run = np.concatenate([np.full(len(view), k) for k, view in enumerate(views)])
    return replace(first, run=run, runs=tuple(f"run-{k + 1}" for k in range(len(views))), **whole)
