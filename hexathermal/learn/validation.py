"""The proof on runs never fitted: residuals, reductions with intervals, coverage of the prediction intervals.

Landings are the independent units, of a run of one landing its hours, and runs above them;
`hexathermal.learn.validation_scores` tells how intervals are made. A law that makes the drift worse is found and said;
so is a run whose rows were fitted, by its fingerprint. Memory does not grow with the rows of a run: beyond
`MOST_LANDINGS`, neighbouring landings are taken together.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from enum import Enum

import numpy as np
import numpy.typing as npt

from hexathermal.errors import DataError, UnknownNameError
from hexathermal.learn.campaign import Block
from hexathermal.learn.coverage import TWO_SIDED
from hexathermal.learn.law import IdentifiedLaw
from hexathermal.learn.merged_sums import MergedSums
from hexathermal.learn.row_fingerprints import RowFingerprints
from hexathermal.learn.validation_motion import AFTER_MOVE_S, MotionGroup, RunMotion, motion_groups
from hexathermal.learn.validation_scores import DRAWS as DRAWS
from hexathermal.learn.validation_scores import LARGEST, Scores, scores
from hexathermal.learn.validation_scores import Figure as Figure
from hexathermal.machine.leg_repairs import repaired
from hexathermal.machine.leg_signals import LegSignals
from hexathermal.machine.leg_states import sensors_of
from hexathermal.machine.shown import Shown
from hexathermal.machine.thermal import frozen
from hexathermal.poses import FloatArray

SEED = 20260101
CURVE_POINTS = 3000
"""Points of a run that are kept for its figure; longer runs are thinned evenly."""

MOST_LANDINGS = 1024
"""Landings of a run that are held apart."""

STRETCH_S = 3600.0
"""Of a run of one landing, so long stretches stand for landings [s]: a part that never moves has no others."""

TRIFLE = 0.02
"""Part of the drift by which a law may make it worse, within its interval, without being called so."""


@dataclass(frozen=True, eq=False)
class Predicted:
    """What a law says of rows: dT of its sensors (n, k) [K] as it reads them, drift [m] and variance [m^2] (n,)."""

    dT: FloatArray
    drift: FloatArray
    variance: FloatArray


Predictor = Callable[[Block], Predicted]
"""From complete rows to what a law says of them."""


class Verdict(Enum):
    """What the runs left out of the fit say about a law."""

    BETTER = "makes it better"
    UNPROVEN = "no gain proven"
    WORSE = "makes it worse"
    FITTED = "nothing proven: every run was fitted"


@dataclass(frozen=True, eq=False)
class RunCurves:
    """A run as its figure shows it: time [s], q [m], dT of the law's sensors [K], drift measured and predicted [m].

    `half_width` is that of the 95 % prediction interval [m].
    """

    run: str
    time: FloatArray
    q: FloatArray | None
    dT: FloatArray
    measured: FloatArray
    predicted: FloatArray
    half_width: FloatArray


@dataclass(frozen=True, eq=False, repr=False)
class Validation(Shown):
    """What the validation found.

    Runs that were fitted have their own scores, but count in `total`, `verdict`, `coverage`, `rows`, `motion` and
    `outside` only where every run was fitted.

    Attributes
    ----------
    runs : dict of str to Scores
    total : Scores
    verdict : Verdict
    coverage : float
        Part of the rows inside their 95 % prediction interval.
    run_coverage : dict of str to float
    rows : int
    motion : tuple of MotionGroup
    outside : dict of str to float
        Parts of the rows beyond the law's range: ``dT``, ``q``.
    curves : tuple of RunCurves
    notes : tuple of str
    half_width : float [m]
        Mean half-width of the 95 % prediction intervals.
    fitted : dict of str to str
        Runs whose rows were fitted, and the names that they had then.
    fits_known : bool
        Whether the law tells which tables it was fitted to.
    landings : dict of str to array, shape (landings, columns)
        Sums of each run's landings, columns as in `hexathermal.learn.validation_scores`.
    """

    runs: dict[str, Scores]
    total: Scores
    verdict: Verdict
    coverage: float
    run_coverage: dict[str, float]
    rows: int
    motion: tuple[MotionGroup, ...]
    outside: dict[str, float]
    curves: tuple[RunCurves, ...]
    notes: tuple[str, ...]
    half_width: float = float("nan")
    fitted: dict[str, str] = field(default_factory=dict)
    fits_known: bool = False
    landings: dict[str, FloatArray] = field(default_factory=dict)

    def __repr__(self) -> str:
        left, drift = self.total.rmse.value * 1e6, self.total.drift_rms * 1e6
        return f"Validation: {self.verdict.value}; RMS {drift:.3f} um of drift, {left:.3f} um left, {self.rows} rows"


@dataclass(frozen=True, eq=False)
class LandingsJudged:
    """Sums of the landings of runs, and runs that were fitted, as `Validation` has them."""

    landings: dict[str, FloatArray]
    fitted: dict[str, str]


def _summed(rows: list[FloatArray], edges: npt.NDArray[np.int64]) -> FloatArray:
    """Return sums of rows from edge to edge, and the largest of `LARGEST`, shape (k, columns)."""
    table = np.column_stack(rows)
    sums = np.add.reduceat(table, edges, axis=0)
    sums[:, LARGEST] = np.maximum.reduceat(table[:, LARGEST], edges, axis=0)
    return np.asarray(sums)


class _Run:
    """Sums of one run: of its landings (`SUMS`, `LARGEST`, covered, half-width), of motion, and its thinned curves."""

    def __init__(self) -> None:
        self.landings, self.stretches = (MergedSums(9, MOST_LANDINGS, LARGEST) for _kind in range(2))
        self.motion = RunMotion()
        self.outside = np.zeros(2)
        self.curves: list[FloatArray] = []
        self.step, self.seen = 1, 0
        self._number, self._last, self._begun = -1, -1, 0.0

    def add(self, law: IdentifiedLaw, block: Block, said: Predicted) -> None:
        """Add complete rows."""
        time, q, drift = block.time, block.q, block.drift
        dT, predicted = said.dT, said.drift
        e, half = drift - predicted, law.factor * np.sqrt(said.variance)
        edges = np.flatnonzero(np.concatenate([[True], np.diff(block.landing) != 0]))
        goes_on = self._number >= 0 and block.landing[0] == self._last
        numbers = self._number + np.arange(len(edges)) + (0 if goes_on else 1)
        begun = time[edges].copy()
        if goes_on:
            begun[0] = self._begun
        age = time - np.repeat(begun, np.diff(np.append(edges, len(time))))
        size, whole = np.abs(e), np.ones(len(e))
        rows = [whole, e**2, size, size, drift**2, np.abs(drift), np.abs(drift), size <= half, half]
        self.landings.add(numbers, _summed(rows, edges))
        if numbers[-1] == 0:  # one landing so far
            stretch = np.floor(age / STRETCH_S).astype(np.int64)
            begins = np.flatnonzero(np.concatenate([[True], np.diff(stretch) != 0]))
            self.stretches.add(stretch[begins], _summed(rows, begins))
        young, old = age < AFTER_MOVE_S[0], age >= AFTER_MOVE_S[1]
        moved = np.add.reduceat(np.column_stack([whole, e, young, young * e, old, old * e]), edges, axis=0)
        first_q = np.zeros(len(edges)) if q is None else q[edges]
        self.motion.add(numbers, np.column_stack([moved, first_q]))
        self._number, self._last, self._begun = int(numbers[-1]), int(block.landing[-1]), float(begun[-1])
        self.outside += _beyond(law, dT, q)
        self._keep(np.column_stack([time, np.zeros(len(time)) if q is None else q, drift, predicted, half, dT]))

    @property
    def units(self) -> FloatArray:
        """Sums of landings; of one landing alone, those of its stretches."""
        table = self.stretches.table if len(self.landings.table) == 1 else self.landings.table
        return np.asarray(table[table[:, 0] > 0.0])

    def _keep(self, table: FloatArray) -> None:
        """Keep rows for the figure, every other one where there are too many."""
        self.curves.append(table[-self.seen % self.step :: self.step])
        self.seen += len(table)
        while sum(map(len, self.curves)) > 2 * CURVE_POINTS:
            self.curves = [np.concatenate(self.curves)[::2]]
            self.step *= 2

    def drawn(self, name: str, law: IdentifiedLaw) -> RunCurves:
        """Return what the run's figure shows."""
        table = np.concatenate(self.curves)
        q = table[:, 1] if law.stroked else None
        return RunCurves(name, table[:, 0], q, table[:, 5:], table[:, 2], table[:, 3], table[:, 4])


def _some(block: Block, good: npt.NDArray[np.bool_]) -> Block:
    """Return some rows of a block."""
    q = None if block.q is None else block.q[good]
    return Block(block.run, block.time[good], block.dT[good], block.drift[good], q, block.landing[good],
                 block.inputs[good], block.air[good])  # fmt: skip


def _readable(law: IdentifiedLaw, block: Block, sensors: Sequence[str]) -> npt.NDArray[np.bool_]:
    """Return in which rows all temperatures that the law reads have values, behind its repairs."""
    dT = {name: block.dT[:, k] for k, name in enumerate(sensors)}
    at_once = [repair for repair in law.repairs if repair.kind != "clock"]
    if at_once:
        # gaps of the air are filled where the law predicts; whatever the zero is, it has a value
        signals = LegSignals(block.time, dT, block.time, air=np.zeros(len(block)), zero_degC=dict.fromkeys(dT, 0.0))
        dT = dict(repaired(signals, at_once, block.run.name).dT)
    needed = [dT[name] for name in dict.fromkeys((*law.sensors, *sensors_of(law.terms)))]
    return np.asarray(np.isfinite(np.column_stack(needed)).all(axis=1))


def _beyond(law: IdentifiedLaw, dT: FloatArray, q: FloatArray | None) -> FloatArray:
    """Return how many rows lie beyond the law's range of dT and of q."""
    low, high = law.validity.dT[:, 0], law.validity.dT[:, 1]
    span = law.validity.q
    far_q = 0 if q is None or span is None else ((q < span[0] - 1e-6) | (q > span[1] + 1e-6)).sum()
    return np.array([((dT < low) | (dT > high)).any(axis=1).sum(), far_q], dtype=np.float64)


def at_once(law: IdentifiedLaw, sensors: Sequence[str]) -> Predictor:
    """Return what predicts each row of a block by itself; `sensors` are the columns of ``Block.dT``."""
    chosen = [list(sensors).index(name) for name in law.sensors]

    def said(block: Block) -> Predicted:
        dT = block.dT[:, chosen]
        return Predicted(dT, law.predict(dT, block.q), law.variance(dT, block.q, block.time))

    return said


def validate(
    law: IdentifiedLaw, blocks: Iterable[Block], sensors: Sequence[str], predictor: Predictor | None = None
) -> Validation:
    """Return how a law predicts runs that it was not fitted to.

    Parameters
    ----------
    law : IdentifiedLaw
    blocks : iterable of Block
        Of the runs for validation.
    sensors : sequence of str
        Names of the columns of ``Block.dT``.
    predictor : function, optional
        Predicts complete rows where a row by itself is not enough: for a law with terms or repairs, see
        `hexathermal.learn.validation_rows`.

    Raises
    ------
    UnknownNameError
        The campaign lacks a sensor of the law.
    ArgumentError
        A law with terms has no `predictor`.
    DataError
        There are no rows, or a law that reads q meets a run without it.
    """
    return _summary(law, *_gathered(law, blocks, sensors, predictor))


def landings_judged(
    law: IdentifiedLaw, blocks: Iterable[Block], sensors: Sequence[str], predictor: Predictor | None = None
) -> LandingsJudged:
    """Return what `validate` gathers, without its scores: enough for `hexathermal.learn.validation_gain.gain`."""
    runs, fitted, _lost = _gathered(law, blocks, sensors, predictor)
    return LandingsJudged({name: frozen(run.units) for name, run in runs.items()}, fitted)


def _gathered(
    law: IdentifiedLaw, blocks: Iterable[Block], sensors: Sequence[str], predictor: Predictor | None
) -> tuple[dict[str, _Run], dict[str, str], int]:
    """Return the sums of runs, those that were fitted and their names then, and how many rows were not read."""
    for name in law.read_sensors:
        if name not in sensors:
            raise UnknownNameError(
                f"the law reads sensor {name!r}, which the campaign does not have; it has {', '.join(sensors)}",
                tuple(sensors),
            )
    predicted = at_once(law, sensors) if predictor is None else predictor
    runs: dict[str, _Run] = {}
    marks, lost = RowFingerprints(), 0
    for block in marks.passing(blocks):
        if law.stroked and block.q is None:
            raise DataError(f"run {block.run.name} has no displacement q_mm, which the law of this {law.kind} needs")
        good = _readable(law, block, sensors) & np.isfinite(block.drift)
        if block.q is not None:
            good &= np.isfinite(block.q)
        lost += int((~good).sum())
        if good.any():
            kept = block if good.all() else _some(block, good)
            runs.setdefault(block.run.name, _Run()).add(law, kept, predicted(kept))
    if not runs:
        raise DataError(
            'there is no row to validate on: a campaign needs runs with role = "validation", never fitted, in which '
            "the law's sensors have values"
        )
    known = dict(zip(law.origin.run_fingerprints, law.origin.runs, strict=False))
    fitted = {name: known[mark] for name, mark in marks.made().items() if mark in known and name in runs}
    return runs, fitted, lost


def _summary(law: IdentifiedLaw, runs: dict[str, _Run], fitted: dict[str, str], lost: int) -> Validation:
    """Return the validation of gathered runs."""
    rng = np.random.default_rng(SEED)
    judged = {name: run for name, run in runs.items() if name not in fitted} or runs
    for run in runs.values():
        run.motion.finish()
    total = scores([run.units for run in judged.values()], rng)
    each = {name: scores([run.units], rng) for name, run in runs.items()}
    sums = {name: run.units.sum(axis=0) for name, run in runs.items()}
    whole = np.array([sums[name] for name in judged]).sum(axis=0)
    outside = np.array([run.outside for run in judged.values()]).sum(axis=0) / whole[0]
    beyond = {"dT": float(outside[0]), "q": float(outside[1])}
    motion = motion_groups(run.motion for run in judged.values()) if law.stroked else ()
    halves = {name: float(row[8] / row[0]) for name, row in sums.items()}
    notes = (*_notes(each, beyond, halves), *_doubts(law, runs, fitted, lost))
    notes += tuple(
        f"{group.name}: mean residual {group.mean * 1e6:+.3f} +- {TWO_SIDED * group.uncertainty * 1e6:.3f} um"
        for group in motion
        if group.notable
    )
    return Validation(
        each, total, _verdict(total, len(fitted) == len(runs)), float(whole[7] / whole[0]),
        {name: float(row[7] / row[0]) for name, row in sums.items()}, int(whole[0]), motion, beyond,
        tuple(run.drawn(name, law) for name, run in runs.items()), notes, float(whole[8] / whole[0]), fitted,
        bool(law.origin.run_fingerprints), {name: frozen(run.units) for name, run in runs.items()},
    )  # fmt: skip


def _verdict(total: Scores, all_fitted: bool) -> Verdict:
    """Return the verdict of scores: worse beyond doubt or by more than a trifle, better beyond doubt, or neither."""
    gain = total.rms_reduction
    if gain.value < 0.0 and (gain.high < 0.0 or gain.value < -TRIFLE):
        return Verdict.WORSE
    if all_fitted:
        return Verdict.FITTED
    return Verdict.BETTER if gain.low > 0.0 else Verdict.UNPROVEN


def _notes(each: dict[str, Scores], beyond: dict[str, float], halves: dict[str, float]) -> list[str]:
    """Return what the scores say beside themselves."""
    notes = []
    worse = [name for name, one in each.items() if one.rms_reduction.value < 0.0]
    if worse:
        notes.append(
            f"over-correction: in {', '.join(worse)} the drift with correction is larger (RMS) than without; the law "
            "corrects for warmth that does not move this part, or its zero is wrong"
        )
    wide = [f"{name} (+-{half * 1e6:.2f} um on average, largest drift {each[name].drift_largest * 1e6:.2f} um)"
            for name, half in halves.items() if half > each[name].drift_largest]  # fmt: skip
    if wide:
        notes.append(
            f"prediction intervals wider than the largest drift in {', '.join(wide)}: that rows lie inside them says "
            "nothing about the law"
        )
    for key, part in beyond.items():
        if part > 0.0:
            text = f"{100.0 * part:.1f}" if part >= 0.001 else "below 0.1"
            notes.append(f"{text} % of the rows lie beyond the law's range of {key}: there it extrapolates")
    return notes


def _doubts(law: IdentifiedLaw, runs: dict[str, _Run], fitted: dict[str, str], lost: int) -> list[str]:
    """Return what speaks against the runs."""
    notes = []
    if lost:
        notes.append(f"{lost} rows were left out: a sensor of the law has no value there")
    if not law.origin.run_fingerprints:
        same = sorted(set(runs) & set(law.origin.runs))
        alike = (
            f"; a run of the same name was: {', '.join(same)}, which proves nothing if it is the same" if same else ""
        )
        notes.append(
            f"whether these runs were fitted cannot be told, for the law holds no fingerprints of its runs{alike}"
        )
    if fitted and len(fitted) < len(runs):
        notes.append(f"{', '.join(fitted)}: fitted, and left out of the verdict and of what is said of all runs")
    return notes
