"""What this campaign can see: how large an effect must be to be named, and which causes it would confuse."""

from __future__ import annotations

import numpy as np
from scipy import linalg

from hexathermal.learn.diagnosis.channels import Levels
from hexathermal.learn.diagnosis.evidence import changed_base, tolerance, visible
from hexathermal.learn.diagnosis.result import Confusion, Limit
from hexathermal.learn.diagnosis.stage import Stage
from hexathermal.learn.diagnosis.trials import Trial, evenly
from hexathermal.poses import FloatArray

ASKED = 9
"""Trials of a cause whose strength is asked."""

CLOSE = 6.0
"""Log evidence below which two causes are told to be confused."""

ROUNDING = 1e-9
"""Log evidence below which two causes are the same column: what is left is rounding, and would order the pairs."""


def limits_of(stage: Stage, levels: Levels, threshold: float) -> tuple[tuple[Limit, ...], tuple[Confusion, ...]]:
    """Return each cause's limit of detection, and pairs that these data confuse.

    The evidence that an effect of visible size ``a`` brings on average is ``1/2 a^2 s`` with
    ``s = z' P z / visible(z)^2`` in whitened data; what the search over a cause's parameters costs is added to the
    threshold, and the null's tolerance sets a floor: less is named only where every run left out shows it. Two causes
    differ by ``1/2 a^2 s (1 - r^2)``, r the correlation of their whitened columns with the law refitted.
    """
    causes: dict[str, list[Trial]] = {}
    for trial in stage.search.trials:
        if trial.named:
            causes.setdefault(trial.cause, []).append(trial)
    Q = _whitened_base(stage, levels)
    limits, shapes = [], {}
    for name, trials in sorted(causes.items()):
        found = [_strength(stage, levels, Q, trial) for trial in evenly(trials, ASKED)]
        usable = [one for one in found if one is not None]
        if not usable:
            continue
        s = float(np.median([one[0] for one in usable]))
        share = float(np.median([one[1] for one in usable]))
        need = threshold + np.log(len(trials))
        tolerated = tolerance(levels.rms, max(trial.feigned for trial in trials))
        least = max(np.sqrt(2.0 * need / s), np.sqrt(2.0 * threshold) * tolerated)
        limits.append(Limit(name, float(least), float(least / max(share, 1e-3))))
        shapes[name] = (np.column_stack([one[2] for one in usable]), s, least)
    return tuple(limits), _confused(shapes)


def _whitened_base(stage: Stage, levels: Levels) -> FloatArray:
    """Return an orthonormal basis of the whitened base."""
    table, _ = stage.channel.whitened(stage.base.X, levels)
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
    white = white[:, 0] - Q @ (Q.T @ white[:, 0])
    size = float(white @ white)
    if size <= 0.0:
        return None
    return size / left**2, left / rms, white / np.sqrt(size)


def _confused(shapes: dict[str, tuple[FloatArray, float, float]]) -> tuple[Confusion, ...]:
    """Return pairs of causes that differ by less than `CLOSE` at twice the limit."""
    names = list(shapes)
    found = []
    for i, first in enumerate(names):
        for second in names[i + 1 :]:
            (U, s, least), (V, _s, _least) = shapes[first], shapes[second]
            alike = float(np.abs(U.T @ V).max())
            gap = 0.5 * (2.0 * least) ** 2 * s * (1.0 - alike**2)
            gap = gap if gap > ROUNDING else 0.0
            if gap < CLOSE:
                found.append(Confusion((first, second), gap))
    return tuple(sorted(found, key=lambda item: item.separation))
