"""Residuals of each run in windows, with what they may follow: for pictures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from hexathermal.learn.campaign import Campaign
from hexathermal.learn.coverage import TWO_SIDED
from hexathermal.learn.diagnosis.ranking import Ranked
from hexathermal.learn.diagnosis.result import Autocorrelation, RunResidual
from hexathermal.learn.diagnosis.smoothing import smoothed
from hexathermal.learn.diagnosis.spans import beside
from hexathermal.learn.diagnosis.stage import Stage, view_of
from hexathermal.learn.diagnosis.view import View
from hexathermal.learn.law import IdentifiedLaw
from hexathermal.learn.signals import RunRows
from hexathermal.learn.validation_rows import memories
from hexathermal.machine.leg_signals import Memory
from hexathermal.machine.leg_states import LegMemory
from hexathermal.poses import FloatArray

LAGS = 20
"""Windows from one to another up to which whitened residuals are held against each other."""


def whiteness(first: Stage, last: Stage) -> Autocorrelation | None:
    """Return the autocorrelation of whitened residuals of the runs for identification, before and after.

    ``r_l = sum x_i x_(i+l) / sum x_i^2`` within runs; of independent noise ``N(0, 1 / n)``, n the pairs of the first
    lag (Box and Jenkins, Time Series Analysis, 1976, 2.1.6).

    Parameters
    ----------
    first, last : Stage
        Without anything, and with what joined the law.

    Returns
    -------
    Autocorrelation or None
        None where no run has twice as many windows as lags.
    """
    run = first.channel.run
    if len(run) != len(last.channel.run) or np.bincount(run).max() < 2 * LAGS:
        return None
    before, after = (_autocorrelation(_whitened(stage), run) for stage in (first, last))
    return Autocorrelation(before, after, TWO_SIDED / float(np.sqrt((run[1:] == run[:-1]).sum())))


def _whitened(stage: Stage) -> FloatArray:
    """Return the whitened residual of a stage's law, with what it allows its thermometers, shape (n,)."""
    base, levels = stage.base, stage.step.levels
    _, mean = stage.channel.solved(base.X, base.sd, levels)
    return stage.channel.whitened((stage.channel.y - base.X @ mean)[:, None], levels)[0][:, 0]


def _autocorrelation(values: FloatArray, run: npt.NDArray[np.int64]) -> FloatArray:
    """Return the autocorrelation within runs at 1 to `LAGS`."""
    found = [(values[lag:] * values[:-lag])[run[lag:] == run[:-lag]].sum() for lag in range(1, LAGS + 1)]
    return np.array(found) / max(float(values @ values), np.finfo(float).tiny)


def run_residuals(
    campaign: Campaign, rows: Sequence[RunRows], held: Sequence[RunRows], law: IdentifiedLaw, extended: IdentifiedLaw
) -> tuple[RunResidual, ...]:  # fmt: skip
    """Return the residuals of all runs, those for identification first."""
    past = memories(extended, campaign, {one.run.name: one.signals for one in (*rows, *held)})
    found = []
    for runs in (rows, held):
        if runs:
            view = view_of(campaign, runs, law.sensors, placed=law.stroked)
            found += [_residual(view, k, law, extended, past[runs[k].run.name]) for k in range(len(runs))]
    return tuple(found)


def with_followed(runs: tuple[RunResidual, ...], stage: Stage, leader: Ranked | None) -> tuple[RunResidual, ...]:
    """Return residuals with what one column without a name explains beside the law, as the signal ``"followed"`` [m].

    Of the runs for identification, where it was found; many columns go with signals that are there already.
    """
    if leader is None or leader.named or leader.best.trial.columns.shape[1] != 1:
        return runs
    law = np.column_stack([np.ones(len(stage.channel.run)), stage.view.base_columns])
    explained = beside(leader.best.trial.columns, law)[:, 0] * float(stage.amplitudes(leader)[0][0])
    names = [rows.run.name for rows in stage.view.runs]
    own = {name: explained[stage.channel.run == k] for k, name in enumerate(names)}
    return tuple(
        replace(one, signals={**one.signals, "followed": own[one.run]})
        if len(own.get(one.run, ())) == len(one.time) and "followed" not in one.signals  # an input may be called so
        else one
        for one in runs
    )


def _residual(view: View, k: int, law: IdentifiedLaw, extended: IdentifiedLaw, past: LegMemory) -> RunResidual:
    """Return the residual of one run; `past` is what the extended law remembers of those before."""
    rows, piece = view.runs[k], view.pieces[k]
    signals = rows.signals

    def mean(values: FloatArray) -> FloatArray:
        return piece.means(np.asarray(values, dtype=np.float64))

    before = rows.drift - law.predict_signals(signals, run=rows.run.name)
    after = rows.drift - extended.predict_signals(signals, run=rows.run.name, before=past.copy())
    own = view.signals[k].dT[law.sensors[0]]
    moves = Memory().moves(signals.q)
    last = np.maximum.accumulate(np.where(moves != 0.0, signals.time, -np.inf))
    known = {
        "q": mean(signals.q),
        "direction": mean(Memory().direction(signals.q)),
        "dT": mean(own),
        "rate": mean(np.gradient(smoothed(signals.time, own[:, None], 900.0)[:, 0], signals.time)),
    }
    since = mean(np.where(np.isfinite(last), signals.time - last, np.nan))
    if np.isfinite(since).any():
        known["since_move"] = since
    if rows.weather is not None:
        for column, name in enumerate(("air", "pressure", "humidity")):
            values = rows.weather[:, column]
            if not np.isnan(values).any():
                known[name] = mean(values)
    for name, values in signals.inputs.items():
        known[name] = mean(values)
    if not view.moves:
        for name in ("q", "direction", "since_move"):
            known.pop(name, None)
    return RunResidual(
        rows.run.name, rows.run.role, mean(signals.time), mean(rows.drift), mean(before), mean(after), known
    )
