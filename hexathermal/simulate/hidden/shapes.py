"""Shapes that several effects are made of: lags of several stages, moves, ways, times; and how effects are added."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy.signal import lfilter

from hexathermal.poses import FloatArray
from hexathermal.simulate.hidden.truth import CampaignTruth, RunTruth

MOVE = 2e-6
"""A displacement between two rows by more is a move [m]: a controller holds its place far better."""


def log_uniform(low: float, high: float, generator: np.random.Generator) -> float:
    """Return a number whose logarithm is uniform between those of two bounds."""
    return float(np.exp(generator.uniform(np.log(low), np.log(high))))


def either_sign(generator: np.random.Generator) -> float:
    """Return -1 or 1."""
    return float(generator.choice([-1.0, 1.0]))


def add(truth: CampaignTruth, shape: Callable[[RunTruth], FloatArray]) -> CampaignTruth:
    """Return the campaign with `shape(run)` [m] added to the effect of each run."""
    return truth.changed(runs=tuple(run.changed(effect=run.effect + shape(run)) for run in truth.runs))


def misread(truth: CampaignTruth, sensor: str, reading: Callable[[int, RunTruth], FloatArray]) -> CampaignTruth:
    """Return the campaign with `reading(number, run)` [degC] as what a sensor reads in each run."""
    j, runs = truth.sensors.index(sensor), []
    for k, run in enumerate(truth.runs):
        errors = run.sensor_errors.copy()
        errors[:, j] = reading(k, run) - run.temperatures[:, j]
        runs.append(replace(run, sensor_errors=errors))
    return truth.changed(runs=tuple(runs))


def share_of_length(truth: CampaignTruth, run: RunTruth) -> FloatArray:
    """Return the length at each row over the retracted one, shape (n,); 1 of a component."""
    if truth.kind != "leg":
        return np.ones(run.time.size)
    return np.asarray(1.0 + run.q / truth.retracted_length)


def swing_of(truth: CampaignTruth, sensor: str) -> float:
    """Return from how cold to how warm a sensor's place goes in a run, of the middle one [K]."""
    j = truth.sensors.index(sensor)
    return float(np.median([np.ptp(run.temperatures[:, j]) for run in truth.runs]))


def place_in_stroke(truth: CampaignTruth, run: RunTruth) -> FloatArray:
    """Return where the rod is, 0 to 1 from end to end of what all runs use, shape (n,)."""
    low = min(float(one.q.min()) for one in truth.runs)
    high = max(float(one.q.max()) for one in truth.runs)
    return np.asarray((run.q - low) / (high - low))


def starts(truth: CampaignTruth) -> tuple[float, ...]:
    """Return how long each run begins after the campaign did [s]: runs follow each other, by their logs or by turns."""
    found, end = list[float](), 0.0
    for run in truth.runs:
        found.append(float(run.time[0]) if found and run.time[0] >= end else end)
        end = found[-1] + float(run.time[-1] - run.time[0])
    return tuple(found)


def since_start(truth: CampaignTruth) -> tuple[FloatArray, ...]:
    """Return the times of each run's rows since the campaign began [s]."""
    return tuple(begin + run.time - run.time[0] for begin, run in zip(starts(truth), truth.runs, strict=True))


def first_order(time: FloatArray, values: FloatArray, constant: float) -> FloatArray:
    """Return ``y`` of ``constant y' = values - y``, in equilibrium at the first row; exact of straight pieces.

    Parameters
    ----------
    time : array, shape (n,) [s]
        Increasing; where rows are missing, values between them are interpolated.
    values : array, shape (n,)
    constant : float [s]
    """
    step = float(np.median(np.diff(time)))
    even = np.arange(round(float(time[-1] - time[0]) / step) + 1) * step + time[0]
    rows = values if even.size == time.size else np.interp(even, time, values)
    kept = np.exp(-step / constant)
    new = 1.0 - (1.0 - kept) * constant / step
    found = rows[0] + lfilter([new, 1.0 - kept - new], [1.0, -kept], rows - rows[0])
    return np.asarray(found if even.size == time.size else np.interp(time, even, found))


def with_past(time: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return times and values with as long a past before them: the values turned about their first point."""
    return (
        np.concatenate([2.0 * time[0] - time[:0:-1], time]),
        np.concatenate([2.0 * values[0] - values[:0:-1], values]),
    )


def cascade(time: FloatArray, values: FloatArray, constants: Sequence[float], *, past: bool = False) -> FloatArray:
    """Return values after stages of first order, one behind the other.

    They begin in equilibrium, as a leg that has rested; with `past` they had followed the values before the first row
    too, as what stands in a room that never rests.
    """
    longer, found = with_past(time, values) if past else (time, values)
    for constant in constants:
        found = first_order(longer, found, constant)
    return found[-time.size :]


def diffused(time: FloatArray, values: FloatArray, delay: float) -> FloatArray:
    """Return the mean temperature of a slab whose one face has the given ones; the other face is insulated.

        mean = sum_n  8 / ((2 n + 1)^2 pi^2) * lag(values, tau_1 / (2 n + 1)^2)

    (Carslaw and Jaeger, 3.4), cut after four terms that share the whole; tau_1 makes the mean delay as stated [s].
    """
    odd = np.array([1.0, 3.0, 5.0, 7.0])
    shares = 1.0 / odd**2
    shares /= shares.sum()
    longest = delay / float((shares / odd**2).sum())
    lags = [cascade(time, values, (longest / n**2,)) for n in odd]
    return np.asarray(sum(share * lag for share, lag in zip(shares, lags, strict=True)))


def step_sizes(run: RunTruth) -> FloatArray:
    """Return by how much the rod moved up to each row, shape (n,) [m]; what a controller wobbles is none."""
    found = np.diff(run.q, prepend=run.q[0])
    return np.where(np.abs(found) > MOVE, found, 0.0)


def moves(run: RunTruth) -> tuple[FloatArray, FloatArray]:
    """Return when each move ended [s] and how far it went [m]: rows in which the rod moves one way belong together."""
    steps = step_sizes(run)
    way = np.sign(steps)
    last = np.flatnonzero((way != 0.0) & (np.append(way[1:], 0.0) != way))
    first = np.flatnonzero((way != 0.0) & (np.concatenate([[0.0], way[:-1]]) != way))
    sums = np.concatenate([[0.0], np.cumsum(steps)])
    return run.time[last], sums[last + 1] - sums[first]


def play(values: FloatArray, width: float, start: float) -> FloatArray:
    """Return the play operator: where in its gap, -0.5 to 0.5, something sits that is pushed by `values`.

        x[k+1] = clip(x[k] + (values[k+1] - values[k]) / width, -0.5, 0.5)

    Parameters
    ----------
    values : array, shape (n,)
    width : float
        Of the gap, in the values' unit.
    start : float
        Where it sits at first.
    """
    pushes = (np.diff(values) / width).tolist()
    found, x = [start], start
    for push in pushes:
        x = min(0.5, max(-0.5, x + push))
        found.append(x)
    return np.array(found)


def play_of_many(values: FloatArray, width: float, start: float) -> FloatArray:
    """Return the mean of gaps of 0.4, 1 and 2.2 times a width: they engage one after the other."""
    parts = [play(values, scale * width, start) for scale in (0.4, 1.0, 2.2)]
    return np.asarray(sum(parts) / 3.0)
