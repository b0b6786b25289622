"""Another recorded temperature matters."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from hexathermal.learn.diagnosis.common_error import CommonError
from hexathermal.learn.diagnosis.sensor_model import sensor_model
from hexathermal.learn.diagnosis.trials import Cause, Parameter, Trial, Workbench

CAUSE = Cause(
    name="missing-sensor",
    physics="Part of the length has a temperature of its own, which a thermometer outside the law shows.",
    signature="The residual follows another thermometer, at rest and at work.",
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


TOLD = (0.5, 1.0)
"""Parts of what is taken for a thermometer's temperature that the others foretell, the rest as it reads itself: its own
slow bias would else hide what it stands for, where another thermometer of the law is near."""


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give each other thermometer, acting on the retracted length, as the law's own, or with its own A and B."""
    view = bench.view
    ratios = sorted({0.0, bench.ratios[bench.main]} if view.stroked else {0.0})
    ratios += [bench.along_screw] if view.stroked and view.moves else []
    asked = [sensor for sensor in view.sensors if sensor not in view.base and sensor not in bench.noisy]
    terms = []
    for sensor in asked:
        for ratio in ratios:
            own = bench.term(CAUSE.name, "temperature", sensor, quick=True, sensor=sensor, ratio=ratio)
            told = list(_told(bench, sensor, ratio))
            yield from (own, *told)
            terms.append(told[0] if told else own)
        # as recorded: smoothing takes what is quicker than the noise of a good thermometer
        for ratio in ratios:
            raw = view.span(ratio) * view.recorded(sensor)
            yield Trial(CAUSE.name, raw[:, None], sensor, "temperature", {"sensor": sensor, "ratio": ratio})
        if view.stroked and view.moves:
            yield bench.term(CAUSE.name, "expansion", sensor, quick=True, sensor=sensor)
    if asked and view.kind != "leg" and view.moves:
        yield from _warmed(bench, asked, terms)


def _told(bench: Workbench, sensor: str, ratio: float) -> Iterator[Trial]:
    """Give what a thermometer should read, as it and those outside the law besides tell; none where these are few.

    In a part of many lumps the others tell it as far as they were taught, and no farther: only where it moves, and
    warms by that in many ways, are they asked. Noisy ones are not: a law reads row by row.
    """
    if bench.view.kind != "leg" and not bench.view.moves:
        return
    noisy = tuple(name for name in bench.noisy if name not in bench.view.base)
    model = sensor_model(bench.view, sensor, (*bench.view.base, *noisy)) if noisy else bench.model(sensor)
    if model is None:
        return
    told = bench.view.once((CAUSE.name, "told", sensor, model.unasked), lambda: model.sensor_weights(model.weights()))
    for part in TOLD:
        weights = {name: part * weight for name, weight in told.items()}
        weights |= {sensor: 1.0 - part} if part < 1.0 else {}
        yield bench.term(CAUSE.name, "temperature", sensor, quick=True, sensor=sensor, ratio=ratio, weights=weights)


def _warmed(bench: Workbench, sensors: Sequence[str], terms: Sequence[Trial]) -> Iterator[Trial]:
    """Give what motion, inputs and the room foretell of each thermometer, by half and wholly, in place of a term.

    A micrometre a kelvin or ten of them: the slow bias of a part's thermometer is as large as the effect, and stored
    heat, or the room, which have none, would stand for its place. A law reads the thermometer, and the others.
    """
    view = bench.view
    warmed = view.once((CAUSE.name, "warmed", tuple(sensors)), lambda: CommonError(view, tuple(sensors)).warmed)
    own = view.tables(sensors)
    for part in TOLD:
        mixed = [part * foretold + (1.0 - part) * read for foretold, read in zip(warmed, own, strict=True)]
        columns = view.windows_zeroed(mixed)
        for term in terms:
            k, ratio = sensors.index(str(term.target)), term.parameters["ratio"]
            column = view.span(ratio) * columns[:, k]
            yield Trial(CAUSE.name, column[:, None], sensors[k], "", {"sensor": sensors[k]}, term=term)
