"""The virtual leg that stands for a campaign's: its lengths by what the campaign states, its sensors where they sit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hexathermal.compare.measured import MeasuredRun
from hexathermal.errors import ArgumentError, DataError
from hexathermal.learn.campaign import Campaign
from hexathermal.simulate.bench.leg import VirtualLeg

PARTS = ("body", "rod")

MARGIN = 0.002
"""The body, where it is lengthened, ends so far above its highest thermometer [m]."""

LARGEST_IN_METRES = 0.005
"""Positions that do not exceed this [m] are those of a leg of 5 m, written in metres."""

PUBLISHED_LENGTH = VirtualLeg().retracted_length
"""Retracted length of the bench [m]; other legs are the same one, longer or shorter."""


@dataclass(frozen=True)
class Placed:
    """A leg with thermocouples on it.

    Attributes
    ----------
    leg : VirtualLeg
    sensors : tuple of int
        Which of the campaign's thermocouples are compared.
    places : tuple of (str, float)
        Part and position [m] of each.
    notes : tuple of str
        What was fitted to the campaign, and which thermocouples are left out, and why.
    """

    leg: VirtualLeg
    sensors: tuple[int, ...]
    places: tuple[tuple[str, float], ...]
    notes: tuple[str, ...]


def placed(campaign: Campaign, leg: VirtualLeg | None = None) -> Placed:
    """Return the leg for a campaign.

    Parameters
    ----------
    campaign : Campaign
    leg : VirtualLeg, optional
        Taken as it is; default: the bench's own, its lengths fitted to the campaign's.

    Raises
    ------
    ArgumentError
        The campaign is of another kind, or its leg cannot be built.
    DataError
        It states no positions.
    """
    if campaign.kind != "leg" or campaign.leg is None:
        why = {"component": "a part without a rod: the bench has no model of its heat and of its shape",
               "hexapod": "a whole machine: compare its legs one by one on a bench"}  # fmt: skip
        raise ArgumentError(
            f"{campaign.folder} is of kind {campaign.kind!r}, {why.get(campaign.kind, 'which no leg can stand for')}; "
            "the virtual bench simulates kind 'leg', with [leg] and the thermocouples' parts and positions"
        )
    known = [item for item in campaign.thermocouples if item.part in PARTS and item.position is not None]
    if not known:
        raise DataError(
            f'no thermocouple of {campaign.file} states both part = "body" or "rod" and position_mm: without a '
            "place there is nothing to simulate; add them under [[thermocouples]]"
        )
    notes: list[str] = []
    built = _fitted(campaign, notes) if leg is None else leg
    sensors, places, reasons = [], [], list[str]()
    for k, item in enumerate(campaign.thermocouples):
        reason = _reason(item.part, item.position, built)
        if reason:
            reasons.append(f"{item.name} is not compared: {reason}")
        else:
            sensors.append(k)
            places.append((item.part, float(item.position or 0.0)))
    if len(reasons) > len(campaign.thermocouples) // 2:
        reasons.append(_in_metres(campaign))
    notes += filter(None, reasons)
    if not sensors:
        raise DataError("\n  ".join([f"{campaign.folder}: no thermocouple can be placed on the leg", *notes]))
    return Placed(built, tuple(sensors), tuple(places), tuple(notes))


def without_silent(
    where: Placed, runs: Sequence[MeasuredRun], names: Sequence[str]
) -> tuple[Placed, list[MeasuredRun]]:
    """Return a leg and runs without the thermocouples that no run for identification has a value of.

    Parameters
    ----------
    where : Placed
    runs : sequence of MeasuredRun
    names : sequence of str
        Of all thermocouples of the campaign.
    """
    fitted = [run for run in runs if run.role == "identification"]
    heard = [any(np.isfinite(run.rises[:, k]).any() for run in fitted) for k in range(len(where.sensors))]
    if not fitted or all(heard):
        return where, list(runs)
    silent = [names[k] for k, one in zip(where.sensors, heard, strict=True) if not one]
    note = f"{', '.join(silent)}: not compared, no run for identification has a settled row with a value"
    kept = np.flatnonzero(heard)
    fewer = replace(where, sensors=tuple(where.sensors[k] for k in kept), places=tuple(where.places[k] for k in kept),
                    notes=(*where.notes, note))  # fmt: skip
    return fewer, [
        replace(run, rises=run.rises[:, kept], row_noise=run.row_noise[kept], lowest_degC=run.lowest_degC[kept])
        for run in runs
    ]


def _in_metres(campaign: Campaign) -> str:
    """Return a question about the unit of positions that are all smaller than any leg is long; empty elsewhere."""
    largest = max((item.position or 0.0 for item in campaign.thermocouples), default=0.0)
    if not 0.0 < largest < LARGEST_IN_METRES:
        return ""
    return f"no position exceeds {largest * 1e3:g} mm: are they in metres? position_mm is expected in millimetres"


def _reason(part: str, position: float | None, leg: VirtualLeg) -> str:
    """Return why a thermocouple cannot be placed; empty where it can."""
    if part not in PARTS or position is None:
        return "its part is not said to be body or rod, or its position is not stated"
    try:
        leg.weights(part, position)
    except ArgumentError as error:
        return str(error)
    return ""


def _fitted(campaign: Campaign, notes: list[str]) -> VirtualLeg:
    """Return the bench's leg with the campaign's lengths."""
    stated = campaign.leg
    if stated is None:  # pragma: no cover - `placed` has looked
        raise ArgumentError("the campaign states no leg")
    own = VirtualLeg()
    factor = stated.retracted_length / own.retracted_length
    low, high = stated.stroke
    foot = own.joints.length * factor
    body = replace(own.body, length=own.body.length * factor, head_position=own.body.head_position * factor)
    top = max((item.position or 0.0 for item in campaign.thermocouples if item.part == "body"), default=0.0) + MARGIN
    if foot + body.length < top < stated.retracted_length + low - foot:
        notes.append(f"the body is taken to end at {top * 1e3:.0f} mm, above its highest thermocouple")
        body = replace(body, length=top - foot)
    contact = own.contact
    contact = replace(
        contact, nut_position=contact.nut_position * factor, guide_position=contact.guide_position * factor
    )
    shortest = stated.retracted_length + high - foot - (contact.nut_position - 0.5 * contact.nut_length)
    longest = stated.retracted_length + low - 2.0 * foot
    length = float(np.clip(own.rod.length * factor, shortest, max(shortest, longest)))
    if abs(factor - 1.0) > 1e-6 or abs(length - own.rod.length) > 1e-6:
        notes.append(
            f"the bench's lengths are multiplied by {factor:.3f} to a leg of {stated.retracted_length * 1e3:g} mm, its "
            f"rod is {length * 1e3:.0f} mm long"
        )
    try:
        return VirtualLeg(
            stated.retracted_length, (low, high), body, replace(own.rod, length=length), contact,
            replace(own.joints, length=foot), own.drive,
        )  # fmt: skip
    except ArgumentError as error:
        raise ArgumentError(
            f"the virtual bench has no leg of q0 = {stated.retracted_length * 1e3:g} mm with a stroke of "
            f"{low * 1e3:g} to {high * 1e3:g} mm: {error}; give one in Python: "
            "compare_campaign(..., leg=VirtualLeg(...))"
        ) from None
