"""Budgets of many places at once: the numbers of `error_budget` that a map keeps, chunk by chunk.

Sources move a machine in the same way wherever it stands: their factors are one matrix for all places, and the
derivatives of a chunk are multiplied by it together.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hexathermal.errors import KinematicsError, NotConvergedError
from hexathermal.kinematics.constants import LARGEST_CONDITION
from hexathermal.kinematics.inverse import inverse_kinematics
from hexathermal.kinematics.jacobian import condition_number
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray
from hexathermal.predict.budget_blocks import deviation_factors, deviation_size
from hexathermal.predict.budget_causes import cause_steps, parts_of_bias
from hexathermal.predict.budget_gum import fourth_powers, welch_satterthwaite
from hexathermal.predict.budget_inputs import commanded, refuse_singular
from hexathermal.predict.budget_plates import Plates, plate_rows
from hexathermal.predict.budget_rates import Places, certain, pose_numbers
from hexathermal.predict.budget_view import Look
from hexathermal.predict.leg_drift import between_reversals
from hexathermal.predict.sources import Sources
from hexathermal.predict.temperatures import active_model

CHUNK = 256
"""Places that are worked on together: their derivatives take some 2 MB."""


@dataclass(frozen=True, eq=False)
class SourceTable:
    """Sources of a machine as one matrix, in the order of their labels.

    Attributes
    ----------
    labels : tuple of str
    factors : array, shape (k, r)
        Of all sources side by side, see `deviation_factors`.
    starts : array, shape (sources,)
        First column of each source.
    dof, together : array, shape (sources,)
    """

    labels: tuple[str, ...]
    factors: FloatArray
    starts: npt.NDArray[np.intp]
    dof: FloatArray
    together: npt.NDArray[np.bool_]

    def spread(self, rates: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the variances (N, sources, 6) that sources give, and the degrees of freedom (N, 6) of their sum.

        Parameters
        ----------
        rates : array, shape (N, 6, k)
        """
        n, below = len(rates), np.zeros(rates.shape[:2])
        if not self.labels:
            return np.zeros((n, 0, 6)), np.full((n, 6), np.inf)
        columns = (rates.reshape(-1, rates.shape[-1]) @ self.factors).reshape(n, 6, self.factors.shape[1])
        variances = np.add.reduceat(columns**2, self.starts, axis=-1)
        ends = [*self.starts[1:], self.factors.shape[1]]
        for k in np.flatnonzero(np.isfinite(self.dof)):
            below += fourth_powers(columns[..., self.starts[k] : ends[k]], float(self.dof[k]), bool(self.together[k]))
        return np.swapaxes(variances, 1, 2), welch_satterthwaite(variances.sum(axis=-1), below)


def source_table(hexapod: Hexapod, sources: Sources) -> SourceTable:
    """Return the sources of a machine as one matrix."""
    ordered = sorted(sources, key=lambda source: source.label)
    factors = [deviation_factors(hexapod, source) for source in ordered]
    widths = [own.shape[1] for own in factors]
    whole = np.concatenate([np.zeros((deviation_size(hexapod) + 6, 0)), *factors], axis=1)
    return SourceTable(
        tuple(source.label for source in ordered), whole, np.cumsum([0, *widths], dtype=np.intp)[:-1],
        np.array([source.dof for source in ordered]), np.array([source.joint for source in ordered], dtype=bool),
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Chunk:
    """Budgets of some places; `kept` are those that can be reached, all other arrays lead with these.

    Attributes
    ----------
    kept : array, shape (M,)
    refused : dict of int to str
        Reason of each other place.
    uncorrected, remaining, dof : array, shape (M, 6)
    variances : array, shape (M, sources, 6)
    causes : list of (names, parts (c, 6))
        Of `remaining`.
    """

    kept: npt.NDArray[np.intp]
    refused: dict[int, str]
    uncorrected: FloatArray
    remaining: FloatArray
    dof: FloatArray
    variances: FloatArray
    causes: list[tuple[tuple[str, ...], FloatArray]]


def budgets_of_chunk(
    hexapod: Hexapod,
    poses: FloatArray,
    temps: FloatArray,
    air: FloatArray,
    plates: Sequence[Plates],
    seen: Look,
    correction: bool,
    table: SourceTable,
) -> Chunk:
    """Return the budgets of some places: poses (N, 4, 4), temps (N, n) that are valid, air (N,) and plates."""
    hexapod = between_reversals(hexapod)
    told, refused = _told(hexapod, poses, temps, correction)
    places, kept = _places(hexapod, poses, temps, air, plates, seen, told, refused), _rest(len(poses), refused)
    nominal = inverse_kinematics(hexapod, places.poses)
    bias: list[FloatArray] = []
    drift: list[FloatArray] = []
    causes: list[tuple[tuple[str, ...], FloatArray]] = []
    machines: list[tuple[FloatArray, FloatArray]] = []
    good = np.ones(len(kept), dtype=bool)
    for k in range(len(kept)):
        steps = cause_steps(hexapod, places.plates[k], correction)
        made = [places.machine(k), *(places.machine(k, plates=rows) for _name, rows, _load in steps)]
        load = np.array([1.0, *(load for _name, _rows, load in steps), 1.0])[:, None]
        made.append(places.machine(k, told=nominal[k]) if correction else made[0])
        lengths, joints = (np.concatenate(arrays) for arrays in zip(*made, strict=True))
        try:
            errors = certain(*places.solved(k, lengths, joints, load=load), expected=True)
        except NotConvergedError as error:
            refused[int(kept[k])], good[k] = str(error), False
            continue
        machines.append(made[0])
        bias.append(errors[0])
        drift.append(errors[-1])
        causes.append(parts_of_bias([name for name, _rows, _load in steps], errors[:-1], correction))
    remaining = np.array(bias).reshape(-1, 6)
    joints = np.array([own[1][0] for own in machines]).reshape(-1, 36)
    variances, dof = table.spread(_some(places, good).rates(remaining, joints))
    return Chunk(kept[good], refused, np.array(drift).reshape(-1, 6), remaining, dof, variances, causes)


def _told(
    hexapod: Hexapod, poses: FloatArray, temps: FloatArray, correction: bool
) -> tuple[FloatArray, dict[int, str]]:
    """Return commanded lengths (N, 6), and for each place that is refused its reason."""
    refused: dict[int, str] = {}
    told = np.full((len(poses), 6), np.nan)
    try:
        regular = condition_number(hexapod, poses) <= LARGEST_CONDITION
    except KinematicsError:
        regular = np.zeros(len(poses), dtype=bool)
    if regular.all():
        try:
            return commanded(hexapod, poses, temps, correction), refused
        except KinematicsError:
            pass
    for k in range(len(poses)):
        try:
            if not regular[k]:
                refuse_singular(hexapod, poses[k])
            told[k] = commanded(hexapod, poses[k], temps[k], correction)
        except KinematicsError as error:
            refused[k] = str(error)
    return told, refused


def _rest(count: int, refused: dict[int, str]) -> npt.NDArray[np.intp]:
    """Return the places that are not refused."""
    return np.setdiff1d(np.arange(count, dtype=np.intp), np.fromiter(refused, dtype=np.intp))


def _places(
    hexapod: Hexapod,
    poses: FloatArray,
    temps: FloatArray,
    air: FloatArray,
    plates: Sequence[Plates],
    seen: Look,
    told: FloatArray,
    refused: dict[int, str],
) -> Places:
    """Return the places that are not refused, ready to be deviated from."""
    kept = _rest(len(poses), refused)
    own, hot = np.ascontiguousarray(poses[kept]), temps[kept]
    reference = np.asarray(active_model(hexapod).reference_temperature_degC)
    rows = np.array([plate_rows(hexapod, temps[k], plates[k]) for k in kept]).reshape(-1, 2, 8)
    axes = seen.axes(own)
    return Places(
        hexapod, own, told[kept], hot - reference, hot - air[kept][:, None], rows, axes, seen.arm,
        pose_numbers(hexapod, own, axes, seen.arm),
    )  # fmt: skip


def _some(places: Places, good: npt.NDArray[np.bool_]) -> Places:
    """Return some of the places."""
    if good.all():
        return places
    return Places(
        places.hexapod, places.poses[good], places.told[good], places.dT[good], places.lag[good], places.plates[good],
        places.axes[good], places.arm, places.numbers[good],
    )  # fmt: skip
