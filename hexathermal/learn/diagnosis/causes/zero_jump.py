"""The zero jumps once, at an unknown time."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from hexathermal.learn.diagnosis.trials import Cause, Parameter, Trial, Workbench
from hexathermal.learn.diagnosis.view import View
from hexathermal.poses import FloatArray

CAUSE = Cause(
    name="zero-jump",
    physics="A beam was touched, a clamp slipped, a count was lost: from then on all is off by a constant.",
    signature="A step of the residual at one moment of one run, at no move of that size elsewhere.",
    parameters=(
        Parameter("time_s", "s", "any moment of any run"),
        Parameter("step", "m", "visible effect of 0.25 to 4 times the noise"),
    ),
    confused_with=(
        "sensor-detached",
        "backlash",
    ),
    experiment="Return to the first position and temperature after the run: the step stays.",
    words="the zero jumps in {target}",
    readings=2,
)

MOST_MOMENTS = 960
"""Of all runs together, so that the work grows with the rows alone: a quarter evenly among the windows of a run,
half evenly in time, so that neither many short landings nor one long rest is passed over, and a quarter where the drift
changes most from one window to the next."""

LEAST_BEHIND = 3
"""Windows of a run that must come before a step and follow it, where each run has a zero of its own: fewer may be a
spike, or a bad zero."""


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give steps at the beginnings of windows, run by run."""
    yield from bench.view.once((CAUSE.name,), lambda: tuple(_steps(bench.view)), ())


def _steps(view: View) -> Iterator[Trial]:
    """Give the trials, which no stage of a diagnosis changes."""
    run, time = view.channel.run, view.time
    moments = max(4, MOST_MOMENTS // len(view.runs))
    for k, rows in enumerate(view.runs):
        own = np.flatnonzero(run == k)
        first, last = (LEAST_BEHIND, len(own) - LEAST_BEHIND) if view.zeroed_by_run else (int(k == 0), len(own) - 1)
        change = np.abs(np.diff(view.channel.y[own], prepend=view.channel.y[own[:1]]))
        for i in _moments(time[own], change, first, last, moments) + own[0] if last > first else ():
            moment = float(time[i])
            where = {"run": rows.run.name, "time_s": round(moment, 1)}
            yield Trial(CAUSE.name, view.step_from(k, moment)[:, None], rows.run.name, "", where)


def _moments(time: FloatArray, change: FloatArray, first: int, last: int, most: int) -> npt.NDArray[np.int64]:
    """Return windows of a run in which a step may begin, from window `first` to `last`."""
    if last - first < most:
        return np.arange(first, last + 1)
    by_time = np.searchsorted(time, np.linspace(time[first], time[last], most // 2))
    largest = first + np.argsort(-change[first : last + 1])[: most // 4]
    return np.unique([*np.linspace(first, last, most // 4).astype(int), *by_time, *largest])
