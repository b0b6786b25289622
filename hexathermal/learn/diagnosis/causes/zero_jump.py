"""The zero jumps once, at an unknown time."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt
from scipy.ndimage import maximum_filter1d

from hexathermal.learn.cleaning_rules import medians_of_five
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

FIVE, MOST_WITHIN = 5, 8
"""Within landings, the moments of each run at which medians of so many rows step most: a step hardly ever keeps to
windows, and the rows of one landing may scatter much less than landings do."""

LEAST_BEHIND = 3
"""Windows of a run that must come before a step and follow it, where each run has a zero of its own: fewer may be a
spike, or a bad zero."""


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give steps at the beginnings of windows, run by run."""
    yield from bench.view.once((CAUSE.name,), lambda: tuple(_steps(bench.view)), ())


def _steps(view: View) -> Iterator[Trial]:
    """Give the trials, which no stage of a diagnosis changes."""
    run = view.channel.run
    most = max(4, MOST_MOMENTS // len(view.runs))
    for k, (rows, piece) in enumerate(zip(view.runs, view.pieces, strict=True)):
        y, time = view.channel.y[run == k], rows.signals.time[piece.used]
        first, last = (LEAST_BEHIND, len(y) - LEAST_BEHIND) if view.zeroed_by_run else (int(k == 0), len(y) - 1)
        if last <= first:
            continue
        began = time[piece.edges]
        change = np.abs(np.diff(y, prepend=y[:1]))
        sharp = time[_within(rows.drift[piece.used], rows.landing[piece.used])]
        sharp = sharp[(sharp > began[first]) & (sharp < began[last])]
        for moment in np.union1d(began[_moments(began, change, first, last, most)], sharp):
            where = {"run": rows.run.name, "time_s": round(float(moment), 1)}
            yield Trial(CAUSE.name, view.step_from(k, float(moment))[:, None], rows.run.name, "", where)


def _within(drift: FloatArray, landing: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Return the rows at which the drift steps most within a landing, of medians of five rows."""
    if len(drift) < 2 * FIVE:
        return np.zeros(0, dtype=np.int64)
    medians = medians_of_five(drift[:, None])[:, 0]
    rows = np.arange(FIVE, len(drift) - FIVE + 1)
    step = np.abs(medians[FIVE:] - medians[:-FIVE]) * (landing[rows - FIVE] == landing[rows + FIVE - 1])
    peak = step == maximum_filter1d(step, 2 * FIVE - 1, mode="constant")
    sharp = np.flatnonzero(peak & (step > 0.0))
    return np.asarray(rows[sharp[np.argsort(-step[sharp])[:MOST_WITHIN]]])


def _moments(time: FloatArray, change: FloatArray, first: int, last: int, most: int) -> npt.NDArray[np.int64]:
    """Return windows of a run in which a step may begin, from window `first` to `last`."""
    if last - first < most:
        return np.arange(first, last + 1)
    by_time = np.searchsorted(time, np.linspace(time[first], time[last], most // 2))
    largest = first + np.argsort(-change[first : last + 1])[: most // 4]
    return np.unique([*np.linspace(first, last, most // 4).astype(int), *by_time, *largest])
