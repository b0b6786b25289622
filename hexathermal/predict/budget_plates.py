"""What the plates of a machine are said to be at, where no thermometer tells, and how that enters a budget."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError, ThermalModelError
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.thermal import ABSOLUTE_ZERO_DEGC
from hexathermal.poses import FloatArray, finite_array
from hexathermal.predict.temperatures import active_model, check_stated

PARTS = ("platform", "base")


@dataclass(frozen=True)
class Plates:
    """Temperatures of plates that no thermometer tells, and gradients across plates.

    Parameters
    ----------
    platform_degC, base_degC : float, optional
        Temperature at the plate's origin. Default: the mean of the legs' thermometers. Not for a plate with a
        thermometer.
    platform_gradient, base_gradient : (float, float, float) [K/m]
        Along x, y and z of the platform's and of the base's frame.
    base_held_at : (float, float, float) [m], optional
        Point of the base that does not move, in the base frame. Default: the base frame's origin where the base has a
        thermometer (the correction counts from there), else the centre of the base joints.
    """

    platform_degC: float | None = None
    base_degC: float | None = None
    platform_gradient: tuple[float, float, float] = (0.0, 0.0, 0.0)
    base_gradient: tuple[float, float, float] = (0.0, 0.0, 0.0)
    base_held_at: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        for part in PARTS:
            value = getattr(self, f"{part}_degC")
            if value is not None:
                number = finite_array(value, (), f"{part}_degC")
                if number.shape or number < ABSOLUTE_ZERO_DEGC:
                    raise ArgumentError(f"{part}_degC must be one possible temperature, found {value!r}")
            slope = finite_array(getattr(self, f"{part}_gradient"), (3,), f"{part}_gradient")
            if slope.shape != (3,):
                raise ArgumentError(f"{part}_gradient has shape {slope.shape}; expected (3,), K/m along x, y, z")
            object.__setattr__(self, f"{part}_gradient", tuple(float(value) for value in slope))
        if self.base_held_at is not None:
            held = finite_array(self.base_held_at, (3,), "base_held_at")
            if held.shape != (3,):
                raise ArgumentError(f"base_held_at has shape {held.shape}; expected (3,), metres in the base frame")
            object.__setattr__(self, "base_held_at", tuple(float(value) for value in held))


def blind_plates(hexapod: Hexapod) -> tuple[str, ...]:
    """Return the plates that have a law and no thermometer: those whose temperature somebody may state."""
    model = active_model(hexapod)
    plates = ((part, getattr(model, part)) for part in PARTS)
    return tuple(part for part, plate in plates if plate is not None and plate.sensor is None)


def plate_rows(hexapod: Hexapod, temps: FloatArray, given: Plates) -> FloatArray:
    """Return expansion, temperature, gradient and resting point of both plates."""
    model = active_model(hexapod)
    check_plates(given)
    legs = sum(len(law.sensors) for law in model.legs)
    reference = float(np.mean(model.reference_temperature_degC))
    rows = np.zeros((2, 8))
    for k, part in enumerate(PARTS):
        plate, told, slope = getattr(model, part), getattr(given, f"{part}_degC"), getattr(given, f"{part}_gradient")
        if plate is None:
            if told is not None or any(slope):
                raise ThermalModelError(
                    f"machine {hexapod.name!r} has no law for its {part}: give it one ([thermal.{part}] with "
                    "expansion_per_K), or leave its temperature and gradient out"
                )
            continue
        if told is not None and plate.sensor is not None:
            raise ArgumentError(f"the {part} has a thermometer ({plate.sensor}): its temperature is one of temps")
        if told is not None:
            check_stated(hexapod, float(told), part)
        warm = float(temps[:legs].mean()) if told is None else float(told)
        rows[k, :5] = [plate.expansion, 0.0 if plate.sensor else warm - reference, *slope]
    if given.base_held_at is not None:
        rows[1, 5:] = given.base_held_at
    elif model.base is None or model.base.sensor is None:
        rows[1, 5:] = hexapod.base_joints.mean(axis=0)
    return rows


def each_of(common: Plates | None, each: Sequence[Plates] | None, count: int) -> list[Plates]:
    """Return the plates of each place."""
    if each is not None and len(each) != count:
        raise ArgumentError(f"{len(each)} plates for {count} places; give as many")
    found = [common] * count if each is None else list(each)
    for own in found:
        if own is not None:
            check_plates(own)
    return [Plates() if own is None else own for own in found]


def check_plates(given: Any) -> None:
    """Refuse what is no `Plates`."""
    if not isinstance(given, Plates):
        raise ArgumentError(f"plates must be a Plates, found {type(given).__name__}")


def stated_alike(plates: list[Plates]) -> list[npt.NDArray[np.intp]]:
    """Return the places whose plates are stated in the same way: they share their default sources."""
    kinds: dict[tuple[bool, bool], list[int]] = {}
    for k, own in enumerate(plates):
        kinds.setdefault((own.platform_degC is not None, own.base_degC is not None), []).append(k)
    return [np.array(rows, dtype=np.intp) for rows in kinds.values()]
