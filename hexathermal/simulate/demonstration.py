"""A machine warms through a working day: what its platform does with and without thermal correction.

The truth: legs and plates expand by laws of the same form at their true temperatures, the base about the centre of its
joints; the legs' true coefficients differ from those that the controller knows by `WorkingDay.law_uncertainty`. The
controller knows only what the machine's own thermometers read; the temperature of a plate without a thermometer stays
unknown to it.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from hexathermal.errors import KinematicsError
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.thermal import LegLaw
from hexathermal.poses import FloatArray, coordinates_from_pose, pose_from_coordinates
from hexathermal.predict.pose_errors import pose_errors
from hexathermal.predict.table_writing import written_together
from hexathermal.predict.temperatures import active_model
from hexathermal.simulate.day import (
    HOUR_S,
    DayTemperatures,
    WorkingDay,
    day_temperatures,
    readings,
    reference_degC,
    sensor_truth,
)

FORMAT = "hexathermal-demo/1"
TRAVEL_SHARE = 0.2
"""Half-width of the work trajectory as a part of the stroke; of the mean leg at home where no stroke is known."""

LIMIT_SHARE = 0.8
"""Largest part of the maker's travel limits that the work trajectory uses."""


@dataclass(frozen=True, eq=False)
class Demonstration:
    """One simulated day of a machine; n times, m work poses.

    Attributes
    ----------
    machine : Hexapod
        What the machine truly is: base frame where the base is held, every plate with a thermometer, and the legs' true
        coefficients.
    truth : DayTemperatures
    readings : array, shape (n, s) [degC]
        What the controller knows, in the order of `hexapod.sensor_names`.
    poses : array, shape (m, 4, 4) [m]
        Wanted poses, platform in base.
    nominal : array, shape (m, 6) [m]
        Leg lengths without correction.
    corrected : array, shape (n, m, 6) [m]
        Leg lengths with correction.
    errors_without, errors_with : array, shape (n, m, 6) [m, m, m, rad, rad, rad]
        Reached minus wanted pose: the platform's origin and the rotation vector, both in base axes.
    """

    hexapod: Hexapod
    day: WorkingDay
    seed: int
    machine: Hexapod
    truth: DayTemperatures
    readings: FloatArray
    poses: FloatArray
    nominal: FloatArray
    corrected: FloatArray
    errors_without: FloatArray
    errors_with: FloatArray


def with_plate_sensors(hexapod: Hexapod) -> Hexapod:
    """Return the machine with a thermometer on every plate that has an expansion law: the truth knows all."""
    model = active_model(hexapod)
    named = {
        part: None if plate is None or plate.sensor is not None else replace(plate, sensor="true")
        for part, plate in (("platform", model.platform), ("base", model.base))
    }
    plates = {part: plate for part, plate in named.items() if plate is not None}
    if not plates:
        return hexapod
    known = dict(zip(model.sensor_names, np.asarray(model.reference_temperature_degC), strict=True))
    whole = replace(model, reference_temperature_degC=reference_degC(hexapod), **plates)  # type: ignore[arg-type]
    reference = np.array([known.get(name, reference_degC(hexapod)) for name in whole.sensor_names])
    return replace(hexapod, thermal=replace(whole, reference_temperature_degC=reference))


def held_at_its_base(hexapod: Hexapod) -> tuple[Hexapod, FloatArray]:
    """Return the machine with its base frame at the centre of the base joints, and the move (3,) [m].

    A plate expands about its frame's origin. Where the base has no thermometer, its frame was chosen for other reasons,
    and the truth is told where the base is held; with a thermometer the machine's own frame says where that is.
    """
    base = active_model(hexapod).base
    centre = hexapod.base_joints.mean(axis=0) if base is not None and base.sensor is None else np.zeros(3)
    home = hexapod.home.copy()
    home[:3, 3] -= centre
    return replace(hexapod, base_joints=hexapod.base_joints - centre, home=home), centre


def with_true_law(hexapod: Hexapod, day: WorkingDay, generator: np.random.Generator) -> Hexapod:
    """Return the machine with legs that expand a little otherwise than their law says.

    ``A_true = A (1 + u g)``, likewise B, with ``u = day.law_uncertainty`` and a standard normal ``g`` for each
    coefficient; ``u = 0`` changes nothing. Terms that extend the law are true.
    """
    model = active_model(hexapod)

    def drawn(values: FloatArray) -> FloatArray:
        return np.asarray(values * (1.0 + day.law_uncertainty * generator.standard_normal(values.shape)))

    legs = tuple(
        LegLaw(law.sensors, drawn(law.A), drawn(law.B), campaign="drawn", terms=law.terms) for law in model.legs
    )
    return replace(hexapod, thermal=replace(model, legs=legs))


def work_poses(hexapod: Hexapod, temps: FloatArray, count: int = 8) -> FloatArray:
    """Return a closed work trajectory that the machine can take at all temperatures given.

    A figure of eight about home with tilts; it is halved until every pose is within stroke and cones.

    Parameters
    ----------
    temps : array, shape (k, s) [degC]
        Temperatures at which every pose must be reachable.
    count : int
        Number of poses.

    Returns
    -------
    array, shape (count, 4, 4) [m]
    """
    six, convention = _figure_of_eight(hexapod, count)
    for _halving in range(20):
        poses = pose_from_coordinates(six, convention, hexapod)
        try:
            hexapod.corrected_leg_lengths(poses, temps[:, None])
        except KinematicsError:
            six *= 0.5
        else:
            return poses
    raise KinematicsError(f"machine {hexapod.name!r} can hardly leave its home: no work trajectory was found about it")


def _figure_of_eight(hexapod: Hexapod, count: int) -> tuple[FloatArray, str]:
    """Return coordinates (count, 6) [mm, deg] that suit the size of a machine, and their rotation convention."""
    lengths = hexapod.inverse_kinematics(hexapod.home)
    low, high = hexapod.length_limits
    room = lengths.mean() if hexapod.stroke is None else 2.0 * np.minimum(high - lengths, lengths - low).min()
    travel = TRAVEL_SHARE * float(room)
    arm = float(np.linalg.norm(hexapod.platform_joints - hexapod.platform_joints.mean(axis=0), axis=1).mean())
    phase = 2.0 * np.pi * np.arange(count) / count
    loop = np.column_stack([np.cos(phase), np.sin(phase), np.sin(2.0 * phase)])
    units = np.array([1e3, 1e3, 1e3, *np.degrees([1.0, 1.0, 1.0])])
    sizes = np.array([travel, travel, 0.5 * travel, *(np.array([0.3, 0.3, 0.2]) * travel / arm)])
    if hexapod.limits is None:
        return np.hstack([loop, loop]) * sizes * units, "fixed-xyz"
    allowed = [min(abs(bound) for bound in getattr(hexapod.limits, axis)) for axis in ("x", "y", "z", "rx", "ry", "rz")]
    sizes = sizes * min(1.0, float((LIMIT_SHARE * np.array(allowed) / sizes).min()))
    return np.hstack([loop, loop]) * sizes * units, hexapod.limits.convention


def demonstrate(hexapod: Hexapod, *, day: WorkingDay | None = None, seed: int = 1) -> Demonstration:
    """Return a simulated working day of a machine, with its errors with and without correction.

    Parameters
    ----------
    hexapod : Hexapod
        With a thermal law.
    day : WorkingDay, optional
    seed : int
        Of everything that is drawn: how legs, their true laws and thermometers differ, and noise.

    Raises
    ------
    ThermalModelError
        The machine has no thermal law.
    TemperatureError
        The day leaves the law's range of validity.
    KinematicsError
        The machine cannot move about its home.
    """
    held, centre = held_at_its_base(hexapod)
    whole = with_plate_sensors(held)
    day = WorkingDay() if day is None else day
    generator = np.random.default_rng(seed)
    truth = day_temperatures(day, reference_degC(hexapod), generator)
    read = readings(hexapod, sensor_truth(hexapod, truth), day, generator)
    extremes = np.stack([read.min(axis=0), read.max(axis=0)])
    whole = with_true_law(whole, day, generator)
    poses = work_poses(hexapod, extremes)
    nominal = hexapod.inverse_kinematics(poses)
    corrected = hexapod.corrected_leg_lengths(poses, read[:, None])
    true_temps = sensor_truth(whole, truth)[:, None]
    wanted = poses.copy()
    wanted[:, :3, 3] -= centre
    without = pose_errors(wanted, whole.predicted_pose(nominal, true_temps))
    with_ = pose_errors(wanted, whole.predicted_pose(corrected, true_temps))
    return Demonstration(hexapod, day, seed, whole, truth, read, poses, nominal, corrected, without, with_)


def largest(errors: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the largest shift [um] and turn [urad] of any work pose at each time, shape (n,) each."""
    shift = np.linalg.norm(errors[..., :3], axis=-1).max(axis=-1) * 1e6
    turn = np.linalg.norm(errors[..., 3:], axis=-1).max(axis=-1) * 1e6
    return shift, turn


def summary(result: Demonstration) -> dict[str, Any]:
    """Return the day in numbers, ready for JSON."""
    (shift, turn), (shift_left, turn_left) = largest(result.errors_without), largest(result.errors_with)
    legs = result.truth.legs.mean(axis=1)
    correction = (result.corrected - result.nominal).mean(axis=(1, 2)) * 1e6

    def pair(before: FloatArray, after: FloatArray) -> dict[str, float]:
        lower = 100.0 * (1.0 - after.max() / before.max())
        return {"without": float(before.max()), "with": float(after.max()), "reduction_percent": float(lower)}

    return {
        "format": FORMAT,
        "machine": result.hexapod.name,
        "seed": result.seed,
        "hours": float(result.truth.time[-1] / HOUR_S),
        "work_poses": len(result.poses),
        "largest_leg_rise_K": float(result.truth.legs.max() - reference_degC(result.hexapod)),
        "largest_mean_leg_rise_K": float(legs.max() - reference_degC(result.hexapod)),
        "largest_mean_correction_um": float(correction[np.abs(correction).argmax()]),
        "largest_shift_um": pair(shift, shift_left),
        "largest_turn_urad": pair(turn, turn_left),
        "day": asdict(result.day),
    }


def table(result: Demonstration) -> tuple[list[str], list[list[float]]]:
    """Return the day as a table: names of the columns, and a row for each time and work pose."""
    axes = ("x_um", "y_um", "z_um", "rx_urad", "ry_urad", "rz_urad")
    names = ["time_s", "pose", "x_mm", "y_mm", "z_mm", "rx_deg", "ry_deg", "rz_deg"]
    names += [f"{name}_degC" for name in result.hexapod.sensor_names]
    names += ["room_true_degC", *(f"leg{i}_true_degC" for i in range(1, 7)), "platform_true_degC", "base_true_degC"]
    names += [f"leg{i}_length_mm" for i in range(1, 7)] + [f"without_{axis}" for axis in axes]
    names += [f"with_{axis}" for axis in axes]
    n, m = result.corrected.shape[:2]
    truth = result.truth
    parts = np.column_stack([truth.room, truth.legs, truth.platform, truth.base])
    coordinates = coordinates_from_pose(result.poses, hexapod=result.hexapod)

    def each(array: FloatArray, digits: int) -> FloatArray:
        return np.broadcast_to(array, (n, m, array.shape[-1])).reshape(n * m, -1).round(digits)

    columns = np.hstack(
        [
            each(truth.time[:, None, None], 3), each(np.arange(1.0, m + 1)[:, None], 0), each(coordinates, 9),
            each(result.readings[:, None], 4), each(parts[:, None], 4), each(result.corrected * 1e3, 7),
            each(result.errors_without * 1e6, 4), each(result.errors_with * 1e6, 4),
        ]
    )  # fmt: skip
    return names, columns.tolist()


def save(
    result: Demonstration, folder: Path, more: Mapping[str, Callable[[Path], object]] | None = None
) -> tuple[Path, ...]:
    """Write ``day.csv`` and ``summary.json`` into an existing folder, all or none; returns their paths.

    Parameters
    ----------
    more : mapping, optional
        Names of further files that belong to the day, each with a function that writes it to the path it is given.
    """
    names, rows = table(result)
    more = {} if more is None else more
    files = tuple(folder / name for name in ("day.csv", "summary.json", *more))
    with written_together(files) as (days, numbers, *others):
        with days.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(names)
            writer.writerows(rows)
        numbers.write_text(json.dumps(summary(result), indent=2) + "\n", encoding="utf-8")
        for part, write in zip(others, more.values(), strict=True):
            write(part)
    return files
