"""From an unknown time a thermometer reads the air."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from hexathermal.learn.diagnosis.sensor_model import BIAS_K, SensorModel
from hexathermal.learn.diagnosis.trials import Cause, Parameter, Trial, Workbench
from hexathermal.machine.leg_repairs import SensorRepair
from hexathermal.poses import FloatArray

CAUSE = Cause(
    name="sensor-detached",
    physics=(
        "The tape or the glue of one thermometer gives way: from then on it shows mostly the air beside the part."
    ),
    signature=(
        "From one moment on the thermometer leaves its neighbours and goes towards the air; the drift follows"
        " the neighbours."
    ),
    parameters=(
        Parameter("time_s", "s", "any moment of any run"),
        Parameter("share", "1", "of the air in the reading after that"),
    ),
    confused_with=(
        "sensor-drift",
        "zero-jump",
        "missing-sensor",
    ),
    experiment="Look at that thermometer; touch it and see whether it answers as before.",
    words="{target} has come off and reads the air",
    thermal=True,
)

MOST_MOMENTS = 63
"""Evenly in all runs together."""

LAST = 0.98
"""Part of a run in which it may happen: what is lost near the end still shows in later runs."""

LEARNT_S = 600.0
"""So long it must have been seen on the part before, for the others to be able to speak for it."""

SCANNED, CLOSER, PROMISING = 360, 3, 10
"""Moments at which the parity is asked where it breaks, the best of them that are looked at more closely, and so many
of the best that are tried besides."""


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give a loss of contact of each of the law's sensors at moments of each run."""
    view = bench.view
    if any(rows.signals.air is None for rows in view.runs):
        return
    for sensor in view.base:
        model = bench.model(sensor)
        if model is None:
            continue
        span, own = bench.slopes_span(sensor), view.temperatures(sensor)
        even = _even_moments(model, min(7, MOST_MOMENTS // len(view.runs)))
        promising = set(view.once((CAUSE.name, sensor), partial(_promising_moments, model)))
        for k, moment in sorted({*even, *promising}):
            told = view.once((CAUSE.name, sensor, k, moment), partial(_told, model, k, moment))
            off = (view.channel.run > k) | ((view.channel.run == k) & (view.time >= moment))
            lost = off * (told - own)
            where = {"run": view.runs[k].run.name, "time_s": round(moment, 1)}
            asked = (k, moment) in promising
            yield Trial(CAUSE.name, (span * lost)[:, None], sensor, "", where, parity=partial(_parity, k, moment),
                        repair=partial(_repair, model, k, moment), asked=asked, partly=True,
                        advantage=-math.log(SCANNED / len(even)) if asked else 0.0)  # fmt: skip


def _even_moments(model: SensorModel, each: int) -> list[tuple[int, float]]:
    """Return moments evenly in each run; in the first, after what the others learn from."""
    found = []
    for k in range(len(model.view.runs)):
        begin, end = _span(model, k)
        last = begin + LAST * (end - begin)
        found += [(k, float(moment)) for moment in np.linspace(begin, last, max(2, each))]
    return found


def _span(model: SensorModel, run: int) -> tuple[float, float]:
    """Return the first and the last moment of a run [s] at which it may come off."""
    time = model.view.signals[run].time
    begin, end = float(time[0]), float(time[-1])
    return (begin if run else min(begin + LEARNT_S, 0.5 * (begin + end))), end


def _promising_moments(model: SensorModel) -> list[tuple[int, float]]:
    """Return the moments from which on the parity goes towards the air most clearly.

    They are compared at a noise without a fault: what was fitted with the fault in it forgives any.
    """
    levels = model.null[0]
    sound = replace(levels, slow=min(levels.slow, BIAS_K), offset=min(levels.offset, BIAS_K))
    scores: dict[tuple[int, float], float] = {}

    def scan(places: Iterable[tuple[int, float]]) -> list[tuple[int, float]]:
        """Score places; return the best of all so far."""
        for k, moment in places:
            columns, sizes = _parity(k, moment, model)
            X, sd = np.column_stack([model.X, columns]), np.concatenate([model.sd, sizes])
            scores[k, moment] = model.channel.evidence(X, sd, sound)
        return sorted(scores, key=lambda place: -scores[place])

    best = scan(_even_moments(model, SCANNED // len(model.view.runs)))[:CLOSER]
    for k, moment in best:
        begin, end = _span(model, k)
        step = LAST * (end - begin) / (SCANNED // len(model.view.runs) - 1)
        near = np.clip(moment + step * np.array([-0.75, -0.5, -0.25, 0.25, 0.5, 0.75]), begin, end)
        scan((k, float(one)) for one in near)
    return scan(())[:PROMISING]


def _repair(model: SensorModel, run: int, moment: float) -> SensorRepair:
    """Return the repair: from the moment on the others speak for the sensor, in all later runs too."""
    runs = model.view.order
    at = runs.index(model.view.runs[run].run.name)
    begins = {runs[at]: moment} | dict.fromkeys(runs[at + 1 :], 0.0)
    weights = model.sensor_weights(model.weights(_before(model, run, moment)))
    return SensorRepair(CAUSE.name, "detached", {"sensor": model.sensor, "weights": weights, "from_s": begins})


def _told(model: SensorModel, run: int, moment: float) -> FloatArray:
    """Return what the other sensors foretell in windows, learnt before the moment in run `run`."""
    return model.view.windows_zeroed(model.foretold(_before(model, run, moment)))[:, 0]


def _before(model: SensorModel, run: int, moment: float) -> list[slice]:
    """Return the rows of each run before the moment in run `run`."""
    before = []
    for i, signals in enumerate(model.view.signals):
        last = int(np.searchsorted(signals.time, moment)) if i == run else 0
        before.append(slice(None) if i < run else slice(0, last))
    return before


def _parity(run: int, moment: float, model: SensorModel) -> tuple[FloatArray, FloatArray]:
    """Return by how much the air differs from the foretold temperature once contact is lost, in the parity."""
    weights = model.weights(_before(model, run, moment))
    gaps = []
    for i, (signals, profiles) in enumerate(zip(model.view.signals, model.profiles, strict=True)):
        assert signals.air is not None  # looked at before
        gap = np.zeros(len(profiles))
        first = len(gap) if i < run else int(np.searchsorted(signals.time, moment)) if i == run else 0
        gap[first:] = signals.air[first:] - profiles[first:] @ weights
        gaps.append(gap)
    return model.means(gaps)[:, None], np.array([0.7])
