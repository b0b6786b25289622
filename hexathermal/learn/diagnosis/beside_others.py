"""What a thermometer reads beside what the others foretell: it drifts, or its contact with the part comes and goes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from hexathermal.learn.diagnosis.sensor_model import SensorModel
from hexathermal.learn.diagnosis.view import View
from hexathermal.machine.leg_repairs import SensorRepair
from hexathermal.machine.leg_signals import Memory
from hexathermal.poses import FloatArray

SLOW_S = 1800.0
"""What wanders is slower than that; what the others foretell wrong is as quick as heat."""

USUAL_SHARE = 0.3
"""Standard deviation of the share of the air that is read on the whole."""

LEAST_GAP_K = 0.05
"""Where the air differs from the part by less, RMS, nobody tells how it is read."""


def lost(model: SensorModel, weights: FloatArray) -> FloatArray:
    """Return what the others foretell less what is read, at once and behind a low pass, in windows, (n, 2) [K].

    `weights` (k,) are those of the leading profiles.
    """
    at_once, late = [], []
    for signals, profiles in zip(model.view.signals, model.profiles, strict=True):
        left = profiles @ weights - signals.dT[model.sensor]
        at_once.append(left)
        late.append(Memory().low_pass("lost", signals.time, left, SLOW_S))
    return np.column_stack([model.view.windows_zeroed(at_once), model.view.windows_zeroed(late)])


def weights_beside_drift(model: SensorModel) -> FloatArray:
    """Return the weights of the others' profiles, learnt beside a drift of the reading in each run, shape (k,)."""

    def learnt() -> FloatArray:
        zeroed = model.view.zeroed_by_run
        hours = [(signals.time - zeroed * signals.time[0]) / 3600.0 for signals in model.view.signals]
        return model.weights_beside(model.means(hours)[:, None], np.array([2.0 * model.null[0].rms]))

    return model.view.once(("weights beside drift", model.sensor), learnt)


def replaced(
    cause: str, model: SensorModel, weights: FloatArray, since: Mapping[str, Any] | None = None
) -> SensorRepair:  # fmt: skip
    """Return the repair of a cause: the others speak for the sensor, in all runs, or `since` a moment of some."""
    own = {"sensor": model.sensor, "weights": model.sensor_weights(weights)}
    return SensorRepair(cause, "detached", own | dict(since or {}))


def coming_and_going(model: SensorModel) -> tuple[float, list[FloatArray]]:
    """Return how much likelier it is that a share of the air wanders than that the reading does, and weights, (k,).

    With s the share of the air, ``s (T_air - T)`` is what the other thermometers do not foretell; of a reading that
    drifts it is a process of its own, whatever the air does. Either is a first-order process, beside a mean share; its
    log evidence in the parity is over that of the other. The weights are those of the leading profiles that foretell
    the thermometer beside the one and beside the other, and beside a drift.
    """
    centre, gap = model.expected[0], _above(model)
    size = float(np.sqrt((gap**2).mean()))
    if size < LEAST_GAP_K:
        return -np.inf, []
    levels, plain = model.null
    # a share that stays is open to both
    since = gap - gap[model.channel.start][model.channel.run] if model.view.zeroed_by_run else gap
    X, sd = np.column_stack([model.X, since]), np.append(model.sd, USUAL_SHARE)
    steady = max(plain, model.channel.fitted(X, sd, near=levels)[1])
    channel = replace(model.channel, shown=gap / size)
    loose, value = channel.fitted(X, sd, near=levels)
    means = channel.solved(X, sd, loose)[1], model.channel.solved(model.X, model.sd, levels)[1]
    return value - steady, [*(centre + mean[: len(centre)] for mean in means), weights_beside_drift(model)]


def _above(model: SensorModel) -> FloatArray:
    """Return by how much the air is warmer than what the others foretell, in windows of the parity, shape (m,) [K]."""
    airs, told = model.view.airs, model.foretold()
    assert airs is not None  # looked at before
    return model.means([air - own + air_above_at_zero(model, run)
                        for run, (air, own) in enumerate(zip(airs, told, strict=True))])  # fmt: skip


def air_read(view: View, key: str = "sensor") -> dict[str, Any]:
    """Return what makes a term or a repair read the thermometer that stands for the air; nothing where none does."""
    names = {rows.air_sensor for rows in view.runs}
    name = names.pop() if len(names) == 1 else None
    return {} if name is None else {key: name}


def air_above_at_zero(model: SensorModel, run: int) -> float:
    """Return by how much the air is warmer than the sensor at a run's zero [K]; 0 where that is not known.

    A part that is warm when a run begins counts from its own warmth, the air from that of the room.
    """
    rows = model.view.runs[run]
    if rows.air_sensor is not None and {rows.air_sensor, model.sensor} <= rows.signals.zero_degC.keys():
        return rows.signals.zero_of(rows.air_sensor) - rows.signals.zero_of(model.sensor)
    if rows.weather is None or rows.signals.air is None or model.sensor not in rows.signals.zero_degC:
        return 0.0
    return float(rows.weather[0, 0] - rows.signals.air[0]) - rows.signals.zero_of(model.sensor)
