"""From an unknown time a thermometer reads the air."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hexathermal.learn.diagnosis.trials import Cause, Parameter, Trial, Workbench
from hexathermal.poses import FloatArray

CAUSE = Cause(
    name="sensor-detached",
    physics="The tape or the glue of one thermometer gives way: from then on it shows mostly the air beside the part.",
    signature="From one moment on the thermometer leaves its neighbours and goes towards the air; the drift follows the neighbours.",
    parameters=(Parameter("time_s", "s", "any moment of any run"), Parameter("share", "1", "of the air in the reading after that"),),
    confused_with=("sensor-drift", "zero-jump", "missing-sensor",),
    experiment="Look at it; touch it and see whether it answers as before.",
    words="{target} has come off and reads the air",
)

PARTS_OF_RUN = (0.0, 0.15, 0.3, 0.45, 0.6, 0.75, 0.9)


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give a loss of contact of each of the law's sensors at moments of each run."""
    view = bench.view
    if any(rows.signals.air is None for rows in view.runs):
        return
    for sensor in view.base:
        model = bench.model(sensor)
        if model is None:
            continue
        span = view.span(bench.ratios[sensor])
        own = view.temperatures(sensor)
        size = np.array([0.7])
        for k, rows in enumerate(view.runs):
            end = float(rows.signals.time[-1])
            for part in PARTS_OF_RUN:
                if k == 0 and part == 0.0:
                    continue
                moment = part * end
                before = [_until(signals.time, k, i, moment) for i, signals in enumerate(view.signals)]
                told = model.foretold(before)
                off = ((view.channel.run > k) | ((view.channel.run == k) & (view.time >= moment))).astype(float)
                lost = off * (view.windows_zeroed(told) - own)
                gap = [_gap(signals.air, foretold, signals.time, k, i, moment)
                       for i, (signals, foretold) in enumerate(zip(view.signals, told, strict=True))]  # fmt: skip
                parity = (model, model.means(gap)[:, None], size)
                where = {"run": rows.run.name, "time_s": round(moment, 1)}
                yield Trial(CAUSE.name, (span * lost)[:, None], sensor, "", where, parity=parity)


def _until(time: FloatArray, run: int, i: int, moment: float) -> slice:
    """Return the rows of run `i` before the moment in run `run`."""
    return slice(None) if i < run else slice(0, int(np.searchsorted(time, moment)) if i == run else 0)


def _gap(air: FloatArray | None, told: FloatArray, time: FloatArray, run: int, i: int, moment: float) -> FloatArray:
    """Return by how much the air differs from the foretold temperature once contact is lost [K]."""
    assert air is not None  # looked at before
    on = (time >= moment) if i == run else np.full(len(time), i > run)
    return np.asarray(on * (air - told))
