"""The proof on runs never fitted: residuals, reductions with intervals, coverage of the prediction intervals.

Landings are the independent units, and runs above them: intervals of RMSE, largest residual and reductions come from a
bootstrap that draws runs and, within each, landings. A law that makes the drift worse is found and said.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from enum import Enum

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError, UnknownNameError
from hexathermal.learn.campaign import Block
from hexathermal.learn.law import IdentifiedLaw
from hexathermal.poses import FloatArray

DRAWS = 2000
SEED = 20260101
CURVE_POINTS = 3000
"""Points of a run that are kept for its figure; longer runs are thinned evenly."""

AFTER_MOVE_S = (60.0, 300.0)
"""Ages of a landing that residuals are compared between: younger than the first, older than the second [s]."""


class Verdict(Enum):
    """What the runs left out of the fit say about a law."""

    BETTER = "makes it better"
    UNPROVEN = "no gain proven"
    WORSE = "makes it worse"


@dataclass(frozen=True)
class Figure:
    """A number with its 95 % interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Scores:
    """What a law leaves of the drift, with 95 % intervals.

    Attributes
    ----------
    rmse, linf, mean : Figure [m]
        Root mean square, largest and mean absolute residual.
    drift_rms, drift_largest, drift_mean : float [m]
    mean_reduction, largest_reduction, rms_reduction : Figure
        ``1 - residual / drift``; negative where the law makes it worse.
    """

    rmse: Figure
    linf: Figure
    mean: Figure
    drift_rms: float
    drift_largest: float
    drift_mean: float
    mean_reduction: Figure
    largest_reduction: Figure
    rms_reduction: Figure


@dataclass(frozen=True)
class MotionGroup:
    """Mean residual of some landings: what they have in common, how many, the mean and its uncertainty [m]."""

    name: str
    landings: int
    mean: float
    uncertainty: float

    @property
    def notable(self) -> bool:
        """Whether the mean differs from zero by more than three standard uncertainties."""
        return self.landings > 3 and abs(self.mean) > 3.0 * self.uncertainty


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


@dataclass(frozen=True, eq=False)
class Validation:
    """What the validation found.

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


@dataclass
class _Run:
    """Sums of one run, one row for each landing: n, e^2, |e|, max |e|, y^2, |y|, max |y|, covered, sum e, q."""

    landings: dict[int, FloatArray] = field(default_factory=dict)
    started: dict[int, float] = field(default_factory=dict)
    young: dict[int, FloatArray] = field(default_factory=dict)
    old: dict[int, FloatArray] = field(default_factory=dict)
    curves: list[FloatArray] = field(default_factory=list)
    step: int = 1
    seen: int = 0


def validate(law: IdentifiedLaw, blocks: Iterable[Block], sensors: Sequence[str]) -> Validation:
    """Return how a law predicts runs that it was not fitted to.

    Parameters
    ----------
    law : IdentifiedLaw
    blocks : iterable of Block
        Of the runs for validation.
    sensors : sequence of str
        Names of the columns of ``Block.dT``.

    Raises
    ------
    UnknownNameError
        The campaign lacks a sensor of the law.
    ArgumentError
        There are no rows; a leg's law meets a part without q; a run was fitted.
    """
    for name in law.sensors:
        if name not in sensors:
            raise UnknownNameError(
                f"the law reads sensor {name!r}, which the campaign does not have; it has {', '.join(sensors)}",
                tuple(sensors),
            )
    chosen = [list(sensors).index(name) for name in law.sensors]
    runs: dict[str, _Run] = {}
    outside, rows, lost = np.zeros(2), 0, 0
    for block in blocks:
        if law.kind == "leg" and block.q is None:
            raise ArgumentError(f"run {block.run.name} has no displacement q_mm, which a leg's law needs")
        dT = block.dT[:, chosen]
        good = np.isfinite(dT).all(axis=1) & np.isfinite(block.drift)
        if block.q is not None:
            good &= np.isfinite(block.q)
        lost += int((~good).sum())
        if not good.any():
            continue
        run = runs.setdefault(block.run.name, _Run())
        q = None if block.q is None else block.q[good]
        rows += int(good.sum())
        outside += _add(run, law, dT[good], q, block.time[good], block.drift[good], block.landing[good])
    if not runs:
        raise ArgumentError(
            'there is no row to validate on: a campaign needs runs with role = "validation", never fitted, in which '
            "the law's sensors have values"
        )
    return _summary(law, runs, outside / rows, rows, lost)


def _add(
    run: _Run,
    law: IdentifiedLaw,
    dT: FloatArray,
    q: FloatArray | None,
    time: FloatArray,
    drift: FloatArray,
    landing: npt.NDArray[np.int64],
) -> FloatArray:
    """Add rows to a run's sums; returns how many lie beyond the law's range of dT and of q."""
    predicted = law.predict(dT, q)
    e = drift - predicted
    half = law.factor * np.sqrt(law.variance(dT, q, time))
    covered = np.abs(e) <= half
    for number in np.unique(landing):
        here = landing == number
        begun = run.started.setdefault(int(number), float(time[here][0]))
        age = time[here] - begun
        parts = np.array([here.sum(), (e[here] ** 2).sum(), np.abs(e[here]).sum(), np.abs(e[here]).max(),
                          (drift[here] ** 2).sum(), np.abs(drift[here]).sum(), np.abs(drift[here]).max(),
                          covered[here].sum(), e[here].sum(), 0.0 if q is None else q[here][0]])  # fmt: skip
        before = run.landings.get(int(number))
        if before is not None:
            largest = np.maximum(before[[3, 6]], parts[[3, 6]])
            first_q, parts = before[9], before + parts
            parts[[3, 6]], parts[9] = largest, first_q
        run.landings[int(number)] = parts
        for ages, mask in ((run.young, age < AFTER_MOVE_S[0]), (run.old, age >= AFTER_MOVE_S[1])):
            if mask.any():
                ages[int(number)] = ages.get(int(number), np.zeros(2)) + [mask.sum(), e[here][mask].sum()]
    _keep(run, np.column_stack([time, np.zeros(len(time)) if q is None else q, drift, predicted, half, dT]))
    low, high = law.validity.dT[:, 0], law.validity.dT[:, 1]
    far_dT = ((dT < low) | (dT > high)).any(axis=1).sum()
    span = law.validity.q
    far_q = 0 if q is None or span is None else ((q < span[0] - 1e-6) | (q > span[1] + 1e-6)).sum()
    return np.array([far_dT, far_q], dtype=np.float64)


def _keep(run: _Run, table: FloatArray) -> None:
    """Keep rows for the figure, every other one where there are too many."""
    first = -run.seen % run.step
    run.curves.append(table[first :: run.step])
    run.seen += len(table)
    while sum(map(len, run.curves)) > 2 * CURVE_POINTS:
        run.curves = [np.concatenate(run.curves)[::2]]
        run.step *= 2


def _summary(law: IdentifiedLaw, runs: dict[str, _Run], outside: FloatArray, rows: int, lost: int) -> Validation:
    """Return the validation of gathered runs."""
    tables = {name: np.array([run.landings[k] for k in sorted(run.landings)]) for name, run in runs.items()}
    rng = np.random.default_rng(SEED)
    total = _scores(list(tables.values()), rng)
    each = {name: _scores([table], rng) for name, table in tables.items()}
    inside = {name: float(table[:, 7].sum() / table[:, 0].sum()) for name, table in tables.items()}
    gain = total.rms_reduction
    verdict = Verdict.UNPROVEN
    if gain.value < 0.0:
        verdict = Verdict.WORSE
    elif gain.low > 0.0:
        verdict = Verdict.BETTER
    notes = []
    worse = [name for name, one in each.items() if one.rms_reduction.value < 0.0]
    if worse:
        notes.append(
            f"over-correction: in {', '.join(worse)} the drift with correction is larger (RMS) than without; the law "
            "corrects for warmth that does not move this part, or its zero is wrong"
        )
    beyond = {"dT": float(outside[0]), "q": float(outside[1])}
    for key, part in beyond.items():
        if part > 0.0:
            text = f"{100.0 * part:.1f}" if part >= 0.001 else "below 0.1"
            notes.append(f"{text} % of the rows lie beyond the law's range of {key}: there it extrapolates")
    if lost:
        notes.append(f"{lost} rows were left out: a sensor of the law has no value there")
    fitted = sorted(set(runs) & set(law.origin.runs))
    if fitted:
        notes.append(
            f"a run of the same name was fitted: {', '.join(fitted)}; if it is the same run, this proves nothing"
        )
    motion = _motion(runs) if law.kind == "leg" else ()
    notes += [f"{group.name}: mean residual {group.mean * 1e6:+.3f} +- {1.96 * group.uncertainty * 1e6:.3f} um"
              for group in motion if group.notable]  # fmt: skip
    covered = sum(float(table[:, 7].sum()) for table in tables.values()) / rows
    curves = tuple(_curves(name, run, law) for name, run in runs.items())
    return Validation(each, total, verdict, covered, inside, rows, motion, beyond, curves, tuple(notes))


def _curves(name: str, run: _Run, law: IdentifiedLaw) -> RunCurves:
    """Return what a run's figure shows."""
    table = np.concatenate(run.curves)
    q = table[:, 1] if law.kind == "leg" else None
    return RunCurves(name, table[:, 0], q, table[:, 5:], table[:, 2], table[:, 3], table[:, 4])


def _measures(table: FloatArray, counts: FloatArray) -> FloatArray:
    """Return RMSE, largest and mean |e|, then RMS, largest and mean of the drift, for draws of landings."""
    n = counts @ table[:, 0]
    drawn = counts > 0
    largest = [np.where(drawn, table[:, k], 0.0).max(axis=-1) for k in (3, 6)]
    return np.stack([
        np.sqrt(counts @ table[:, 1] / n), largest[0], counts @ table[:, 2] / n,
        np.sqrt(counts @ table[:, 4] / n), largest[1], counts @ table[:, 5] / n,
    ])  # fmt: skip


def _scores(tables: list[FloatArray], rng: np.random.Generator) -> Scores:
    """Return the scores of runs, with intervals from drawing runs and landings."""
    table = np.concatenate(tables)
    now = _measures(table, np.ones(len(table)))
    counts = np.zeros((DRAWS, len(table)))
    start = np.cumsum([0, *map(len, tables)])
    drawn = rng.multinomial(len(tables), np.full(len(tables), 1.0 / len(tables)), size=DRAWS)
    for r, one in enumerate(tables):
        n = len(one)
        # a run drawn twice has its landings drawn twice
        counts[:, start[r] : start[r + 1]] = rng.multinomial(drawn[:, r] * n, np.full(n, 1.0 / n))
    m = _measures(table, counts)

    def figure(value: float, draws: FloatArray) -> Figure:
        low, high = np.quantile(draws, [0.025, 0.975])
        return Figure(float(value), float(min(low, value)), float(max(high, value)))

    def reduction(k: int) -> Figure:
        with np.errstate(divide="ignore", invalid="ignore"):
            value = 1.0 - now[k] / now[k + 3] if now[k + 3] > 0.0 else 0.0
            draws = np.where(m[k + 3] > 0.0, 1.0 - m[k] / m[k + 3], 0.0)
        return figure(value, draws)

    return Scores(
        figure(now[0], m[0]), figure(now[1], m[1]), figure(now[2], m[2]), float(now[3]), float(now[4]), float(now[5]),
        reduction(2), reduction(1), reduction(0),
    )  # fmt: skip


def _motion(runs: dict[str, _Run]) -> tuple[MotionGroup, ...]:
    """Return how residuals step at reversals, and how they age within a landing.

    Neighbouring landings are compared with each other, so that slow changes, which moves go along with, drop out.
    """
    reversal, young, old = ("reversals: outwards less inwards", "less than a minute of rest, less its landing's mean",
                            "more than five minutes of rest, less its landing's mean")  # fmt: skip
    groups: dict[str, list[float]] = {reversal: [], young: [], old: []}
    for run in runs.values():
        numbers = sorted(run.landings)
        table = np.array([run.landings[k] for k in numbers])
        means, step = table[:, 8] / table[:, 0], np.diff(table[:, 9])
        turned = np.flatnonzero((np.sign(step[1:]) * np.sign(step[:-1]) < 0.0) & (np.abs(step[1:]) > 1e-6)) + 1
        groups[reversal] += [float(np.sign(step[i]) * (means[i + 1] - means[i])) for i in turned]
        for ages, name in ((run.young, young), (run.old, old)):
            for number, (count, total) in ages.items():
                whole = run.landings[number]
                if count < whole[0]:
                    groups[name].append(float(total / count - whole[8] / whole[0]))
    made = []
    for name, values in groups.items():
        if len(values) > 1:
            spread = float(np.std(values, ddof=1) / np.sqrt(len(values)))
            made.append(MotionGroup(name, len(values), float(np.mean(values)), spread))
    return tuple(made)
