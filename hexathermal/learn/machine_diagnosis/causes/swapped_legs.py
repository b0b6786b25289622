"""The thermometers of two legs are exchanged: plugs, or columns of the table.

With the law of leg i read from leg j's thermometers and the other way round,

    y_i = sum_s (A_is q0_i + B_is q_i) (dT_js - dT_is),     y_j = sum_s (A_js q0_j + B_js q_j) (dT_is - dT_js)

so nothing is free: the share of it is 1, or 0. What may be off is how well the law itself is known.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from hexathermal.learn.diagnosis.trials import Cause, Parameter
from hexathermal.learn.machine_diagnosis.candidate import Candidate
from hexathermal.learn.machine_diagnosis.law_columns import reading_noise
from hexathermal.learn.machine_diagnosis.view import MachineView
from hexathermal.poses import FloatArray

LAW_SPREAD = 0.05
"""Standard deviation of the share about 1: how well a law is known that is taken as exact."""

CAUSE = Cause(
    name="swapped-legs",
    physics="Two legs' thermometers are plugged, or logged, in each other's place: each leg's law reads the other.",
    signature="Two legs are wrong in opposite senses, in proportion to the difference of their temperatures.",
    parameters=(Parameter("share", "1", "1, standard deviation 0.05"),),
    confused_with=("leg-coefficient",),
    experiment="Warm one of the two legs with a hand, and see which column moves.",
    words="the thermometers of {target} are exchanged",
)


SMALLEST = 1e-12
"""Legs whose exchange changes less than this are equally warm: the rest is rounding [m]."""


def candidates(view: MachineView) -> list[Candidate]:
    """Give the fifteen pairs of legs."""
    found, calm = [], calm_heat(view)
    for one, two in combinations(range(6), 2):
        if np.abs(_drift(view, one, calm[:, two] - calm[:, one])).max() <= SMALLEST:
            continue
        columns = np.zeros((len(view), 6, 1))
        columns[:, one, 0] = _drift(view, one, calm[:, two] - view.heat[:, one])
        columns[:, two, 0] = _drift(view, two, calm[:, one] - view.heat[:, two])
        found.append(Candidate(CAUSE.name, f"leg{one + 1}+leg{two + 1}", ("share",), ("1",), columns,
                               np.array([LAW_SPREAD]), np.ones(1)))  # fmt: skip
    return found


def calm_heat(view: MachineView) -> FloatArray:
    """Return the legs' temperatures with as much of their flicker left as is heat, shape (n, 6, s) [K].

    A reading's noise makes nothing in the leg that it truly tells of: of its flicker only the part
    ``1 - noise^2 / variance`` counts. That of the leg's own readings is a column of the law.
    """
    spread = view.flicker.var(axis=0)
    share = np.minimum(reading_noise(view) ** 2 / np.where(spread > 0.0, spread, np.inf), 1.0)
    return np.asarray(view.heat - share * view.flicker)


def _drift(view: MachineView, leg: int, dT: FloatArray) -> FloatArray:
    """Return the drift of a leg at other temperatures, shape (n,) [m]."""
    A, B = view.laws[leg]
    return np.asarray((dT @ A) * view.retracted[leg] + (dT @ B) * view.q[:, leg])
