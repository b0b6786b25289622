"""A case: the rows of a machine, what may be in them, and the tables of all columns, ready to be searched."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hexathermal.learn.hexapod_data import AIR, HexapodRows
from hexathermal.learn.machine_diagnosis.candidate import Candidate
from hexathermal.learn.machine_diagnosis.causes import all_candidates, catalogue
from hexathermal.learn.machine_diagnosis.finer import finer_candidates
from hexathermal.learn.machine_diagnosis.gain import leg_residuals
from hexathermal.learn.machine_diagnosis.law_columns import law_columns
from hexathermal.learn.machine_diagnosis.leg_sensors import sensor_candidates
from hexathermal.learn.machine_diagnosis.noise_levels import SMALLEST_NOISE, PoseNoise, coordinates_of, pose_noise
from hexathermal.learn.machine_diagnosis.single_leg import single_leg_candidates
from hexathermal.learn.machine_diagnosis.tables import Tables, tables_of
from hexathermal.learn.machine_diagnosis.unexplained import flexible_candidates, wide_candidates
from hexathermal.learn.machine_diagnosis.view import MachineView
from hexathermal.machine.hexapod import Hexapod
from hexathermal.poses import FloatArray

OF_ONE_LEG = 0.1
"""Prior of a cause of a single leg's catalogue, over that of one of the machine's."""

NAMELESS = 0.5
"""The same of all flexible shapes together."""

OF_A_PLATE = 0.2
"""Prior of a measuring frame that follows a plate's thermometer, over one that follows the air."""


@dataclass(frozen=True, eq=False)
class Case:
    """Rows with candidates and tables.

    Attributes
    ----------
    view : MachineView
    y : array, shape (n, 6) [m]
        Residual of the leg lengths under the machine's law.
    laws : str
        See `hexathermal.learn.machine_diagnosis.law_columns`.
    candidates : tuple of Candidate
    prior : array, shape (c,)
        Log prior of each candidate.
    noise : PoseNoise
    tables : Tables
    finer : tuple of Candidate
        Those that are tried at more values of their setting; these stand behind all others.
    """

    view: MachineView
    y: FloatArray
    laws: str
    candidates: tuple[Candidate, ...]
    prior: FloatArray
    noise: PoseNoise
    tables: Tables
    finer: tuple[Candidate, ...] = ()

    def named(self, which: int) -> bool:
        """Whether a candidate is of a catalogue."""
        return bool(self.candidates[which].units[0])


def case_of(rows: HexapodRows, laws: str = "kept", start: FloatArray | None = None) -> Case:
    """Return the case of a campaign's rows.

    Parameters
    ----------
    rows : HexapodRows
    laws : str
        ``"kept"`` or ``"refit"``.
    start : array, shape (6,), optional [m, rad]
        First guess of the coordinates' noise.
    """
    view, y = leg_residuals(rows, rows.hexapod)
    return _made(view, y, laws, start, None)


def with_exchanged(case: Case, hexapod: Hexapod) -> Case:
    """Return a case with a machine whose legs read other thermometers; the noise stays."""
    view = case.view.with_hexapod(hexapod)
    y = case.y + case.view.law_drift - view.law_drift
    return _made(view, y, case.laws, None, case.noise, case.finer)


def with_finer(case: Case, one: Candidate) -> Case:
    """Return a case in which a candidate is tried at more values of its setting; numbers of the others stay."""
    return _made(case.view, case.y, case.laws, None, case.noise, (*case.finer, one))


def _made(
    view: MachineView, y: FloatArray, laws: str, start: FloatArray | None, noise: PoseNoise | None,
    finer: tuple[Candidate, ...] = (),
) -> Case:  # fmt: skip
    """Return a case; the noise is found where none is given."""
    law = law_columns(view, laws)
    told = y - law.known
    own = (*single_leg_candidates(view), *sensor_candidates(view))
    candidates = (*all_candidates(view), *own, *flexible_candidates(view))
    if noise is None:
        noise = pose_noise(view, told, law.columns, candidates, first_noise(view, told) if start is None else start)
    candidates += (*wide_candidates(view), *(part for one in finer for part in finer_candidates(view, one)))
    tables = tables_of(view, told, noise.coordinates, noise.weight, law.columns, [one.columns for one in candidates])
    return Case(view, y, laws, candidates, _priors(candidates), noise, tables, finer)


def first_noise(view: MachineView, y: FloatArray) -> FloatArray:
    """Return a rough noise of the coordinates: robust spread within runs."""
    e = coordinates_of(view, y)
    for run in np.unique(view.run):
        own = view.run == run
        e[own] -= np.median(e[own], axis=0)
    return np.maximum(np.median(np.abs(e), axis=0) / 0.6745, SMALLEST_NOISE)


def _priors(candidates: Sequence[Candidate]) -> FloatArray:
    """Return the log prior of each candidate: causes are as likely, and within a cause its places."""
    own = set(catalogue())
    weight = np.ones(len(candidates))
    groups: dict[str, list[int]] = {}
    for k, one in enumerate(candidates):
        group = one.cause if one.units[0] else "nameless"
        groups.setdefault(group, []).append(k)
        if one.cause == "tracker-drift" and one.target != AIR:
            weight[k] = OF_A_PLATE
    for group, which in groups.items():
        share = 1.0 if group in own else NAMELESS if group == "nameless" else OF_ONE_LEG
        weight[which] *= share / weight[which].sum()
    return np.asarray(np.log(weight / weight.sum()))
