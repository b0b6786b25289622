"""Two thermometers have exchanged their names."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from hexathermal.learn.diagnosis.order import FEIGNED, Order
from hexathermal.learn.diagnosis.trials import Cause, Parameter, Trial, Workbench
from hexathermal.learn.diagnosis.view import View
from hexathermal.machine.leg_repairs import SensorRepair

CAUSE = Cause(
    name="swapped-sensors",
    physics="Two plugs were exchanged: what is written under the name of one is the temperature of the other.",
    signature=(
        "The drift follows another thermometer in place of the law's own, with the same coefficients; the "
        "profile along the leg is out of order."
    ),
    parameters=(Parameter("other", "name", "any other thermometer"),),
    confused_with=("missing-sensor",),
    experiment="Warm one of the two with a finger.",
    words="the plugs of {target} and another thermometer are exchanged",
    thermal=True,
)


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give each of the law's sensors exchanged with each other one."""
    yield from bench.view.once((CAUSE.name,), lambda: tuple(_exchanged(bench.view)))


def _exchanged(view: View) -> Iterator[Trial]:
    """Give the trials, which no stage of a diagnosis changes."""
    order = Order(view)
    for k, sensor in enumerate(view.base):
        for other in view.sensors:
            if other in view.base:
                continue
            names = [*view.base[:k], other, *view.base[k + 1 :]]
            base = view.base_of([view.temperatures(name) for name in names])
            yield Trial(CAUSE.name, np.zeros((len(view.q), 0)), sensor, "", {"other": other}, base=base,
                        repair=partial(SensorRepair, CAUSE.name, "swap", {"first": sensor, "second": other}),
                        anew=True, advantage=order.advantage(sensor, other),
                        most=order.most(sensor, other), doubt=FEIGNED)  # fmt: skip
