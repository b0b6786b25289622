"""The zero jumps once, at an unknown time."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hexathermal.learn.diagnosis.trials import Cause, Parameter, Trial, Workbench

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
)

MOST_MOMENTS = 480
"""Of all runs together, so that the work grows with the rows alone."""


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give steps at the beginnings of windows, run by run."""
    view = bench.view
    run, time = view.channel.run, view.time
    moments = max(4, MOST_MOMENTS // len(view.runs))
    for k, rows in enumerate(view.runs):
        own = np.flatnonzero(run == k)
        later = run > k if not view.zeroed_by_run else np.zeros(len(run), dtype=bool)
        first = 1 if (k == 0 or view.zeroed_by_run) else 0
        chosen = own[np.unique(np.linspace(first, len(own) - 1, moments).astype(int))] if len(own) > 2 else ()
        for i in chosen:
            step = (((run == k) & (np.arange(len(run)) >= i)) | later).astype(float)
            where = {"run": rows.run.name, "time_s": round(float(time[i]), 1)}
            yield Trial(CAUSE.name, step[:, None], rows.run.name, "", where)
