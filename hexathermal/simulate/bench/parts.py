"""Parts of the leg on the virtual bench: every number named, with its unit and where it comes from.

*Source* names a published value, *engineering value* one that nobody has published for this machine, *derived* one that
follows from the figures of Robert et al. (a drift of 7.81 um at some 5.3 K, A = 1.99e-6 /K, B = 1.09e-6 /K).
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import isfinite, pi
from typing import Any

from hexathermal.errors import ArgumentError


def require_finite(value: Any, *, above_zero: tuple[str, ...] = (), signed: tuple[str, ...] = ()) -> None:
    """Refuse a dataclass with a number that is not finite, negative (unless `signed`) or 0 (where `above_zero`).

    Raises
    ------
    ArgumentError
        Names the field, its value and the limit.
    """
    for item in fields(value):
        numbers = getattr(value, item.name)
        each = _flat(numbers)
        if isinstance(numbers, bool) or not each or not all(isinstance(number, int | float) for number in each):
            continue
        kind = type(value).__name__
        if not all(map(isfinite, each)):
            raise ArgumentError(f"{kind}.{item.name} must be finite, found {numbers!r}")
        if item.name in above_zero and min(each) <= 0.0:
            raise ArgumentError(f"{kind}.{item.name} must be above 0, found {numbers!r}")
        if item.name not in signed and min(each) < 0.0:
            raise ArgumentError(f"{kind}.{item.name} must be 0 or more, found {numbers!r}")


def _flat(numbers: Any) -> list[Any]:
    """Return a number, or what stands in a tuple of tuples, in one list."""
    return [one for part in numbers for one in _flat(part)] if isinstance(numbers, tuple) else [numbers]


def _require_cells(part: LegBody | Rod) -> None:
    """Refuse a part that is not cut into two cells or more."""
    if not isinstance(part.cells, int) or part.cells < 2:
        raise ArgumentError(f"{type(part).__name__}.cells must be a whole number from 2 on, found {part.cells!r}")


def ring_area(outer: float, inner: float) -> float:
    """Return the cross-section of a tube [m2]."""
    return 0.25 * pi * (outer * outer - inner * inner)


@dataclass(frozen=True)
class LegBody:
    """The fixed body: an Invar tube with a steel spindle inside, the motor at its foot, the reading head near its top.

    Attributes
    ----------
    length : float [m]
        From the lower joint's end to the body's top. Engineering value: the rod shows 40 mm when it is retracted.
    outer_diameter, inner_diameter : float [m]
        Engineering value: 70/54 mm.
    density, heat_capacity, conductivity : float [kg/m3], [J/kg/K], [W/m/K]
        Invar 36. Source: CarTech data sheet.
    expansion : float [1/K]
        Invar, 1.2e-6 to 2.0e-6 (source: Robert et al.); derived within that range so that A comes out as published.
    spindle_diameter, spindle_conductivity, spindle_capacity : float [m], [W/m/K], [J/m3/K]
        Spindle and bearings, at the body's temperature: they carry heat along the leg. Engineering value: steel.
    convection : float [W/m2/K]
        To the room, radiation of bright metal included. Source: 3 to 6 for natural convection;
        the lower half for bright metal.
    head_position : float [m]
        Reading head's foot, from the lower joint's centre. Engineering value.
    head_bracket, head_bracket_expansion : float [m], [1/K]
        Bracket between that foot and the reading head's mark, along the leg. Engineering value: steel.
    motor_capacity, motor_conductance, motor_convection : float [J/K], [W/K], [W/K]
        Motor as one lump, to the body's foot and to the room. Engineering value: 1.2 kg, flanged.
    cells : int
        Finite volumes along the body.
    """

    length: float = 0.530
    outer_diameter: float = 0.070
    inner_diameter: float = 0.054
    density: float = 8050.0
    heat_capacity: float = 515.0
    conductivity: float = 10.0
    expansion: float = 2.00e-6
    spindle_diameter: float = 0.030
    spindle_conductivity: float = 45.0
    spindle_capacity: float = 3.69e6
    convection: float = 4.0
    head_position: float = 0.530
    head_bracket: float = 0.010
    head_bracket_expansion: float = 11.5e-6
    motor_capacity: float = 550.0
    motor_conductance: float = 2.0
    motor_convection: float = 0.25
    cells: int = 27

    def __post_init__(self) -> None:
        positive = ("length", "outer_diameter", "density", "heat_capacity", "conductivity", "cells", "motor_capacity",
                    "motor_conductance")  # fmt: skip
        require_finite(self, above_zero=positive, signed=("expansion", "head_bracket_expansion", "head_bracket"))
        _require_cells(self)
        if not self.spindle_diameter < self.inner_diameter < self.outer_diameter:
            raise ArgumentError(
                f"LegBody needs spindle_diameter < inner_diameter < outer_diameter, found {self.spindle_diameter:g}, "
                f"{self.inner_diameter:g} and {self.outer_diameter:g} m"
            )

    @property
    def section_conductance(self) -> float:
        """Conductivity times cross-section of tube and spindle [W m/K]."""
        spindle = ring_area(self.spindle_diameter, 0.0) * self.spindle_conductivity
        return ring_area(self.outer_diameter, self.inner_diameter) * self.conductivity + spindle

    @property
    def capacity(self) -> float:
        """Heat capacity of tube and spindle per length [J/m/K]."""
        spindle = ring_area(self.spindle_diameter, 0.0) * self.spindle_capacity
        return ring_area(self.outer_diameter, self.inner_diameter) * self.density * self.heat_capacity + spindle


@dataclass(frozen=True)
class Rod:
    """The sliding rod with its scale; it reaches from inside the body to the upper joint.

    Attributes
    ----------
    length : float [m]
        Engineering value: it stays in the nut over the whole stroke.
    outer_diameter, inner_diameter : float [m]
        Engineering value: 40/26 mm.
    density, heat_capacity, conductivity : float [kg/m3], [J/kg/K], [W/m/K]
        Invar 36. Source: CarTech data sheet.
    expansion : float [1/K]
        Of the rod's own material. Source: Invar, 1.2e-6 to 2.0e-6.
    scale_expansion : float [1/K]
        Of the scale as it is held on the rod: an Invar tape. Derived: B comes out as published; source: Invar is
        specified as 1.2e-6 to 2.7e-6 (ASTM F1684).
    scale_held : float [m]
        From the rod's upper end to where the scale is held; the rest of the scale slides. Engineering value.
    convection : float [W/m2/K]
        Of what is outside the body. Source: as the body's.
    cells : int
        Finite volumes along the rod.
    """

    length: float = 0.530
    outer_diameter: float = 0.040
    inner_diameter: float = 0.026
    density: float = 8050.0
    heat_capacity: float = 515.0
    conductivity: float = 10.0
    expansion: float = 1.90e-6
    scale_expansion: float = 1.85e-6
    scale_held: float = 0.020
    convection: float = 4.0
    cells: int = 27

    def __post_init__(self) -> None:
        positive = ("length", "outer_diameter", "density", "heat_capacity", "conductivity", "cells")
        require_finite(self, above_zero=positive, signed=("expansion", "scale_expansion"))
        _require_cells(self)
        if not self.inner_diameter < self.outer_diameter:
            raise ArgumentError(
                f"Rod needs inner_diameter < outer_diameter, found {self.inner_diameter:g}, {self.outer_diameter:g} m"
            )

    @property
    def section_conductance(self) -> float:
        """Conductivity times cross-section [W m/K]."""
        return ring_area(self.outer_diameter, self.inner_diameter) * self.conductivity

    @property
    def capacity(self) -> float:
        """Heat capacity per length [J/m/K]."""
        return ring_area(self.outer_diameter, self.inner_diameter) * self.density * self.heat_capacity


@dataclass(frozen=True)
class Contact:
    """How heat passes between body and rod where they overlap, per area of the rod's surface.

    Attributes
    ----------
    gap_conductance : float [W/m2/K]
        Air gap of some 4 mm, and radiation. Derived: 0.026 W/m/K over the gap, plus 4.
    nut_position, nut_length, nut_conductance : float [m], [m], [W/m2/K]
        Centre of the nut from the lower joint's centre, its length and its contact. Engineering value; contact
        conductance cannot be computed (source: 500 to 5000 is usual).
    guide_position, guide_length, guide_conductance : float [m], [m], [W/m2/K]
        The bush that guides the rod at the body's top, likewise.
    """

    gap_conductance: float = 10.0
    nut_position: float = 0.330
    nut_length: float = 0.040
    nut_conductance: float = 800.0
    guide_position: float = 0.520
    guide_length: float = 0.040
    guide_conductance: float = 800.0

    def __post_init__(self) -> None:
        require_finite(self)


@dataclass(frozen=True)
class EndJoints:
    """The two joints and the platform pieces beyond them.

    Attributes
    ----------
    length : float [m]
        From each joint's centre to the end of body or rod. Engineering value.
    expansion : float [1/K]
        Of that length. Engineering value: steel.
    capacity, leg_conductance, piece_conductance : float [J/K], [W/K], [W/K]
        Of each joint, to the leg and to its piece. Engineering value: 0.4 kg of steel, two narrow contacts.
    piece_capacity, piece_convection : float [J/K], [W/K]
        Each platform piece as one lump, and to the room. Engineering value: 5 kg.
    """

    length: float = 0.015
    expansion: float = 11.5e-6
    capacity: float = 190.0
    leg_conductance: float = 0.3
    piece_conductance: float = 0.3
    piece_capacity: float = 2400.0
    piece_convection: float = 0.8

    def __post_init__(self) -> None:
        positive = ("length", "capacity", "leg_conductance", "piece_conductance", "piece_capacity")
        require_finite(self, above_zero=positive, signed=("expansion",))


@dataclass(frozen=True)
class Drive:
    """Motor and screw: what moves the rod, and how much heat that makes.

    Attributes
    ----------
    speed : float [m/s]
        Of the rod. Engineering value.
    holding_power : float [W]
        Lost in the motor all the time: it holds the rod. Source: 1 to 10 W, servo or stepper.
    moving_power : float [W]
        Lost in the motor besides, while it turns. Derived: the published drift asks for some 5 K at T07; on this leg
        that takes some 6 W in the mean of a working run, motor and screw together.
    screw_torque, screw_lead : float [N m], [m]
        Friction of the preloaded screw; its heat is ``2 pi torque / lead`` for each metre. Source of the form: power is
        torque times angular speed. Derived with `moving_power`; a stiffly preloaded roller screw of fine lead.
    rod_share : float [1]
        Part of the friction heat that enters the rod at the nut; the rest enters the body there. Engineering value.
    """

    speed: float = 0.002
    holding_power: float = 1.0
    moving_power: float = 13.0
    screw_torque: float = 1.07
    screw_lead: float = 0.001
    rod_share: float = 0.35

    def __post_init__(self) -> None:
        require_finite(self, above_zero=("speed", "screw_lead"))
        if self.rod_share > 1.0:
            raise ArgumentError(f"Drive.rod_share is a part, 0 to 1, found {self.rod_share!r}")

    @property
    def friction_force(self) -> float:
        """Friction heat at the nut per way of the rod [J/m]."""
        return 2.0 * pi * self.screw_torque / self.screw_lead

    @property
    def motor_force(self) -> float:
        """Heat of the motor per way of the rod, besides what holding takes [J/m]."""
        return self.moving_power / self.speed
