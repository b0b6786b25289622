"""Where the truth of a campaign puts the platform, and where the machine as filed would have put it.

With dT from the campaign's zero, leg i is ``L_i = q0_i + q_i + sum_s (A_is q0_i + B_is q_i) dT_is + stretch_i`` long,
less what it gives way under a load; plates grow about the origins of their frames, joints stand where they truly are.
The platform stands where six such legs let it (`hexathermal.simulate.hidden.machines.posture`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.machines.posture import Posture, legs_of, standing
from hexathermal.simulate.hidden.machines.rotation import angles_of, from_angles, from_vector, product, turned
from hexathermal.simulate.hidden.machines.truth import Load, MachineTruth

ROUNDS = 3
"""A leg gives way by some 1e-5 of its length, and by as much less in each round."""


@dataclass(frozen=True, eq=False)
class Heat:
    """Temperatures of all rows: legs (n, 6, s), plates (n, 2) [degC]."""

    legs: FloatArray
    plates: FloatArray


def true_heats(truth: MachineTruth) -> list[Heat]:
    """Return what the machine's parts are at in each run."""
    return [Heat(run.legs, run.plates) for run in truth.runs]


def mended_heats(truth: MachineTruth) -> list[Heat]:
    """Return what the thermometers read in each run, each put down to the leg on which it sits."""
    return [Heat(run.legs + run.leg_errors, run.plates + run.plate_errors) for run in truth.runs]


def told_heats(truth: MachineTruth) -> list[Heat]:
    """Return what faultless thermometers would read in each run, in the columns in which it is recorded."""
    return [_in_columns(truth, heat) for heat in true_heats(truth)]


def read_heats(truth: MachineTruth) -> list[Heat]:
    """Return what the thermometers read in each run, in the columns in which it is recorded."""
    return [_in_columns(truth, heat) for heat in mended_heats(truth)]


def _in_columns(truth: MachineTruth, heat: Heat) -> Heat:
    """Return temperatures of legs in the columns that hold them."""
    return Heat(heat.legs[:, list(truth.read_from)], heat.plates)


def rises(truth: MachineTruth, heats: list[Heat]) -> list[Heat]:
    """Return temperatures of the runs from the campaign's zero [K]."""
    first = [heat if truth.zero == "run" else heats[0] for heat in heats]
    return [
        Heat(heat.legs - zero.legs[0], heat.plates - zero.plates[0]) for heat, zero in zip(heats, first, strict=True)
    ]


def as_filed(truth: MachineTruth) -> MachineTruth:
    """Return the campaign as if the machine were as filed and nothing moved what is measured."""
    hexapod, model = truth.hexapod, truth.hexapod.thermal
    assert model is not None  # machines are drawn with their law
    plates = [0.0 if law is None or law.sensor is None else law.expansion for law in (model.platform, model.base)]
    runs = tuple(
        run.changed(stretch=np.zeros_like(run.stretch), platform_bend=np.zeros_like(run.platform_bend),
                    moved=np.zeros_like(run.moved))
        for run in truth.runs
    )  # fmt: skip
    return truth.changed(
        runs=runs, A=np.array([law.A for law in model.legs]), B=np.array([law.B for law in model.legs]),
        expansions=np.array(plates), base_joints=hexapod.base_joints, platform_joints=hexapod.platform_joints,
        load=None,
    )  # fmt: skip


def nominal(truth: MachineTruth, coordinates: FloatArray) -> Posture:
    """Return the posture of coordinates from home (n, 6) [m, rad]."""
    return Posture(truth.hexapod.home[:3, 3] + coordinates[:, :3], from_angles(coordinates[:, 3:]))


def coordinates_of(truth: MachineTruth, posture: Posture) -> FloatArray:
    """Return coordinates from home, shape (n, 6) [m, rad]."""
    return np.hstack([posture.position - truth.hexapod.home[:3, 3], angles_of(posture.turn)])


def stood(truth: MachineTruth, heats: list[Heat]) -> FloatArray:
    """Return where the platform stands in all rows at temperatures of the runs: coordinates (n, 6) [m, rad]."""
    rise = rises(truth, heats)
    legs = np.concatenate([heat.legs for heat in rise])
    plates = 1.0 + np.concatenate([heat.plates for heat in rise]) * truth.expansions
    q, q0 = truth.all("q"), truth.retracted
    grown = ((truth.A * q0[:, None] + truth.B * q[..., None]) * legs).sum(-1)
    lengths = q0 + q + grown + truth.all("stretch")
    platform = (truth.platform_joints + truth.all("platform_bend")) * plates[:, :1, None]
    base = truth.base_joints * plates[:, 1:, None]
    found = standing(lengths, base, platform, nominal(truth, truth.all("commanded")))
    if truth.load is not None:
        for _round in range(ROUNDS):
            sag = truth.load.compliance * thrusts(truth.load, found, base, platform)
            found = standing(lengths - sag, base, platform, found)
    return coordinates_of(truth, found)


def thrusts(load: Load, posture: Posture, base: FloatArray, platform: FloatArray) -> FloatArray:
    """Return by which forces the legs push to hold a load, shape (n, 6) [N]; pulling is negative.

    Forces and moments about the origin of the base, of the six thrusts and of the weight, add up to zero.
    """
    legs = legs_of(posture, base, platform)
    along = legs / np.linalg.norm(legs, axis=-1, keepdims=True)
    balance = np.concatenate([along, np.cross(base + 0.0 * legs, along)], axis=-1)
    centre = posture.position + turned(posture.turn, load.centre)
    weight = np.broadcast_to(load.weight, centre.shape)
    wrench = np.hstack([weight, np.cross(centre, weight)])
    return np.asarray(np.linalg.solve(np.swapaxes(balance, 1, 2), -wrench[..., None])[..., 0])


def seen(coordinates: FloatArray, motion: FloatArray) -> FloatArray:
    """Return coordinates (n, 6) as seen from where a motion about home (n, 6) [m, rad] puts them."""
    turn = from_vector(motion[:, 3:])
    return np.hstack([
        turned(turn, coordinates[:, :3]) + motion[:, :3], angles_of(product(turn, from_angles(coordinates[:, 3:])))
    ])  # fmt: skip


def effect(truth: MachineTruth) -> FloatArray:
    """Return what the hidden effects do to the six coordinates of all rows, shape (n, 6) [m, rad].

    That is the platform as it truly stands and is seen, less what the machine as filed foretells from the temperatures
    in the columns where they are recorded; without noise, without errors of thermometers, the measuring frame true.
    """
    true = seen(stood(truth, true_heats(truth)), truth.all("moved"))
    filed = stood(as_filed(truth), told_heats(truth))
    return np.asarray(true - filed)


def measured(truth: MachineTruth) -> FloatArray:
    """Return the measured coordinates of all rows, shape (n, 6) [m, rad]."""
    true = seen(stood(truth, true_heats(truth)), truth.all("moved"))
    return np.asarray(seen(true, truth.all("frame")) + truth.all("noise"))
