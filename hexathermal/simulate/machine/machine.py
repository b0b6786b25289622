"""The virtual hexapod: six virtual legs, two plates, a room, thermometers, and a 6-D positioning system."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.kinematics.formulas import leg_drift
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.thermometers import AS_RECORDED
from hexathermal.poses import FloatArray
from hexathermal.simulate.bench.room import Room
from hexathermal.simulate.bench.thermocouples import Thermocouples
from hexathermal.simulate.machine.heat import MachineHeat, MachineHistory
from hexathermal.simulate.machine.parts import MachineScenario, PositioningSystem

GROWTHS = ("heat", "law")


@dataclass(frozen=True)
class VirtualMachine:
    """All that the virtual hexapod is made of.

    Attributes
    ----------
    hexapod : Hexapod
        The machine as its maker knows it: nominal joints, and the law that its controller has, if any. Its base frame
        stands where the base is held, see `as_built`.
    heat : MachineHeat
        Legs and plates as they truly are.
    sensors : tuple of (str, float)
        Thermometers of each leg: name, and place on the body as a part of the retracted length.
    room, tracker, scenario
        See their classes.
    thermocouples : Thermocouples
        Their errors; their places on the bench do not count here.
    landing : float [m]
        Standard deviation by which a leg's end misses its scale at each landing. Engineering value.
    growth : str
        ``"heat"``: legs and plates grow as heat flows in them, which no law follows exactly; ``"law"``: exactly as the
        laws of `hexapod` say, from the true temperatures under its thermometers.
    """

    hexapod: Hexapod
    heat: MachineHeat
    sensors: tuple[tuple[str, float], ...] = (("T1", 0.44),)
    room: Room = field(default_factory=Room)
    tracker: PositioningSystem = field(default_factory=PositioningSystem)
    scenario: MachineScenario = field(default_factory=MachineScenario)
    thermocouples: Thermocouples = field(default_factory=Thermocouples)
    landing: float = 5e-8
    growth: str = "heat"

    def __post_init__(self) -> None:
        if self.hexapod.stroke is None or self.hexapod.retracted_length is None:
            raise ArgumentError(
                f"machine {self.hexapod.name!r} has no q0 or no stroke; a virtual leg needs both: give q0_mm, stroke_mm"
            )
        if not self.sensors or len({name for name, _place in self.sensors}) != len(self.sensors):
            raise ArgumentError(f"a leg needs thermometers with names of their own, found {self.sensors!r}")
        if not (np.isfinite(self.landing) and self.landing >= 0.0):
            raise ArgumentError(f"VirtualMachine.landing must be 0 or more, found {self.landing!r}")
        if self.growth not in GROWTHS:
            raise ArgumentError(f"growth is {self.growth!r}, expected {' or '.join(map(repr, GROWTHS))}")
        if self.growth == "law" and not self.law_told:
            raise ArgumentError(
                f"machine {self.hexapod.name!r} has no law of the thermometers "
                f"{', '.join(name for name, _place in self.sensors)} that its legs could follow: let them grow as heat "
                "flows, or give a machine with such a law"
            )

    @property
    def lowest(self) -> FloatArray:
        """Displacement of each leg at the lower end of its stroke, shape (6,) [m]."""
        stroke = self.hexapod.stroke
        assert stroke is not None  # checked when it was made
        return stroke[:, 0]

    @property
    def retracted(self) -> FloatArray:
        """Inter-articular length of each leg at q = 0, shape (6,) [m]."""
        length = self.hexapod.retracted_length
        assert length is not None  # checked when it was made
        return length

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of all thermometers: those of the legs, leg by leg, the platform's and the base's."""
        legs = tuple(f"leg{leg}_{name}" for leg in range(1, 7) for name, _place in self.sensors)
        return (*legs, "platform_T1", "base_T1")

    @property
    def law_told(self) -> bool:
        """Whether the machine has a law for the thermometers that are on its legs."""
        model, names = self.hexapod.thermal, tuple(name for name, _place in self.sensors)
        return model is not None and all(law.sensors == names for law in model.legs)

    @property
    def recorded_columns(self) -> tuple[str, ...]:
        """Names under which `columns` are recorded: plugs of legs may be exchanged."""
        model = self.hexapod.thermal if self.law_told else None
        told = AS_RECORDED if model is None else model.thermometers_of_leg
        legs = tuple(f"leg{leg}_{name}" for leg in told for name, _place in self.sensors)
        return (*legs, "platform_T1", "base_T1")

    def reference(self) -> FloatArray:
        """Return the temperatures at which geometry and scales are true: at rest at home, mean room, shape (m,)."""
        home = self.hexapod.strokes(self.hexapod.home_lengths) - self.lowest
        return self.heat.at_rest(self.room.temperature, home)

    def surfaces(self, history: MachineHistory) -> FloatArray:
        """Return the true temperatures under the thermometers, shape (n, c) [degC], in the order of `columns`."""
        found = [
            history.surface(leg, "body", place * self.heat.legs[leg].retracted_length)
            for leg in range(6)
            for _name, place in self.sensors
        ]
        return np.column_stack([*found, history.platform, history.base])

    def told_growth(self, rise: FloatArray, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return by how much the machine's laws let legs and plates grow.

        Parameters
        ----------
        rise : array, shape (n, c) [K]
            Of the temperatures under the thermometers, in the order of `columns`.
        q : array, shape (n, 6) [m]

        Returns
        -------
        growth : array, shape (n, 6) [m]
        expansions : array, shape (n, 2)
            Of platform and base.
        """
        model = self.hexapod.thermal
        assert model is not None  # checked when it was made
        of_leg = rise[:, :-2].reshape(len(rise), 6, -1)
        a, b = (np.stack([of_leg[:, i] @ part[i] for i in range(6)], axis=1)
                for part in ([law.A for law in model.legs], [law.B for law in model.legs]))  # fmt: skip
        plates = [0.0 if plate is None else plate.expansion for plate in (model.platform, model.base)]
        return np.asarray(leg_drift(a, b, self.retracted, q)), rise[:, -2:] * plates
