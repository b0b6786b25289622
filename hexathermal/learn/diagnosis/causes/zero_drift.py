"""The zero drifts with time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from hexathermal.learn.diagnosis.trials import Cause, Parameter, Trial, Workbench

CAUSE = Cause(
    name="zero-drift",
    physics="The laser, the optics, a clamp or a foundation drifts steadily, whatever the temperatures do.",
    signature="The residual is proportional to time.",
    parameters=(Parameter("rate", "m/h", "visible effect of 0.25 to 4 times the noise; runs may differ about it"),),
    confused_with=(
        "frame-expansion",
        "sensor-drift",
        "air-refraction",
    ),
    experiment="A night at rest at constant temperature.",
    words="the zero drifts with time",
    wanders=True,
    readings=12,
)

FEWEST_RATES = 4
"""With fewer runs nobody tells rates that differ from a slow noise."""


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give the time since the zero; at one rate, or at one of its own besides in each run."""
    trial = bench.term(CAUSE.name, "time", None, quick=True)
    yield trial
    run = bench.view.channel.run
    own = run[:, None] == np.unique(run)
    if bench.view.zeroed_by_run and own.shape[1] >= FEWEST_RATES:
        yield replace(trial, columns=np.column_stack([trial.columns, trial.columns * own]), starts=own.shape[1])
