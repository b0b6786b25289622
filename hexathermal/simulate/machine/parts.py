"""Parts of the virtual hexapod beside its legs: plates, the 6-D positioning system, what users do with it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.machine.thermal import frozen
from hexathermal.poses import FloatArray
from hexathermal.simulate.bench.parts import require_finite

COORDINATES = ("x", "y", "z", "rx", "ry", "rz")


@dataclass(frozen=True)
class Plate:
    """Platform or base: one lump of heat that six joints warm and the room cools; it expands about its frame's origin.

    Attributes
    ----------
    capacity : float [J/K]
    convection : float [W/K]
        To the room.
    expansion : float [1/K]
    """

    capacity: float
    convection: float
    expansion: float = 1.6e-6

    def __post_init__(self) -> None:
        require_finite(self, above_zero=("capacity",), signed=("expansion",))


@dataclass(frozen=True)
class PositioningSystem:
    """A 6-D positioning system that looks at the platform, as a laser tracker or a set of interferometers.

    Attributes
    ----------
    noise : tuple of float [m, m, m, rad, rad, rad]
        Standard deviation of each coordinate x, y, z, rx, ry, rz. Engineering value: 0.4 um, 1 urad.
    frame_shift, frame_turn : float [m], [rad]
        Its frame is tied to the machine's anew before each run: standard deviation of what is left, about the
        platform's home. Engineering value.
    """

    noise: tuple[float, ...] = (4e-7, 4e-7, 4e-7, 1e-6, 1e-6, 1e-6)
    frame_shift: float = 5e-7
    frame_turn: float = 1e-6

    def __post_init__(self) -> None:
        if len(self.noise) != 6:
            raise ArgumentError(f"a positioning system has a noise for each of {COORDINATES}, found {self.noise!r}")
        require_finite(self)

    def frame(self, generator: np.random.Generator) -> FloatArray:
        """Return the error of its frame in a run, drawn anew, shape (6,) [m, rad]."""
        return frozen(generator.standard_normal(6) * ([self.frame_shift] * 3 + [self.frame_turn] * 3))


@dataclass(frozen=True)
class MachineScenario:
    """What users do with a hexapod: it works, is measured from time to time, and rests.

    Attributes
    ----------
    errands : int
        Other poses that a machine in full work goes to between two measured ones. Engineering value.
    pause, settling : float [s]
        At every pose; longer before a measurement. Engineering value.
    working : tuple of int
        Fewest and most measured poses of a phase of work. Engineering value.
    resting : tuple of int
        Fewest and most measurements of a phase of rest, the platform held where it is. Engineering value.
    interval : float [s]
        Between measurements at rest. Engineering value.
    loads : tuple of float [1]
        Runs take these in turn: part of the errands that are run.
    """

    errands: int = 1
    pause: float = 15.0
    settling: float = 30.0
    working: tuple[int, int] = (30, 50)
    resting: tuple[int, int] = (12, 25)
    interval: float = 240.0
    loads: tuple[float, ...] = field(default=(1.0, 0.4, 1.0, 0.7))

    def __post_init__(self) -> None:
        require_finite(self, above_zero=("pause", "settling", "working", "interval"))
        for name in ("working", "resting"):
            low, high = getattr(self, name)
            if low > high:
                raise ArgumentError(f"MachineScenario.{name} is (fewest, most), found {(low, high)!r}")
