"""What this campaign can see: how large an effect must be to be named, and which causes it would confuse."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import linalg

from hexathermal.learn.diagnosis.channels import Levels
from hexathermal.learn.diagnosis.evidence import changed_base, tolerance
from hexathermal.learn.diagnosis.result import Confusion, Limit
from hexathermal.learn.diagnosis.spans import visible
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.trials import Trial, evenly
from hexathermal.poses import FloatArray

ASKED = 9
"""Trials of a cause whose strength is asked."""

CLOSE = 6.0
"""Log evidence below which two causes are told to be confused."""

SOUND_CAMPAIGNS = 0.2
"""Part of all campaigns that hold nothing."""

WEAKEST, STRONGEST = 0.25, 2.0
"""Visible RMS over the noise between which effects lie, evenly in the logarithm: less changes no law, more is seen by
eye."""

ROUNDING = 1e-9
"""Log evidence below which two causes are the same column: what is left is rounding, and would order the pairs."""


@dataclass(frozen=True, eq=False)
class Shape:
    """A cause as these data see it.

    Attributes
    ----------
    directions : array, shape (n, t)
        Of its trials in whitened data, the law refitted.
    strength : float [1/m^2]
        ``s`` of `limits_of`.
    least : float [m]
        Visible RMS from which on it would be named.
    witness : array, shape (t,)
        Log evidence that other witnesses would have for each trial at twice that.
    """

    directions: FloatArray
    strength: float
    least: float
    witness: FloatArray


def limits_of(stage: Stage, levels: Levels, threshold: float) -> tuple[tuple[Limit, ...], tuple[Confusion, ...]]:
    """Return each cause's limit of detection, and pairs that these data confuse.

    The evidence that an effect of visible size ``a`` brings on average is ``1/2 a^2 s`` with
    ``s = z' P z / visible(z)^2`` in whitened data; what the search over a cause's parameters costs is added to the
    threshold, and the null's tolerance sets a floor: less is named only where every run left out shows it. Two causes
    differ by ``1/2 a^2 s (1 - r^2)``, r the correlation of their whitened columns with the law refitted, and by what
    other witnesses than the drift would say for the one and not for the other: the parity of a thermometer, the
    order along the leg, the motion that warms it.
    """
    limits, shapes = _shapes_of(stage, levels, threshold)
    return tuple(limits), _confused(shapes)


def sure_of_nothing(limits: Sequence[Limit], noise: float) -> float:
    """Return the probability that a campaign in which nothing is seen holds nothing.

    ``s / (s + (1 - s) m)``: s is `SOUND_CAMPAIGNS`, m the mean over the causes of the part of effects, log-uniform
    between `WEAKEST` and `STRONGEST` times the noise, that is below their limits of detection.

    Parameters
    ----------
    limits : sequence of Limit
    noise : float
        RMS of the noise in windows [m].
    """
    if not limits:
        return SOUND_CAMPAIGNS
    # a cause that shows nothing after the refit has a limit of 0: none of its visible effects is missed
    seen = np.clip(np.array([one.visible for one in limits]) / noise, WEAKEST, STRONGEST)
    missed = np.mean(np.log(seen / WEAKEST) / np.log(STRONGEST / WEAKEST))
    return float(SOUND_CAMPAIGNS / (SOUND_CAMPAIGNS + (1.0 - SOUND_CAMPAIGNS) * missed))


def at_most_named(limits: Sequence[Limit], named: Mapping[str, float]) -> tuple[Limit, ...]:
    """Return limits none of which is larger than what was named: as little is named, then.

    A limit is that of the middle one of a cause's trials, and what these data hold may be one that they see better.

    Parameters
    ----------
    limits : sequence of Limit
    named : mapping of str to float [m]
        Visible RMS of the smallest effect of each cause that was named.
    """
    found = []
    for one in limits:
        least = min(one.visible, named.get(one.cause, np.inf))
        found.append(Limit(one.cause, least, one.whole * least / one.visible) if least < one.visible else one)
    return tuple(found)


def _shapes_of(stage: Stage, levels: Levels, threshold: float) -> tuple[list[Limit], dict[str, Shape]]:
    """Return each cause's limit of detection, and how these data see it."""
    causes: dict[str, list[Trial]] = {}
    for trial in stage.search.trials:
        if trial.named:
            causes.setdefault(trial.cause, []).append(trial)
    Q = _whitened_base(stage, levels)
    limits, shapes = [], dict[str, Shape]()
    for name, trials in sorted(causes.items()):
        asked = {trial: _strength(stage, levels, Q, trial) for trial in evenly(trials, ASKED)}
        usable = {trial: one for trial, one in asked.items() if one is not None}
        if not usable:
            continue
        s, share = (float(np.median([one[k] for one in usable.values()])) for k in (0, 1))
        need = threshold + np.log(len(trials))
        tolerated = tolerance(levels.usual, max(trial.feigned for trial in trials))
        least = max(np.sqrt(2.0 * need / s), np.sqrt(2.0 * threshold) * tolerated)
        limits.append(Limit(name, float(least), float(least / max(share, 1e-3))))
        witness = np.array([_witness(stage, trial, 2.0 * least) for trial in usable])
        shapes[name] = Shape(np.column_stack([one[2] for one in usable.values()]), s, float(least), witness)
    return limits, shapes


def _whitened_base(stage: Stage, levels: Levels) -> FloatArray:
    """Return an orthonormal basis of the whitened base, priors of its columns as rows behind, shape (n + p, p).

    What it leaves of whitened columns, zeros behind, has their products ``Z' P Z`` of eq. (3).
    """
    table, _ = stage.channel.whitened(stage.base.X, levels)
    table = np.concatenate([table, np.diag(1.0 / np.maximum(stage.base.sd, np.finfo(float).tiny ** 0.25))])
    Q, _R = linalg.qr(table / (np.sqrt((table**2).mean(axis=0)) + 1e-30), mode="economic")
    return np.asarray(Q)


def _strength(stage: Stage, levels: Levels, Q: FloatArray, trial: Trial) -> tuple[float, float, FloatArray] | None:
    """Return ``s`` [1/m^2], the visible share, and the whitened direction of a trial's effect."""
    column = trial.columns[:, :1]
    if trial.base is not None:
        mean, _ = stage.fit(levels)
        p = trial.base.shape[1]
        column = ((changed_base(stage.base, trial).X[:, :p] - stage.base.X[:, :p]) @ mean[:p])[:, None]
    rms = float(np.sqrt((column**2).mean()))
    if rms <= 0.0:
        return None
    left = float(visible(column, stage.base.X[:, : stage.base.plain])[0])
    if left < 1e-6 * rms:
        return None
    white, _ = stage.channel.whitened(column, levels)
    white = np.concatenate([white[:, 0], np.zeros(len(Q) - len(white))])
    white = white - Q @ (Q.T @ white)
    size = float(white @ white)
    if size <= 0.0:
        return None
    return size / left**2, left / rms, white / np.sqrt(size)


def _witness(stage: Stage, trial: Trial, size: float) -> float:
    """Return the log evidence that other witnesses than the drift would have for a trial of a visible size [m].

    What they say now against a clock that is off, or an exchange, they would say for it, were it true.
    """
    if not trial.columns.shape[1]:
        return max(-trial.advantage, 0.0)
    left = float(visible(trial.columns[:, -1:], stage.base.X[:, : stage.base.plain])[0])
    return stage.search.witnesses.would_say(trial, size / left) if left > 0.0 else 0.0


def _confused(shapes: dict[str, Shape]) -> tuple[Confusion, ...]:
    """Return pairs of causes that differ by less than `CLOSE` at twice the limit."""
    names = list(shapes)
    found = []
    for i, first in enumerate(names):
        for second in names[i + 1 :]:
            one, other = shapes[first], shapes[second]
            gaps = 0.5 * (2.0 * one.least) ** 2 * one.strength * (1.0 - (one.directions.T @ other.directions) ** 2)
            gap = float((gaps + np.abs(one.witness[:, None] - other.witness)).min())
            gap = gap if gap > ROUNDING else 0.0
            if gap < CLOSE:
                found.append(Confusion((first, second), gap))
    return tuple(sorted(found, key=lambda item: item.separation))
