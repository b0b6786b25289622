"""Thermometers of one leg: one that its law should read, and two whose plugs are exchanged.

With ``c_s = A_s q0 + B_s q`` of leg i's law, a thermometer t that it does not read adds (`missing-sensor`)

    y_i = A_t q0 dT_t + B_t q dT_t,

and where s and t of this leg are recorded in each other's place (`swapped-sensors`)

    y_i = (c_s - c_t) (dT_t - dT_s),

of which nothing is free: its share is 1, or 0, as of two legs (`causes.swapped_legs`, whose `trust` it has as well).
Neither exists where a leg has one thermometer.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np

from hexathermal.learn.machine_diagnosis.candidate import Candidate
from hexathermal.learn.machine_diagnosis.causes.swapped_legs import LAW_SPREAD, SMALLEST, calm_heat
from hexathermal.learn.machine_diagnosis.law_columns import reading_noise, zero_errors
from hexathermal.learn.machine_diagnosis.leg_terms import term_candidate
from hexathermal.learn.machine_diagnosis.view import MachineView
from hexathermal.machine.thermal import LegLaw, ThermalModel
from hexathermal.poses import FloatArray

MISSING, SWAPPED = "missing-sensor", "swapped-sensors"

WORDS = {
    MISSING: "the temperature at {thermometer}, which the law of {target} does not read, moves that leg",
    SWAPPED: "the plugs of {exchanged} and {with} on {target} are exchanged",
}
ADVICE = {
    MISSING: "Heat the leg near that thermometer alone.",
    SWAPPED: "Warm one of the two thermometers with a finger, and see which column moves.",
}


def sensor_candidates(view: MachineView) -> list[Candidate]:
    """Return what is wrong with which thermometers tell a leg, on each leg that has several.

    Parameters
    ----------
    view : MachineView
    """
    if len(view.sensors) < 2:
        return []
    calm = calm_heat(view) + zero_errors(view, view.readings.flicker)
    heat = view.heat + zero_errors(view, view.readings.flicker)
    found = []
    for leg in range(6):
        read = view.read[leg]
        for t in np.flatnonzero(~read).tolist():
            name = view.sensors[t]
            one = term_candidate(view, MISSING, leg, "expansion", (f"A_per_K_{name}", f"B_per_K_{name}"),
                                 ("1/K", "1/K"), {"sensor": name})  # fmt: skip
            # no term: the law itself comes to read it
            found.append(replace(one, leg_shape="", settings={"thermometer": name}))
        pairs = combinations(range(len(view.sensors)), 2)
        found += [_swapped(view, leg, pair, heat, calm) for pair in pairs if read[list(pair)].any()]
    return [one for one in found if np.abs(one.columns).max(initial=0.0) > SMALLEST]


def _swapped(view: MachineView, leg: int, pair: tuple[int, int], heat: FloatArray, calm: FloatArray) -> Candidate:
    """Return the exchange of two thermometers of a leg."""
    s, t = pair
    reach = view.laws[leg, 0] * view.retracted[leg] + view.laws[leg, 1] * view.q[:, leg, None]
    columns = np.zeros((len(view), 6, 1))
    columns[:, leg, 0] = reach[:, s] * (calm[:, leg, t] - heat[:, leg, s])
    columns[:, leg, 0] += reach[:, t] * (calm[:, leg, s] - heat[:, leg, t])
    settings = {"exchanged": view.sensors[s], "with": view.sensors[t]}
    trust = _trust(view, calm[:, leg, t] - calm[:, leg, s], (reach[:, s] - reach[:, t]), (leg, s, t))
    return Candidate(SWAPPED, f"leg{leg + 1}", ("share",), ("1",), columns, np.array([LAW_SPREAD]), np.ones(1),
                     settings, trust=trust)  # fmt: skip


def _trust(view: MachineView, apart: FloatArray, reach: FloatArray, at: tuple[int, int, int]) -> float:
    """Return the part of two thermometers' difference that is no slow error of their readings."""
    leg, s, t = at
    slow = reading_noise(view) ** 2 * view.readings.own[:, leg].mean(axis=0)
    left = apart.copy()
    for shared in view.zeros:
        left[shared] -= left[shared].mean()
    seen, wrong = float(((reach * left) ** 2).mean()), float((reach**2).mean() * (slow[s] + slow[t]))
    return max(1.0 - wrong / seen, 0.0) if seen > 0.0 else 0.0


def exchanged_heat(view: MachineView, one: Candidate) -> FloatArray:
    """Return the difference of temperatures that are exchanged, between legs or on one, shape (n, s) [K]."""
    if one.cause == SWAPPED:
        s, t = (view.sensors.index(one.settings[name]) for name in ("exchanged", "with"))
        return np.asarray(view.heat[:, one.legs[0], [s]] - view.heat[:, one.legs[0], [t]])
    first, second = one.legs
    return np.asarray(view.heat[:, first] - view.heat[:, second])


def swapped_law(law: LegLaw, settings: Mapping[str, Any]) -> LegLaw:
    """Return the law of a leg that reads two thermometers in each other's place: coefficients stay with the places.

    Examples
    --------
    >>> swapped_law(LegLaw(["T1", "T2"], [2e-6, 1e-6], [0.0, 0.0]), {"exchanged": "T2", "with": "T3"}).sensors
    ('T1', 'T3')
    """
    one, two = settings["exchanged"], settings["with"]
    other = {one: two, two: one}
    terms = [term.reading(other) for term in law.terms]
    names = tuple(other.get(name, name) for name in law.sensors)
    return LegLaw(names, law.A, law.B, law.covariance, law.campaign, terms, law.spread)


def reading_law(law: LegLaw, sensor: str, found: FloatArray, covariance: FloatArray, title: str = "") -> LegLaw:
    """Return the law of a leg that reads one more thermometer.

    Parameters
    ----------
    law : LegLaw
    sensor : str
    found, covariance : array, shape (2,), (2, 2)
        A and B of the thermometer [1/K], and their covariance.
    title : str
        Of the campaign.
    """
    names = law.sensors if sensor in law.sensors else (*law.sensors, sensor)
    s, at = len(names), names.index(sensor)
    A, B, own, spread = np.zeros(s), np.zeros(s), np.zeros((2 * s, 2 * s)), np.zeros(2 * s)
    known = [names.index(name) for name in law.sensors]
    A[known], B[known] = law.A, law.B
    order = [*known, *(s + k for k in known)]
    if law.covariance is not None:
        own[np.ix_(order, order)] = law.covariance
    A[at], B[at] = A[at] + found[0], B[at] + found[1]
    own[np.ix_([at, s + at], [at, s + at])] += covariance
    if law.spread is not None:
        spread[order] = law.spread
    return LegLaw(names, A, B, own, title or law.campaign, law.terms, None if law.spread is None else spread)


def with_laws(thermal: ThermalModel, legs: list[LegLaw]) -> ThermalModel:
    """Return a model with other laws of legs; a thermometer that is new has the mean of the others' references."""
    known = dict(zip(thermal.sensor_names, thermal.reference_temperature_degC.tolist(), strict=True))
    usual = float(np.mean(thermal.reference_temperature_degC))
    single = replace(thermal, legs=tuple(legs), reference_temperature_degC=np.array(usual))
    own = [known.get(name, usual) for name in single.sensor_names]
    return replace(single, reference_temperature_degC=np.array(own))
