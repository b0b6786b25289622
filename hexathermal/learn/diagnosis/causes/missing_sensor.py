"""Another recorded temperature matters."""

from __future__ import annotations

from collections.abc import Iterator

from hexathermal.learn.diagnosis.trials import Cause, Parameter, Trial, Workbench

CAUSE = Cause(
    name="missing-sensor",
    physics="Part of the length has a temperature of its own, which a thermometer outside the law shows.",
    signature="The residual follows another thermometer, at rest and in motion.",
    parameters=(Parameter("coefficient", "1/K", "visible effect of 0.25 to 4 times the noise"),),
    confused_with=(
        "hidden-heat",
        "thermal-lag",
        "frame-expansion",
    ),
    experiment="Heat the part near that thermometer alone.",
    words="the temperature at {target}, which the law does not read, moves the part",
    thermal=True,
    readings=10,
)


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give each other thermometer, acting on the retracted length, as the law's own, or with its own A and B."""
    view = bench.view
    ratios = {0.0, bench.ratios[bench.main]} if view.kind == "leg" else {0.0}
    for sensor in view.sensors:
        if sensor not in view.base and sensor not in bench.noisy:
            for ratio in sorted(ratios):
                yield bench.term(CAUSE.name, "temperature", sensor, quick=True, sensor=sensor, ratio=ratio)
            # as recorded: smoothing takes what is quicker than the noise of a good thermometer
            for ratio in sorted(ratios):
                raw = view.span(ratio) * view.recorded(sensor)
                yield Trial(CAUSE.name, raw[:, None], sensor, "temperature", {"sensor": sensor, "ratio": ratio})
            if view.kind == "leg" and view.moves:
                yield bench.term(CAUSE.name, "expansion", sensor, quick=True, sensor=sensor)
