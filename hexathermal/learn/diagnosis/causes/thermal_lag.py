"""The part follows its thermometer late, or the thermometer the part."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from hexathermal.learn.diagnosis.mending import law_late
from hexathermal.learn.diagnosis.sensor_model import SensorModel
from hexathermal.learn.diagnosis.steadied import motion_of
from hexathermal.learn.diagnosis.trials import Cause, Delay, Parameter, Trial, Workbench
from hexathermal.learn.diagnosis.view import View
from hexathermal.machine.leg_signals import Memory
from hexathermal.poses import FloatArray

CAUSE = Cause(
    name="thermal-lag",
    physics=(
        "Heat needs time: the part behind the thermometer warms later (structure), or the thermometer later "
        "than the part (sensor)."
    ),
    signature="The residual follows the rate of the temperature; heating and cooling make a loop.",
    parameters=(
        Parameter("time_constant_s", "s", "log-uniform, 15 s to 4 h, two rows at least below 1 min"),
        Parameter("amplitude", "1", "of the law's own A; 1: the whole part lags, less: a part of it"),
    ),
    confused_with=(
        "clock-offset",
        "missing-sensor",
        "hidden-heat",
    ),
    experiment=(
        "A step of temperature at rest, logged every few seconds, beside a bare thermometer: a lag is an "
        "exponential, a clock a pure shift."
    ),
    words="{target} and the part behind it do not warm together",
    thermal=True,
    readings=10,
)

TIMES_S = (15.0, 30.0, 60.0, 120.0, 240.0, 480.0, 960.0, 1920.0, 3840.0, 7680.0, 15360.0)

KEPT_S = (1920.0, 3840.0, 7680.0)
"""Of these the part may not have come to rest when a run began, which its rows do not tell."""

LEAD_TIMES_S = (10.0, 20.0, 35.0, 60.0, 150.0, 400.0, 1000.0)
LATE_TIMES_S = (150.0, 400.0, 1000.0, 2500.0, 6000.0)
"""Of a thermometer that is so late that only the others know what it has yet to show."""

WHOLE_TIMES_S = tuple(np.geomspace(10.0, 1200.0, 15).tolist())
"""Of a law that is late as a whole: as short, and as close, as clocks may be off."""

WHOLE_LEADS = ((1, False), (3, False), (2, True))
"""Stages by which a thermometer is late as a whole, and whether its rates are smoothed."""

ALWAYS_S = 60.0
"""Shorter times are tried where two rows or more fall into them."""


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give low passes of each sensor of the law, of first and second order, and what a late sensor has yet to show.

    That is what its own rates tell, or where it is very late what the others foretell: they see it warm at once.
    """
    least = min(ALWAYS_S, 2.0 * bench.view.sampling)
    for sensor in bench.view.base:
        own = {"sensor": sensor, "ratio": bench.ratios[sensor]}
        for order in (1, 2):
            lags = [bench.term(CAUSE.name, "lag", sensor, time_constant_s=tau, order=order, **own)
                    for tau in TIMES_S if tau >= least]  # fmt: skip
            for term in lags:
                yield from _read(bench, term)
                if order == 1 and term.parameters["time_constant_s"] in KEPT_S:
                    yield bench.not_at_rest(term, term.parameters["time_constant_s"])
            yield from _wholly(bench, lags, order, late=False)
        leads = [bench.term(CAUSE.name, "lead", sensor, time_constant_s=tau, **own)
                 for tau in LEAD_TIMES_S if tau >= least]  # fmt: skip
        leads = [replace(term, parity=partial(_parity, term.parameters["time_constant_s"]), least_parity=0.0)
                 for term in leads]  # fmt: skip
        for term in leads:
            yield from _read(bench, term)
        for order, smooths in WHOLE_LEADS:
            yield from _wholly(bench, leads, order, late=True, smooths=smooths)
        if bench.view.moves:
            yield from _by_motion(bench, leads, own)
        yield from _late(bench, sensor, bench.ratios[sensor])


def _by_motion(bench: Workbench, leads: Sequence[Trial], own: dict[str, Any]) -> Iterator[Trial]:
    """Give what a late sensor has yet to show by its rate as motion explains it, and a law that is late as a whole."""
    view, sensor = bench.view, own["sensor"]
    heats = view.once((CAUSE.name, "heats", sensor), partial(_heats, view, sensor), [sensor])
    times = [lead.parameters["time_constant_s"] for lead in leads]
    first = bench.term(CAUSE.name, "lead-by-motion", sensor, **{**own, "time_constant_s": times[0], **heats})
    terms = [replace(first, columns=tau / times[0] * first.columns, parity=lead.parity, least_parity=lead.least_parity,
                     parameters={**first.parameters, "time_constant_s": tau})
             for tau, lead in zip(times, leads, strict=True)]  # fmt: skip
    yield from terms
    yield from _wholly(bench, terms, 1, late=True, by_motion=True)


def _heats(view: View, sensor: str) -> dict[str, Any]:
    """Return what motion explains of a sensor's readings, as parameters of its term."""
    return motion_of(view).heats(view.as_recorded.tables([sensor]))


def _wholly(
    bench: Workbench,
    terms: Sequence[Trial],
    order: int,
    *,
    late: bool,
    smooths: bool = False,
    by_motion: bool = False,
) -> Iterator[Trial]:
    """Give trials that are compared with a clock as that is told: the law is late as a whole, as its errors are.

    Of several thermometers this one alone, or all of them. The nearest of the terms stands for each in the law.
    """
    view, target = bench.view, str(terms[0].target)
    chosen = [(target,), view.base] if len(view.base) > 1 and target == bench.main else [(target,)]
    unlate = {sensors: _unlate(view, target, sensors) for sensors in chosen} if by_motion else {}
    times = np.log([term.parameters["time_constant_s"] for term in terms])

    def trial(sensors: tuple[str, ...], place: float) -> Trial:
        """Return the trial of a time constant, by its place among `WHOLE_TIMES_S`."""
        log_tau = float(np.interp(place, np.arange(len(WHOLE_TIMES_S)), np.log(WHOLE_TIMES_S)))
        term = terms[int(np.argmin(np.abs(times - log_tau)))]
        delay = Delay(sensors, (float(np.exp(log_tau)) / order,) * order, late, smooths, by_motion)
        law = view.once((CAUSE.name, delay), partial(law_late, view, delay))
        return Trial(CAUSE.name, np.zeros((len(law), 0)), target, "", term.parameters, base=law, anew=True, delay=delay,
                     unlate=unlate.get(sensors), term=term,
                     finer=lambda step: trial(sensors, place + step))  # fmt: skip

    for sensors in chosen:
        for place in range(len(WHOLE_TIMES_S)):
            yield trial(sensors, float(place))


def _unlate(view: View, target: str, sensors: tuple[str, ...]) -> Trial:
    """Return the trial of a law that reads its thermometers as motion explains them, none of them late."""
    delay = Delay(sensors, (), late=True, by_motion=True)
    law = view.once((CAUSE.name, delay), partial(law_late, view, delay))
    return Trial(CAUSE.name, np.zeros((len(law), 0)), target, base=law, anew=True, delay=delay)


def _read(bench: Workbench, trial: Trial) -> Iterator[Trial]:
    """Give a trial, and where lag and warming are quick also with temperatures as recorded: smoothing takes that."""
    yield trial
    sensor = trial.parameters["sensor"]
    if trial.parameters["time_constant_s"] < bench.view.smoothing[sensor] and bench.warms_quickly(sensor):
        yield replace(trial, columns=bench.view.as_recorded.columns(trial.shape, trial.parameters))


def _parity(tau: float, model: SensorModel) -> tuple[FloatArray, FloatArray]:
    """Return what a late sensor lacks against the others, in its parity."""
    lacks = []
    for signals, told in zip(model.view.signals, model.foretold(), strict=True):
        memory = Memory()
        once = memory.low_pass("once", signals.time, told, tau)
        lacks.append(np.stack([told - once, told - memory.low_pass("twice", signals.time, once, tau)], axis=1))
    columns = model.means(lacks)
    return columns, np.full(2, 2.0)


def _late(bench: Workbench, sensor: str, ratio: float) -> Iterator[Trial]:
    """Give what a late sensor lacks as the others foretell it, by weights that explain it behind low passes."""
    model = bench.model(sensor)
    if model is None:
        return
    for tau in LATE_TIMES_S:
        for order in (1, 2):
            stages = (tau / order,) * order
            weights = bench.view.once((CAUSE.name, sensor, stages), partial(_late_weights, model, stages))
            trial = bench.term(CAUSE.name, "foretold", sensor, sensor=sensor, weights=weights, ratio=ratio,
                               time_constant_s=tau, order=order)  # fmt: skip
            yield replace(trial, parity=partial(_late_parity, stages), least_parity=0.0, whole=True, asked=True)


def _late_weights(model: SensorModel, stages: tuple[float, ...]) -> dict[str, float]:
    """Return the weights of the other sensors that explain a sensor behind low passes."""
    return model.sensor_weights(model.weights(behind=model.behind(stages)))


def _late_parity(stages: tuple[float, ...], model: SensorModel) -> tuple[FloatArray, FloatArray]:
    """Return by how much a late sensor is behind what the others foretell, in its parity."""
    behind = model.behind(stages)
    weights = model.weights(behind=behind)
    late = [(then - now) @ weights for then, now in zip(behind, model.profiles, strict=True)]
    return model.means(late)[:, None], np.ones(1)
