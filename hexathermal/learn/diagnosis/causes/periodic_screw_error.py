"""A wave of the displacement with the pitch of a screw or of a scale."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hexathermal.learn.diagnosis.trials import Cause, Parameter, Trial, Workbench
from hexathermal.learn.diagnosis.view import View
from hexathermal.machine.leg_signals import LegSignals
from hexathermal.machine.leg_terms import term_columns

CAUSE = Cause(
    name="periodic-screw-error",
    physics="The screw, or the scale, has an error that repeats with each turn.",
    signature="The residual is a wave of the displacement whose phase never changes.",
    parameters=(
        Parameter("pitch_m", "m", "uniform in waves per metre, 1.25 mm to 40 mm"),
        Parameter("amplitude", "m", "visible effect of 0.25 to 4 times the noise"),
    ),
    confused_with=(
        "scale-error",
        "backlash",
    ),
    experiment="Steps of a fraction of the pitch over three pitches, without warming.",
    words="an error repeats with the displacement",
)

LONGEST_M, SHORTEST_M = 0.040, 0.00125
PARTS = 4.0
"""Waves are tried so closely that a phase is off by at most pi / PARTS at the end of the stroke."""


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give waves of all pitches that the stroke can tell apart."""
    # no stage of a diagnosis changes them
    yield from bench.view.once((CAUSE.name,), lambda: tuple(_waves(bench.view)))


def _waves(view: View) -> Iterator[Trial]:
    """Give the trials."""
    if not view.moves:
        return
    stroke = float(np.ptp(view.q))
    step = 1.0 / (PARTS * stroke)
    first = max(1.0 / LONGEST_M, 1.5 / stroke)
    windows = LegSignals(view.time, {}, view.q)
    begin = np.flatnonzero(view.channel.start)[view.channel.run]
    for frequency in np.arange(first, 1.0 / SHORTEST_M, step):
        own = {"pitch_m": 1.0 / float(frequency)}
        waves = term_columns("periodic", windows, own)
        # a run counts from its own beginning
        yield Trial(CAUSE.name, waves - waves[begin], None, "periodic", own)
