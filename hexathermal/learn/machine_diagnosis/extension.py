"""The extended machine: named causes join the Hexapod; correction, prediction and budget use them as they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hexathermal.learn.machine_diagnosis.candidate import Candidate
from hexathermal.learn.machine_diagnosis.course import SWAPS, exchanged
from hexathermal.learn.machine_diagnosis.leg_sensors import MISSING, reading_law, with_laws
from hexathermal.machine.compliance import STANDARD_GRAVITY, Compliance
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.leg_terms import LegTerm
from hexathermal.machine.measuring_frame import MeasuringFrame
from hexathermal.machine.thermal import LegLaw, PlateLaw, ThermalModel
from hexathermal.poses import FloatArray

STANDS_FOR = 100.0
"""Payload [kg] of a machine that states none: compliance times weight is all that was found."""


def extended(hexapod: Hexapod, one: Candidate, found: FloatArray, covariance: FloatArray, title: str = "") -> Hexapod:
    """Return a machine that holds a cause.

    Parameters
    ----------
    hexapod : Hexapod
    one : Candidate
    found, covariance : array, shape (k,), (k, k)
        Amplitudes and their covariance.
    title : str
        Of the campaign.
    """
    if one.cause in SWAPS:
        return exchanged(hexapod, one)
    if one.cause == "joint-offset":
        moved = np.zeros((6, 3))
        moved[one.legs[0]] = found
        if str(one.target).startswith("base"):
            return replace(hexapod, base_joints=hexapod.base_joints + moved)
        return replace(hexapod, platform_joints=hexapod.platform_joints + moved)
    if one.cause == "payload-compliance":
        return replace(hexapod, compliance=_loaded(hexapod, found, covariance))
    if one.cause == "tracker-drift":
        return replace(hexapod, measuring_frame=_frame(hexapod, one, found, covariance))
    thermal = hexapod.thermal
    assert thermal is not None  # checked where views are made
    if one.cause in ("platform-expansion", "base-expansion"):
        part = str(one.target)
        before: PlateLaw | None = getattr(thermal, part)
        known = before.expansion if before is not None and before.sensor is not None else 0.0
        law = PlateLaw(known + float(found[0]), one.settings["sensor"], float(np.sqrt(covariance[0, 0])))
        return replace(hexapod, thermal=_with_plate(thermal, part, law))
    legs = list(thermal.legs)
    leg = one.legs[0]
    if one.cause == MISSING:
        legs[leg] = reading_law(legs[leg], str(one.settings["thermometer"]), found, covariance, title)
        return replace(hexapod, thermal=with_laws(thermal, legs))
    legs[leg] = _changed(legs[leg], one, found, covariance, title)
    return replace(hexapod, thermal=replace(thermal, legs=tuple(legs)))


def _with_plate(thermal: ThermalModel, part: str, law: PlateLaw) -> ThermalModel:
    """Return a model with another plate; where that adds a thermometer, its reference is the mean of the others."""
    platform, base = (law, thermal.base) if part == "platform" else (thermal.platform, law)
    known = dict(zip(thermal.sensor_names, thermal.reference_temperature_degC.tolist(), strict=True))
    usual = float(np.mean(thermal.reference_temperature_degC))
    single = replace(thermal, platform=platform, base=base, reference_temperature_degC=np.array(usual))
    own = [known.get(name, usual) for name in single.sensor_names]
    return replace(single, reference_temperature_degC=np.array(own))


def _changed(law: LegLaw, one: Candidate, found: FloatArray, covariance: FloatArray, title: str) -> LegLaw:
    """Return the law of a leg with changed coefficients, or with one more term."""
    if one.leg_shape:
        term = LegTerm(one.cause, one.leg_shape, one.settings, found, covariance)
        return LegLaw(law.sensors, law.A, law.B, law.covariance, law.campaign, (*law.terms, term), law.spread)
    at = [law.sensors.index(name) for name in one.settings["sensors"]]
    A, B = np.array(law.A), np.array(law.B)
    A[at] += found[0::2]
    B[at] += found[1::2]
    order = [*at, *(len(law.sensors) + k for k in at)]
    own = np.zeros((2 * len(law.sensors),) * 2)
    pick = [*range(0, len(found), 2), *range(1, len(found), 2)]
    own[np.ix_(order, order)] = covariance[np.ix_(pick, pick)]
    return LegLaw(law.sensors, A, B, own, title or law.campaign, law.terms)


def _loaded(hexapod: Hexapod, found: FloatArray, covariance: FloatArray) -> Compliance:
    """Return the compliance under the load that was known and the one that was found."""
    before = hexapod.compliance
    g = np.array(STANDARD_GRAVITY) if before is None else before.gravity
    size = float(np.linalg.norm(g))
    stated, centre, mass = 0.0, np.zeros(3), STANDS_FOR
    if before is not None and before.payload_mass != 0.0:
        mass = before.payload_mass
        stated = float(before.leg_compliance.mean()) * mass * size
        centre = before.payload_centre
    sag = stated + float(found[0])
    whole = (stated * centre + found[1:]) / sag
    mass = float(np.copysign(abs(mass), sag))
    std = np.sqrt(np.diagonal(covariance))
    slopes = np.sqrt(std[1:] ** 2 + (whole * std[0]) ** 2) / abs(sag)
    weight = abs(mass) * size
    return Compliance(abs(sag) / weight, mass, whole, g, std[0] / weight, None, slopes)


def _frame(hexapod: Hexapod, one: Candidate, found: FloatArray, covariance: FloatArray) -> MeasuringFrame:
    """Return the drift of the measuring frame, with what was known of it: it follows the same thermometer then."""
    std, before = np.sqrt(np.diagonal(covariance)), hexapod.measuring_frame
    known = np.zeros(6)
    if before is not None:
        known = np.concatenate([before.shift, before.turn])
    whole = known + found
    delay = float(one.settings.get("time_constant_s", 0.0))
    return MeasuringFrame(str(one.target), whole[:3], whole[3:], std[:3], std[3:], delay)
