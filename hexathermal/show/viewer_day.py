"""A simulated working day for the viewer: the machine works along a figure of eight, warms up, and rests."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.thermal import frozen
from hexathermal.poses import FloatArray
from hexathermal.predict.budget_plates import Plates
from hexathermal.predict.temperatures import active_model
from hexathermal.show.viewer_course import (
    Course,
    Progress,
    budget_regions,
    clock,
    commanded_pair,
    evenly,
    reached_pair,
    tool_errors,
)
from hexathermal.simulate.day import (
    DayTemperatures,
    WorkingDay,
    day_temperatures,
    readings,
    reference_degC,
    sensor_truth,
)
from hexathermal.simulate.demonstration import held_at_its_base, with_plate_sensors, with_true_law, work_poses

WORK_POSES, STEPS_A_POSE = 48, 5
"""Poses of the figure of eight, and steps of the day for which each is held."""


def day_course(hexapod: Hexapod, pose: FloatArray | None, tool: FloatArray, seed: int, progress: Progress) -> Course:
    """Return a simulated working day of a machine.

    The truth is that of `hexathermal.simulate.demonstration`: legs whose coefficients differ a little from the law,
    plates with temperatures of their own; the controller knows what the thermometers read.

    Parameters
    ----------
    hexapod : Hexapod
        With a thermal law.
    pose : array, shape (4, 4) [m], or None
        Held all day; None: the machine moves along a figure of eight while it works.
    tool : array, shape (3,) [m]
    seed : int
        Of all that is drawn.
    progress : callable

    Raises
    ------
    ThermalModelError, TemperatureError, KinematicsError
        As `hexathermal.simulate.demonstration.demonstrate`.
    """
    progress(0, 0, "simulating the day (the first run compiles)")
    held, centre = held_at_its_base(hexapod)
    day, generator = WorkingDay(), np.random.default_rng(seed)
    truth = day_temperatures(day, reference_degC(hexapod), generator)
    read = readings(hexapod, sensor_truth(hexapod, truth), day, generator)
    whole = with_true_law(with_plate_sensors(held), day, generator)
    ideal = _wanted(hexapod, pose, truth, read)
    reached = reached_pair(whole, commanded_pair(hexapod, ideal, read, truth.time), sensor_truth(whole, truth),
                           truth.time)  # fmt: skip
    reached[..., :3, 3] += centre
    errors = np.stack([tool_errors(ideal, poses, tool) for poses in reached])
    kept = evenly(len(truth.time))
    plates = [_plates(hexapod, truth, k) for k in kept]
    centres, regions, notes = budget_regions(
        hexapod, ideal[kept], read[kept], tool, progress, plates=plates, air_degC=truth.room[kept]
    )
    states = ["working" if truth.working[k] else "resting" for k in kept]
    labels = tuple(f"{clock(truth.time[k])}, {state}" for k, state in zip(kept, states, strict=True))
    notes = [
        f"a simulation, seed {seed}: the true A and B of each leg are {100.0 * day.law_uncertainty:g} % (standard "
        "deviation) off the law's",
        *notes,
        f"{len(kept)} of {len(truth.time)} minutes are shown",
    ]
    return Course(
        hexapod, "a simulated working day", labels, np.zeros(len(kept), dtype=np.int64), frozen(ideal[kept]),
        frozen(errors[:, kept]), frozen(truth.legs[kept]), frozen(centres), frozen(regions), frozen(tool), True,
        ("simulated without correction", "simulated with correction"), tuple(notes),
    )  # fmt: skip


def _wanted(hexapod: Hexapod, pose: FloatArray | None, truth: DayTemperatures, read: FloatArray) -> FloatArray:
    """Return the wanted pose of each minute, (n, 4, 4)."""
    if pose is not None:
        return np.broadcast_to(pose, (len(truth.time), 4, 4)).copy()
    model = active_model(hexapod)
    plain = replace(hexapod, thermal=model.without_states()) if model.states else hexapod
    path = work_poses(plain, np.stack([read.min(axis=0), read.max(axis=0)]), WORK_POSES)
    return np.asarray(path[np.cumsum(truth.working) // STEPS_A_POSE % WORK_POSES])


def _plates(hexapod: Hexapod, truth: DayTemperatures, k: int) -> Plates:
    """Return the temperatures of plates without thermometers in one minute."""
    model = active_model(hexapod)
    blind = [part for part in ("platform", "base") if getattr(model, part) and getattr(model, part).sensor is None]
    return Plates(**{f"{part}_degC": float(getattr(truth, part)[k]) for part in blind})  # type: ignore[arg-type]
