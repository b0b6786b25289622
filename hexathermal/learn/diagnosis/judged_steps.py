"""Steps of the zero in runs for validation: no law is fitted to these, and what it foretells for them shows a step.

What the extended law leaves of those runs is searched for steps as the runs for identification are, beside the law's
own columns, which take up what it foretells a little wrong. A run that is not foretold well may wander, bend or relax:
one step must beat all that does so from the same moment on. Where the search left something without a name, that is in
these runs, too: a step must stand beside all forms of it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hexathermal.learn.diagnosis.beforehand import Beforehand, shown_together
from hexathermal.learn.diagnosis.causes.zero_jump import CAUSE, trials
from hexathermal.learn.diagnosis.channels import Levels
from hexathermal.learn.diagnosis.deciding import SOUND
from hexathermal.learn.diagnosis.evidence import Base, Scored, relevance
from hexathermal.learn.diagnosis.pieces import LONGEST_S
from hexathermal.learn.diagnosis.result import ALSO, Effect, Quantity
from hexathermal.learn.diagnosis.search import Search
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.stand_offs import fading
from hexathermal.learn.diagnosis.trials import PREFIX, Trial
from hexathermal.learn.diagnosis.view import View
from hexathermal.learn.diagnosis.words import UM, told, two_digits
from hexathermal.learn.law import IdentifiedLaw
from hexathermal.learn.signals import RunRows
from hexathermal.poses import FloatArray

SURE = 24.0
"""Log evidence that such a step needs, the price of all moments paid: nothing foretells that it will be there again."""

RELAXING_S = (300.0, 1200.0, 4800.0)
"""Time constants of what may relax from the same moment on."""

RIVAL_LEAD = 0.1
"""Part of its evidence by which a step must beat what bends or relaxes."""

MOST_STEPS = 4

ALIKE = 1e-3
"""Part of the largest singular value below which forms of what has no name say the same."""


@dataclass(frozen=True, eq=False)
class JudgedStep:
    """A step of the zero in a run for validation.

    Attributes
    ----------
    run : str
    time : float [s]
        Since the run's first row.
    size, error : float [m]
        And its standard uncertainty.
    evidence : float
    """

    run: str
    time: float
    size: float
    error: float
    evidence: float


def judged_steps(
    view: View, law: IdentifiedLaw, held: Sequence[RunRows], threshold: float, nameless: str | None = None
) -> list[JudgedStep]:
    """Return the steps of the zero that runs for validation have, largest evidence first.

    Parameters
    ----------
    view : View
        Of all runs.
    law : IdentifiedLaw
        With all that joined it.
    held : sequence of RunRows
        For validation, as they were read, in which everything that the law reads has values.
    threshold : float
        Log evidence that a name needs in this campaign against a small misfit.
    nameless : str, optional
        What the search left without a name.
    """
    if not view.zeroed_by_run or not held:
        return []
    runs = [replace(rows, drift=rows.drift - law.predict_signals(rows.signals, run=rows.run.name)) for rows in held]
    judged = replace(view, runs=tuple(runs))
    judged.__dict__["channel"] = replace(judged.channel, walks=False)  # of steps in two runs a walk would be learnt
    stage = Stage(judged)
    X = stage.view.base_columns
    base = Base(X, stage.channel.loose(X), X.shape[1])
    found = _steps_beside(stage, base, stage.levels, threshold)
    if found and nameless is not None:
        more = _forms_of(stage, nameless)
        beside = base.extended(more, stage.channel.loose(more))
        found = _steps_beside(stage, beside, stage.channel.fitted(beside.X, beside.sd)[0], threshold)
    records = {rows.run.name: rows for rows in runs}
    found = [one for one in found if not _taken_back(one, records[one.run])]
    return sorted(found, key=lambda one: -one.evidence)


def _steps_beside(stage: Stage, base: Base, levels: Levels, threshold: float) -> list[JudgedStep]:
    """Return the steps that stand beside a base, as they were found."""
    found = list[JudgedStep]()
    while len(found) < MOST_STEPS:
        step = _next(stage, base, levels, threshold)
        if step is None:
            break
        found.append(step[0])
        base = base.extended(step[1].trial.columns, step[1].size)
        levels, _ = stage.channel.fitted(base.X, base.sd)
    return found


def _forms_of(stage: Stage, nameless: str) -> FloatArray:
    """Return columns that make all forms of something without a name, shape (n, k)."""
    forms = [trial.columns for trial in stage.search.trials if trial.cause == nameless]
    if not forms:
        return np.empty((len(stage.channel), 0))
    u, s, _ = np.linalg.svd(np.column_stack(forms), full_matrices=False)
    return np.asarray((u * s)[:, s > ALIKE * s[0]])


def _taken_back(step: JudgedStep, rows: RunRows) -> bool:
    """Whether cleaning took back a step of a beam there: what that left, or put there, is no jump of the zero."""
    begun = float(rows.signals.time[0])
    return any(abs(begun + one.time - step.time) < LONGEST_S for one in rows.record.beam_steps)


def _next(stage: Stage, base: Base, levels: Levels, threshold: float) -> tuple[JudgedStep, Scored] | None:
    """Return the best step beside a base with its noise that stands, and as it was scored: of each run its best one."""
    channel, tried = stage.channel, list(trials(stage.bench))
    if not tried:
        return None
    bests: dict[str | None, Scored] = {}
    search = Search(stage.bench, channel, base, stage.largest)
    for item in sorted(search.scored(levels, tried), key=lambda item: -item.value):
        if item.trial.cause == CAUSE.name and item.value >= SURE:
            bests.setdefault(item.trial.target, item)
    null, price = channel.evidence(base.X, base.sd, levels), math.log(len(tried))
    for best in bests.values():
        value, own = _against(stage, base, best.trial.columns, best.size, levels, null)
        value -= price
        rivals = (_against(stage, base, one.columns, best.size, levels, null)[0] for one in _rivals(stage.view, best))
        small = value < SURE or relevance(best.visible, own.rms, 0.0) < threshold
        if small or value < (1.0 + RIVAL_LEAD) * max(rivals):
            continue
        with_step = base.extended(best.trial.columns, best.size)
        mean, covariance = channel.estimated(with_step.X, with_step.sd, own)
        where = best.trial.parameters
        size, error = float(mean[-1]), float(np.sqrt(covariance[-1, -1]))
        return JudgedStep(str(where["run"]), float(where["time_s"]), size, error, value), best
    return None


def _against(
    stage: Stage, base: Base, columns: FloatArray, sizes: FloatArray, levels: Levels, null: float
) -> tuple[float, Levels]:
    """Return the evidence of columns against a null with its own noise, every noise open to both, and their noise."""
    channel, more = stage.channel, base.extended(columns, np.resize(sizes, columns.shape[1]))
    own, value = channel.fitted(more.X, more.sd, levels, 40)
    return value - max(null, channel.evidence(base.X, base.sd, own)), own


def _rivals(view: View, step: Scored) -> list[Trial]:
    """Return what may stand in a step's place: what bends or relaxes from its moment on, or a slope of all its run."""
    where = step.trial.parameters
    k = next(k for k, rows in enumerate(view.runs) if rows.run.name == where["run"])
    inside = view.channel.run == k
    since = np.where(inside, np.maximum(view.time - float(where["time_s"]), 0.0), 0.0)
    passed = (step.trial.columns[:, 0] > 0.0) & inside
    shapes = [since, np.where(inside, view.time, 0.0)]
    shapes += [fading(passed, since, tau) for tau in RELAXING_S]
    scale = float(np.sqrt((step.trial.columns**2).mean()))
    alike = (shape * scale / max(float(np.sqrt((shape**2).mean())), 1e-30) for shape in shapes)
    return [Trial(PREFIX + CAUSE.name, shape[:, None]) for shape in alike]


def told_steps(steps: Sequence[JudgedStep], view: View) -> Beforehand | None:
    """Return the steps as one effect, told by the largest of them; None where there is none.

    Parameters
    ----------
    steps : sequence of JudgedStep
    view : View
        Of all runs: what of the steps is visible, is so in all of them.
    """
    if not steps:
        return None
    names = [rows.run.name for rows in view.runs]
    columns = np.column_stack([view.step_from(names.index(one.run), one.time) for one in steps])
    sizes, errors = (np.array([getattr(one, name) for one in steps]) for name in ("size", "error"))
    seen, spread = shown_together(columns, sizes, errors, view.base_columns)
    at = int(np.argmax(np.abs(sizes)))
    first, rows = steps[at], view.runs[names.index(steps[at].run)]
    parameters = {
        "time_s": Quantity(first.time, float(np.median(np.diff(rows.signals.time))), "s"),
        "step_um": Quantity(first.size * UM, first.error * UM, "um"),
    }
    others = ALSO.join(dict.fromkeys(one.run for one in steps if one.run != first.run))
    settings = {"run": first.run, "role": "validation"} | ({"also": others} if others else {})
    sentence = (
        f"In a run for validation the zero jumps, {CAUSE.name} (in {first.run}; at {told(parameters['time_s'])}; step "
        f"of the drift {told(parameters['step_um'])}{f'; and in {others}' if others else ''}): no law can foretell it, "
        f"and the gain is judged with it; {two_digits(seen * UM)} um of it would stay visible in all runs."
    )
    effect = Effect(CAUSE.name, first.run, parameters, settings, SOUND, (), seen, sentence, joined=False)
    return Beforehand(effect, sum(one.evidence for one in steps), spread)
