"""Heat in a whole hexapod: six virtual legs that meet in two plates.

Each leg is the finite-volume leg of `hexathermal.simulate.bench.leg`; its two platform pieces are replaced by the base
and the platform, which all legs share.  So a plate is warmed through six joints, and hands heat from leg to leg.  One
step of time is the implicit midpoint rule over the whole machine:

    C (T1 - T0) = dt (-K(q) T_m - g(q) (T_m - T_room)) + Q,      T_m = (T0 + T1) / 2

second order, stable for every step, and heat balances to rounding.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy.linalg import lapack

from hexathermal.errors import ArgumentError
from hexathermal.machine.thermal import frozen
from hexathermal.poses import FloatArray
from hexathermal.simulate.bench.leg import LOWER_PIECE, MOTOR, VirtualLeg
from hexathermal.simulate.machine.parts import Plate


@dataclass(frozen=True)
class MachineHeat:
    """The thermal network of a hexapod.

    Parameters
    ----------
    legs : tuple of VirtualLeg
        Six; their own platform pieces do not count.
    platform, base : Plate
    """

    legs: tuple[VirtualLeg, ...]
    platform: Plate
    base: Plate

    def __post_init__(self) -> None:
        if len(self.legs) != 6:
            raise ArgumentError(f"a hexapod has six legs, found {len(self.legs)}")

    @cached_property
    def places(self) -> tuple[npt.NDArray[np.int64], ...]:
        """For each leg, where its temperatures stand in the machine's: base first, platform second, then the legs."""
        found, start = [], 2
        for leg in self.legs:
            own = np.empty(leg.size, dtype=np.int64)
            inner = np.ones(leg.size, dtype=bool)
            inner[[LOWER_PIECE, leg.size - 1]] = False
            own[inner] = start + np.arange(leg.size - 2)
            own[LOWER_PIECE], own[leg.size - 1] = 0, 1
            found.append(own)
            start += leg.size - 2
        return tuple(found)

    @property
    def size(self) -> int:
        """Number of temperatures."""
        return 2 + sum(leg.size - 2 for leg in self.legs)

    @cached_property
    def capacities(self) -> FloatArray:
        """Heat capacities, shape (m,) [J/K]."""
        found = np.empty(self.size)
        for leg, own in zip(self.legs, self.places, strict=True):
            found[own] = leg.capacities
        found[0], found[1] = self.base.capacity, self.platform.capacity
        return frozen(found)

    def conductances(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the conductances between all parts, (m, m), and to the room, (m,) [W/K], at six displacements."""
        matrix, room = np.zeros((self.size, self.size)), np.zeros(self.size)
        for leg, own, place in zip(self.legs, self.places, q, strict=True):
            K, to_room = leg.conductances(float(place))
            matrix[own[:, None], own[None, :]] += K
            room[own] = to_room
        room[0], room[1] = self.base.convection, self.platform.convection
        return matrix, room

    def at_rest(self, room: float, q: FloatArray) -> FloatArray:
        """Return the steady temperatures of a machine that only holds its pose, shape (m,) [degC]."""
        matrix, to_room = self.conductances(q)
        heat = to_room * room
        for leg, own in zip(self.legs, self.places, strict=True):
            heat[own[MOTOR]] += leg.drive.holding_power
        return np.asarray(np.linalg.solve(matrix + np.diag(to_room), heat), dtype=np.float64)

    def heat_made(self, q: FloatArray, way: FloatArray, step: float) -> FloatArray:
        """Return the heat that drives make in a step in which rods go a way at a mean displacement, shape (m,) [J]."""
        found = np.zeros(self.size)
        for leg, own, place, gone in zip(self.legs, self.places, q, way, strict=True):
            if gone > 0.0:
                found[own] += leg.friction_places(float(place)) * (leg.drive.friction_force * gone)
            found[own[MOTOR]] += leg.drive.holding_power * step + leg.drive.motor_force * gone
        return found

    def warm(self, time: FloatArray, q: FloatArray, room: FloatArray, start: FloatArray) -> MachineHistory:
        """Return how the machine's temperatures follow motion and room.

        Parameters
        ----------
        time : array, shape (n,) [s]
            Increasing; the steps are taken as they are.
        q : array, shape (n, 6) [m]
            Displacements of the rods, counted from each leg's lowest; linear between the times.
        room : array, shape (n,) [degC]
        start : array, shape (m,) [degC]
        """
        n = time.size
        if q.shape != (n, 6) or room.shape != (n,) or start.shape != (self.size,) or not (np.diff(time) > 0.0).all():
            raise ArgumentError(
                f"time (n,) must increase, q is (n, 6), room (n,), start ({self.size},); found {time.shape}, "
                f"{q.shape}, {room.shape}, {start.shape}"
            )
        temperatures = np.empty((n, self.size))
        temperatures[0] = start
        heat_in, heat_out = np.zeros(n), np.zeros(n)
        kept: tuple[float, bytes] | None = None
        for k in range(n - 1):
            step, middle = float(time[k + 1] - time[k]), 0.5 * (q[k] + q[k + 1])
            if kept != (step, middle.tobytes()):
                if kept is None or kept[1] != middle.tobytes():
                    matrix, to_room = self.conductances(middle)
                system = (0.5 * step) * matrix
                np.einsum("ii->i", system)[:] += self.capacities + (0.5 * step) * to_room
                factor, _info = lapack.dpotrf(system, lower=1, overwrite_a=1)
                kept = (step, middle.tobytes())
            heat = self.heat_made(middle, np.abs(q[k + 1] - q[k]), step)
            air, before = 0.5 * (room[k] + room[k + 1]), temperatures[k]
            drive = 0.5 * (heat - step * (matrix @ before + to_room * (before - air)))
            half, _info = lapack.dpotrs(factor, drive, lower=1)
            temperatures[k + 1] = before + 2.0 * half
            heat_in[k + 1] = heat_in[k] + heat.sum()
            heat_out[k + 1] = heat_out[k] + step * float(to_room @ (before + half - air))
        return MachineHistory(self, *map(frozen, (time, q, temperatures, heat_in, heat_out)))


@dataclass(frozen=True, eq=False)
class MachineHistory:
    """What happened in a machine; n times, m temperatures.

    Attributes
    ----------
    heat : MachineHeat
    time : array, shape (n,) [s]
    q : array, shape (n, 6) [m]
        From each leg's lowest displacement.
    temperatures : array, shape (n, m) [degC]
    heat_in, heat_out : array, shape (n,) [J]
        Heat made inside, and heat given to the room, since the first time.
    """

    heat: MachineHeat
    time: FloatArray
    q: FloatArray
    temperatures: FloatArray
    heat_in: FloatArray
    heat_out: FloatArray

    def at(self, rows: npt.NDArray[np.int64]) -> MachineHistory:
        """Return some of the times."""
        return MachineHistory(self.heat, *(frozen(getattr(self, name)[rows]) for name in (
            "time", "q", "temperatures", "heat_in", "heat_out")))  # fmt: skip

    def stored(self) -> FloatArray:
        """Return the heat stored since the first time, shape (n,) [J]."""
        return np.asarray((self.temperatures - self.temperatures[0]) @ self.heat.capacities)

    def surface(self, leg: int, part: str, position: float) -> FloatArray:
        """Return the temperature of a place on a leg (0 to 5), shape (n,) [degC]; see `VirtualLeg.weights`."""
        weights = self.heat.legs[leg].weights(part, position)
        return np.asarray(self.temperatures[:, self.heat.places[leg]] @ weights)

    @property
    def base(self) -> FloatArray:
        """Temperature of the base, shape (n,) [degC]."""
        return self.temperatures[:, 0]

    @property
    def platform(self) -> FloatArray:
        """Temperature of the platform, shape (n,) [degC]."""
        return self.temperatures[:, 1]

    def growth(self, reference: FloatArray) -> FloatArray:
        """Return by how much each leg is longer than its scale says, shape (n, 6) [m]."""
        return np.column_stack([
            leg.growth(self.temperatures[:, own], self.q[:, i], reference[own])
            for i, (leg, own) in enumerate(zip(self.heat.legs, self.heat.places, strict=True))
        ])  # fmt: skip
