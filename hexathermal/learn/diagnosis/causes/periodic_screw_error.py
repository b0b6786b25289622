"""A wave of the displacement with the pitch of a screw or of a scale."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hexathermal.learn.diagnosis.places import common_step
from hexathermal.learn.diagnosis.trials import Cause, Parameter, Trial, Workbench
from hexathermal.learn.diagnosis.view import View
from hexathermal.machine.leg_signals import LegSignals
from hexathermal.machine.leg_terms import term_columns
from hexathermal.poses import FloatArray

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
    experiment="Steps of an eighth of the pitch over three pitches, without warming.",
    words="an error repeats with the displacement",
    readings=24,
)

LONGEST_M, SHORTEST_M = 0.040, 0.00125
PARTS, FINER = 4.0, 8.0
"""Waves are tried so closely that a phase is off by at most pi / PARTS at the end of the stroke; or, at few places with
a common step, where bumps imitate any long wave, by pi / FINER."""

BOTH = 0.1
"""There sine and cosine must differ: the least singular value of both over the largest."""


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give waves of all pitches that the stroke can tell apart."""
    # no stage of a diagnosis changes them
    yield from bench.view.once((CAUSE.name,), lambda: tuple(_waves(bench.view)), ())


def _waves(view: View) -> Iterator[Trial]:
    """Give the trials; of waves that look alike at places with a common step, the longest."""
    if not view.moves:
        return
    stroke, common = float(np.ptp(view.q)), common_step(view)
    if common is None:
        for frequency in np.arange(max(1.0 / LONGEST_M, 1.5 / stroke), 1.0 / SHORTEST_M, 1.0 / (PARTS * stroke)):
            own = {"pitch_m": 1.0 / float(frequency)}
            yield Trial(CAUSE.name, _counted(view, "periodic", own), None, "periodic", own)
        return
    # a short wave may look like one of any length
    first, last, step = 1.5 / stroke, min(1.0 / SHORTEST_M, 0.5 / common[0]), 1.0 / (FINER * stroke)
    for frequency in np.arange(first, last - 0.5 * step, step):
        own = {"pitch_m": 1.0 / float(frequency)}
        waves = _counted(view, "periodic", own)
        size = np.linalg.svd(waves - waves.mean(axis=0), compute_uv=False)
        if size[1] > BOTH * size[0]:
            yield Trial(CAUSE.name, waves, None, "periodic", own)
    if last >= first:
        own = {"pitch_m": 2.0 * common[0], "origin_m": common[1]}
        yield Trial(CAUSE.name, _counted(view, "wave", own), None, "wave", own)


def _counted(view: View, shape: str, parameters: dict[str, float]) -> FloatArray:
    """Return a shape's columns in windows; a run counts from its own beginning."""
    waves = term_columns(shape, LegSignals(view.time, {}, view.q), parameters)
    begin = np.flatnonzero(view.channel.start)[view.channel.run]
    return np.asarray(waves - waves[begin])
