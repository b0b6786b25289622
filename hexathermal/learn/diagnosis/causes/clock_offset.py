"""The clocks of the loggers differ."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from hexathermal.learn.diagnosis.read_later import read_later
from hexathermal.learn.diagnosis.timing import Timing
from hexathermal.learn.diagnosis.trials import Cause, Parameter, Trial, Workbench
from hexathermal.learn.diagnosis.view import View
from hexathermal.machine.leg_repairs import SensorRepair

CAUSE = Cause(
    name="clock-offset",
    physics="Temperatures and displacement are logged by two machines whose clocks differ.",
    signature=(
        "All temperatures lead, or follow, by the same time, both against the drift and against the motion "
        "that warms the part."
    ),
    parameters=(Parameter("offset_s", "s", "10 s to 20 min, either sign; less where both neighbours say so"),),
    confused_with=("thermal-lag",),
    experiment="One pulse on both loggers.",
    words="the clock of the temperatures runs ahead of that of the displacement",
)

OFFSETS_S = tuple(np.geomspace(10.0, 1200.0, 28))


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give the law at temperatures that are read earlier or later."""
    yield from bench.view.once((CAUSE.name,), lambda: tuple(_shifted(bench.view)))


def _shifted(view: View) -> Iterator[Trial]:
    """Give the trials, which no stage of a diagnosis changes."""
    timing, tables = Timing(view), view.tables(view.base)
    offsets = (*(-value for value in OFFSETS_S[::-1]), *OFFSETS_S)

    def trial(place: float) -> Trial:
        """Return the trial of an offset, by its place among `offsets`."""
        offset = float(np.interp(place, np.arange(len(offsets)), offsets))
        base = view.base_of(list(read_later(view, tables, offset).T))
        return Trial(CAUSE.name, np.zeros((len(view.q), 0)), None, "", {"offset_s": offset}, base=base,
                     repair=partial(SensorRepair, CAUSE.name, "clock", {"offset_s": offset}),
                     anew=True, advantage=timing.advantage(offset), finer=lambda step: trial(place + step))  # fmt: skip

    for place in range(len(offsets)):
        yield trial(float(place))
