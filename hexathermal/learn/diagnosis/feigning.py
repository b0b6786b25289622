"""What errors of thermometers may feign: a misfit that looks like a cause."""

from __future__ import annotations

import numpy as np

from hexathermal.learn.diagnosis.common_error import common_error
from hexathermal.learn.diagnosis.trials import Trial, Workbench

FEIGNED = 0.3
"""Part of the thermometers' slow bias that may look like a cause: most of it looks like a slow process. Steps of the
recording count whole: they are the error of anything that goes smoothly."""

ERRING = 0.5
"""Part of the slow biases of thermometers that may look like a fault which consists of such errors."""

FEIGNED_NOISE, MOST_FEIGNED = 2.0, 1.5
"""Part of their noise, times what it is of all noise, that may look like a cause, and the most: where readings scatter
as much as the drift does, anything that scatters less and goes alike is preferred."""


def feigned_by(bench: Workbench, slow: float | None = None) -> float:
    """Return the misfit that errors of the law's thermometers may feign in thermal causes, RMS [m].

    Each has a slow bias, as its parity shows, a resolution, below which it sees no warming at all, and noise that
    smoothing leaves: whatever goes as the temperature does with less noise stands for a better reading. All of them
    may err alike, by no more than they wander beside what warms them, and than wanders in the drift: `slow` of it
    [m] beside all that the null doubts, where that is known.
    """
    wanders = bench.slow if slow is None else min(bench.slow, slow)
    biases, steps, noises = [], [], []
    for sensor in bench.view.base:
        step, noise = bench.reading(sensor)
        biases.append(bench.moved_by(sensor) * bench.bias(sensor))
        steps.append(bench.moved_by(sensor) * step / np.sqrt(12.0))
        noises.append(bench.moved_by(sensor) * noise * bench.view.noise_left(sensor))
    alike = common_error(bench.view)
    together = abs(sum(bench.moved_by(sensor) for sensor in bench.view.base))
    shared = 0.0 if alike is None else together * alike.beside(bench.usual_bias)
    # errors that moved the part by more than the law leaves would stand in what it leaves
    moved = min(float(np.linalg.norm(biases)), bench.noise), min(shared, wanders)
    parts = [FEIGNED * float(np.linalg.norm(moved)), *steps]
    whole = float(np.linalg.norm(noises))
    lured = whole * min(MOST_FEIGNED, FEIGNED_NOISE * whole / bench.noise)
    return float(np.hypot(np.linalg.norm(parts), lured))


def erring(bench: Workbench, trial: Trial) -> float:
    """Return the misfit that slow biases of a trial's `errors` feign, RMS [m]; 0 where it has none.

    Of two thermometers at one temperature the second may fit the drift of few runs better by chance, and what the
    others foretell may do so better than a sound thermometer's reading: all that they differ by is errors.
    """
    if not trial.errors:
        return 0.0
    biases = np.linalg.norm([bench.bias(sensor) for sensor in trial.errors])
    return ERRING * abs(bench.moved_by(str(trial.target))) * float(biases)
