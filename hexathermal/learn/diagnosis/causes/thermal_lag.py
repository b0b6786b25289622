"""The part follows its thermometer late, or the thermometer the part."""

from __future__ import annotations

from collections.abc import Iterator

from hexathermal.learn.diagnosis.trials import Cause, Parameter, Trial, Workbench

CAUSE = Cause(
    name="thermal-lag",
    physics="Heat needs time: the leg behind the thermometer warms later (structure), or the thermometer later than the leg (sensor).",
    signature="The residual follows the rate of the temperature; heating and cooling make a loop.",
    parameters=(Parameter("time_constant_s", "s", "log-uniform, 1 min to 4 h"), Parameter("amplitude", "1", "+1: the whole part lags; below 0: the thermometer does"),),
    confused_with=("clock-offset", "missing-sensor", "hidden-heat",),
    experiment="A step of temperature at rest, logged every few seconds, beside a bare thermometer: a lag is an exponential, a clock a pure shift.",
    words="{target} and the part behind it do not warm together",
)

TIMES_S = (60.0, 120.0, 240.0, 480.0, 960.0, 1920.0, 3840.0, 7680.0, 15360.0)


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give a low pass of each sensor of the law, of first and second order."""
    for sensor in bench.view.base:
        for tau in TIMES_S:
            for order in (1, 2):
                yield bench.term(CAUSE.name, "lag", sensor, sensor=sensor, time_constant_s=tau, order=order,
                                 ratio=bench.ratios[sensor])  # fmt: skip
