"""Two thermometers have exchanged their names."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from hexathermal.learn.diagnosis.order import FEIGNED, Order
from hexathermal.learn.diagnosis.trials import Cause, Parameter, Trial, Workbench, evenly
from hexathermal.learn.diagnosis.view import View
from hexathermal.machine.leg_repairs import SensorRepair

CAUSE = Cause(
    name="swapped-sensors",
    physics="Two plugs were exchanged: what is written under the name of one is the temperature of the other.",
    signature=(
        "The drift follows another thermometer in place of the law's own, with the same coefficients; the "
        "profile along the part is out of order; where some runs are so, the others foretell each as the other."
    ),
    parameters=(
        Parameter("other", "name", "any other thermometer"),
        Parameter("from_run", "name", "any run"),
    ),
    confused_with=("missing-sensor",),
    experiment="Warm one of the two with a finger.",
    words="the plugs of {target} and another thermometer are exchanged",
    thermal=True,
)


ORDERS = 4
"""Later runs, evenly chosen, from which on the order along the leg is asked; the nearest before it stands for a run."""


def trials(bench: Workbench) -> Iterator[Trial]:
    """Give each of the law's sensors exchanged with each other one, from the beginning or from a later run on."""
    yield from bench.view.once((CAUSE.name,), lambda: tuple(_exchanged(bench.view)))


def _exchanged(view: View) -> Iterator[Trial]:
    """Give the trials, which no stage of a diagnosis changes."""
    names = [rows.run.name for rows in view.runs]
    zeros = None if view.zeroed_by_run else view.runs[0].signals.zero_degC
    later_ones = range(1, len(names)) if zeros is None or set(view.sensors) <= zeros.keys() else range(0)
    asked = evenly(later_ones, ORDERS) if later_ones else []
    for first in (0, *later_ones):
        order = Order(view, range(max((one for one in asked if one <= first), default=0), len(names)))
        later = view.channel.run >= first
        # a run that was not looked at counts with those before it
        start = view.order.index(names[first]) if first else 0
        sound: dict[str, Any] = {"not_in": list(view.order[:start])} if first else {}
        sound |= {"zero_else": list(view.order[start:])} if first and zeros is not None else {}
        told: dict[str, Any] = {"from_run": names[first]} if first else {}
        for k, sensor in enumerate(view.base):
            for other in view.sensors:
                if other in view.base or (first and not order.allows(sensor, other)):
                    continue
                tables = [view.temperatures(name) for name in view.base]
                above = zeros[other] - zeros[sensor] if first and zeros is not None else 0.0
                tables[k] = np.where(later, view.temperatures(other) + above, tables[k])
                yield Trial(CAUSE.name, np.zeros((len(view.q), 0)), sensor, "", {"other": other} | told,
                            base=view.base_of(tables), repair=partial(SensorRepair, CAUSE.name, "swap",
                                                                      {"first": sensor, "second": other} | sound),
                            anew=True, advantage=order.advantage(sensor, other),
                            most=order.most(sensor, other), doubt=FEIGNED,
                            errors=(sensor, other) if first else ())  # fmt: skip
