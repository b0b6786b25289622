"""What causes of a machine see: poses, displacements, temperatures, and the machine as its file states it.

A view is made of a campaign's rows, and as well of a plan: poses and temperatures that nobody has measured yet. It
holds no measured residual, so that what these rows could tell apart is known before anything is looked at.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError, ThermalModelError
from hexathermal.kinematics.inverse import inverse_kinematics
from hexathermal.kinematics.jacobian import jacobian
from hexathermal.kinematics.statics import payload_sag
from hexathermal.learn.hexapod_data import PLATES, HexapodRows, heat_of_legs
from hexathermal.learn.hexapod_model import frame_columns
from hexathermal.learn.hexapod_stated import terms_drift
from hexathermal.learn.machine_diagnosis.readings import Readings, flickering
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.leg_signals import LegSignals, Memory
from hexathermal.machine.thermal import ThermalModel, frozen
from hexathermal.poses import FloatArray


@dataclass(frozen=True, eq=False)
class MachineView:
    """Rows of a machine, n of them, in order of time within each run. SI units.

    Attributes
    ----------
    hexapod : Hexapod
        With a thermal law.
    sensors : tuple of str
        Thermometers that every leg has, without ``leg1_``.
    plate_sensors : tuple of (str or None, str or None)
        Platform's and base's.
    poses : array, shape (n, 4, 4) [m]
        At which the legs' directions are taken: measured, or planned.
    q : array, shape (n, 6) [m]
        Displacements of the rods by their scales.
    dT : array, shape (n, 6, s) [K]
        Of the legs' thermometers as they are recorded, from the zero.
    plates : array, shape (n, 2) [K]
        Of platform and base; NaN where not recorded.
    air : array, shape (n,) [K]
        Of the room's air, from the zero; NaN where not recorded.
    run : array, shape (n,), int
    time : array, shape (n,) [s]
        Since the run's first row.
    runs : tuple of str
        Names of the runs.
    """

    hexapod: Hexapod
    sensors: tuple[str, ...]
    plate_sensors: tuple[str | None, str | None]
    poses: FloatArray
    q: FloatArray
    dT: FloatArray
    plates: FloatArray
    air: FloatArray
    run: npt.NDArray[np.int64]
    time: FloatArray
    runs: tuple[str, ...] = field(default=())

    def __len__(self) -> int:
        return len(self.time)

    @property
    def retracted(self) -> FloatArray:
        """Inter-articular lengths at q = 0, shape (6,) [m]."""
        if self.hexapod.retracted_length is None:
            raise ArgumentError(f"machine {self.hexapod.name!r} has no q0_mm in its hexapod.toml: a law needs it")
        return self.hexapod.retracted_length

    @cached_property
    def laws(self) -> FloatArray:
        """A and B of each leg's thermometers, shape (6, 2, s) [1/K]; 0 for one that the law does not read."""
        thermal = self.hexapod.thermal
        assert thermal is not None  # checked where views are made
        found = np.zeros((6, 2, len(self.sensors)))
        for leg, law in enumerate(thermal.legs):
            at = [self.sensors.index(name) for name in law.sensors]
            found[leg, 0, at], found[leg, 1, at] = law.A, law.B
        return found

    @cached_property
    def read(self) -> npt.NDArray[np.bool_]:
        """Which thermometers each leg's law reads, shape (6, s)."""
        return np.asarray(self.laws.any(axis=1))

    @cached_property
    def leg_heat(self) -> FloatArray:
        """Mean of the temperatures that each leg's law reads, of all where it reads none, shape (n, 6) [K]."""
        told = np.where(self.read.any(axis=1, keepdims=True), self.read, True)
        return np.asarray(self.heat.mean(axis=2) if told.all() else (self.heat * told).sum(axis=2) / told.sum(axis=1))

    @cached_property
    def heat(self) -> FloatArray:
        """Temperatures that each leg's law reads, shape (n, 6, s) [K]."""
        return heat_of_legs(self.hexapod, self.dT)

    @cached_property
    def readings(self) -> Readings:
        """What each leg's readings, (n, 6, s), tell of their own noise."""
        return flickering(self.time, self.run, self.heat)

    @cached_property
    def plate_readings(self) -> Readings:
        """The same of the plates' readings, (n, 2); not recorded, they have none."""
        return flickering(self.time, self.run, np.nan_to_num(self.plates))

    @cached_property
    def zeros(self) -> tuple[npt.NDArray[np.bool_], ...]:
        """Rows that may share a zero of their temperatures: each run's where each begins at it, else all and each."""
        runs = [self.run == run for run in np.unique(self.run)]
        begun = [not self.dT[np.flatnonzero(own)[0]].any() for own in runs]
        every = np.ones(len(self), dtype=bool)
        if len(runs) == 1 or (begun[0] and not any(begun[1:])):
            return (every,)
        return tuple(runs) if all(begun) else (every, *runs)

    @cached_property
    def jacobian(self) -> FloatArray:
        """Rates of the leg lengths, shape (n, 6, 6)."""
        return jacobian(self.hexapod, self.poses)

    @cached_property
    def directions(self) -> FloatArray:
        """Unit vectors along the legs, from base to platform, shape (n, 6, 3)."""
        return self.jacobian[..., :3]

    @cached_property
    def frame(self) -> FloatArray:
        """What a motion of the measuring frame about home does to the lengths, shape (n, 6, 6)."""
        return frame_columns(self.hexapod, self.poses)

    @cached_property
    def law_drift(self) -> FloatArray:
        """Drift of the legs and plates by the machine's law, in leg lengths as `y` counts them, shape (n, 6) [m]."""
        thermal = self.hexapod.thermal
        assert thermal is not None  # checked where views are made
        A = np.einsum("nls,ls->nl", self.heat, self.laws[:, 0])
        B = np.einsum("nls,ls->nl", self.heat, self.laws[:, 1])
        drift = A * self.retracted + B * self.q + terms_drift(self)
        for k, plate in enumerate((thermal.platform, thermal.base)):
            if plate is not None and plate.sensor is not None:
                drift = drift + plate.expansion * self.plate_column(PLATES[k])
        return np.asarray(drift + payload_sag(self.hexapod, self.poses))

    def plate_column(self, part: str) -> FloatArray:
        """Return what the expansion of a plate does to the lengths, shape (n, 6) [m K].

        ``-dT (u_i . R p_i)`` for the platform, ``dT (u_i . b_i)`` for the base; zero where it has no thermometer.
        """
        heat = np.nan_to_num(self.plates[:, PLATES.index(part)])[:, None]
        return heat * self.plate_reach(part)

    def plate_reach(self, part: str) -> FloatArray:
        """Return what the growth of a plate by its own size does to the lengths, shape (n, 6) [m]."""
        if part == "base":
            return np.asarray((self.directions * self.hexapod.base_joints).sum(axis=-1))
        turned = np.einsum("nij,kj->nki", self.poses[:, :3, :3], self.hexapod.platform_joints)
        return np.asarray(-(self.directions * turned).sum(axis=-1))

    def late(self, values: FloatArray, time_constant: float) -> FloatArray:
        """Return values (n,) behind a first-order low pass that begins at rest in each run."""
        out = np.empty_like(values)
        for run in np.unique(self.run):
            rows = self.run == run
            out[rows] = Memory().low_pass("late", self.time[rows], values[rows], time_constant)
        return out

    def signals(self, leg: int) -> list[tuple[npt.NDArray[np.int64], LegSignals]]:
        """Return the rows of each run, and what the terms of a leg (0 to 5) see there."""
        found = []
        for run in np.unique(self.run):
            rows = np.flatnonzero(self.run == run)
            dT = {name: self.heat[rows, leg, k] for k, name in enumerate(self.sensors)}
            q0 = float(self.retracted[leg])
            found.append((rows, LegSignals(self.time[rows], dT, self.q[rows, leg], q0, self.air[rows])))
        return found

    def with_hexapod(self, hexapod: Hexapod) -> MachineView:
        """Return the same rows as another machine sees them."""
        return replace(self, hexapod=hexapod)


def machine_view(rows: HexapodRows) -> MachineView:
    """Return the view of a campaign's rows.

    Parameters
    ----------
    rows : HexapodRows
        Of a machine with a thermal law.

    Raises
    ------
    ThermalModelError
        The machine has no law.
    """
    _refuse_lawless(rows.hexapod)
    air = np.full(len(rows), np.nan) if rows.air is None else rows.air
    return MachineView(rows.hexapod, rows.sensors, rows.plate_sensors, rows.measured, rows.q, rows.dT, rows.plates,
                       air, rows.run, rows.time, rows.runs)  # fmt: skip


def planned_view(
    hexapod: Hexapod,
    poses: FloatArray,
    dT: FloatArray,
    *,
    plates: FloatArray | None = None,
    air: FloatArray | None = None,
    run: npt.NDArray[np.int64] | None = None,
    time: FloatArray | None = None,
    sensors: Sequence[str] = (),
    plate_sensors: tuple[str | None, str | None] = ("T1", "T1"),
) -> MachineView:
    """Return the view of rows that nobody has measured yet.

    Parameters
    ----------
    hexapod : Hexapod
        With a thermal law and q0.
    poses : array, shape (n, 4, 4) [m]
        In the order in which they are reached.
    dT : array, shape (n, 6, s) [K]
    plates : array, shape (n, 2) [K], optional
        Without it no plate has a thermometer.
    air : array, shape (n,) [K], optional
        Without it the air is not recorded.
    run : array, shape (n,), int, optional
        Default: all of one run.
    time : array, shape (n,) [s], optional
        Default: a minute a row.
    sensors : sequence of str, optional
        Default: those of the first leg's law.
    plate_sensors : (str or None, str or None)

    Raises
    ------
    ThermalModelError
        The machine has no law.
    """
    thermal = _refuse_lawless(hexapod)
    n = len(poses)
    names = tuple(sensors) or thermal.legs[0].sensors
    run = np.zeros(n, dtype=np.int64) if run is None else run
    heat = np.full((n, 2), np.nan) if plates is None else plates
    known = tuple(None if np.isnan(heat[:, k]).all() else plate_sensors[k] for k in range(2))
    if hexapod.retracted_length is None:
        raise ArgumentError(f"machine {hexapod.name!r} has no q0_mm in its hexapod.toml: a law needs it (A q0 dT)")
    q = np.asarray(inverse_kinematics(hexapod, poses) - hexapod.retracted_length)
    runs = tuple(f"run-{k + 1}" for k in range(int(run.max(initial=0)) + 1))
    return MachineView(
        hexapod, names, (known[0], known[1]), frozen(poses), frozen(q), frozen(dT), frozen(heat),
        frozen(np.full(n, np.nan)) if air is None else frozen(air), run,
        frozen(np.arange(0.0, 60.0 * n, 60.0)) if time is None else frozen(time), runs,
    )  # fmt: skip


def _refuse_lawless(hexapod: Hexapod) -> ThermalModel:
    """Return the machine's thermal model, or say that there is nothing to judge."""
    if hexapod.thermal is None:
        raise ThermalModelError(
            f"machine {hexapod.name!r} has no thermal law: there is nothing to diagnose; 'identify' makes one"
        )
    return hexapod.thermal
