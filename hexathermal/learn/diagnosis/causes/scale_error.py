"""The scale, or the lead of the screw, is wrong by a constant part."""

from __future__ import annotations

from collections.abc import Iterator

from hexathermal.learn.diagnosis.trials import Cause, Parameter, Trial, Workbench

CAUSE = Cause(
    name="scale-error",
    physics=(
        "The scale that the displacement is read from, or the wavelength of the laser, is off by some parts "
        "in a million."
    ),
    signature="The residual is proportional to the displacement at any temperature.",
    parameters=(Parameter("scale", "1", "visible effect of 0.25 to 4 times the noise"),),
    confused_with=(
        "periodic-screw-error",
        "air-refraction",
    ),
    experiment="The whole stroke up and down within minutes, ten times, before any warming.",
    words="the scale of the displacement is wrong by a constant part",
    readings=20,
    misfit=0.05,  # whatever a law gets wrong of the rod's warmth goes with the displacement times a mean temperature
    bent=0.55,  # scales are bowed, or wrong by different parts in their pieces; of a cube it is 0.6 to 2
)


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give the displacement."""
    if bench.view.moves:
        yield bench.term(CAUSE.name, "position", None, quick=True)
