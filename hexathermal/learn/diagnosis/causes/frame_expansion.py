"""The bench follows the room."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from hexathermal.learn.diagnosis.beside_others import air_read
from hexathermal.learn.diagnosis.trials import Cause, Parameter, Trial, Workbench

CAUSE = Cause(
    name="frame-expansion",
    physics=(
        "The frame that carries the interferometer, or a part outside the leg, expands with the air of the "
        "room, hours later."
    ),
    signature="The residual follows the air temperature behind a low pass, whatever the displacement.",
    parameters=(
        Parameter("time_constant_s", "s", "0 to 4 h"),
        Parameter("order", "1", "1 or 2 equal stages"),
        Parameter("coefficient", "m/K", "visible effect of 0.25 to 4 times the noise"),
    ),
    confused_with=(
        "air-refraction",
        "zero-drift",
        "missing-sensor",
    ),
    experiment="Let the room step by 2 K with the leg at rest and unheated; fix a thermometer on the frame.",
    words="the bench follows the temperature of the room",
    thermal=True,
    readings=6,
)

TIMES_S = (0.0, 600.0, 1800.0, 5400.0, 14400.0)

STAGED_S = 1800.0
"""From this time on the skin of a frame, and what it carries, are tried as two stages as well."""


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give the air temperature behind low passes; at rest when a run begins, or on its way from what was before."""
    view = bench.view
    if view.airs is not None:
        read = air_read(view)
        # what follows the air at once is its index, where beams measure
        for tau in TIMES_S[1:] if view.indexed else TIMES_S:
            trial = bench.term(CAUSE.name, "room", None, time_constant_s=tau, **read)
            yield trial
            if tau > 0.0:
                yield bench.not_at_rest(trial, tau)
            if tau >= STAGED_S:
                yield from _staged(bench, tau, read)


def _staged(bench: Workbench, tau: float, read: Mapping[str, Any]) -> Iterator[Trial]:
    """Give the air temperature behind two low passes of half the time constant each."""
    trial = bench.term(CAUSE.name, "room", None, time_constant_s=tau, order=2, **read)
    yield trial
    yield bench.not_at_rest(trial, 0.5 * tau)
