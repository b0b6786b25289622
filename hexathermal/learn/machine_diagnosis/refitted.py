"""Laws fitted anew beside the causes: with ``laws="refit"`` the extended machine has them, and says what they are.

What the law's columns explain of the rows at the posterior mean ``b`` changes coefficients by ``T b``, of covariance
``T C T'`` (`law_columns.LawColumns.shifts`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from hexathermal.learn.hexapod_data import PLATES
from hexathermal.learn.machine_diagnosis.course import Course
from hexathermal.learn.machine_diagnosis.evidence import posterior
from hexathermal.learn.machine_diagnosis.law_columns import law_columns
from hexathermal.learn.machine_diagnosis.search import priors_of
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.thermal import LegLaw, PlateLaw
from hexathermal.poses import FloatArray

PER_K = 1e6

OF_A_LAW = ("leg-coefficient", "platform-expansion", "base-expansion")
"""Causes whose amplitudes hold already what their law is off by (`settled`)."""


def refitted(course: Course, hexapod: Hexapod, title: str = "") -> Hexapod:
    """Return a machine with the laws that were fitted beside the causes, but those that a cause changes.

    Parameters
    ----------
    course : Course
        Of a case with ``laws="refit"``; with ``"kept"`` the machine stays as it is.
    hexapod : Hexapod
    title : str
        Of the campaign.
    """
    thermal = hexapod.thermal
    if course.case.laws != "refit" or thermal is None:
        return hexapod
    shifts = _shifts(course)
    for one in course.adopted:
        if one.candidate.cause in OF_A_LAW:
            shifts.pop(str(one.candidate.target), None)
    view, legs = course.case.view, list(thermal.legs)
    assert view.hexapod.thermal is not None  # checked where views are made
    for leg, law in enumerate(legs):
        if f"leg{leg + 1}" in shifts:
            # plugs may have been exchanged since: coefficients stay with the places
            at = [view.sensors.index(name) for name in view.hexapod.thermal.legs[leg].sensors]
            legs[leg] = _changed(law, [*at, *(len(view.sensors) + k for k in at)], *shifts[f"leg{leg + 1}"], title)
    plates = dict(zip(PLATES, (thermal.platform, thermal.base), strict=True))
    for part, plate in plates.items():
        if plate is not None and plate.sensor is not None and part in shifts:
            mean, covariance = shifts[part]
            std = float(np.sqrt(covariance[0, 0]))
            plates[part] = PlateLaw(plate.expansion + float(mean[0]), plate.sensor, std)
    return replace(
        hexapod, thermal=replace(thermal, legs=tuple(legs), platform=plates["platform"], base=plates["base"])
    )


def told_laws(before: Hexapod, after: Hexapod) -> str:
    """Return what laws were fitted anew to, in words; empty where none was.

    Parameters
    ----------
    before, after : Hexapod
    """
    old, new = before.thermal, after.thermal
    if old is None or new is None or old.legs == new.legs:
        return ""
    alike: dict[str, list[str]] = {}
    for leg, (was, law) in enumerate(zip(old.legs, new.legs, strict=True)):
        alike.setdefault(_told(was, law), []).append(str(leg + 1))
    said = [f"of leg{'s' if len(legs) > 1 else ''} {', '.join(legs)}: {words}" for words, legs in alike.items()]
    return f"laws fitted anew, um/m/K, {'; '.join(said)}; --extend writes them"


def _shifts(course: Course) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Return by how much each law's coefficients are off, mean and covariance, by leg and plate."""
    case, adopted = course.case, [one for one in course.adopted if one.which >= 0]
    mean, joint = posterior(case.tables, course.end.null, priors_of(case, adopted))
    p, columns = case.tables.law, law_columns(case.view, case.laws)
    shifts: Mapping[str, FloatArray] = columns.shifts
    return {name: (T @ mean[:p], T @ joint[:p, :p] @ T.T) for name, T in shifts.items() if T.any()}


def _changed(law: LegLaw, order: list[int], mean: FloatArray, covariance: FloatArray, title: str) -> LegLaw:
    """Return a law with other coefficients, which stand in an order among those of the view; its terms stay."""
    s, own = len(order) // 2, covariance[np.ix_(order, order)]
    A, B = np.array(law.A) + mean[order[:s]], np.array(law.B) + mean[order[s:]]
    return LegLaw(law.sensors, A, B, 0.5 * (own + own.T), title or law.campaign, law.terms)


def _told(before: LegLaw, after: LegLaw) -> str:
    """Return coefficients of a law with their standard uncertainties, and those it had."""
    s = len(after.sensors)
    std = np.zeros(2 * s) if after.covariance is None else np.sqrt(np.diagonal(after.covariance))
    parts = []
    for k, (symbol, value, was) in enumerate(
        [("A", *pair) for pair in zip(after.A, before.A, strict=True)]
        + [("B", *pair) for pair in zip(after.B, before.B, strict=True)]
    ):
        sensor = f" ({after.sensors[k % s]})" if s > 1 else ""
        parts.append(f"{symbol}{sensor} {value * PER_K:.3f} ± {std[k] * PER_K:.3f} (was {was * PER_K:.3f})")
    return ", ".join(parts)
