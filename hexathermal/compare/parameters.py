"""Numbers of the virtual bench that a campaign may contradict: what each is, and which experiment tells it apart."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import exp, sqrt
from typing import Any

from hexathermal.errors import UnknownNameError
from hexathermal.learn.coverage import TWO_SIDED
from hexathermal.simulate.bench.leg import VirtualLeg

MATERIAL, SURFACE, JOINT = 0.03, 0.04, 0.06
"""Standard deviation of the logarithm of a number that is as it should be: its own tolerance.

Materials, dimensions and heat are known to 3 %, convection to 4 %; contacts cannot be computed (the bench's own sources
say so), and what cells of some 20 mm make of a contact differs by some per cent: 6 %.
"""

FREE = 0.5
"""The same of a number that is not: factors from 0.4 to 2.7 lie within two of it."""


CELLS, CELLS_JOINT, CELLS_CONTACT = 0.015, 0.05, 0.01
"""What another cutting into cells makes of a factor's logarithm, of that of a contact between parts, and of a
thermocouple's part of the air: standard deviations, measured on benches cut otherwise. They are in the intervals.
"""


@dataclass(frozen=True)
class Parameter:
    """One physical number (or several that change together), as a factor on the bench's own.

    Attributes
    ----------
    name : str
    family : str
        Of the physics: ``"heat"``, ``"convection"``, ``"contact"``, ``"conduction"``, ``"storage"``, ``"expansion"``.
    words : str
        What it is.
    fields : tuple of (str, str)
        Part of the leg and its field, see `hexathermal.simulate.bench.parts`.
    tolerance : float
        Standard deviation of its logarithm where it is as it should be.
    more, less : str
        What a larger and a smaller value may stand for.
    experiment : str
        What shows it apart from others.
    """

    name: str
    family: str
    words: str
    fields: tuple[tuple[str, str], ...]
    tolerance: float
    more: str
    less: str
    experiment: str


_CONVECTION = (("body", "convection"), ("rod", "convection"), ("body", "motor_convection"),
               ("joints", "piece_convection"))  # fmt: skip

PARAMETERS: tuple[Parameter, ...] = (
    Parameter("motor-heat", "heat", "heat of the motor for each metre of way", (("drive", "moving_power"),),
              MATERIAL,
              "more current, a brake that drags", "less load", "hold still under power, then move without load"),
    Parameter("friction-heat", "heat", "friction heat of the screw in the nut", (("drive", "screw_torque"),),
              MATERIAL, "more preload, little grease", "lost preload", "move slowly and fast over the same way"),
    Parameter("convection", "convection", "heat given to the room by all surfaces", _CONVECTION,
              SURFACE,
              "a fan, a draught", "a cover, a housing", "let the warm leg cool at rest, with a fan and without"),
    Parameter("convection-body", "convection", "heat given to the room by the body", _CONVECTION[:1],
              SURFACE,
              "a fan on the body", "a cover on the body", "let the warm leg cool at rest with the body wrapped"),
    Parameter("convection-rod", "convection", "heat given to the room by what shows of the rod", _CONVECTION[1:2],
              SURFACE,
              "a fan on the rod", "a bellows about the rod", "let the warm leg cool with the rod out, then in"),
    Parameter("convection-motor", "convection", "heat given to the room by the motor", _CONVECTION[2:3],
              SURFACE, "a fan on the motor", "a cover on the motor", "a thermometer on the motor while it cools"),
    Parameter("convection-platforms", "convection", "heat given to the room by the platform pieces", _CONVECTION[3:],
              JOINT, "a fan on a platform", "a cover on a platform", "a thermometer on each platform piece"),
    Parameter("contact-gap", "contact", "heat across the gap between rod and body", (("contact", "gap_conductance"),),
              SURFACE, "a narrower gap, oil in it", "a wider gap", "cool at rest with the rod in, then out"),
    Parameter("contact-bushes", "contact", "heat across nut and guide",
              (("contact", "nut_conductance"), ("contact", "guide_conductance")),
              JOINT,
              "more preload, more grease", "worn bushes, little grease", "thermometers on both sides of nut and guide"),
    Parameter("conduction-body", "conduction", "heat along body and spindle",
              (("body", "conductivity"), ("body", "spindle_conductivity")),
              MATERIAL,
              "another alloy, thicker walls", "another alloy, thinner walls", "heat the foot only, the rod at rest"),
    Parameter("conduction-rod", "conduction", "heat along the rod", (("rod", "conductivity"),),
              MATERIAL,
              "another alloy, thicker walls", "another alloy, thinner walls", "heat the rod's end only, rod out"),
    Parameter("conduction-motor", "conduction", "heat from the motor into the body", (("body", "motor_conductance"),),
              JOINT, "a better flange", "an insulating flange", "a thermometer on the motor"),
    Parameter("conduction-joints", "conduction", "heat through the joints into the platforms",
              (("joints", "leg_conductance"), ("joints", "piece_conductance")),
              JOINT, "stiffer joints", "looser joints", "a thermometer on each platform piece"),
    Parameter("heat-capacity", "storage", "heat stored by body and rod",
              (("body", "heat_capacity"), ("body", "spindle_capacity"), ("rod", "heat_capacity")),
              MATERIAL, "heavier parts", "lighter parts", "a known heat from a heating foil, the rod at rest"),
    Parameter("expansion-body", "expansion", "expansion of the body", (("body", "expansion"),),
              MATERIAL, "another alloy", "another alloy", "warm the whole room, the rod at rest and in"),
    Parameter("expansion-rod", "expansion", "expansion of the rod above the scale's hold", (("rod", "expansion"),),
              MATERIAL, "another alloy", "another alloy", "warm the rod's upper end alone"),
    Parameter("expansion-scale", "expansion", "expansion of the scale on the rod", (("rod", "scale_expansion"),),
              MATERIAL,
              "another scale, held otherwise", "another scale, held otherwise", "warm the whole room, rod in and out"),
    Parameter("expansion-joints", "expansion", "expansion of the joints", (("joints", "expansion"),),
              MATERIAL, "another alloy", "another alloy", "warm a joint alone"),
    Parameter("expansion-bracket", "expansion", "expansion of the reading head's bracket",
              (("body", "head_bracket_expansion"),),
              MATERIAL, "another alloy", "another alloy", "warm the reading head alone"),
)  # fmt: skip
"""All that is looked for besides sensors that read the air."""

NAMES = tuple(one.name for one in PARAMETERS)
TOLERANCES = tuple(one.tolerance for one in PARAMETERS)

SENSOR_EXPERIMENT = "blow at this thermometer, the leg at rest; tape it anew"


def parameter_named(name: str) -> Parameter:
    """Return a parameter by its name.

    Raises
    ------
    UnknownNameError
        There is none.
    """
    found = {one.name: one for one in PARAMETERS}
    if name not in found:
        raise UnknownNameError(f"unknown parameter {name!r}; known: {', '.join(NAMES)}", NAMES)
    return found[name]


def scaled_leg(leg: VirtualLeg, logs: Mapping[str, float]) -> VirtualLeg:
    """Return a leg whose numbers are larger by factors, given as their natural logarithms.

    Parameters
    ----------
    leg : VirtualLeg
    logs : mapping of a parameter's name to float

    Examples
    --------
    >>> from math import log
    >>> scaled_leg(VirtualLeg(), {"motor-heat": log(2.0)}).drive.moving_power
    26.0
    """
    changed: dict[str, dict[str, Any]] = {}
    for name, value in logs.items():
        for part, field in parameter_named(name).fields if value else ():
            fields = changed.setdefault(part, {})
            fields[field] = fields.get(field, getattr(getattr(leg, part), field)) * exp(value)
    parts = {part: replace(getattr(leg, part), **fields) for part, fields in changed.items()}
    return replace(leg, **parts) if parts else leg


def half_interval(place: int, variance: float) -> float:
    """Return half a 95 % interval of a candidate: a factor's logarithm, or a part of the air."""
    cells = CELLS_CONTACT
    if place < len(NAMES):
        cells = CELLS_JOINT if TOLERANCES[place] >= JOINT else CELLS
    return TWO_SIDED * sqrt(variance + cells**2)
