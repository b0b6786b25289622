"""What the residual of a machine can be held against, row for row: pose, displacements, directions, temperatures."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hexathermal.learn.campaign import Campaign
from hexathermal.learn.hexapod_data import AXES, HexapodRows
from hexathermal.learn.machine_diagnosis.gain import MachineResidual, without_motion
from hexathermal.learn.machine_diagnosis.result import MachineDiagnosis
from hexathermal.learn.machine_diagnosis.view import MachineView, machine_view
from hexathermal.learn.machine_proposal import diagnosed_rows
from hexathermal.machine.leg_signals import Memory
from hexathermal.poses import FloatArray, coordinates_from_pose
from hexathermal.show.diagnosis_run_figures import BINS, binned
from hexathermal.show.machine_words import framed_out

UM = 1e6
CHANCE = 2e-4
"""Of a share that is no share: some 450 are looked at in one report."""

POSE_UNITS = ("mm",) * 3 + ("°",) * 3


@dataclass(frozen=True, eq=False)
class Signal:
    """Something that a residual may follow, in all rows of all runs.

    Attributes
    ----------
    name, label, unit : str
        `name` is that of files; `label` what people call it.
    values : array, shape (n,) or (n, 6)
        One for all, or each leg's own; NaN where it is not known. In `unit`.
    """

    name: str
    label: str
    unit: str
    values: FloatArray

    @property
    def each_leg(self) -> bool:
        """Whether every leg has its own."""
        return self.values.ndim == 2

    @property
    def short(self) -> str:
        """The label without what goes without saying."""
        return _without(self.label, " since the zero", "commanded ", " since the run began")

    @property
    def shortest(self) -> str:
        """The label where there is little room."""
        return self.name.replace("temperature", "temp.").replace("-", " ")

    @property
    def axis(self) -> str:
        """The words of an axis."""
        return f"{self.label} ({self.unit})" if self.unit else self.label


@dataclass(frozen=True, eq=False)
class Pooled:
    """All rows of all runs, one run behind the other.

    Attributes
    ----------
    run : array, shape (n,), int
    signals : tuple of Signal
        Those that vary.
    before, after : array, shape (n, 12) [um, urad]
        Residual of six coordinates and six legs.
    runs : tuple of MachineResidual
        The runs as they are shown.
    """

    run: FloatArray
    signals: tuple[Signal, ...]
    before: FloatArray
    after: FloatArray
    runs: tuple[MachineResidual, ...]

    def signal(self, name: str) -> Signal | None:
        """Return a signal, None where it does not vary."""
        return next((one for one in self.signals if one.name == name), None)


def pooled(campaign: Campaign, found: MachineDiagnosis) -> Pooled:
    """Return residuals and signals of all runs of a diagnosis.

    Where the measuring frame differs between runs, each run counts without the rigid motion that suits it best: else
    that alone would be seen, and its turn as something that follows the pose.
    """
    parts: list[dict[str, FloatArray]] = []
    runs: list[MachineResidual] = []
    views: dict[str, tuple[HexapodRows, MachineView]] = {}
    for one in found.residuals:
        if one.role not in views:
            rows = diagnosed_rows(campaign, found, one.role)
            views[one.role] = rows, machine_view(rows)
        rows, view = views[one.role]
        parts.append(_values(rows, view, one))
        runs.append(_freed(view, _kept(rows, one), one) if framed_out(found) else one)
    both = [
        np.concatenate([np.concatenate(pair, axis=1) for pair in each]) * UM
        for each in ([(run.before, run.legs_before) for run in runs], [(run.after, run.legs_after) for run in runs])
    ]
    told = _told()
    signals = [Signal(name, *told[name], np.concatenate([part[name] for part in parts])) for name in told]
    count = np.concatenate([np.full(len(run.time), k) for k, run in enumerate(found.residuals)])
    return Pooled(count, tuple(one for one in signals if _varies(one.values)), both[0], both[1], tuple(runs))


def _without(text: str, *words: str) -> str:
    """Return a text without some words."""
    for one in words:
        text = text.replace(one, "")
    return text


def _told() -> dict[str, tuple[str, str]]:
    """Return labels and units by name."""
    return {
        "time": ("time since the run began", "h"),
        **{axis: (f"commanded {axis}", unit) for axis, unit in zip(AXES, POSE_UNITS, strict=True)},
        "length": ("displacement of the leg", "mm"),
        "direction": ("direction of the leg's last move", ""),
        "leg-temperature": ("temperature of the leg since the zero", "K"),
        "platform-temperature": ("temperature of the platform since the zero", "K"),
        "base-temperature": ("temperature of the base since the zero", "K"),
        "air-temperature": ("temperature of the air since the zero", "K"),
    }


def _values(rows: HexapodRows, view: MachineView, run: MachineResidual) -> dict[str, FloatArray]:
    """Return the signals of a run, in the rows that a diagnosis kept."""
    own, keep = np.flatnonzero(rows.run == rows.runs.index(run.run)), _kept(rows, run)
    pose = coordinates_from_pose(rows.commanded[keep], hexapod=rows.hexapod)
    direction = np.column_stack([Memory().direction(rows.q[own, leg]) for leg in range(6)])
    heat = view.heat.mean(axis=2)
    return {
        "time": run.time / 3600.0,
        **{axis: pose[:, k] for k, axis in enumerate(AXES)},
        "length": rows.q[keep] * 1e3,
        "direction": np.where(direction == 0.0, np.nan, direction)[keep - own[0]],  # 0: no move yet
        "leg-temperature": heat[keep],
        "platform-temperature": view.plates[keep, 0],
        "base-temperature": view.plates[keep, 1],
        "air-temperature": view.air[keep],
    }


def _kept(rows: HexapodRows, run: MachineResidual) -> FloatArray:
    """Return the numbers of the rows of a run that a diagnosis kept."""
    own = np.flatnonzero(rows.run == rows.runs.index(run.run))
    return np.asarray(own[np.searchsorted(rows.time[own], run.time)])


def _freed(view: MachineView, keep: FloatArray, run: MachineResidual) -> MachineResidual:
    """Return what is left in a run without the measuring frame's own motion in it."""
    before, legs_before = without_motion(view, keep, run.legs_before)
    after, legs_after = without_motion(view, keep, run.legs_after)
    return replace(run, before=before, after=after, legs_before=legs_before, legs_after=legs_after)


def _varies(values: FloatArray) -> bool:
    """Whether a signal is known somewhere and is not constant."""
    known = values[np.isfinite(values)]
    return bool(len(known)) and float(np.ptp(known)) > 1e-9


def share(signal: FloatArray, residual: FloatArray) -> float:
    """Return the part of a residual's variance that follows a signal: by means of parts, freed of what chance gives.

    ``1 - (1 - R^2) (n - 1) / (n - k)`` (adjusted coefficient of determination); 0 where chance alone gives such an
    ``R^2`` in more than `CHANCE` of cases: without a cause it is distributed as ``Beta((k - 1) / 2, (n - k) / 2)``.
    """
    from scipy.special import betainc

    known = np.isfinite(signal) & np.isfinite(residual)
    n = int(known.sum())
    if n <= 2 * BINS or not float(np.ptp(signal[known])) > 0.0:
        return 0.0
    x, _y, part = binned(signal[known], residual[known])
    k = len(x)
    if k < 2 or float(betainc((n - k) / 2.0, (k - 1) / 2.0, 1.0 - part)) > CHANCE:
        return 0.0
    return float(max(0.0, 1.0 - (1.0 - part) * (n - 1) / (n - k)))


def shares(all_of: Pooled, residual: FloatArray) -> FloatArray:
    """Return the share of each coordinate's and leg's residual that follows each signal, shape (signals, 12).

    A coordinate is held against each leg's signal, and has the largest of the six.
    """
    found = np.zeros((len(all_of.signals), 12))
    for k, signal in enumerate(all_of.signals):
        for j in range(12):
            if not signal.each_leg:
                found[k, j] = share(signal.values, residual[:, j])
            else:
                found[k, j] = share(signal.values[:, followed_leg(signal, residual, j)], residual[:, j])
    return found


def followed_leg(signal: Signal, residual: FloatArray, column: int) -> int:
    """Return the leg (0 to 5) whose signal a residual follows most; a leg's residual is held against its own."""
    if column >= 6:
        return column - 6
    return int(np.argmax([share(signal.values[:, leg], residual[:, column]) for leg in range(6)]))
