"""How the parts of a machine may be warmed in a planned run: one leg, a plate, everything, the room."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.poses import FloatArray

USUAL_RISE_K = 5.0
"""By how much a part is warmed: a heating mat or some hours of work."""

CONDUCTED = 0.15
"""Part of a leg's rise that reaches the plates, or of a plate's that reaches the legs. Engineering value."""


@dataclass(frozen=True)
class Scenario:
    """What warms in a run, by how much from its first row to its last, evenly.

    Attributes
    ----------
    name, words : str
        What it is, and what to do.
    legs : tuple of six float [K]
    platform, base, air : float [K]
    """

    name: str
    words: str
    legs: tuple[float, ...]
    platform: float = 0.0
    base: float = 0.0
    air: float = 0.0

    def __post_init__(self) -> None:
        if len(self.legs) != 6:
            raise ArgumentError(f"scenario {self.name!r} needs a rise for each of six legs, found {len(self.legs)}")
        if not np.isfinite([*self.legs, self.platform, self.base, self.air]).all():
            raise ArgumentError(f"scenario {self.name!r} holds a rise that is no finite number")

    def temperatures(self, course: FloatArray, sensors: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the rises of legs (n, 6, s), plates (n, 2) and air (n,) [K] at parts 0 to 1 of the course (n,)."""
        course = np.asarray(course, dtype=np.float64)
        legs = np.repeat((course[:, None] * np.array(self.legs))[..., None], sensors, axis=2)
        return legs, course[:, None] * np.array([self.platform, self.base]), course * self.air


def usual_scenarios(rise: float = USUAL_RISE_K) -> tuple[Scenario, ...]:
    """Return the ways of warming that a workshop can do.

    Parameters
    ----------
    rise : float [K]
        By how much a part is warmed.

    Examples
    --------
    >>> [one.name for one in usual_scenarios()][:3]
    ['at rest', 'everything alike', 'legs']
    """
    if not (np.isfinite(rise) and rise > 0.0):
        raise ArgumentError(f"a rise of temperature must be above 0 K, found {rise!r}")
    some, all_, none = CONDUCTED * rise, (rise,) * 6, (0.0,) * 6
    odd, even = (tuple(rise * ((leg % 2) == side) for leg in range(6)) for side in (0, 1))
    single = tuple(
        Scenario(f"leg {leg + 1}", f"warm leg {leg + 1} alone by {rise:g} K",
                 tuple(rise * (other == leg) for other in range(6)), some / 6.0, some / 6.0)
        for leg in range(6)
    )  # fmt: skip
    conducted = (some,) * 6
    return (
        Scenario("at rest", "keep the machine and the room at one temperature", none),
        Scenario("everything alike", f"let the room rise slowly by {rise:g} K, the machine with it", all_, rise, rise,
                 rise),
        Scenario("legs", f"let the machine work until its six legs are {rise:g} K warmer", all_, some, some),
        *single,
        Scenario("legs 1, 3, 5", f"warm legs 1, 3 and 5 by {rise:g} K", odd, 0.5 * some, 0.5 * some),
        Scenario("legs 2, 4, 6", f"warm legs 2, 4 and 6 by {rise:g} K", even, 0.5 * some, 0.5 * some),
        Scenario("platform", f"warm the platform alone by {rise:g} K", conducted, rise, 0.0),
        Scenario("base", f"warm the base alone by {rise:g} K", conducted, 0.0, rise),
        Scenario("room", f"let the room's air rise by {rise:g} K faster than the machine follows", conducted, some,
                 some, rise),
    )  # fmt: skip


def checked(scenarios: Sequence[Scenario]) -> tuple[Scenario, ...]:
    """Return scenarios, at least one, with names of their own."""
    names = [one.name for one in scenarios]
    if not names or len(set(names)) != len(names):
        raise ArgumentError(f"scenarios need names of their own, at least one; found {names!r}")
    return tuple(scenarios)
