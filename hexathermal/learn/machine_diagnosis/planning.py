"""The next experiment on a machine: poses and temperatures by which candidates separate most.

A run is a scenario (which parts warm by how much) and m poses, each measured at its part of the warming.  Chosen is
what makes the worst separation of any two candidates, each being the true one, largest (`separation`; a maximin form of
the T-optimal design of Atkinson and Fedorov, Biometrika 62, 1975, with the law refitted and rivals at their best):

    max over scenario, poses   min over i != j   E log p(y | i) / p(y | j)           i true

where what is measured already counts too.  Scenarios are ranked by random poses; in the best ones poses are exchanged,
one slot after the other, for the best of a pool within all limits, until none gains (Fedorov's exchange).  Where
columns depend on the order of the rows (backlash), the order is searched in the end.  The separation that is promised
is that of the plan as it is written, computed anew.

Two joints of one leg look alike wherever that leg has one direction; other poses tell them apart:

>>> from dataclasses import replace
>>> import hexathermal as ht
>>> from hexathermal.learn.machine_diagnosis.causes.joint_offset import candidates
>>> from hexathermal.learn.machine_diagnosis.view import planned_view
>>> model = ht.ThermalModel(ht.LegLaw("T1", 2e-6, 1e-6))
>>> hexapod = replace(ht.load_hexapod("reference"), thermal=model)
>>> view = planned_view(hexapod, np.repeat(hexapod.home[None], 5, axis=0), np.zeros((5, 6, 1)))
>>> pair = [one for one in candidates(view) if one.target in ("base joint 4", "platform joint 4")]
>>> noise = Noise(np.array([4e-7] * 3 + [1e-6] * 3))
>>> plan = next_experiment(view, pair, noise, slots=10, scenarios=usual_scenarios()[:1], pool=20)
>>> plan.promises[0].before < 0.1, plan.separation > 20.0
(True, True)
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.kinematics.sampled_poses import reachable_coordinates
from hexathermal.learn.machine_diagnosis.candidate import Candidate
from hexathermal.learn.machine_diagnosis.exchange import (
    Design,
    Maker,
    Problem,
)
from hexathermal.learn.machine_diagnosis.observability import (
    CLOSE,
    TWICE,
    limits_of,
    mean_square_at,
    one_of_each,
    shapes_of,
    usual_size,
)
from hexathermal.learn.machine_diagnosis.planner import Planner, joined, maker_of
from hexathermal.learn.machine_diagnosis.scenarios import Scenario, checked, usual_scenarios
from hexathermal.learn.machine_diagnosis.separation import FREE_FRAME, Noise
from hexathermal.learn.machine_diagnosis.tables import Levels
from hexathermal.learn.machine_diagnosis.view import MachineView
from hexathermal.machine.thermal import frozen
from hexathermal.poses import FloatArray

SAME = 1.0
"""Mean log evidence below which two names are the same at all poses of a pool."""

POOL = 80
"""Poses within all limits among which slots choose."""

SLOTS = 40
"""Poses of a run."""


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
    strength: float | None = None, laws: str = "kept", make: Maker | None = None,
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
    make : function, optional
        From a view to its candidates; default: the catalogues of machines and legs.
    levels : Levels
        Sizes of what disturbs each run beside the noise; default: the measuring frame alone, free in each.
    pool : int
        Poses among which slots choose, drawn at random within stroke, cones and travel.
    seed : int

    Raises
    ------
    ArgumentError
        A number is out of range, or no scenario shows one of the candidates.
    UnknownNameError
        A candidate's cause is in no catalogue, and `make` is not given.
    KinematicsError
        The machine can hardly leave its home.
    """
    _refuse_numbers(slots, runs, pool, strength)
    wanted = one_of_each(candidates)
    sizes, known = _known(view, wanted, noise, amplitudes or {}, strength, laws, levels)
    problem = Problem(wanted, sizes, make or maker_of(wanted), laws, noise, levels, known)
    generator = np.random.default_rng(seed)
    six = reachable_coordinates(view.hexapod, pool, generator)
    planner = Planner(problem, view, six, checked(usual_scenarios() if scenarios is None else scenarios), slots)
    planner.refuse_unseen()
    return _told(problem, planner, planner.designs(runs, generator), generator)


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
    problem: Problem, planner: Planner, found: list[Design], generator: np.random.Generator
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
        f"{design.scenario.words}, and measure {len(design.chosen)} poses meanwhile" for design in found
    )
    rivals = " from ".join(names) if c == 2 else f"{', '.join(names)} from {'each other' if c > 1 else 'nothing'}"
    least = promises[0]
    words = (
        f"{steps[0].upper()}{steps[1:]}: tells {rivals} with a log evidence of {least.after:.1f} or more on average "
        f"({least.before:.1f} without it; random poses and scenarios: {random:.1f})"
    )
    if least.before >= CLOSE:
        words += "; on average these data tell that already"
    if least.after < SAME:
        words += f"; no pose that this machine reaches tells {least.true} from {least.rival}"
    elif least.after < CLOSE:
        words += f"; that is below {CLOSE:g}: plan more runs, more poses or larger rises of temperature"
    return MachineExperiment(
        tuple(design.scenario for design in found),
        plan,
        frozen(six),
        names,
        tuple(promises),
        random,
        words,
    )
