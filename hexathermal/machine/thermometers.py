"""Under which names the temperatures of a machine are recorded, and which leg each of them tells."""

from __future__ import annotations

from collections.abc import Sequence

from hexathermal.errors import ArgumentError
from hexathermal.poses import as_array

AS_RECORDED = (1, 2, 3, 4, 5, 6)
"""Thermometers of legs that are recorded under the legs they sit on."""


def checked_thermometers(given: Sequence[int]) -> tuple[int, ...]:
    """Return a checked `ThermalModel.thermometers_of_leg`: each leg from 1 to 6 once.

    Examples
    --------
    >>> checked_thermometers([1, 2, 4, 3, 5, 6])
    (1, 2, 4, 3, 5, 6)
    """
    numbers = as_array(given, "thermometers_of_leg")
    if numbers.shape != (6,) or sorted(numbers.tolist()) != list(AS_RECORDED):
        found = ", ".join(f"{number:g}" for number in numbers.ravel())
        raise ArgumentError(
            f"thermometers_of_leg must hold each leg from 1 to 6 once, found [{found}]; legs 3 and 4 exchanged are "
            "[1, 2, 4, 3, 5, 6]"
        )
    return tuple(int(number) for number in numbers)


def recorded_names(legs: Sequence[Sequence[str]], legs_as_recorded: Sequence[int]) -> list[str]:
    """Return the names of legs' thermometers in the order of the record: ``leg1_<sensor>`` .. ``leg6_<sensor>``.

    Parameters
    ----------
    legs : sequence of sequences of str
        Sensors of each leg's law.
    legs_as_recorded : sequence of int
        Leg, from 0, that is recorded as leg 1, 2 .. 6.

    Examples
    --------
    >>> recorded_names([["T1"], ["leg2_T1", "T2"], ["T1"]], [0, 2, 1])
    ['leg1_T1', 'leg2_T1', 'leg3_T1', 'leg3_T2']
    """
    names = []
    for recorded, leg in enumerate(legs_as_recorded):
        own = f"leg{leg + 1}_" if leg != recorded else ""
        names += [full_name(f"leg{recorded + 1}", sensor.removeprefix(own)) for sensor in legs[leg]]
    return names


def full_name(part: str, sensor: str) -> str:
    """Return ``part_sensor``, the column name of the sensor without its unit."""
    return sensor if sensor.startswith(part + "_") else f"{part}_{sensor}"
