"""The reading of a thermometer drifts."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from functools import partial

import numpy as np

from hexathermal.learn.diagnosis.beside_others import lost, replaced, weights_beside_drift
from hexathermal.learn.diagnosis.onsets import KINDS, Onset, promising, runs_since, sound_rows, where
from hexathermal.learn.diagnosis.sensor_model import SensorModel
from hexathermal.learn.diagnosis.trials import Cause, Parameter, Trial, Workbench
from hexathermal.learn.diagnosis.view import View
from hexathermal.machine.leg_repairs import SensorRepair
from hexathermal.poses import FloatArray

CAUSE = Cause(
    name="sensor-drift",
    physics=(
        "The contact, the wire or the logger channel of one thermometer changes: its reading walks away from "
        "the temperature."
    ),
    signature=(
        "The residual is the law at a temperature error that grows with time; the other thermometers do not see it."
    ),
    parameters=(
        Parameter("rate", "K/h", "0.25 to 4 times the noise in the drift"),
        Parameter("from_share", "1", "0 to 0.6 of the running time"),
        Parameter("time_s", "s", "in place of that any moment of any run"),
        Parameter("ends_with_run", "1", "0: it goes on in later runs; 1: it does not"),
        Parameter("power", "1", "of the time since, 0.7 to 1.6"),
        Parameter("wander", "K", "as the other thermometers tell"),
    ),
    confused_with=(
        "zero-drift",
        "missing-sensor",
    ),
    experiment="Read the thermometer beside a second one for a day at constant temperature.",
    words="the reading of {target} drifts",
    thermal=True,
    readings=24,
)

DECAYS = (1e9, 3.0)
"""The drift keeps its rate from run to run, or loses it within so many runs."""

ONSETS, POWERS = (0.0, 0.2, 0.4, 0.6), (0.7, 1.0, 1.6)
"""Parts of the campaign's running time from which on it may drift, and powers of the time with which it does."""


@dataclass(frozen=True)
class Course:
    """How a reading drifts: in each run, less from run to run; or, without `decay_runs`, in all of them together."""

    decay_runs: float = 0.0
    from_share: float = 0.0
    power: float = 1.0


COURSES = (
    *(Course(decay) for decay in DECAYS),
    *(Course(0.0, share, power) for share in ONSETS for power in POWERS if (share, power) != (0.0, 1.0)),
)
STEADY = COURSES[0]

ASKED_AT = 120
"""Moments of either kind at which the parity is asked whether a drift begins."""


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give errors of each of the law's sensors that grow with time, and the sensor as the others foretell it."""
    view = bench.view
    for sensor in view.base:
        model = bench.model(sensor)
        if model is None:
            continue
        span = bench.slopes_span(sensor)
        for course in COURSES:
            rows = view.once((CAUSE.name, course), partial(_hours, view, course))
            column = view.windows_zeroed(rows)[:, 0]
            settings = {name: number for name, number in asdict(course).items() if number != getattr(Course(), name)}
            yield Trial(CAUSE.name, -(span * column)[:, None], sensor, "", settings,
                        parity=partial(_parity, course), in_parity=1.0, repair=partial(_repair, model),
                        lessened=_lessened(view, sensor, course, rows))  # fmt: skip
        yield from _begun(bench, model)
        hours = view.time / 3600.0
        for left in view.once((CAUSE.name, sensor), partial(lost, model, weights_beside_drift(model))).T:
            rate = -float(hours @ left / (hours @ hours))
            alike = float(rate**2 * (hours @ hours) / max(left @ left, np.finfo(float).tiny))
            settings = {"decay_runs": STEADY.decay_runs, "rate_K_per_h": rate}
            told = Trial(CAUSE.name, (span * left)[:, None], sensor, "", settings,
                         parity=partial(_parity, STEADY), in_parity=rate, alike=alike, errors=(sensor,),
                         repair=partial(_repair, model))  # fmt: skip
            yield told
            yield replace(told, parameters={}, in_parity=0.0, wanders=True)


def _begun(bench: Workbench, model: SensorModel) -> Iterator[Trial]:
    """Give a drift that begins at a moment at which the parity breaks, to the end of that run or of all."""
    view, sensor = bench.view, model.sensor
    onsets = view.once((CAUSE.name, sensor, "onsets"), partial(promising, model, _ramp, ASKED_AT))
    price = math.log(KINDS * ASKED_AT / max(len(onsets), 1))
    for onset in onsets:
        column = view.windows_zeroed(_hours_since(view, onset))[:, 0]
        told = where(model, onset, "ends_with_run")
        yield Trial(CAUSE.name, -(bench.slopes_span(sensor) * column)[:, None], sensor, "", told,
                    parity=partial(_ramp, onset), in_parity=1.0, repair=partial(_from_then_on, model, onset),
                    asked=True, advantage=-price)  # fmt: skip


def _hours_since(view: View, onset: Onset) -> list[FloatArray]:
    """Return hours of drift in all rows of each run, at a rate of 1: since the moment it began; later runs go on.

    On the campaign's clock, where all runs count from one zero; else since each one's begin.
    """
    clocks = _clocks(view)
    begin = clocks[onset.run][0] + (onset.moment - float(view.signals[onset.run].time[0])) / 3600.0
    rows = []
    for run, clock in enumerate(clocks):
        shows = run == onset.run or (onset.stays and run > onset.run)
        own = np.maximum(clock - begin, 0.0) * shows
        rows.append(own - own[0] if view.zeroed_by_run else own)
    return rows


def _ramp(onset: Onset, model: SensorModel) -> tuple[FloatArray, FloatArray]:
    """Return a drift that begins at a moment in the parity of a sensor."""
    return model.means(_hours_since(model.view, onset))[:, None], np.array([2.0 * model.null[0].rms])


def _from_then_on(model: SensorModel, onset: Onset) -> SensorRepair:
    """Return the repair: the others speak for the sensor from the moment on, as they learnt where it was sound."""
    return replaced(CAUSE.name, model, model.weights(sound_rows(model, onset)), runs_since(model, onset))


def _hours(view: View, course: Course) -> list[FloatArray]:
    """Return hours of drift in all rows of each run, at a rate that ends, or begins to decay, at 1.

    They run with the runs, or on the campaign's clock.
    """
    if course.decay_runs:
        return [one.time / 3600.0 * np.exp(-run / course.decay_runs) for run, one in enumerate(view.signals)]
    clocks = _clocks(view)
    whole = float(clocks[-1][-1])
    late = (np.maximum(clock / whole - course.from_share, 0.0) for clock in clocks)
    steepest = course.power * (1.0 - course.from_share) ** (course.power - 1.0)
    return [whole / steepest * share**course.power for share in late]


def _clocks(view: View) -> list[FloatArray]:
    """Return what `_counted` does, made once."""
    return view.once((CAUSE.name, "clocks"), partial(_counted, view), ())


def _counted(view: View) -> list[FloatArray]:
    """Return the campaign's clock in all rows of each run [h]: pauses count where they are known."""
    clocks, begun = list[FloatArray](), 0.0
    for signals, goes_on in zip(view.signals, view.goes_on, strict=True):
        begun = begun if goes_on or not clocks else float(clocks[-1][-1])
        clocks.append(signals.time / 3600.0 + begun)
    return clocks


def _repair(model: SensorModel) -> SensorRepair:
    """Return the repair: the others speak for the sensor."""
    return replaced(CAUSE.name, model, weights_beside_drift(model))


def _lessened(
    view: View, sensor: str, course: Course, hours: list[FloatArray]
) -> Callable[[float], SensorRepair] | None:
    """Return what gives the repair that takes an error of a rate [K/h] away; None where runs have not rates alone.

    Each run drifts at its mean rate; runs that were not looked at as the last one before them did.
    """
    if not view.zeroed_by_run and course != STEADY:
        return None
    shares = [3600.0 * float((own[-1] - own[0]) / (signals.time[-1] - signals.time[0]))
              for own, signals in zip(hours, view.signals, strict=True)]  # fmt: skip
    names = [rows.run.name for rows in view.runs]
    known = sorted((view.order.index(name), share) for name, share in zip(names, shares, strict=True))

    def lessened(rate: float) -> SensorRepair:
        """Return the repair."""
        own: dict[str, float] = {}
        for place, name in enumerate(view.order):
            before = [share for at, share in known if at <= place]
            own[name] = rate * (before[-1] if before else shares[0])
        last = rate * known[-1][1]
        others = {name: value for name, value in own.items() if not np.isclose(value, last, rtol=1e-6)}
        parameters = {"sensor": sensor, "rate_K_per_h": last} | ({"rates_K_per_h": others} if others else {})
        return SensorRepair(CAUSE.name, "drift", parameters)

    return lessened


def _parity(course: Course, model: SensorModel) -> tuple[FloatArray, FloatArray]:
    """Return the error in the parity of a sensor."""
    view = model.view
    rows = view.once((CAUSE.name, course), partial(_hours, view, course))
    if view.zeroed_by_run:
        rows = [own - own[0] for own in rows]
    return model.means(rows)[:, None], np.array([2.0 * model.null[0].rms])
