"""Several virtual legs along one motion: variants that differ in a number or in their start, warmed side by side.

The scheme is that of `VirtualLeg.warm`, with steps of one length. The rod's place is rounded to a grid, so that the
step is a linear map that is made once for each leg and place and serves all runs:

    T1 = P(q) T0 + air dt S(q)^-1 g(q) + way S(q)^-1 f(q) + dt S(q)^-1 h,
    S = C + dt / 2 (K + g),    P = 1 - dt S^-1 (K + g)

with ``f`` the heat for each metre of way and ``h`` the power of holding. What steps and grid cost is measured, not
assumed: `hexathermal.compare` simulates one run both ways and states the largest difference.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hexathermal.errors import ArgumentError
from hexathermal.machine.thermal import frozen
from hexathermal.poses import FloatArray
from hexathermal.simulate.bench.leg import MOTOR, VirtualLeg

GRID = 0.010
"""Places of the rod are rounded to this [m]: half of a cell."""


@dataclass(frozen=True, eq=False)
class _Maps:
    """The linear maps of one step at one place of the rod, for v legs of m temperatures."""

    keep: FloatArray
    air: FloatArray
    way: FloatArray
    hold: FloatArray


class LegsTogether:
    """Legs that are warmed together; maps of steps are kept, so that further runs cost little.

    Parameters
    ----------
    legs : sequence of VirtualLeg
        All cut into as many cells.
    step : float [s]

    Raises
    ------
    ArgumentError
        There is no leg, they differ in cells, or the step is not above 0.

    Examples
    --------
    >>> legs = LegsTogether([VirtualLeg()], step=30.0)
    >>> start = VirtualLeg().at_rest(room=20.0, q=0.1)[None]
    >>> still = np.zeros(10)
    >>> found = legs.warm(np.full(10, 0.1), still, np.full(10, 20.0), start)
    >>> found.shape, bool(abs(found - start).max() < 1e-9)
    ((11, 1, 59), True)
    """

    def __init__(self, legs: Sequence[VirtualLeg], step: float) -> None:
        if not legs or len({leg.size for leg in legs}) > 1:
            raise ArgumentError("legs that are warmed together need one number of cells, and there must be one leg")
        if not (np.isfinite(step) and step > 0.0):
            raise ArgumentError(f"the step of time must be above 0 s, found {step!r}")
        self.legs, self.step = tuple(legs), step
        self._maps: dict[int, _Maps] = {}

    def _at(self, place: int) -> _Maps:
        """Return the maps at a place of the grid."""
        if place not in self._maps:
            self._maps[place] = self._made(place * GRID)
        return self._maps[place]

    def _made(self, q: float) -> _Maps:
        """Return the maps at a displacement."""
        count, size, dt = len(self.legs), self.legs[0].size, self.step
        loss, load, to_room = np.empty((count, size, size)), np.zeros((count, size, 3)), np.empty((count, size))
        for k, leg in enumerate(self.legs):
            held = float(np.clip(q, *leg.stroke))
            loss[k], to_room[k] = leg.conductances(held)
            load[k, :, 1] = leg.friction_places(held) * leg.drive.friction_force
            load[k, MOTOR, 1] += leg.drive.motor_force
            load[k, MOTOR, 2] = dt * leg.drive.holding_power
        diagonal = np.einsum("kii->ki", loss)
        diagonal += to_room
        load[:, :, 0] = dt * to_room
        system = 0.5 * dt * loss
        np.einsum("kii->ki", system)[:] += np.array([leg.capacities for leg in self.legs])
        found = np.linalg.solve(system, np.concatenate([dt * loss, load], axis=2))
        return _Maps(np.eye(size) - found[:, :, :size], *(found[:, :, size + k] for k in range(3)))

    def warm(self, q: FloatArray, way: FloatArray, air: FloatArray, start: FloatArray) -> FloatArray:
        """Return the temperatures at the ends of all steps, shape (n + 1, v, m) [degC].

        Parameters
        ----------
        q, way, air : array, shape (n,) [m], [m], [degC]
            Mean displacement, way gone, and mean temperature of the room during each step.
        start : array, shape (v, m) [degC]
        """
        found = np.empty((len(q) + 1, *start.shape))
        found[0] = start
        places = np.round(np.asarray(q) / GRID).astype(int).tolist()
        for k, place in enumerate(places):
            maps = self._at(place)
            now = np.matmul(maps.keep, found[k][:, :, None])[:, :, 0]
            now += air[k] * maps.air
            now += way[k] * maps.way
            now += maps.hold
            found[k + 1] = now
        return frozen(found)
