"""How far simulated and measured channels are apart, before and after what was named is put into the bench."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hexathermal.compare.bench_runs import BenchRuns, RunCurves
from hexathermal.compare.measured import MeasuredRun
from hexathermal.learn.validation_scores import Figure, scores
from hexathermal.poses import FloatArray

START_ROWS = 15
"""Rows at a run's start whose mean measured and simulated channels count from."""

SEED = 20140612
"""Of the draws behind the interval of a single run."""


@dataclass(frozen=True)
class ChannelScore:
    """A channel, before and after; SI units (thermocouples K, drift m).

    Attributes
    ----------
    channel : str
        Name of a thermocouple, or ``"drift"``.
    part : str
        Part it sits on; empty for the drift.
    position : float or None [m]
    rmse_before, rmse_after, linf_before, linf_after : float
    reduction : Figure
        ``1 - rmse_after / rmse_before`` with its 95 % interval.
    foretold : float
        RMS that a bench as it should be would leave, see `hexathermal.compare.unlike`.
    """

    channel: str
    part: str
    position: float | None
    rmse_before: float
    rmse_after: float
    linf_before: float
    linf_after: float
    reduction: Figure
    foretold: float


@dataclass(frozen=True, eq=False)
class ComparedRun:
    """A run's settled rows: measured, simulated by the bench as it is, and with what was named; from the run's start.

    Attributes
    ----------
    name, role : str
    time : array, shape (n,) [s]
    q : array, shape (n,) [m]
    measured, before, after : RunCurves
    """

    name: str
    role: str
    time: FloatArray
    q: FloatArray
    measured: RunCurves
    before: RunCurves
    after: RunCurves


def compared_run(
    bench: BenchRuns, run: MeasuredRun, logs: Mapping[str, float], contact_errors: Mapping[int, float]
) -> ComparedRun:
    """Return a run, simulated before and after."""
    measured = _from_start(RunCurves(run.rises, run.drift))
    before = _from_start(bench.curves(run, {}))
    after = _from_start(bench.curves(run, logs, contact_errors)) if logs or contact_errors else before
    return ComparedRun(run.name, run.role, run.time, run.row_q, measured, before, after)


def _from_start(curves: RunCurves) -> RunCurves:
    """Return curves that count from the mean of their first rows."""
    first = curves.rises[:START_ROWS]
    good = np.isfinite(first)
    zero = np.where(good, first, 0.0).sum(axis=0) / np.maximum(good.sum(axis=0), 1)
    return RunCurves(curves.rises - zero, curves.drift - curves.drift[:START_ROWS].mean())


def channel_scores(
    runs: Sequence[ComparedRun], measured: Sequence[MeasuredRun], names: Sequence[str],
    places: Sequence[tuple[str, float]], foretold: FloatArray,
) -> tuple[ChannelScore, ...]:  # fmt: skip
    """Return the scores of all channels over runs; a thermocouple without a value is left out."""
    found = []
    for k, name in enumerate([*names, "drift"]):
        tables = []
        for run, own in zip(runs, measured, strict=True):
            shown = [channel_of(curves, k) for curves in (run.measured, run.before, run.after)]
            table = _table(shown[2] - shown[0], shown[1] - shown[0], own)
            if len(table):
                tables.append(table)
        if not tables:
            continue
        part, position = places[k] if k < len(places) else ("", None)
        got = scores(tables, np.random.default_rng(SEED))
        found.append(ChannelScore(name, part, position, got.drift_rms, got.rmse.value, got.drift_largest,
                                  got.linf.value, got.rms_reduction, float(foretold[k])))  # fmt: skip
    return tuple(found)


def channel_of(curves: RunCurves, k: int) -> FloatArray:
    """Return the course of a thermocouple, or behind them that of the drift."""
    return curves.rises[:, k] if k < curves.rises.shape[1] else curves.drift


def _table(after: FloatArray, before: FloatArray, run: MeasuredRun) -> FloatArray:
    """Return sums and largest values of residuals in each window, see `hexathermal.learn.validation_scores`."""
    good = np.isfinite(after) & np.isfinite(before)
    e, y = np.where(good, np.abs(after), 0.0), np.where(good, np.abs(before), 0.0)
    first = run.windows.first
    sums = [np.add.reduceat(part, first) for part in (good.astype(float), e * e, e)]
    tops = [np.maximum.reduceat(part, first) for part in (e, y)]
    both = [np.add.reduceat(part, first) for part in (y * y, y)]
    table = np.column_stack([*sums, tops[0], *both, tops[1]])
    return np.asarray(table[table[:, 0] > 0.0])
