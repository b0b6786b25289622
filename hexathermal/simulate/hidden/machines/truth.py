"""What truly happens in a campaign of a whole hexapod, before it is written. SI units, temperatures in degC."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray

Rows = npt.NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Load:
    """A weight on the platform, and how far legs give way.

    Attributes
    ----------
    compliance : array, shape (6,) [m/N]
    weight : array, shape (3,) [N]
        In the base frame.
    centre : array, shape (3,) [m]
        In the platform frame.
    """

    compliance: FloatArray
    weight: FloatArray
    centre: FloatArray


@dataclass(frozen=True, eq=False)
class MachineRunTruth:
    """What truly happens in one run of n measured poses.

    Attributes
    ----------
    name, role : str
    time : array, shape (n,) [s]
        Since the campaign began.
    commanded : array, shape (n, 6) [m, rad]
        Coordinates from home.
    q : array, shape (n, 6) [m]
        Displacements that the scales read.
    legs : array, shape (n, 6, s) [degC]
        Of the places where the thermometers sit, without any error of a thermometer.
    plates : array, shape (n, 2) [degC]
        Of platform and base.
    air : array, shape (n,) [degC]
    leg_errors, plate_errors, air_errors : array, shapes of the above [K]
        Of the thermometers.
    frame : array, shape (n, 6) [m, rad]
        By which the measuring frame stands off, a motion about home: in each run, and slowly within it.
    noise : array, shape (n, 6) [m, rad]
        Of the six measured coordinates.
    stretch : array, shape (n, 6) [m]
        What hidden effects add to the legs' lengths.
    platform_bend : array, shape (n, 6, 3) [m]
        By which hidden effects move the platform's joints in the platform.
    moved : array, shape (n, 6) [m, rad]
        By which hidden effects move what is measured, about home.
    """

    name: str
    role: str
    time: FloatArray
    commanded: FloatArray
    q: FloatArray
    legs: FloatArray
    plates: FloatArray
    air: FloatArray
    leg_errors: FloatArray
    plate_errors: FloatArray
    air_errors: FloatArray
    frame: FloatArray
    noise: FloatArray
    stretch: FloatArray
    platform_bend: FloatArray
    moved: FloatArray

    def changed(self, **fields: object) -> MachineRunTruth:
        """Return the run with some fields changed."""
        return replace(self, **fields)  # type: ignore[arg-type]


@dataclass(frozen=True, eq=False)
class MachineTruth:
    """What truly happens in a campaign of a hexapod.

    Attributes
    ----------
    hexapod : Hexapod
        The machine as filed; where nothing is hidden it is the truth.
    hall : str
        Name of what made it warm.
    runs : tuple of MachineRunTruth
        One behind the other, by time.
    zero : str
        What temperatures count from: ``"run"`` or ``"campaign"``.
    levels : array, shape (6,) [m, m, m, rad, rad, rad]
        Standard deviations of the white noise of the six coordinates.
    plates_recorded : (bool, bool)
        Of platform and base.
    air_recorded : bool
    A, B : array, shape (6, s) [1/K]
        Of the true legs.
    expansions : array, shape (2,) [1/K]
        Of the true platform and base, about the origins of their frames.
    base_joints, platform_joints : array, shape (6, 3) [m]
        Where the true joints are.
    read_from : tuple of six int
        Leg i's columns hold what the thermometers of leg ``read_from[i]`` read, counted from 0.
    load : Load or None
    notes : mapping
        Whatever a test may want to know.
    """

    hexapod: Hexapod
    hall: str
    runs: tuple[MachineRunTruth, ...]
    zero: str
    levels: FloatArray
    plates_recorded: tuple[bool, bool]
    air_recorded: bool
    A: FloatArray
    B: FloatArray
    expansions: FloatArray
    base_joints: FloatArray
    platform_joints: FloatArray
    read_from: tuple[int, ...] = (0, 1, 2, 3, 4, 5)
    load: Load | None = None
    notes: Mapping[str, object] = field(default_factory=dict)

    def changed(self, **fields: object) -> MachineTruth:
        """Return the campaign with some fields changed."""
        return replace(self, **fields)  # type: ignore[arg-type]

    @property
    def sensors(self) -> tuple[str, ...]:
        """Names of the thermometers of each leg."""
        assert self.hexapod.thermal is not None  # machines are drawn with their law
        return self.hexapod.thermal.legs[0].sensors

    @property
    def retracted(self) -> FloatArray:
        """Lengths of the legs at q = 0, shape (6,) [m]."""
        assert self.hexapod.retracted_length is not None  # checked where machines are drawn
        return self.hexapod.retracted_length

    def rows(self, role: str) -> Rows:
        """Return which of all rows, run behind run, belong to runs of a role."""
        return np.concatenate([np.full(run.time.size, run.role == role) for run in self.runs])

    def all(self, name: str) -> FloatArray:
        """Return a field of all runs, one behind the other."""
        return np.concatenate([getattr(run, name) for run in self.runs])
