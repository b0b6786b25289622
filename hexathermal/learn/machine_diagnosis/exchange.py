"""The exchange of poses in a planned run: sums of information, and what they are worth for separating candidates."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from scipy.special import logsumexp

from hexathermal.learn.machine_diagnosis.separation import (
    Base,
    Noise,
    base_of,
    expected_evidence,
    information_of_rows,
    places_of,
    refitted,
    whitened_rows,
)
from hexathermal.learn.machine_diagnosis.tables import Levels
from hexathermal.machine.thermal import frozen
from hexathermal.poses import FloatArray

if TYPE_CHECKING:
    from hexathermal.learn.machine_diagnosis.candidate import Candidate
    from hexathermal.learn.machine_diagnosis.scenarios import Scenario
    from hexathermal.learn.machine_diagnosis.view import MachineView

LEVELS = 6
"""Parts of the warming at which poses are compared; a slot takes the next one."""

SWEEPS = 6

ORDERS = 60
"""Orders of the rows that are tried where columns depend on them."""

Maker = Callable[["MachineView"], Sequence["Candidate"]]
"""Gives candidates of a view."""


@dataclass(frozen=True, eq=False)
class Problem:
    """What is to be separated, and what is known already.

    Attributes
    ----------
    wanted : tuple of Candidate
        Of any view: cause, target, settings and sizes count.
    mean_squares : tuple of array, shape (k, k)
        Of each one's amplitudes.
    make : function
        Gives the candidates of a planned view.
    laws : str
    noise : Noise
    levels : Levels
        Sizes of each run's own disturbances.
    known : array, shape (p + K, p + K)
        Information that is there already.
    """

    wanted: tuple[Candidate, ...]
    mean_squares: tuple[FloatArray, ...]
    make: Maker
    laws: str
    noise: Noise
    levels: Levels
    known: FloatArray

    @property
    def places(self) -> tuple[slice, ...]:
        """Where the columns of each candidate stand."""
        return places_of([len(one.scale) for one in self.wanted])

    @property
    def scale(self) -> FloatArray:
        """Usual sizes of all amplitudes, shape (K,)."""
        return np.concatenate([np.hypot(one.scale, one.mean) for one in self.wanted])

    def columns(self, view: MachineView) -> FloatArray:
        """Return the columns of what is wanted in the rows of a view, shape (n, 6, K); zero where they show nothing."""
        made = list(self.make(view))
        found = np.zeros((len(view), 6, len(self.scale)))
        for one, own in zip(self.wanted, self.places, strict=True):
            match = [other for other in made if other.called == one.called and _same(other, one)]
            if match:
                found[:, :, own] = match[0].columns
        return found

    def base(self, view: MachineView) -> Base:
        """Return what is there in planned rows beside candidates; planned temperatures are read without error."""
        found = base_of(view, self.laws, self.noise, self.levels)
        return replace(found, own=found.own[..., :0])

    def information(self, view: MachineView) -> FloatArray:
        """Return what the rows of a view tell, frames eliminated, shape (p + K, p + K)."""
        base = self.base(view)
        return information_of_rows(view, base, self.columns(view), self.noise, self.levels).M

    def separations(self, M: FloatArray, sd: FloatArray) -> FloatArray:
        """Return the mean log evidence between each true candidate and each rival, shape (..., c, c).

        Of a single candidate: that against nothing.
        """
        G, scale, places = refitted(self.known + M, sd), self.scale, self.places
        c = len(places)
        found = np.zeros((*G.shape[:-2], c, c))
        for i, own in enumerate(places):
            values = [expected_evidence(G, rival, own, self.mean_squares[i], scale) for rival in places]
            for j in range(c):
                found[..., i, j] = values[i] - (values[j] if c > 1 else 0.0)
        return found

    def rivals(self, M: FloatArray, sd: FloatArray) -> FloatArray:
        """Return the separations of all that is true from its rivals in a row, shape (..., c (c - 1)), or (..., 1)."""
        found = self.separations(M, sd)
        c = found.shape[-1]
        return found[..., 0] if c == 1 else found[..., ~np.eye(c, dtype=bool)]

    def least(self, M: FloatArray, sd: FloatArray) -> FloatArray:
        """Return the least separation, shape (...)."""
        return np.asarray(self.rivals(M, sd).min(axis=-1))

    def worth(self, M: FloatArray, sd: FloatArray) -> FloatArray:
        """Return the least separation, smoothed: ``-log sum exp(-E_ij)`` over what is true and its rivals."""
        return np.asarray(-logsumexp(-self.rivals(M, sd), axis=-1))


def _same(other: Candidate, one: Candidate) -> bool:
    """Whether two candidates of one name are the same one, not one with other settings or parameters."""
    return other.names == one.names and dict(other.settings) == dict(one.settings)


@dataclass(frozen=True, eq=False)
class Design:
    """Which pose of the pool stands in each slot of a run, and what that is worth."""

    scenario: Scenario
    chosen: npt.NDArray[np.int64]
    worth: float


@dataclass(frozen=True, eq=False)
class Slots:
    """Information of each pose of a pool at each level of warming, frame first, shape (L, N, f + u, f + u).

    `levels` are those of the slots; `sd` and `frame` the sizes of what runs share and of their own frame.
    """

    tables: FloatArray
    levels: npt.NDArray[np.int64]
    sd: FloatArray
    frame: FloatArray

    def run(self, chosen: npt.NDArray[np.int64]) -> FloatArray:
        """Return the sum over the slots of a run, the frame among the unknowns."""
        return np.asarray(self.tables[self.levels, chosen].sum(axis=0))

    def freed(self, M: FloatArray) -> FloatArray:
        """Return information without the frame; batches lead."""
        return refitted(M, self.frame)


def course_of(slots: int) -> FloatArray:
    """Return the part of the warming, 0 to 1, at which each slot of a run is measured."""
    return np.linspace(0.0, 1.0, slots)


def slots_of(problem: Problem, pool: MachineView, count: int, size: int) -> Slots:
    """Return the table of a scenario.

    Parameters
    ----------
    problem : Problem
    pool : MachineView
        All poses of the pool at the first level, then at the next, ...
    count : int
        Poses of the pool.
    size : int
        Slots of the run.
    """
    # slow errors belong to the time of a row, which its level does not tell: poses are chosen with the frame alone
    levels_alone = Levels(frame=problem.levels.frame, campaign=problem.levels.campaign)
    base = problem.base(pool)
    W, sizes = whitened_rows(pool, base.shared, problem.columns(pool), problem.noise, levels_alone)
    tables = (np.swapaxes(W, 1, 2) @ W).reshape(-1, count, W.shape[2], W.shape[2])
    levels = np.round(course_of(size) * (len(tables) - 1)).astype(np.int64)
    return Slots(tables, levels, base.sizes, sizes)


def exchanged(
    problem: Problem, slots: Slots, scenario: Scenario, start: npt.NDArray[np.int64], generator: np.random.Generator
) -> Design:
    """Return the design in which no exchange of one pose gains, from a start."""
    chosen, M = start.copy(), slots.run(start)
    now = float(problem.worth(slots.freed(M), slots.sd))
    for _sweep in range(SWEEPS):
        before = now
        for slot in generator.permutation(len(chosen)):
            each = slots.tables[slots.levels[slot]]
            others = M - each[chosen[slot]]
            worth = problem.worth(slots.freed(others + each), slots.sd)
            best = int(worth.argmax())
            if worth[best] > now + 1e-6 * abs(now):
                chosen[slot], M, now = best, others + each[best], float(worth[best])
        if now <= before + 1e-3 * abs(before):
            break
    return Design(scenario, chosen, now)


def order_matters(problem: Problem, view: MachineView) -> bool:
    """Whether what is wanted depends on the order of the rows of one run: the same rows, last first, differ."""
    turned: dict[str, Any] = {name: frozen(getattr(view, name)[::-1]) for name in ("poses", "q", "dT", "plates", "air")}
    columns, back = problem.columns(view), problem.columns(replace(view, **turned))[::-1]
    return not np.allclose(columns, back, rtol=1e-9, atol=1e-15)


def reordered(
    problem: Problem, design: Design, sd: FloatArray, plan: Callable[[npt.NDArray[np.int64]], MachineView],
    generator: np.random.Generator,
) -> Design:  # fmt: skip
    """Return the design in the best order of its rows that was found, worth as it is in that order."""
    trials = [design.chosen, *(generator.permutation(design.chosen) for _order in range(ORDERS))]
    worth = [float(problem.worth(problem.information(plan(one)), sd)) for one in trials]
    best = int(np.argmax(worth))
    return Design(design.scenario, trials[best], worth[best])
