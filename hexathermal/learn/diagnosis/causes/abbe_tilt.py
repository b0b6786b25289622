"""Differences of the beams leak into their mean."""

from __future__ import annotations

from collections.abc import Iterator

from hexathermal.learn.diagnosis.trials import Cause, Parameter, Trial, Workbench

CAUSE = Cause(
    name="abbe-tilt",
    physics=(
        "The target tilts and the beams do not stand evenly about the axis: a part of the tilt is read as length."
    ),
    signature="The residual follows the differences of the beams.",
    parameters=(Parameter("lever", "m", "visible effect of 0.25 to 4 times the noise"),),
    confused_with=(
        "missing-sensor",
        "zero-drift",
    ),
    experiment="Tilt the target by hand ten times at constant temperature, or turn the beams by 60 degrees and repeat.",
    words="tilt of the target leaks into the mean of the beams",
    readings=10,
)


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give the two tilts together."""
    if all(rows.signals.tilt is not None for rows in bench.view.runs):
        yield bench.term(CAUSE.name, "tilt", None, quick=True)
