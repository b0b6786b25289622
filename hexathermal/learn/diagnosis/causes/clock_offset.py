"""The clocks of the loggers differ."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
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
        "All temperatures lead, or follow, by the same time, or by the more the longer a run lasts, both against the "
        "drift and against the motion that warms the part."
    ),
    parameters=(
        Parameter("offset_s", "s", "10 s to 20 min, either sign; less where both neighbours say so"),
        Parameter("gains_s_per_h", "s/h", "none, or 30 s to 20 min at the end of the longest run, either sign"),
    ),
    confused_with=("thermal-lag",),
    experiment="One pulse on both loggers when a run begins, and one when it ends.",
    words="the clock of the temperatures runs ahead of that of the displacement",
)

OFFSETS_S = tuple(np.geomspace(10.0, 1200.0, 28))


GAINED_S = tuple(np.geomspace(30.0, 1200.0, 9))
"""What a clock that gains or loses time is off by at the end of the longest run."""

LEAST_SPAN_S = 3600.0
"""In runs that are no longer nobody tells such a clock."""


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give the law at temperatures that are read earlier or later, all alike or the more the longer a run lasts."""
    yield from bench.view.once((CAUSE.name,), lambda: tuple(_made(bench.view)))


def _made(view: View) -> Iterator[Trial]:
    """Give the trials, which no stage of a diagnosis changes: offsets, and clocks that are right when a run begins."""
    timing = Timing(view)
    yield from _line(view, timing, OFFSETS_S, lambda offset: {"offset_s": offset})
    longest = max(float(np.ptp(signals.time)) for signals in view.signals)
    if longest > LEAST_SPAN_S and all(signals.time[0] == 0.0 for signals in view.signals):
        hours = longest / 3600.0
        yield from _line(view, timing, GAINED_S, lambda gained: {"gains_s_per_h": gained / hours})


def _line(
    view: View, timing: Timing, sizes: Sequence[float], named: Callable[[float], dict[str, float]]
) -> Iterator[Trial]:
    """Give trials of sizes of either sign, in their order, whose parameters are `named`."""
    tables = view.tables(view.base)
    steps = (*(-value for value in sizes[::-1]), *sizes)

    def trial(place: float) -> Trial:
        """Return a trial by its place among the sizes."""
        own = named(float(np.interp(place, np.arange(len(steps)), steps)))
        offset, gains = own.get("offset_s", 0.0), own.get("gains_s_per_h", 0.0)
        base = view.base_of(list(read_later(view, tables, offset, gains).T))
        return Trial(CAUSE.name, np.zeros((len(view.q), 0)), None, "", own, base=base,
                     repair=partial(SensorRepair, CAUSE.name, "clock", {"offset_s": offset, **own}), anew=True,
                     advantage=timing.advantage(offset, gains), finer=lambda step: trial(place + step))  # fmt: skip

    for place in range(len(steps)):
        yield trial(float(place))
