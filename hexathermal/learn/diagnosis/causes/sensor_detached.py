"""From an unknown time a thermometer reads the air."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from hexathermal.learn.diagnosis.sensor_model import SensorModel
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
    experiment="Look at it; touch it and see whether it answers as before.",
    words="{target} has come off and reads the air",
    thermal=True,
)

MOST_MOMENTS = 63
"""Of all runs together."""


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
        for k, rows in enumerate(view.runs):
            for part in np.linspace(0.0, 0.9, max(2, min(7, MOST_MOMENTS // len(view.runs)))):
                if k == 0 and part == 0.0:
                    continue
                begin, end = float(rows.signals.time[0]), float(rows.signals.time[-1])
                moment = begin + part * (end - begin)
                told = _foretold(model, k, moment)
                off = (view.channel.run > k) | ((view.channel.run == k) & (view.time >= moment))
                lost = off * (view.windows_zeroed(told) - own)
                where = {"run": rows.run.name, "time_s": round(moment, 1)}
                yield Trial(CAUSE.name, (span * lost)[:, None], sensor, "", where, parity=partial(_parity, k, moment),
                            repair=partial(_repair, model, k, moment))  # fmt: skip


def _repair(model: SensorModel, run: int, moment: float) -> SensorRepair:
    """Return the repair: from the moment on the others speak for the sensor, in all later runs too."""
    runs = model.view.order
    at = runs.index(model.view.runs[run].run.name)
    begins = {runs[at]: moment} | dict.fromkeys(runs[at + 1 :], 0.0)
    weights = model.sensor_weights(model.weights(_before(model, run, moment)))
    return SensorRepair(CAUSE.name, "detached", {"sensor": model.sensor, "weights": weights, "from_s": begins})


def _foretold(model: SensorModel, run: int, moment: float) -> list[FloatArray]:
    """Return what the other sensors foretell, learnt before the moment in run `run`."""
    return model.foretold(_before(model, run, moment))


def _before(model: SensorModel, run: int, moment: float) -> list[slice]:
    """Return the rows of each run before the moment in run `run`."""
    before = []
    for i, signals in enumerate(model.view.signals):
        last = int(np.searchsorted(signals.time, moment)) if i == run else 0
        before.append(slice(None) if i < run else slice(0, last))
    return before


def _parity(run: int, moment: float, model: SensorModel) -> tuple[FloatArray, FloatArray]:
    """Return by how much the air differs from the foretold temperature once contact is lost, in the parity."""
    gaps = []
    for i, (signals, told) in enumerate(zip(model.view.signals, _foretold(model, run, moment), strict=True)):
        assert signals.air is not None  # looked at before
        on = (signals.time >= moment) if i == run else np.full(len(told), i > run)
        gaps.append(on * (signals.air - told))
    return model.means(gaps)[:, None], np.array([0.7])
