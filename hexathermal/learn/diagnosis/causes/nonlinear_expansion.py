"""Expansion that is not proportional to the temperature."""

from __future__ import annotations

from collections.abc import Iterator

from hexathermal.learn.diagnosis.trials import Cause, Parameter, Trial, Workbench

CAUSE = Cause(
    name="nonlinear-expansion",
    physics=(
        "The coefficient of expansion changes with the temperature (Invar, polymers), or the thermometer is not linear."
    ),
    signature="The residual is a parabola of the temperature, the same in heating and cooling.",
    parameters=(Parameter("curvature", "1/K^2", "visible effect of 0.25 to 4 times the noise"),),
    confused_with=(
        "missing-sensor",
        "thermal-lag",
    ),
    experiment="Soak at three or more temperatures, at rest.",
    words="the expansion is not proportional to the temperature at {target}",
    thermal=True,
)


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give the square of each of the law's temperatures."""
    for sensor in bench.view.base:
        # the retracted length, the law's own mixture, or the whole length
        for ratio in sorted({0.0, bench.ratios[sensor], *([1.0] if bench.view.kind == "leg" else [])}):
            yield bench.term(CAUSE.name, "square", sensor, quick=True, sensor=sensor, ratio=ratio)
