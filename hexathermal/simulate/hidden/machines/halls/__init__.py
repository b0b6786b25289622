"""Halls in which a hexapod gets warm; each makes the temperatures of a campaign from simple physics of its own.

A hall is a module of this folder that holds ``NAME`` and ``warm(course, sides, sensors, generator)``, which returns a
`Warmth` on the even steps of the course. It is found by itself.
"""

from __future__ import annotations

from typing import Protocol, cast

import numpy as np

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.found_modules import chosen, modules_of
from hexathermal.simulate.hidden.machines.halls.warmth import Warmth
from hexathermal.simulate.hidden.machines.motion import Course


class Hall(Protocol):
    """A hall's module."""

    NAME: str

    def warm(self, course: Course, sides: FloatArray, sensors: int, generator: np.random.Generator) -> Warmth:
        """Return what the legs, of which each stands on a side [rad], the plates and the air are at."""


def found() -> dict[str, Hall]:
    """Return the halls of this folder by their name.

    Examples
    --------
    >>> list(found())
    ['climate chamber', 'machine hall', 'warm-up']
    """
    return {module.NAME: cast(Hall, module) for module in modules_of(__name__, __file__) if hasattr(module, "NAME")}


def warm(name: str, course: Course, sides: FloatArray, sensors: int, generator: np.random.Generator) -> Warmth:
    """Return the temperatures of a campaign in a hall.

    Raises
    ------
    UnknownNameError
        No hall has the name.
    """
    return chosen(name, found(), "hall").warm(course, sides, sensors, generator)
