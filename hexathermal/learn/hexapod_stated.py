"""What a machine's file states already: taken off measured poses and lengths before laws are fitted or judged.

With the machine's own payload, terms of legs and drift of the measuring frame (`docs/extended-machine.md`) a measured
pose ``(R', t')`` is first put back into the machine's frame, and of the leg lengths there

    y_i = L_i(R, t) - q0_i - q_i - sag_i(R, t) - sum_k a_ik x_ik

is left to laws and plates.  Terms begin anew in each run and see its usable rows in the order of time.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from hexathermal.errors import ArgumentError, UnknownNameError
from hexathermal.kinematics.statics import payload_sag
from hexathermal.learn.hexapod_data import AIR, PLATES, HexapodRows
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.leg_states import sensors_of
from hexathermal.machine.leg_terms import LegTerm
from hexathermal.machine.thermal import LegLaw, ThermalModel
from hexathermal.machine.thermometers import AS_RECORDED, full_name
from hexathermal.poses import FloatArray
from hexathermal.predict.leg_drift import added_drift, machine_memories
from hexathermal.predict.measuring import machine_poses
from hexathermal.predict.pose_errors import pose_errors

if TYPE_CHECKING:
    from hexathermal.learn.machine_diagnosis.view import MachineView


def terms_of_legs(hexapod: Hexapod) -> tuple[tuple[LegTerm, ...], ...]:
    """Return the terms that the machine states of each of six legs."""
    return ((),) * 6 if hexapod.thermal is None else tuple(law.terms for law in hexapod.thermal.legs)


def refuse_unread_terms(hexapod: Hexapod, sensors: tuple[str, ...]) -> None:
    """Refuse thermometers without those that the machine's own terms read.

    Raises
    ------
    ArgumentError
        With the leg, the term and the thermometer.
    """
    for leg, terms in enumerate(terms_of_legs(hexapod)):
        for term in terms:
            for name in sensors_of([term]):
                if name not in sensors:
                    raise ArgumentError(
                        f"leg {leg + 1} of the machine has {term.cause}, which reads thermometer {name!r}; chosen are "
                        f"{', '.join(sensors)}: name it too (--sensors), or take the term out of the machine's file"
                    )


def terms_drift(rows: HexapodRows | MachineView) -> FloatArray:
    """Return by how much the terms that the machine states lengthen its legs, measured or planned, shape (n, 6) [m].

    Raises
    ------
    ArgumentError
        As `refuse_unread_terms`.
    """
    drift, terms = np.zeros((len(rows), 6)), terms_of_legs(rows.hexapod)
    if not any(terms):
        return drift
    refuse_unread_terms(rows.hexapod, rows.sensors)
    told = AS_RECORDED if rows.hexapod.thermal is None else rows.hexapod.thermal.thermometers_of_leg
    # terms alone, which read the rows' thermometers in the columns of the record
    nothing = np.zeros(len(rows.sensors))
    laws = [LegLaw(rows.sensors, nothing, nothing, terms=own) for own in terms]
    alone = replace(rows.hexapod, thermal=ThermalModel(laws, thermometers_of_leg=told))
    recorded = rows.dT.reshape(len(rows), -1)
    for run in np.unique(rows.run):
        own = np.flatnonzero(rows.run == run)
        lengths = rows.retracted + rows.q[own]
        drift[own] = added_drift(alone, lengths, recorded[own], rows.time[own], machine_memories(alone))
    return drift


def stated_lengths(rows: HexapodRows, poses: FloatArray) -> FloatArray:
    """Return by how much sag and terms, as the machine states them, lengthen its legs at poses, shape (n, 6) [m]."""
    return np.asarray(payload_sag(rows.hexapod, poses) + terms_drift(rows))


def frame_rise(rows: HexapodRows) -> FloatArray:
    """Return the temperature that the machine's measuring frame follows, since the zero, shape (n,) [K].

    Raises
    ------
    UnknownNameError
        It is not among the temperatures of these rows; `available` lists those.
    """
    frame = rows.hexapod.measuring_frame
    if frame is None:
        return np.zeros(len(rows))
    known = {} if rows.air is None else {AIR: rows.air}
    for k, (part, sensor) in enumerate(zip(PLATES, rows.plate_sensors, strict=True)):
        if sensor is not None:
            known[full_name(part, sensor)] = rows.plates[:, k]
    for leg in range(6):
        known |= {f"leg{leg + 1}_{name}": rows.dT[:, leg, k] for k, name in enumerate(rows.sensors)}
    if frame.sensor not in known:
        raise UnknownNameError(
            f"the machine's measuring frame follows {frame.sensor!r} (column {frame.sensor}_degC), which is not among "
            f"the temperatures that are read here: {', '.join(known)}; record it, or take [measuring_frame] out of the "
            "machine's file where another system measures",
            tuple(known),
        )
    return known[frame.sensor]


def in_machine_frame(rows: HexapodRows) -> FloatArray:
    """Return measured poses without the drift of the measuring frame that the machine states, shape (n, 4, 4) [m].

    Raises
    ------
    UnknownNameError
        As `frame_rise`.
    """
    if rows.hexapod.measuring_frame is None:
        return rows.measured
    rise, poses = frame_rise(rows), np.array(rows.measured)
    for run in np.unique(rows.run):
        own = rows.run == run
        poses[own] = machine_poses(rows.hexapod, rows.measured[own], rise[own], rows.time[own])
    return poses


def stated_notes(rows: HexapodRows) -> list[str]:
    """Return in words what the machine states beside laws and plates, and how much it makes in these rows."""
    hexapod, notes = rows.hexapod, []
    told = AS_RECORDED if hexapod.thermal is None else hexapod.thermal.thermometers_of_leg
    for leg, own in enumerate(told):
        if own != leg + 1:
            notes.append(
                f"leg {leg + 1} is told by the thermometers recorded as those of leg {own}, as the machine states"
            )
    drift = terms_drift(rows)
    for leg, terms in enumerate(terms_of_legs(hexapod)):
        if terms:
            notes.append(
                f"leg {leg + 1} keeps {', '.join(term.cause for term in terms)} as the machine states it: up to "
                f"{np.abs(drift[:, leg]).max(initial=0.0) * 1e6:.2f} um in these rows"
            )
    if hexapod.compliance is not None:
        sag = np.abs(payload_sag(hexapod, rows.measured)).max(initial=0.0)
        notes.append(
            f"the payload of {hexapod.compliance.payload_mass:g} kg that the machine states makes up to "
            f"{sag * 1e6:.2f} um in a leg: it is no part of the laws"
        )
    if hexapod.measuring_frame is not None:
        moved = np.abs(pose_errors(in_machine_frame(rows), rows.measured)).max(axis=0, initial=0.0) * 1e6
        notes.append(
            f"measured poses are freed of the drift of the measuring frame with {hexapod.measuring_frame.sensor} that "
            f"the machine states: up to {moved[:3].max():.2f} um and {moved[3:].max():.2f} urad"
        )
    return notes
