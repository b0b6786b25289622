"""The reading of a thermometer drifts."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from hexathermal.learn.diagnosis.sensor_model import SensorModel
from hexathermal.learn.diagnosis.trials import Cause, Parameter, Trial, Workbench
from hexathermal.machine.leg_repairs import SensorRepair
from hexathermal.machine.leg_signals import Memory
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
    parameters=(Parameter("rate", "K/h", "0.25 to 4 times the noise in the drift"),),
    confused_with=(
        "zero-drift",
        "missing-sensor",
    ),
    experiment="Read the thermometer beside a second one for a day at constant temperature.",
    words="the reading of {target} drifts",
    thermal=True,
    readings=24,
)

SLOW_S = 1800.0
"""A drift that wanders is slower than that; what the others foretell wrong is as quick as heat."""

DECAYS = (1e9, 3.0)
"""The drift keeps its rate from run to run, or loses it within so many runs."""


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give errors of each of the law's sensors that grow with time, and the sensor as the others foretell it."""
    view = bench.view
    for sensor in view.base:
        model = bench.model(sensor)
        if model is None:
            continue
        span = bench.slopes_span(sensor)
        for decay in DECAYS:
            fade = np.exp(-view.channel.run / decay)
            yield Trial(CAUSE.name, -(span * view.time / 3600.0 * fade)[:, None], sensor, "", {"decay_runs": decay},
                        parity=partial(_parity, decay), in_parity=1.0, repair=partial(_repair, model))  # fmt: skip
        hours = view.time / 3600.0
        for lost in view.once((CAUSE.name, sensor), partial(_lost, model)).T:
            rate = -float(hours @ lost / (hours @ hours))
            settings = {"decay_runs": DECAYS[0], "rate_K_per_h": rate}
            yield Trial(CAUSE.name, (span * lost)[:, None], sensor, "", settings,
                        parity=partial(_parity, DECAYS[0]), in_parity=rate, repair=partial(_repair, model))  # fmt: skip


def _lost(model: SensorModel) -> FloatArray:
    """Return what the others foretell less what is read, at once and behind a low pass, in windows, (n, 2) [K]."""
    view, weights, at_once, late = model.view, _weights(model), [], []
    for signals, profiles in zip(view.signals, model.profiles, strict=True):
        lost = profiles @ weights - signals.dT[model.sensor]
        at_once.append(lost)
        late.append(Memory().low_pass("lost", signals.time, lost, SLOW_S))
    return np.column_stack([view.windows_zeroed(at_once), view.windows_zeroed(late)])


def _weights(model: SensorModel) -> FloatArray:
    """Return the weights of the others' profiles, learnt beside a drift."""
    learnt = (CAUSE.name, "weights", model.sensor)
    return model.view.once(learnt, lambda: model.weights_beside(*_parity(DECAYS[0], model)))


def _repair(model: SensorModel) -> SensorRepair:
    """Return the repair: the others speak for the sensor."""
    weights = model.sensor_weights(_weights(model))
    return SensorRepair(CAUSE.name, "detached", {"sensor": model.sensor, "weights": weights})


def _parity(decay: float, model: SensorModel) -> tuple[FloatArray, FloatArray]:
    """Return the error in the parity of a sensor."""
    hours = model.means([signals.time / 3600.0 for signals in model.view.signals])
    return (hours * np.exp(-model.channel.run / decay))[:, None], np.array([2.0 * model.null[0].rms])
