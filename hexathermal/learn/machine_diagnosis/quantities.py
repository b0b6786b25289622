"""Parameters of a named cause in units that people use, with uncertainty; and the finding in a sentence."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from hexathermal.learn.diagnosis.result import Quantity
from hexathermal.learn.diagnosis.words import told
from hexathermal.learn.hexapod_data import PLATES
from hexathermal.learn.machine_diagnosis.candidate import Candidate
from hexathermal.learn.machine_diagnosis.causes import catalogue
from hexathermal.learn.machine_diagnosis.leg_sensors import WORDS
from hexathermal.learn.machine_diagnosis.settled import Settled
from hexathermal.learn.machine_diagnosis.view import MachineView
from hexathermal.poses import FloatArray

UM = 1e6
SPOKEN_UNITS = {"m": ("um", UM), "m/K": ("um/K", UM), "rad/K": ("urad/K", UM), "m per unit": ("um per unit", UM)}
"""Unit and factor in which lengths and turns are told."""

NAME_ENDS = {"um": "_um", "um/K": "_um_per_K", "urad/K": "_urad_per_K", "um per unit": "_um_per_unit"}
SPOKEN = {
    "expansion_change": "change of the expansion",
    "expansion": "expansion after it",
    "offset": "size of the offset",
    "share": "share (1: exchanged)",
    "sag": "sag of one leg under the whole load",
}
"""Of parameters, less their units, whose names alone would not be understood."""

ENDS = ("_urad_per_K", "_um_per_K", "_um_per_unit", "_per_K2", "_per_K", "_um", "_urad", "_mm", "_m", "_s", "_ppm")
LAW = re.compile(r"([AB])(_change)?_per_K(_(.+))?")
LEAST_SAG = 1e-12
"""Sag below which no centre of a load is told [m]."""


def quantities(named: Settled, view: MachineView) -> dict[str, Quantity]:
    """Return the parameters of a cause.

    Parameters
    ----------
    named : Settled
    view : MachineView
    """
    one, found, covariance = named.adoption.candidate, named.found, named.covariance
    std = np.sqrt(np.maximum(np.diagonal(covariance), 0.0))
    if one.cause == "payload-compliance":
        return _load(found, covariance)
    made: dict[str, Quantity] = {}
    for name, unit, value, u in zip(one.names, one.units, found, std, strict=True):
        spoken, factor = SPOKEN_UNITS.get(unit, (unit, 1.0))
        end = NAME_ENDS.get(spoken, "")
        called = name.removesuffix("_per_K") if end.endswith("_per_K") else name
        made[called + ("" if called.endswith(end) else end)] = Quantity(
            float(value * factor), float(u * factor), spoken
        )
    if "play_m" in one.settings:
        made["play_mm"] = Quantity(float(one.settings["play_m"]) * 1e3, named.spread * 1e3, "mm")
    if "time_constant_s" in one.settings:
        made["time_constant_s"] = Quantity(float(one.settings["time_constant_s"]), named.spread, "s")
    return (
        made
        | _totals(one, view, named.whole, np.sqrt(np.diagonal(named.whole_covariance)))
        | _size(one, found, covariance)
    )


def _totals(one: Candidate, view: MachineView, found: FloatArray, std: FloatArray) -> dict[str, Quantity]:
    """Return coefficients that a change leads to: those of the extended machine."""
    thermal = view.hexapod.thermal
    assert thermal is not None  # checked where views are made
    if one.cause == "leg-coefficient":
        leg, made = one.legs[0], {}
        for k, sensor in enumerate(one.settings["sensors"]):
            at = view.sensors.index(sensor)
            for symbol in (0, 1):
                name = one.names[2 * k + symbol].replace("_change", "")
                value = float(view.laws[leg, symbol, at] + found[2 * k + symbol])
                made[name] = Quantity(value, float(std[2 * k + symbol]), "1/K")
        return made
    if one.target in PLATES and one.names[0] == "expansion_change_per_K":
        plate = thermal.platform if one.target == "platform" else thermal.base
        before = plate.expansion if plate is not None and plate.sensor is not None else 0.0
        return {"expansion_per_K": Quantity(float(before + found[0]), float(std[0]), "1/K")}
    return {}


def _size(one: Candidate, found: FloatArray, covariance: FloatArray) -> dict[str, Quantity]:
    """Return the length of an offset."""
    if one.cause != "joint-offset":
        return {}
    size = float(np.linalg.norm(found))
    along = found / size if size > 0.0 else np.zeros(3)
    return {"offset_um": Quantity(size * UM, float(np.sqrt(along @ covariance @ along)) * UM, "um")}


def _load(found: FloatArray, covariance: FloatArray) -> dict[str, Quantity]:
    """Return compliance times weight, and the load's centre: a ratio, by first order."""
    sag = float(found[0])
    made = {"sag_um": Quantity(sag * UM, float(np.sqrt(covariance[0, 0])) * UM, "um")}
    if abs(sag) < LEAST_SAG:
        return made
    for k, axis in enumerate("xyz", start=1):
        centre = float(found[k]) / sag
        slope = np.array([-centre / sag, 1.0 / sag])
        own = covariance[np.ix_([0, k], [0, k])]
        made[f"centre_{axis}_mm"] = Quantity(centre * 1e3, float(np.sqrt(slope @ own @ slope)) * 1e3, "mm")
    return made


def spoken(name: str) -> str:
    """Return what people call a parameter, without its unit, which stands with its value.

    Examples
    --------
    >>> spoken("A_change_per_K_T1"), spoken("B_per_K"), spoken("centre_x_mm"), spoken("time_constant_s")
    ('change of A (T1)', 'B after it', 'centre x', 'time constant')
    """
    law = LAW.fullmatch(name)
    if law is not None:
        words = f"change of {law[1]}" if law[2] else f"{law[1]} after it"
        return f"{words} ({law[4]})" if law[4] else words
    end = next((end for end in ENDS if name.endswith(end)), "")
    bare = name.removesuffix(end)
    return SPOKEN.get(bare, bare.replace("_", " "))


def _once(parameters: Mapping[str, Quantity]) -> dict[str, Quantity]:
    """Return parameters without totals that are no other than the change that led to them, from 0."""
    changes = {name.replace("_change", ""): value for name, value in parameters.items() if "_change" in name}
    return {name: value for name, value in parameters.items() if name not in changes or changes[name] != value}


def sentence(one: Candidate, parameters: Mapping[str, Quantity], translation: float, rotation: float) -> str:
    """Return a finding in one sentence.

    Parameters
    ----------
    one : Candidate
    parameters : mapping of str to Quantity
    translation, rotation : float [m, rad]
        RMS of the effect on the platform.
    """
    known = catalogue().get(one.cause)
    where = (one.target or "the platform").replace("+", " and ")
    words = f"in {where}" if known is None else known.CAUSE.words.format(target=where)
    if one.cause in WORDS:
        words = WORDS[one.cause].format(target=where, **one.settings)
    parts = [f"{spoken(name)} {told(value)}" for name, value in _once(parameters).items()]
    inside = f" ({'; '.join(parts)})" if parts else ""
    return (
        f"The residual is {one.cause}{inside}: {words}; on the platform that makes {translation * UM:.2g} um and "
        f"{rotation * UM:.2g} urad (RMS)."
    )
