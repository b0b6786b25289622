"""The thermometers of two legs are exchanged: plugs, or columns of the table.

With the law of leg i read from leg j's thermometers and the other way round,

    y_i = sum_s (A_is q0_i + B_is q_i) (dT_js - dT_is),     y_j = sum_s (A_js q0_j + B_js q_j) (dT_is - dT_js)

so nothing is free: the share of it is 1, or 0. What may be off is how well the law itself is known.

Slow errors of the readings, of which a smooth course cannot be freed, are in these columns, and of the legs that they
truly belong to in y: with v the columns' mean square and e that of one leg's errors, the share that a fit finds is
``a = e / v`` where nothing is exchanged, ``1 - a`` where it is. So with ``S = Z' Z``, ``g = Z' y`` the log evidence is

    S / 2 ((g / S - a)^2 - (g / S - 1 + a)^2) = (1 - 2 a) (g - S / 2),

of which equally warm legs, ``a = 1 / 2``, leave nothing: the candidate's `trust` is ``1 - 2 a``.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from hexathermal.learn.diagnosis.trials import Cause, Parameter
from hexathermal.learn.machine_diagnosis.candidate import Candidate
from hexathermal.learn.machine_diagnosis.law_columns import reading_noise, zero_errors
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
    zero = zero_errors(view, view.readings.flicker)
    heat, calm = view.heat + zero, calm + zero
    for one, two in combinations(range(6), 2):
        if np.abs(_drift(view, one, calm[:, two] - calm[:, one])).max() <= SMALLEST:
            continue
        columns = np.zeros((len(view), 6, 1))
        columns[:, one, 0] = _drift(view, one, calm[:, two] - heat[:, one])
        columns[:, two, 0] = _drift(view, two, calm[:, one] - heat[:, two])
        found.append(Candidate(CAUSE.name, f"leg{one + 1}+leg{two + 1}", ("share",), ("1",), columns,
                               np.array([LAW_SPREAD]), np.ones(1), trust=_trust(view, calm, one, two)))  # fmt: skip
    return found


def _trust(view: MachineView, calm: FloatArray, one: int, two: int) -> float:
    """Return ``1 - 2 a``: the part of two legs' difference that is no slow error of their readings."""
    slow = reading_noise(view) * np.sqrt(view.readings.own.mean(axis=0))
    apart = calm[:, two] - calm[:, one]
    for shared in view.zeros:
        apart[shared] -= apart[shared].mean(axis=0)
    seen = wrong = 0.0
    for leg in (one, two):
        seen += float((_drift(view, leg, apart) ** 2).mean())
        reach = view.laws[leg, 0] * view.retracted[leg] + view.laws[leg, 1] * view.q[:, leg].mean()
        wrong += float(((reach**2) * (slow[one] ** 2 + slow[two] ** 2)).sum())
    return max(1.0 - wrong / seen, 0.0) if seen > 0.0 else 0.0


def calm_heat(view: MachineView) -> FloatArray:
    """Return the legs' temperatures with as much of their flicker left as is heat, shape (n, 6, s) [K].

    A reading's noise makes nothing in the leg that it truly tells of: of its flicker only the part
    ``1 - noise^2 / variance`` counts. That of the leg's own readings is a column of the law.
    """
    spread = view.readings.noise**2
    share = np.minimum(reading_noise(view) ** 2 / np.where(spread > 0.0, spread, np.inf), 1.0)
    return np.asarray(view.heat - share * view.readings.flicker)


def _drift(view: MachineView, leg: int, dT: FloatArray) -> FloatArray:
    """Return the drift of a leg at other temperatures, shape (n,) [m]."""
    A, B = view.laws[leg]
    return np.asarray((dT @ A) * view.retracted[leg] + (dT @ B) * view.q[:, leg])
