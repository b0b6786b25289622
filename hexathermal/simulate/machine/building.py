"""From a machine as its maker knows it to a virtual one: legs in its size, plates, and how each differs a little."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.machine.hexapod import Hexapod
from hexathermal.simulate.bench.leg import VirtualLeg
from hexathermal.simulate.bench.thermocouples import Thermocouples
from hexathermal.simulate.machine.heat import MachineHeat
from hexathermal.simulate.machine.machine import VirtualMachine
from hexathermal.simulate.machine.parts import Plate, PositioningSystem

STEEL_CAPACITY = 470.0
PLATE_MASS_PER_AREA = 90.0
"""Of a ribbed steel plate [kg/m2], where the machine does not state its mass. Engineering value."""

PLATE_CONVECTION = 4.0
"""Of both faces of a plate [W/m2/K]: as the legs'. Engineering value."""


SPREAD = 0.05

NOISY_ALONE = Thermocouples(bias=0.0, cold_junction=0.0, gain=0.0, contact_error=(0.0, 0.0))
"""Thermometers whose differences of temperature are true but for noise."""

CELLS = 16
"""Of a leg's body, and of its rod: 27 change a growth of some 10 um by up to 0.1 um, and A by 0.5 % (tested)."""


def scaled_leg(retracted: float, span: float, cells: int = CELLS) -> VirtualLeg:
    """Return the virtual leg in the size of a machine's: all lengths along the axis scale with its shortest length.

    Parameters
    ----------
    retracted : float [m]
        Inter-articular length at the lower end of the stroke.
    span : float [m]
        Length of the stroke.
    cells : int
        Of the body, and of the rod.
    """
    made = VirtualLeg()
    s = retracted / made.retracted_length
    try:
        return VirtualLeg(
            retracted, (0.0, span),
            replace(made.body, length=made.body.length * s, head_position=made.body.head_position * s, cells=cells),
            replace(made.rod, length=made.rod.length * s, scale_held=made.rod.scale_held * s, cells=cells),
            replace(made.contact, nut_position=made.contact.nut_position * s, nut_length=made.contact.nut_length * s,
                    guide_position=made.contact.guide_position * s, guide_length=made.contact.guide_length * s),
            replace(made.joints, length=made.joints.length * s),
            made.drive,
        )  # fmt: skip
    except ArgumentError as error:
        share = (made.stroke[1] - made.stroke[0]) / made.retracted_length
        raise ArgumentError(
            f"no virtual leg of {retracted * 1e3:g} mm has a stroke of {span * 1e3:g} mm, at most {100 * share:.1f} % "
            f"of its shortest length: {error}"
        ) from None


def as_built(hexapod: Hexapod) -> Hexapod:
    """Return the machine with its base frame at the centre of its base joints, and thermometers on its plates.

    A plate with a thermometer expands about its frame's origin; the base is held at its centre. Poses count from home,
    so nothing that is commanded or measured changes. Terms of its legs' laws are left out: a virtual leg grows as heat
    flows, and does nothing else.
    """
    centre = np.round(hexapod.base_joints.mean(axis=0), 9)
    home = hexapod.home.copy()
    home[:3, 3] = np.round(home[:3, 3] - centre, 12)
    moved = replace(hexapod, base_joints=np.round(hexapod.base_joints - centre, 12), home=home)
    model = hexapod.thermal
    if model is None:
        return moved
    plates = {
        part: replace(plate, sensor="T1")
        for part, plate in (("platform", model.platform), ("base", model.base))
        if plate is not None
    }
    laws = tuple(replace(law, terms=()) for law in model.legs)
    legs = laws[0] if all(law == laws[0] for law in laws) else laws
    mean = float(np.mean(model.reference_temperature_degC))
    return replace(moved, thermal=replace(model, legs=legs, reference_temperature_degC=mean, **plates))  # type: ignore[arg-type]


def virtual_machine(
    hexapod: Hexapod,
    seed: int = 1,
    *,
    spread: float | None = None,
    sensors: tuple[tuple[str, float], ...] | None = None,
    tracker: PositioningSystem | None = None,
    cells: int = CELLS,
    growth: str = "heat",
) -> VirtualMachine:
    """Return a virtual machine whose legs and plates differ a little from each other and from what its maker says.

    Or one that is what its maker says: with ``growth="law"``.

    Parameters
    ----------
    hexapod : Hexapod
    seed : int
    spread : float, optional
        Relative standard deviation of the expansions of bodies, scales and plates from part to part, by default 0.05;
        motors, friction and convection spread by 10 % whatever it is. 0: all legs follow one law.
    sensors : tuple of (str, float), optional
        See `VirtualMachine`; default: those of the machine's law, else ``T1``.
    tracker : PositioningSystem, optional
    cells : int
        Of each leg's body and rod.
    growth : str
        ``"heat"``, or ``"law"``: legs and plates are warm as heat flows, and grow exactly as the machine's laws say
        (`VirtualMachine`); its thermometers then err by noise and a constant alone.

    Examples
    --------
    >>> import hexathermal as ht
    >>> machine = virtual_machine(ht.load_hexapod("reference"), seed=3)
    >>> machine.columns[:2], machine.columns[-1]
    (('leg1_T1', 'leg2_T1'), 'base_T1')
    """
    spread = _checked_spread(spread, growth)
    if hexapod.stroke is None or hexapod.retracted_length is None:
        raise ArgumentError(
            f"machine {hexapod.name!r} has no q0 or no stroke; a virtual leg needs both: give q0_mm and stroke_mm"
        )
    generator = np.random.default_rng([seed, 10])

    def drawn(width: float) -> float:
        """Return a factor about 1."""
        return float(max(0.1, 1.0 + width * generator.standard_normal()))

    legs = [_built_leg(scaled_leg(float(q0 + low), float(high - low), cells), spread, drawn)
            for q0, (low, high) in zip(hexapod.retracted_length, hexapod.stroke, strict=True)]  # fmt: skip
    built = as_built(hexapod)
    platform, base = (_plate(built, part, drawn(spread)) for part in ("platform", "base"))
    if sensors is None:
        sensors = placed(built.thermal.legs[0].sensors) if built.thermal is not None else (("T1", 0.44),)
    made = VirtualMachine(
        built, MachineHeat(tuple(legs), platform, base), sensors, tracker=tracker or PositioningSystem(), growth=growth
    )
    return replace(made, thermocouples=NOISY_ALONE, landing=0.0) if growth == "law" else made


def _checked_spread(spread: float | None, growth: str) -> float:
    """Return the spread of the legs, by default what suits the growth."""
    if spread is None:
        return 0.0 if growth == "law" else SPREAD
    if growth == "law" and spread:
        raise ArgumentError(
            f"legs that follow the machine's law exactly have no spread, found {spread!r}: leave it out"
        )
    if not 0.0 <= spread <= 0.3:
        raise ArgumentError(f"spread is a relative standard deviation from 0 to 0.3, found {spread!r}")
    return spread


def _built_leg(leg: VirtualLeg, spread: float, drawn: Callable[[float], float]) -> VirtualLeg:
    """Return a leg that differs from its drawing: `drawn` gives a factor about 1 of a width."""
    body, rod, drive = leg.body, leg.rod, leg.drive
    return replace(
        leg,
        body=replace(body, expansion=body.expansion * drawn(spread), convection=body.convection * drawn(0.1)),
        rod=replace(rod, scale_expansion=rod.scale_expansion * drawn(spread)),
        drive=replace(drive, screw_torque=drive.screw_torque * drawn(0.1),
                      moving_power=drive.moving_power * drawn(0.1)),
    )  # fmt: skip


def placed(names: tuple[str, ...]) -> tuple[tuple[str, float], ...]:
    """Return thermometers with their places: the bench's where a name is one of its, else spread over the body.

    Examples
    --------
    >>> placed(("T1",)), placed(("T07",))
    ((('T1', 0.44),), (('T07', 0.44),))
    """
    bench = {name: place / VirtualLeg().retracted_length for name, part, place in Thermocouples().places
             if part == "body"}  # fmt: skip
    even = (0.44,) if len(names) == 1 else tuple(np.linspace(0.15, 0.85, len(names)).tolist())
    return tuple((name, round(bench.get(name, place), 4)) for name, place in zip(names, even, strict=True))


def _plate(hexapod: Hexapod, part: str, factor: float) -> Plate:
    """Return a plate in the size of the machine's."""
    joints = hexapod.platform_joints if part == "platform" else hexapod.base_joints
    area = np.pi * float(((joints - joints.mean(axis=0)) ** 2).sum(axis=1).mean())
    mass = PLATE_MASS_PER_AREA * area
    if part == "platform" and hexapod.bodies is not None and hexapod.bodies.platform_mass > 0.0:
        mass = hexapod.bodies.platform_mass
    law = None if hexapod.thermal is None else getattr(hexapod.thermal, part)
    expansion = (Plate(1.0, 0.0).expansion if law is None else law.expansion) * factor
    return Plate(mass * STEEL_CAPACITY, 2.0 * area * PLATE_CONVECTION, expansion)
