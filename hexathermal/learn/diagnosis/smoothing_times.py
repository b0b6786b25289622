"""How long the readings of each thermometer are smoothed: longer than usual where that takes little but their noise.

A reading that errs makes the law's coefficients too small (Fuller, Measurement Error Models, 1987, 1.1), most of all
where what wanders in the drift is slow: quick changes weigh most then, and of those a noisy reading knows least.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from hexathermal.learn.diagnosis.recorded import row_noise
from hexathermal.learn.diagnosis.smoothing import SMOOTHED_S, noise_left, smoothed
from hexathermal.learn.signals import RunRows
from hexathermal.poses import FloatArray

SMOOTHING_S = (SMOOTHED_S, 600.0, 1200.0)
"""Times over which temperatures may be smoothed."""

LOST = 0.5
"""What longer smoothing may take of the temperature itself, over what it takes of its noise, variances."""


def smoothing_times(runs: Sequence[RunRows], sensors: Sequence[str]) -> dict[str, float]:
    """Return over how many seconds the readings of each thermometer are smoothed.

    The next longer time serves where ``mean (S - L)² - taken`` is less than `LOST` of ``taken``, which is
    ``noise² mean (s² - l²)``: S and L are the readings smoothed over the one and the other time, s and l what these
    leave of white noise, whose covariance is l² (the longer parabola is one to the shorter, too).

    Parameters
    ----------
    runs : sequence of RunRows
        Of n rows in all.
    sensors : sequence of str
    """
    times = [rows.signals.time for rows in runs]
    left = {over: np.concatenate([noise_left(time, over) for time in times]) ** 2 for over in SMOOTHING_S}
    found = dict.fromkeys(sensors, SMOOTHED_S)
    for name in sensors:
        read = [rows.signals.dT[name][:, None] for rows in runs]
        noise, shorter = row_noise(runs, name), _all_smoothed(times, read, SMOOTHED_S)
        for longer in SMOOTHING_S[1:]:
            smoother = _all_smoothed(times, read, longer)
            taken = float((left[found[name]] - left[longer]).mean()) * noise**2
            if not ((shorter - smoother) ** 2).mean() - taken < LOST * taken:
                break
            found[name], shorter = longer, smoother
    return found


def _all_smoothed(times: Sequence[FloatArray], values: Sequence[FloatArray], over: float) -> FloatArray:
    """Return values of all runs, each smoothed by itself, one behind the other."""
    return np.concatenate([smoothed(time, own, over) for time, own in zip(times, values, strict=True)])


def smoothed_each(time: FloatArray, values: Mapping[str, FloatArray], over: Mapping[str, float]) -> FloatArray:
    """Return readings by name, shape (n,) each, smoothed over each thermometer's own time, shape (n, s)."""
    out = np.empty((len(time), len(values)))
    names = list(values)
    for span in {over[name] for name in names}:
        own = [k for k, name in enumerate(names) if over[name] == span]
        out[:, own] = smoothed(time, np.column_stack([values[names[k]] for k in own]), span)
    return out
