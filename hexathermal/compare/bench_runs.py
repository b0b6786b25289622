"""A campaign's runs on the virtual bench: what its channels would have shown, for several variants of its numbers.

Channels are the compared thermocouples, as rises [K] of what they read with the bench's usual contact error; the drift
[um]; and in each window how the drift depends on the rod's displacement [um/m].
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hexathermal.compare.measured import MeasuredRun
from hexathermal.compare.parameters import scaled_leg
from hexathermal.compare.placing import Placed
from hexathermal.poses import FloatArray
from hexathermal.simulate.bench.leg import LARGEST_STEP, VirtualLeg
from hexathermal.simulate.bench.room import Room
from hexathermal.simulate.bench.thermocouples import Thermocouples
from hexathermal.simulate.bench.together import LegsTogether

UM = 1e6
"""Micrometres in a metre."""

CONTACT_ERROR = float(np.mean(Thermocouples().contact_error))
"""Part by which every thermocouple follows the air, unless something else was found."""

START_MODES = 3
"""Slowest ways of cooling in which a run may begin out of balance with its room."""

START_SD = 0.1
"""By how much it may be out of balance, in each of them [K]."""

SCALE_SD = 3.0
"""Standard deviation of a run's constant error of the scale [um/m]: 1.5 K off its reference at 2 um/m/K."""

WAY_STEP = 0.02
"""What the way does is a difference over so much of its logarithm."""

Logs = Mapping[str, float]
"""Natural logarithms of factors, by the parameter's name."""


@dataclass(frozen=True, eq=False)
class SimulatedRun:
    """One run of v variants in its windows, c = thermocouples + 2 channels.

    Attributes
    ----------
    values : array, shape (v, c, w)
        What the channels show.
    surfaces, air : array, shape (s, w), (w,) [K]
        Rises of the surfaces under the thermocouples (first variant) and of the air.
    doubts : array, shape (START_MODES + 2, c, w)
        One standard deviation of what is not known of the run: how it began, the way gone, the scale's error.
    """

    values: FloatArray
    surfaces: FloatArray
    air: FloatArray
    doubts: FloatArray


@dataclass(frozen=True, eq=False)
class RunCurves:
    """One run of one variant in its settled rows: `rises` (n, s) [K] of the readings and `drift` (n,) [m]."""

    rises: FloatArray
    drift: FloatArray


@dataclass(frozen=True, eq=False)
class AskedLeg:
    """A leg, and what every run asks of it.

    Attributes
    ----------
    leg : VirtualLeg
    reference : array, shape (m,) [degC]
        Temperatures at which the scale reads true: the bench's mean room, the leg holding its place.
    weights : array, shape (m, s)
        What each temperature counts at each thermocouple.
    """

    leg: VirtualLeg
    reference: FloatArray
    weights: FloatArray

    def growth(self, T: FloatArray, run: MeasuredRun) -> FloatArray:
        """Return by how much the leg is longer than its scale says in each settled row [m]."""
        return self.leg.growth(T, run.row_q, self.reference)

    def first_growth(self, start: FloatArray, run: MeasuredRun) -> float:
        """Return the same at the run's first row [m]."""
        return float(self.leg.growth(start[None], np.array([run.start_q]), self.reference)[0])


class BenchRuns:
    """The virtual bench, driven by the motion and the room of measured runs.

    Parameters
    ----------
    placed : Placed
    runs : sequence of MeasuredRun
    """

    def __init__(self, placed: Placed, runs: Sequence[MeasuredRun]) -> None:
        self.placed, self.runs = placed, tuple(runs)

    def simulated(self, variants: Sequence[Logs]) -> tuple[SimulatedRun, ...]:
        """Return all runs of variants; the first is the one that thermocouples' errors are taken about."""
        legs = [scaled_leg(self.placed.leg, logs) for logs in variants]
        # behind the variants, those that show what is not known of the run: how it began, and the way gone
        legs += [*legs[:1] * START_MODES, scaled_leg(legs[0], {"motor-heat": WAY_STEP, "friction-heat": WAY_STEP})]
        asked, together = [self.asked(leg) for leg in legs], dict[float, LegsTogether]()
        return tuple(
            self._one(run, asked, together.setdefault(run.step, LegsTogether(legs, run.step))) for run in self.runs
        )

    def curves(self, run: MeasuredRun, logs: Logs, contact_errors: Mapping[int, float] | None = None) -> RunCurves:
        """Return a run of one variant row by row.

        Parameters
        ----------
        run : MeasuredRun
        logs : mapping
        contact_errors : mapping of int to float, optional
            Part by which some thermocouples follow the air, by their place among the compared ones.
        """
        leg = scaled_leg(self.placed.leg, logs)
        asked = self.asked(leg)
        start = leg.at_rest(run.start_air, run.start_q)[None]
        T = _at_rows(run, LegsTogether([leg], run.step).warm(run.q, run.way, run.air, start)[:, 0])
        contact = np.full(len(self.placed.places), CONTACT_ERROR)
        for k, value in (contact_errors or {}).items():
            contact[k] = value
        rises = (T - start[0]) @ asked.weights
        rises -= contact * (rises - run.row_air[:, None])
        return RunCurves(rises, asked.growth(T, run) - asked.first_growth(start[0], run))

    def asked(self, leg: VirtualLeg) -> AskedLeg:
        """Return a leg with what all runs ask of it."""
        weights = np.column_stack([leg.weights(part, position) for part, position in self.placed.places])
        return AskedLeg(leg, leg.at_rest(Room().temperature, float(np.mean(leg.stroke))), weights)

    def _one(self, run: MeasuredRun, legs: list[AskedLeg], ensemble: LegsTogether) -> SimulatedRun:
        """Return one run of all variants."""
        count, kept = len(self.placed.places), len(legs) - START_MODES - 1
        balance = np.array([asked.leg.at_rest(run.start_air, run.start_q) for asked in legs])
        first = balance.copy()
        first[kept:-1] += start_modes(legs[0].leg, run.start_q)
        whole = ensemble.warm(run.q, run.way, run.air, first)
        windows = run.windows
        air = windows.mean(run.row_air)
        values = np.empty((len(legs), count + 2, len(air)))
        surfaces = np.empty((count, len(air)))
        for v, asked in enumerate(legs):
            T = _at_rows(run, whole[:, v])
            rises = (windows.mean(T - balance[v]) @ asked.weights).T
            surfaces = rises if v == 0 else surfaces
            values[v, :count] = rises - CONTACT_ERROR * (rises - air)
            drift = UM * (asked.growth(T, run) - asked.first_growth(balance[v], run))
            values[v, count], values[v, count + 1] = windows.mean(drift), windows.slope(drift)
        extra = values[kept:] - values[0]
        scale = np.zeros((1, count + 2, len(air)))
        scale[0, count], scale[0, count + 1] = windows.mean(run.row_q) - run.start_q, 1.0
        doubts = [START_SD * extra[:-1], run.way_doubt / WAY_STEP * extra[-1:], SCALE_SD * scale]
        return SimulatedRun(values[:kept], surfaces, air, np.concatenate(doubts))


def discretisation_error(bench: BenchRuns, run: MeasuredRun) -> tuple[float, float]:
    """Return what steps of time and the rod's grid cost in a run: largest difference of rises [K] and of drift [m].

    Against `VirtualLeg.warm` with steps of `LARGEST_STEP` along the course that is linear between the rows.
    """
    leg = bench.placed.leg
    time, q, way, air = run.course
    fine = np.arange(time[0], time[-1], LARGEST_STEP)
    start = leg.at_rest(run.start_air, run.start_q)
    q, room, way = (np.interp(fine, time, values) for values in (q, air, way))
    exact = leg.warm(fine, q, room, start, way=way)
    asked = bench.asked(leg)
    T = np.column_stack([np.interp(run.time, fine, node) for node in exact.temperatures.T])
    coarse = _at_rows(run, LegsTogether([leg], run.step).warm(run.q, run.way, run.air, start[None])[:, 0])
    rises = np.abs((coarse - T) @ asked.weights)
    drift = np.abs(asked.growth(coarse, run) - asked.growth(T, run))
    return float(rises.max()), float(drift.max())


def start_modes(leg: VirtualLeg, q: float) -> FloatArray:
    """Return the slowest ways in which a leg cools at rest, largest temperature 1 K, shape (START_MODES, m)."""
    from scipy.linalg import eigh

    matrix, to_room = leg.conductances(q)
    modes = eigh(matrix + np.diag(to_room), np.diag(leg.capacities), subset_by_index=(0, START_MODES - 1))[1].T
    return np.asarray(modes / np.abs(modes).max(axis=1, keepdims=True))


def _at_rows(run: MeasuredRun, T: FloatArray) -> FloatArray:
    """Return temperatures of steps, (k, ...), at a run's settled rows."""
    place = np.clip(run.time / run.step, 0.0, len(T) - 1.0)
    k = np.minimum(place.astype(int), len(T) - 2)
    part = (place - k).reshape((-1,) + (1,) * (T.ndim - 1))
    return np.asarray(T[k] * (1.0 - part) + T[k + 1] * part)
