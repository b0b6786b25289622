"""The zero drifts with time."""

from __future__ import annotations

from collections.abc import Iterator

from hexathermal.learn.diagnosis.trials import Cause, Parameter, Trial, Workbench

CAUSE = Cause(
    name="zero-drift",
    physics="The laser, the optics, a clamp or a foundation drifts steadily, whatever the temperatures do.",
    signature="The residual is proportional to time.",
    parameters=(Parameter("rate", "m/h", "visible effect of 0.25 to 4 times the noise"),),
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


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give the time since the zero."""
    yield bench.term(CAUSE.name, "time", None, quick=True)
