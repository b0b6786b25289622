"""A virtual leg: the flow of heat along a fixed body and a sliding rod, and how long they make the leg.

Finite volumes along the axis: motor, lower platform piece, lower joint, cells of the body, cells of the rod, upper
joint, upper platform piece.  Each rod cell keeps its own matter: when the rod slides, no temperature is interpolated;
only the conductances to the body's cells and to the room change, with the lengths by which cells overlap.  So energy is
conserved to rounding whatever the motion.

Over one step of time, with heat capacities ``C``, conductances ``K(q)``, those to the room ``g(q)`` and heat ``Q``:

    C (T1 - T0) = dt (-K(q) T_m - g(q) (T_m - T_room)) + Q,      T_m = (T0 + T1) / 2

the implicit midpoint rule: second order, stable for every step, and it balances exactly.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from math import pi

import numpy as np
from scipy.linalg import lapack

from hexathermal.errors import ArgumentError
from hexathermal.machine.thermal import frozen
from hexathermal.poses import FloatArray
from hexathermal.simulate.bench.cells import overlaps
from hexathermal.simulate.bench.metrology_loop import growth
from hexathermal.simulate.bench.parts import Contact, Drive, EndJoints, LegBody, Rod

LARGEST_STEP = 5.0
"""Step of time [s]: half of it changes the drift of a 6 h run by less than 2 nm (tested)."""

MOTOR, LOWER_PIECE, LOWER_JOINT, BODY = 0, 1, 2, 3
"""Places in the list of temperatures; the rod's cells, the upper joint and the upper piece follow the body's."""


@dataclass(frozen=True, eq=False)
class LegHistory:
    """What happened in a leg; n times, m temperatures.

    Attributes
    ----------
    leg : VirtualLeg
    time : array, shape (n,) [s]
    q : array, shape (n,) [m]
        Displacement of the rod, 0 retracted.
    temperatures : array, shape (n, m) [degC]
        In the order of `VirtualLeg.nodes`.
    heat_in, heat_out : array, shape (n,) [J]
        Heat made inside, and heat given to the room, since the first time.
    """

    leg: VirtualLeg
    time: FloatArray
    q: FloatArray
    temperatures: FloatArray
    heat_in: FloatArray
    heat_out: FloatArray

    def every(self, count: int) -> LegHistory:
        """Return every `count`-th time."""
        part = slice(None, None, count)
        return LegHistory(
            self.leg, self.time[part], self.q[part], frozen(self.temperatures[part]), self.heat_in[part],
            self.heat_out[part],
        )  # fmt: skip

    def stored(self) -> FloatArray:
        """Return the heat stored since the first time, shape (n,) [J]."""
        return np.asarray((self.temperatures - self.temperatures[0]) @ self.leg.capacities)

    def surface(self, part: str, position: float) -> FloatArray:
        """Return the temperature of a place on a part, shape (n,) [degC]; see `VirtualLeg.weights`."""
        return np.asarray(self.temperatures @ self.leg.weights(part, position))

    def growth(self, reference: FloatArray) -> FloatArray:
        """Return by how much the leg is longer than at `reference` temperatures, shape (n,) [m]."""
        return self.leg.growth(self.temperatures, self.q, reference)


@dataclass(frozen=True)
class VirtualLeg:
    """A telescopic leg that warms up when it works.

    Parameters
    ----------
    retracted_length : float [m]
        Inter-articular length at ``q = 0``. Engineering value, as the stroke's lower end: the paper gives none.
    stroke : tuple of float [m]
        Lowest and highest `q`. Source: 250 mm (Robert et al.).
    body, rod, contact, joints, drive
        Parts, see their classes.

    Examples
    --------
    An hour at rest in a room that is 1 K warmer from the first moment on warms the leg's middle by some 0.5 K:

    >>> import numpy as np
    >>> leg = VirtualLeg()
    >>> time = np.arange(0.0, 3601.0, 5.0)
    >>> start = leg.at_rest(room=20.0, q=0.1)
    >>> history = leg.warm(time, np.full(time.size, 0.1), np.full(time.size, 21.0), start)
    >>> middle = history.surface("body", 0.26)
    >>> bool(0.2 < middle[-1] - middle[0] < 0.8)
    True
    """

    retracted_length: float = 0.600
    stroke: tuple[float, float] = (0.0, 0.250)
    body: LegBody = field(default_factory=LegBody)
    rod: Rod = field(default_factory=Rod)
    contact: Contact = field(default_factory=Contact)
    joints: EndJoints = field(default_factory=EndJoints)
    drive: Drive = field(default_factory=Drive)

    def __post_init__(self) -> None:
        low, high = self.stroke
        if not (np.isfinite([low, high, self.retracted_length]).all() and low < high and self.retracted_length > 0.0):
            raise ArgumentError(
                f"a leg needs a retracted length above 0 and a stroke (low, high) with low < high, found "
                f"{self.retracted_length!r} m and {self.stroke!r} m"
            )
        nut, head = self.contact.nut_position, self.body.head_position
        foot = self.joints.length
        if self.rod_end(low) < foot or self.rod_end(high) > nut - 0.5 * self.contact.nut_length:
            raise ArgumentError(
                f"the rod must stay above the body's foot ({foot:g} m) and in the nut ({nut:g} m) over the whole "
                f"stroke; its lower end moves from {self.rod_end(low):g} to {self.rod_end(high):g} m"
            )
        if not foot < head <= foot + self.body.length < self.retracted_length + low - foot:
            raise ArgumentError(
                f"reading head ({head:g} m) and the body's top ({foot + self.body.length:g} m) must stand in this "
                f"order below the retracted rod's upper end ({self.retracted_length + low - foot:g} m)"
            )

    def rod_end(self, q: float) -> float:
        """Return where the rod's lower end stands, from the lower joint's centre [m]."""
        return self.retracted_length + q - self.joints.length - self.rod.length

    @property
    def size(self) -> int:
        """Number of temperatures."""
        return BODY + self.body.cells + self.rod.cells + 2

    @property
    def nodes(self) -> tuple[str, ...]:
        """Names of the temperatures."""
        body = tuple(f"body {k + 1}" for k in range(self.body.cells))
        rod = tuple(f"rod {k + 1}" for k in range(self.rod.cells))
        return ("motor", "lower piece", "lower joint", *body, *rod, "upper joint", "upper piece")

    @cached_property
    def body_edges(self) -> FloatArray:
        """Edges of the body's cells from the lower joint's centre, upwards [m]."""
        return frozen(self.joints.length + np.linspace(0.0, self.body.length, self.body.cells + 1))

    @cached_property
    def rod_edges(self) -> FloatArray:
        """Edges of the rod's cells from the lower joint's centre, upwards, rod retracted [m]."""
        return frozen(self.rod_end(0.0) + np.linspace(0.0, self.rod.length, self.rod.cells + 1))

    @property
    def lower_joint(self) -> int:
        """The lower joint among the temperatures."""
        return LOWER_JOINT

    @property
    def upper_joint(self) -> int:
        """The upper joint among the temperatures."""
        return self.size - 2

    @property
    def in_body(self) -> slice:
        """The body's cells among the temperatures."""
        return slice(BODY, BODY + self.body.cells)

    @property
    def in_rod(self) -> slice:
        """The rod's cells among the temperatures."""
        return slice(BODY + self.body.cells, self.size - 2)

    @cached_property
    def capacities(self) -> FloatArray:
        """Heat capacities, shape (m,) [J/K]."""
        found = np.empty(self.size)
        found[MOTOR] = self.body.motor_capacity
        found[[LOWER_PIECE, self.size - 1]] = self.joints.piece_capacity
        found[[LOWER_JOINT, self.size - 2]] = self.joints.capacity
        found[self.in_body] = self.body.capacity * np.diff(self.body_edges)
        found[self.in_rod] = self.rod.capacity * np.diff(self.rod_edges)
        return frozen(found)

    @cached_property
    def _along(self) -> FloatArray:
        """Conductances that do not depend on the rod's place, as a matrix of shape (m, m) [W/K]."""
        matrix = np.zeros((self.size, self.size))

        def join(a: int, b: int, conductance: float) -> None:
            matrix[[a, b], [a, b]] += conductance
            matrix[[a, b], [b, a]] -= conductance

        end = self.size - 1
        join(MOTOR, BODY, self.body.motor_conductance)
        for piece, joint, cell in ((LOWER_PIECE, LOWER_JOINT, BODY), (end, end - 1, end - 2)):
            join(piece, joint, self.joints.piece_conductance)
            join(joint, cell, self.joints.leg_conductance)
        parts = ((self.in_body, self.body.section_conductance, self.body_edges),
                 (self.in_rod, self.rod.section_conductance, self.rod_edges))  # fmt: skip
        for cells, section, edges in parts:
            for k in range(cells.start, cells.stop - 1):
                join(k, k + 1, section / (edges[1] - edges[0]))
        return matrix

    @cached_property
    def _contact(self) -> FloatArray:
        """Conductance between rod and body per length of the overlap, for each cell of the body [W/m/K]."""
        contact, edges = self.contact, self.body_edges
        bushes = ((contact.nut_position, contact.nut_length, contact.nut_conductance),
                  (contact.guide_position, contact.guide_length, contact.guide_conductance))  # fmt: skip
        found = np.full(self.body.cells, contact.gap_conductance)
        for middle, length, conductance in bushes:
            found += (
                conductance
                * overlaps(edges, np.array([middle - length / 2, middle + length / 2]))[:, 0]
                / (edges[1] - edges[0])
            )
        return frozen(found * pi * self.rod.outer_diameter)

    def conductances(self, q: float) -> tuple[FloatArray, FloatArray]:
        """Return the conductances at a displacement: between all parts, shape (m, m), and to the room, (m,) [W/K]."""
        matrix = self._along.copy()
        overlap = overlaps(self.body_edges, self.rod_edges + q)
        joined = self._contact[:, None] * overlap
        matrix[self.in_body, self.in_rod] -= joined
        matrix[self.in_rod, self.in_body] -= joined.T
        diagonal = np.einsum("ii->i", matrix)
        diagonal[self.in_body] += joined.sum(axis=1)
        diagonal[self.in_rod] += joined.sum(axis=0)
        room = np.zeros(self.size)
        room[MOTOR] = self.body.motor_convection
        room[[LOWER_PIECE, self.size - 1]] = self.joints.piece_convection
        room[self.in_body] = self.body.convection * pi * self.body.outer_diameter * np.diff(self.body_edges)
        outside = np.clip(self.rod_edges + q - self.body_edges[-1], 0.0, None)
        room[self.in_rod] = self.rod.convection * pi * self.rod.outer_diameter * np.diff(outside)
        return matrix, room

    def friction_places(self, q: float) -> FloatArray:
        """Return where the nut's friction heat goes, parts of 1, shape (m,)."""
        contact = self.contact
        nut = contact.nut_position + 0.5 * contact.nut_length * np.array([-1.0, 1.0])
        found = np.zeros(self.size)
        found[self.in_body] = (1.0 - self.drive.rod_share) * overlaps(self.body_edges, nut)[:, 0] / contact.nut_length
        found[self.in_rod] = self.drive.rod_share * overlaps(self.rod_edges + q, nut)[:, 0] / contact.nut_length
        return found

    def at_rest(self, room: float, q: float) -> FloatArray:
        """Return the steady temperatures of a leg that only holds its place, shape (m,) [degC]."""
        matrix, to_room = self.conductances(q)
        heat = to_room * room
        heat[MOTOR] += self.drive.holding_power
        return np.asarray(np.linalg.solve(matrix + np.diag(to_room), heat), dtype=np.float64)

    def warm(
        self, time: FloatArray, q: FloatArray, room: FloatArray, start: FloatArray, *, way: FloatArray | None = None
    ) -> LegHistory:
        """Return how the leg's temperatures follow motion and room.

        Parameters
        ----------
        time : array, shape (n,) [s]
            Increasing; the steps are taken as they are.
        q : array, shape (n,) [m]
            Displacement of the rod.
        room : array, shape (n,) [degC]
        start : array, shape (m,) [degC]
            Temperatures at the first time, see `at_rest`.
        way : array, shape (n,), optional [m]
            Way that the rod has gone, back and forth; default: the least that `q` asks for. It makes the heat.

        Raises
        ------
        ArgumentError
            Shapes differ, times do not increase, values are not finite, or `q` leaves the stroke.
        """
        time, q, room = (np.asarray(item, dtype=np.float64) for item in (time, q, room))
        gone = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(q)))]) if way is None else np.asarray(way, dtype=float)
        self._check(time, q, room, gone, np.asarray(start))
        temperatures = np.empty((time.size, self.size))
        temperatures[0] = start
        heat_in, heat_out = np.zeros(time.size), np.zeros(time.size)
        last: tuple[float, float] | None = None
        for k in range(time.size - 1):
            step, middle = time[k + 1] - time[k], 0.5 * (q[k] + q[k + 1])
            if last != (step, middle):
                if last is None or last[1] != middle:
                    matrix, to_room = self.conductances(middle)
                    places = self.friction_places(middle)
                system = (0.5 * step) * matrix
                np.einsum("ii->i", system)[:] += self.capacities + (0.5 * step) * to_room
                factor, _info = lapack.dpotrf(system, lower=1, overwrite_a=1)
                last = (step, middle)
            moved = gone[k + 1] - gone[k]
            air = 0.5 * (room[k] + room[k + 1])
            heat = places * (self.drive.friction_force * moved)
            heat[MOTOR] += self.drive.holding_power * step + self.drive.motor_force * moved
            # solved as a rise above the step's first state, so that rounding does not build up
            before = temperatures[k]
            drive = 0.5 * (heat - step * (matrix @ before + to_room * (before - air)))
            half, _info = lapack.dpotrs(factor, drive, lower=1)
            temperatures[k + 1] = before + 2.0 * half
            heat_in[k + 1] = heat_in[k] + heat.sum()
            heat_out[k + 1] = heat_out[k] + step * float(to_room @ (before + half - air))
        return LegHistory(self, *map(frozen, (time, q, temperatures, heat_in, heat_out)))

    def _check(self, time: FloatArray, q: FloatArray, room: FloatArray, way: FloatArray, start: FloatArray) -> None:
        """Refuse what no leg can do."""
        if time.ndim != 1 or not time.size or not time.shape == q.shape == room.shape == way.shape:
            raise ArgumentError(
                f"time, q, room and way need one shape (n,), found {time.shape}, {q.shape}, {room.shape}, {way.shape}"
            )
        if start.shape != (self.size,):
            raise ArgumentError(f"start has shape {start.shape}; expected ({self.size},), one value for each node")
        if not all(np.isfinite(item).all() for item in (time, q, room, way, start)):
            raise ArgumentError("time, q, room, way and start must be finite")
        if not (np.diff(time) > 0.0).all() or not (np.diff(way) >= 0.0).all():
            raise ArgumentError("time must increase, and way must not decrease")
        low, high = self.stroke
        if q.min() < low - 1e-9 or q.max() > high + 1e-9:
            raise ArgumentError(
                f"q runs from {q.min() * 1e3:g} to {q.max() * 1e3:g} mm; "
                f"the stroke is {low * 1e3:g} to {high * 1e3:g} mm"
            )

    def weights(self, part: str, position: float) -> FloatArray:
        """Return how much each temperature counts at a place on a part's surface, shape (m,).

        Parameters
        ----------
        part : str
            ``"body"`` or ``"rod"``.
        position : float [m]
            From the lower joint's centre, rod retracted; a place on the rod moves with the rod.

        Raises
        ------
        ArgumentError
            No such part, or it does not reach there.
        """
        parts = {"body": (self.in_body, self.body_edges), "rod": (self.in_rod, self.rod_edges)}
        if part not in parts:
            raise ArgumentError(f"a leg has a body and a rod, no {part!r}")
        cells, edges = parts[part]
        if not edges[0] <= position <= edges[-1]:
            raise ArgumentError(
                f"the {part} reaches from {edges[0] * 1e3:g} to {edges[-1] * 1e3:g} mm; there is nothing at "
                f"{position * 1e3:g} mm"
            )
        found = np.zeros(self.size)
        centres = 0.5 * (edges[1:] + edges[:-1])
        k = int(np.clip(np.searchsorted(centres, position) - 1, 0, centres.size - 2))
        part_of = (position - centres[k]) / (centres[k + 1] - centres[k])
        found[cells.start + k], found[cells.start + k + 1] = 1.0 - part_of, part_of
        return found

    def growth(self, temperatures: FloatArray, q: FloatArray, reference: FloatArray) -> FloatArray:
        """Return by how much the leg is longer than its scale says, shape (n,) [m]; see `metrology_loop.growth`."""
        return growth(self, temperatures, q, reference)
