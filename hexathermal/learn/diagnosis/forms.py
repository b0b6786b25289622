"""Forms of one cause beside each other: with what each run has of its own, or without; as compared, or as joined."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import replace
from typing import Any

import numpy as np

from hexathermal.learn.diagnosis.evidence import Scored, mean_log
from hexathermal.learn.diagnosis.ranking import Ranked
from hexathermal.learn.diagnosis.trials import Trial

CLIMBED = ("clock-offset",)
"""Causes of which motion is a witness; their trials stand in the order of their parameter: neighbours of the best are
mended, too."""

ALIKE = 1.0
"""Evidence that a cause needs for what is alike in all runs, where its decays before each run, or rates, count too."""


def other_form(best: Scored, scored: list[Scored]) -> list[Scored]:
    """Return the best trial of a cause without columns of single runs, where its best one has some; else itself with.

    What these explain by themselves does not count for the cause: it may stand better without. And in the noise of the
    null, in which all that wanders is noise, few columns look best: beside its own it may stand better with them.
    """
    own, kind = best.trial, _kind(best.trial)
    others = [item for item in scored if item.trial.cause == own.cause and bool(item.trial.starts) != bool(own.starts)]
    others = [item for item in others if own.starts or _kind(item.trial) == kind]
    return [max(others, key=lambda item: item.value)] if others else []


def other_lines(best: Scored, scored: list[Scored]) -> list[Scored]:
    """Return the best trial of each other way in which a clock may be off, where a clock is best.

    What motion says of one counts no further than the drift does: another one may stand better when that is weighed.
    """
    own, lines = best.trial, dict[Hashable, list[Scored]]()
    for item in scored:
        if own.cause == item.trial.cause in CLIMBED and item.trial.line != own.line:
            lines.setdefault(item.trial.line, []).append(item)
    return [max(items, key=lambda item: item.value) for items in lines.values()]


def _kind(trial: Trial) -> tuple[str | None, str, dict[str, Any]]:
    """Return what tells a trial from others of its cause, but for columns of single runs."""
    return trial.target, trial.shape, dict(trial.parameters)


def fullest(forms: list[Ranked]) -> Ranked:
    """Return the form of a cause that explains most; against nothing it stands as the form does that stands best.

    What is alike in all runs must stand beside what is each run's own: else that is all there is, and no cause.
    """
    surest, whole = max(forms, key=lambda item: item.gated), max(forms, key=lambda item: item.value)
    if whole.value <= surest.value or whole.gated < ALIKE:
        return surest
    trial = replace(whole.best.trial, doubt=whole.value - surest.gated)
    return replace(whole, best=replace(whole.best, trial=trial))


def as_joined(best: Scored, scored: list[Scored]) -> Scored:
    """Return what joins the law for a trial: itself, or another one that it is compared for.

    For a law of which several thermometers are late together it is the term of the one that explains most.
    """
    term, delay = best.trial.term, best.trial.delay
    if term is None:
        return best
    own = next(item for item in scored if item.trial.columns is term.columns)
    if delay is None or len(delay.sensors) == 1:
        return own
    alike = [item for item in scored if item.trial.target in delay.sensors and _as_late(item.trial, term)]
    return max([own, *alike], key=lambda item: item.value)


def _as_late(trial: Trial, term: Trial) -> bool:
    """Whether a trial is a term as another one, of the same times, be it on another thermometer."""
    same = all(trial.parameters.get(name) == term.parameters.get(name) for name in ("time_constant_s", "order"))
    return same and not trial.starts and (trial.cause, trial.shape) == (term.cause, term.shape)


def by_cause(scored: list[Scored]) -> dict[str, tuple[float, Scored]]:
    """Return the mean evidence of each cause's trials, and its best trial."""
    groups: dict[str, list[Scored]] = {}
    for item in scored:
        groups.setdefault(item.trial.cause, []).append(item)
    found = {}
    for name, items in groups.items():
        values = np.array([item.value for item in items])
        best = items[int(np.argmax(values))]
        found[name] = (float(mean_log(values)), best)
    return found
