"""What the machine is made of besides joints: diameters, masses and plate thicknesses.

They serve collisions, loads and drawings; kinematics and thermal laws do not need them.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from hexathermal.errors import ArgumentError, UnknownNameError
from hexathermal.poses import CONVENTIONS, as_array


@dataclass(frozen=True)
class Bodies:
    """Sizes [m] and masses [kg] of the machine's bodies.

    The fixed body of a leg is a tube that starts at the base joint, the rod one that ends at the platform joint.
    Centres of mass: body and rod at the middle of their length, plates at the centroid of their joints.
    """

    leg_body_diameter: float
    leg_rod_diameter: float
    leg_body_mass: float = 0.0
    leg_rod_mass: float = 0.0
    platform_mass: float = 0.0
    platform_thickness: float = 0.0
    base_thickness: float = 0.0

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if not isinstance(value, int | float) or not np.isfinite(value) or value < 0.0:
                raise ArgumentError(f"{item.name} must be a number >= 0, found {value!r}")
            object.__setattr__(self, item.name, float(value))
        if not self.leg_body_diameter > 0.0 or not self.leg_rod_diameter > 0.0:
            raise ArgumentError("leg diameters must be above 0")


@dataclass(frozen=True)
class PoseLimits:
    """Travel that the maker allows, counted from home: pairs [low, high] in metres and radians.

    `convention` names the rotation convention of the three angles, see `hexathermal.poses`.

    Raises
    ------
    ArgumentError
        A limit is no pair of finite numbers [low, high] with low < high.
    UnknownNameError
        The convention is not known; `available` lists the names.
    """

    x: tuple[float, float]
    y: tuple[float, float]
    z: tuple[float, float]
    rx: tuple[float, float]
    ry: tuple[float, float]
    rz: tuple[float, float]
    convention: str = "fixed-xyz"

    def __post_init__(self) -> None:
        for name in ("x", "y", "z", "rx", "ry", "rz"):
            given = getattr(self, name)
            pair = as_array(given, f"limit of {name}")
            if pair.shape != (2,) or not np.isfinite(pair).all() or not pair[0] < pair[1]:
                raise ArgumentError(f"limit of {name} must be a pair [low, high], found {given!r}")
            object.__setattr__(self, name, (float(pair[0]), float(pair[1])))
        if not isinstance(self.convention, str):
            raise ArgumentError(f"convention must be a name, found {self.convention!r}")
        if self.convention.lower().replace("_", "-") not in CONVENTIONS:
            raise UnknownNameError(
                f"convention {self.convention!r} is not known; choose one of {', '.join(sorted(CONVENTIONS))}",
                tuple(CONVENTIONS),
            )
