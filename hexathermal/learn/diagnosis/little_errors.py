"""What any thermometer of a law errs by a little: it lets in some of the air, and is late by seconds.

Both have small priors, and hide nothing: what they could take of a cause stays visible. With A, r and T of thermometer
s, ``A_s (q0 + r_s q)`` times

``T_air - T_air(0)``, of size `CONTACT`;    ``(lag(T_s) - T_s) / SEEN_S``, of size `LATE_S`: its rate, hardly smoothed
and smoothed. Lateness stands there where it leads, and is as small as it is everywhere.
"""

from __future__ import annotations

import numpy as np

from hexathermal.learn.diagnosis.ranking import Step
from hexathermal.learn.diagnosis.rivals import LATE, OFF, of_cause
from hexathermal.learn.diagnosis.trials import Workbench
from hexathermal.poses import FloatArray

CONTACT = 0.03
"""Part of the room's air that a thermometer on a surface lets in, RMS: tape and stem conduct. Engineering value."""

LATE_S, SEEN_S = 10.0, (10.0, 60.0)
"""By how much a thermometer, or its logger, is late, RMS: a taped one takes 5 to 15 s, and most loggers read theirs in
turn. Engineering value. And the low passes that tell the rate of a temperature."""

MOST_LATE_S, AS_GOOD = 20.0, 0.5
"""Lateness up to which that is how thermometers are, as a clock tells it which has such a part of what leads."""


def little_errors(bench: Workbench, *, late: bool) -> tuple[FloatArray, FloatArray]:
    """Return columns of the misfit that little errors of the law's thermometers make, (n, k), and their sizes, (k,).

    Of the air where somebody records it; of lateness where they are `late`.
    """
    view, columns, sizes = bench.view, [np.zeros((len(bench.view.q), 0))], list[float]()
    if view.airs is not None:
        columns.append(np.column_stack([bench.moving(name) for name in view.base]) * view.windows_zeroed(view.airs))
        sizes += [CONTACT] * columns[-1].shape[1]
    if late:
        columns += [bench.slopes[name] * _rate(bench, name, seen) for name in view.base for seen in SEEN_S]
        sizes += [LATE_S] * (len(SEEN_S) * len(view.base))
    return np.column_stack(columns), np.array(sizes)


def usual_lateness(step: Step, threshold: float) -> float | None:
    """Return by how many seconds temperatures are late where that leads, and is how thermometers are; else None."""
    top = step.ranking[0]
    clock = of_cause(step.ranking, OFF)
    if clock is None or top.cause not in (LATE, OFF) or top.value < threshold:
        return None
    late = float(clock.best.trial.parameters.get("offset_s", np.inf))
    return late if abs(late) <= MOST_LATE_S and clock.value > AS_GOOD * top.value else None


def _rate(bench: Workbench, sensor: str, seen: float) -> FloatArray:
    """Return the rate of a thermometer as its low pass is behind it, times what it acts on, shape (n, 1)."""
    ratio = bench.ratios[sensor]
    return bench.term("", "lag", sensor, time_constant_s=seen, order=1, sensor=sensor, ratio=ratio).columns / seen
