"""The bench follows the room."""

from __future__ import annotations

from collections.abc import Iterator

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
)

TIMES_S = (0.0, 600.0, 1800.0, 5400.0, 14400.0)


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give the air temperature behind low passes."""
    if all(rows.signals.air is not None for rows in bench.view.runs):
        for tau in TIMES_S:
            yield bench.term(CAUSE.name, "room", None, time_constant_s=tau)
