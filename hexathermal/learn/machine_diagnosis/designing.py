"""The next experiment of a diagnosis: poses and temperatures that tell its leader from the rival that is open.

The leader is what was named first, else what leads the ranking. Its rival is the best name that these data cannot tell
from it, one of another cause before one of another place; where all is told apart, the strongest other cause.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hexathermal.errors import ArgumentError, KinematicsError
from hexathermal.learn.machine_diagnosis.candidate import Candidate
from hexathermal.learn.machine_diagnosis.case import Case
from hexathermal.learn.machine_diagnosis.causes import catalogue
from hexathermal.learn.machine_diagnosis.causes.tracker_drift import CAUSE as TRACKER
from hexathermal.learn.machine_diagnosis.causes.tracker_drift import following
from hexathermal.learn.machine_diagnosis.course import Course
from hexathermal.learn.machine_diagnosis.leg_sensors import ADVICE
from hexathermal.learn.machine_diagnosis.leg_terms import term_candidate
from hexathermal.learn.machine_diagnosis.planning import MachineExperiment, next_experiment
from hexathermal.learn.machine_diagnosis.search import Step
from hexathermal.learn.machine_diagnosis.separation import Noise
from hexathermal.learn.machine_diagnosis.view import MachineView
from hexathermal.poses import FloatArray

POSES = 20
"""Of the run that is planned; `hexathermal.learn.machine_proposal` plans longer ones."""

POOL = 60


def designed(course: Course, places: Sequence[str], found: FloatArray | None) -> tuple[MachineExperiment, ...]:
    """Return the next experiment; none where nothing is there or competes, or where no plan shows both.

    Parameters
    ----------
    course : Course
    places : sequence of str
        Names with places that are equivalent to what was named first.
    found : array, shape (k,), or None
        Amplitudes of what was named first.
    """
    first = course.adopted[0] if course.adopted else None
    case, step = (first.case, first.step) if first is not None else (course.case, course.end)
    leader = first.candidate if first is not None else next(iter(_named(case, step)), None)
    # no pose tells the thermometers of one leg apart
    if leader is None or (first is None and course.left is None) or leader.cause in ADVICE:
        return ()
    rival = _rival(case, step, leader, places)
    if rival is None:
        return ()
    amplitudes = {} if first is None or found is None else {leader.called: found}

    def make(view: MachineView) -> Sequence[Candidate]:
        return [part for one in (leader, rival) for part in _again(view, one)]

    try:
        return (next_experiment(case.view, [leader, rival], Noise(case.noise.coordinates), slots=POSES, pool=POOL,
                                laws=case.laws, levels=course.end.null, amplitudes=amplitudes, make=make),)  # fmt: skip
    except (ArgumentError, KinematicsError):
        return ()


def _again(view: MachineView, one: Candidate) -> list[Candidate]:
    """Return a candidate with the settings with which it was found on other rows; none where these cannot show it."""
    if one.leg_shape:
        again = term_candidate(view, one.cause, one.legs[0], one.leg_shape, one.names, one.units, one.settings)
        return [again] if again.columns.any() else []
    every = catalogue()[one.cause].candidates(view)
    if one.cause == TRACKER.name and one.settings:
        every = [following(view, str(one.target), float(one.settings["time_constant_s"]))]
    return [other for other in every if _same(one, other)]


def _named(case: Case, step: Step) -> list[Candidate]:
    """Return the candidates of a ranking that have names, the best first."""
    return [case.candidates[one.which] for one in step.ranking if case.named(one.which)]


def _rival(case: Case, step: Step, leader: Candidate, places: Sequence[str]) -> Candidate | None:
    """Return what the leader is to be told from."""
    others = [one for one in _named(case, step) if one.called != leader.called and one.cause not in ADVICE]
    alike = [one for one in others if one.called in places]
    foreign = [one for one in (alike or others) if one.cause != leader.cause]
    return next(iter([*foreign, *(alike or others)]), None)


def _same(one: Candidate, other: Candidate) -> bool:
    """Whether two candidates are the same one with the same settings."""
    return one.called == other.called and dict(one.settings) == dict(other.settings) and len(one.names) == len(
        other.names) and bool(np.array_equal(one.mean, other.mean))  # fmt: skip
