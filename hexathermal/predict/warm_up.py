"""Every compiled loop called once, so that later calls find it in the cache on disk."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from hexathermal.kinematics.jacobian import condition_number
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.library import load_hexapod
from hexathermal.machine.thermal import PlateLaw, ThermalModel
from hexathermal.predict.montecarlo import drawn_errors

Step = tuple[str, Callable[[], Any]]


def _with_plates(hexapod: Hexapod) -> Hexapod:
    """Return a machine whose plates have thermometers."""
    model = hexapod.thermal
    if model is None:
        return hexapod
    plates = (PlateLaw(1e-6, "T1"), PlateLaw(1e-6, "T1"))
    return replace(hexapod, thermal=ThermalModel(model.legs, *plates, reference_temperature_degC=20.0))


def steps() -> Iterator[Step]:
    """Return what there is to compile: a label for each, and a call without arguments that does it."""
    hexapod = load_hexapod("reference")
    plates = _with_plates(hexapod)
    one, many = np.array(hexapod.home), np.repeat(hexapod.home[None], 70, axis=0)
    cool, warm, hot = np.full(6, 21.0), np.full((70, 6), 22.0), np.full(8, 23.0)
    lengths = hexapod.home_lengths
    yield "leg lengths of one pose", lambda: hexapod.inverse_kinematics(one)
    yield "leg lengths of many poses", lambda: hexapod.inverse_kinematics(many)
    yield "Jacobians", lambda: condition_number(hexapod, many)
    yield "correction, one pose", lambda: hexapod.corrected_leg_lengths(one, cool)
    yield "correction, many poses", lambda: hexapod.corrected_leg_lengths(many, warm)
    yield "correction, one pose and many temperatures", lambda: hexapod.corrected_leg_lengths(one, warm)
    yield "correction, many poses and one set of temperatures", lambda: hexapod.corrected_leg_lengths(many, cool)
    yield "correction with plates", lambda: plates.corrected_leg_lengths(many, hot)
    yield "drift of the legs", lambda: hexapod.leg_drift(lengths, warm)
    yield "poses from lengths, one", lambda: hexapod.forward_kinematics(lengths)
    yield "poses from lengths, many", lambda: hexapod.forward_kinematics(np.repeat(lengths[None], 70, axis=0))
    yield "poses from lengths, with a start", lambda: hexapod.forward_kinematics(lengths, one)
    yield "poses from lengths, with notes", lambda: hexapod.solve_forward(np.repeat(lengths[None], 70, axis=0), many)
    yield "corrected poses", lambda: hexapod.corrected_pose(many, warm)
    yield "where a warm platform stands", lambda: plates.predicted_pose(lengths, hot)
    yield "error budget", lambda: plates.error_budget(one, hot)
    yield "draws around a pose", lambda: drawn_errors(hexapod, one, np.repeat(lengths[None], 70, axis=0))
    yield "all postures", lambda: hexapod.assembly_modes(lengths)
