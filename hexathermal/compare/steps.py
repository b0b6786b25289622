"""Which numbers of the bench differ: forward steps, one at a time, each by evidence and on runs left out.

At each step every candidate is weighed in the linearised bench; the leading ones are followed to their own best value
with the bench simulated anew (Gauss-Newton), the noise sought again where something was named. The best is named only
if it is probable by `PROBABILITY` against "nothing more differs", all candidates taken together as equally likely as
nothing, and if it foretells identification runs left out of its estimate better than without. What later ones made
needless in the end, so that its interval holds the bench's own number, is not named.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from hexathermal.compare.bench_runs import CONTACT_ERROR, BenchRuns
from hexathermal.compare.evidence import (
    FREE_ALL,
    Normal,
    Sensitivities,
    normal,
    own_factors,
    sensitivities,
)
from hexathermal.compare.noise import Noise, first_noise, fitted_noise
from hexathermal.compare.parameters import NAMES, half_interval
from hexathermal.poses import FloatArray

PROBABILITY = 0.99
"""What is named is at least so probable."""

BETTER = 0.7
"""Part of the runs left out that are foretold better with what is named, at least."""

EQUIVALENT = 3.0
"""A candidate whose log-evidence is less than this below the best one's cannot be told from it by these data."""

FOLLOWED, MOST_FOLLOWED = 4, 8
"""Candidates followed to their own best value: so many, and more where the next promises more than the best has."""

FAR = 0.1
"""None is followed whose linearised log-evidence is below this part of the best one's."""

MOST_NAMED = 8
"""Steps at most."""

ITERATIONS, SETTLINGS, LARGEST_LOG_STEP, CONVERGED = 6, 3, 0.7, 0.01
"""Of Gauss-Newton: iterations on the way and at the end, largest step and what counts as none, in logarithms."""

NOISE_RUNS = 4
"""Runs that the noise is sought in: the longest."""

Progress = Callable[[int, int, str], None]


@dataclass(frozen=True, eq=False)
class Fit:
    """The bench with some numbers free.

    Attributes
    ----------
    free : tuple of int
        Places of what differs: below ``len(NAMES)`` parameters, then contact errors of the thermocouples.
    sums : Normal
        About the best point.
    found : Sensitivities
    noise : Noise
    evidence : float
    x, covariance : array
        Estimate of all numbers.
    """

    free: tuple[int, ...]
    sums: Normal
    found: Sensitivities
    noise: Noise
    evidence: float
    x: FloatArray
    covariance: FloatArray


@dataclass(frozen=True, eq=False)
class Step:
    """One forward step.

    Attributes
    ----------
    candidate : int
    gain : float
        Log-evidence above the bench before.
    probability : float
    left_out : array, shape (runs,)
        By how much each run left out is foretold better, see `_left_out`.
    equivalent : tuple of (int, float)
        Candidates that the data cannot tell from it, each with its own estimate (log factor or contact error).
    accepted : bool
    """

    candidate: int
    gain: float
    probability: float
    left_out: FloatArray
    equivalent: tuple[tuple[int, float], ...]
    accepted: bool


@dataclass(frozen=True, eq=False)
class Calibration:
    """All forward steps.

    Attributes
    ----------
    first, last : Fit
        The bench as it is, and with what was named.
    steps : tuple of Step
        As they were taken, each beside those before it: those accepted; not accepted are the one refused at the end,
        if any, and those that later ones made needless.
    gains : array, shape (k,)
        Log-evidence of each candidate over `last`, in the linearised bench; NaN for what is free already.
    """

    first: Fit
    last: Fit
    steps: tuple[Step, ...]
    gains: FloatArray

    @property
    def named(self) -> tuple[int, ...]:
        """Places of what was named, in the order of the steps."""
        return tuple(step.candidate for step in self.steps if step.accepted)


def calibrated(bench: BenchRuns, progress: Progress | None = None) -> Calibration:
    """Return which numbers of the bench differ, and by how much.

    Parameters
    ----------
    bench : BenchRuns
        With the runs for identification.
    progress : callable, optional
        Called as ``progress(done, total, label)``.
    """
    tell = progress or (lambda done, total, label: None)
    tell(0, 0, "simulating the bench")
    found = sensitivities(bench, np.zeros(len(NAMES)))
    tell(0, 0, "noise of the channels")
    noise = sought_noise(bench, found, first_noise(bench.runs))
    now = first = _fit(bench, found, noise, ())
    steps: list[Step] = []
    while True:
        tell(len(steps), MOST_NAMED, "naming what differs")
        gains = _gains(now)
        if len(now.free) >= MOST_NAMED:
            break
        step, fit = _step(bench, now, gains)
        if not step.accepted:
            steps.append(step)
            break
        if now is first:
            # what differed is no noise: seek it again, and weigh the first step with it
            renewed = sought_noise(bench, fit.found, fit.noise)
            now = first = _fit(bench, found, renewed, ())
            step, fit = _step(bench, now, _gains(now))
            if not step.accepted:
                steps.append(step)
                gains = _gains(now)
                break
        steps.append(step)
        now = fit
    if len(now.free) > 1:
        now = _fit(bench, now.found, sought_noise(bench, now.found, now.noise), now.free)
        now = _without_needless(bench, now)
        gains = _gains(now)
    steps = [replace(step, accepted=step.accepted and step.candidate in now.free) for step in steps]
    return Calibration(first, now, tuple(steps), gains)


def _without_needless(bench: BenchRuns, now: Fit) -> Fit:
    """Return the fit without numbers that later ones made needless: whose 95 % intervals hold the bench's own."""
    while True:
        sure = {j: abs(float(now.x[j])) / half_interval(j, float(now.covariance[j, j])) for j in now.free}
        least = min(sure, key=lambda j: sure[j], default=None)
        if least is None or sure[least] > 1.0:
            return now
        logs = now.found.logs.copy()
        if least < len(NAMES):  # a part of the air is no number of the bench
            logs[least] = 0.0
        kept = tuple(j for j in now.free if j != least)
        now = _settled_at(bench, logs, now.noise, kept)


def sought_noise(bench: BenchRuns, found: Sensitivities, noise: Noise) -> Noise:
    """Return the noise of the largest evidence with every number free."""
    order = np.argsort([-len(run.windows.time) for run in bench.runs], kind="stable")[:NOISE_RUNS]
    runs = [bench.runs[k] for k in order]
    part = replace(found, simulated=tuple(found.simulated[k] for k in order),
                   tables=tuple(found.tables[k] for k in order), used=tuple(found.used[k] for k in order))  # fmt: skip

    def evidence(one: Noise) -> float:
        sums = normal(part, runs, one)
        precision = sums.precision(range(len(NAMES) + sums.sensors))
        precision[: len(NAMES)] = FREE_ALL**-2.0
        return sums.evidence(precision)

    best = fitted_noise(noise, evidence)
    return replace(best, own=own_factors(found, bench.runs, best))


def _fit(bench: BenchRuns, found: Sensitivities, noise: Noise, free: tuple[int, ...]) -> Fit:
    """Return a fit about a point that is taken as it is."""
    sums = normal(found, bench.runs, noise)
    precision = sums.precision(free)
    x, covariance = sums.estimate(precision)
    return Fit(free, sums, found, noise, sums.evidence(precision), x, covariance)


def _gains(now: Fit) -> FloatArray:
    """Return the log-evidence that each candidate adds in the linearised bench.

    A thermocouple that would follow the air by less than nothing is no candidate: its gain is negative.
    """
    gains = np.full(len(NAMES) + now.sums.sensors, np.nan)
    for j in range(len(gains)):
        if j in now.free:
            continue
        precision = now.sums.precision((*now.free, j))
        gains[j] = now.sums.evidence(precision) - now.evidence
        if j >= len(NAMES) and now.sums.estimate(precision)[0][j] < -CONTACT_ERROR:
            gains[j] = min(gains[j], -1.0)
    return gains


def followed(bench: BenchRuns, now: Fit, free: tuple[int, ...]) -> Fit:
    """Return the fit with some numbers free, the bench simulated anew until they stay (Gauss-Newton).

    All others stay at the bench's own; they may move within their tolerance about it, where the bench is linear. Their
    sensitivities are those of the fit before.
    """
    parameters = [j for j in free if j < len(NAMES)]
    found = now.found
    if not parameters:
        return _fit(bench, found, now.noise, free)
    x, _covariance = now.sums.estimate(now.sums.precision(free))
    for _k in range(ITERATIONS):
        step = np.zeros(len(NAMES))
        step[parameters] = np.clip((x[: len(NAMES)] - found.logs)[parameters], -LARGEST_LOG_STEP, LARGEST_LOG_STEP)
        if np.abs(step).max() < CONVERGED:
            break
        found = sensitivities(bench, found.logs + step, found, parameters)
        x = _fit(bench, found, now.noise, free).x
    return _fit(bench, found, now.noise, free)


def _step(bench: BenchRuns, now: Fit, gains: FloatArray) -> tuple[Step, Fit]:
    """Return the best next step, and the fit with it."""
    order = [int(j) for j in np.argsort(-gains) if not np.isnan(gains[j])]
    exact, fits = np.full(len(gains), -np.inf), dict[int, Fit]()
    for j in order[:MOST_FOLLOWED]:
        best = float(exact.max())
        if fits and (gains[j] < 0.0 or (len(fits) >= FOLLOWED and gains[j] < best) or gains[j] < FAR * best):
            break
        fits[j] = followed(bench, now, (*now.free, j))
        exact[j] = fits[j].evidence - now.evidence
    chosen = int(np.argmax(exact))
    same = [j for j in fits if j != chosen and exact[j] > exact[chosen] - EQUIVALENT]
    fit = _settled(bench, fits[chosen])
    exact[chosen] = fit.evidence - now.evidence
    # all candidates together are as likely as none before the data
    odds = sum(np.exp(min(exact[j], 500.0)) for j in (chosen, *same)) / (len(NAMES) + now.sums.sensors)
    left_out = _left_out(fit, now)
    pays = float(left_out.sum()) > 0.0 and float((left_out > 0.0).mean()) >= BETTER  # never with one run alone
    probability = float(odds / (1.0 + odds))
    equivalent = tuple((j, float(fits[j].x[j])) for j in same)
    accepted = bool(probability >= PROBABILITY and pays and gains[chosen] > 0.0)
    return Step(chosen, float(exact[chosen]), probability, left_out, equivalent, accepted), fit


def _settled(bench: BenchRuns, fit: Fit) -> Fit:
    """Return a fit with all sensitivities of its own point, which follows its estimate until it stays."""
    return _settled_at(bench, fit.found.logs, fit.noise, fit.free)


def _settled_at(bench: BenchRuns, logs: FloatArray, noise: Noise, free: tuple[int, ...]) -> Fit:
    """Return `_settled` from a point on."""
    named = np.array([j in free for j in range(len(NAMES))])
    for _k in range(SETTLINGS):
        fit = _fit(bench, sensitivities(bench, logs), noise, free)
        move = np.where(named, fit.x[: len(NAMES)] - logs, 0.0)
        if np.abs(move).max() < 2.0 * CONVERGED:
            break
        logs = logs + np.clip(move, -LARGEST_LOG_STEP, LARGEST_LOG_STEP)
    return fit


def _left_out(fit: Fit, before: Fit) -> FloatArray:
    """Return by how much each run is foretold better by the others with the last number free, shape (runs,).

    Half the difference of the whitened squares. The bench is changed in nothing but what is named, as a user gets it,
    and every number may move within its tolerance.
    """
    found = np.zeros(len(fit.sums.grams))
    if len(found) < 2:
        return found
    for sign, one in ((-1.0, fit), (1.0, before)):
        precision, named = one.sums.precision(one.free), np.zeros(len(one.x), dtype=bool)
        named[list(one.free)] = True
        for r in range(len(found)):
            x, _covariance = one.sums.without(r).estimate(precision)
            found[r] += sign * one.sums.misfit(np.where(named, x, 0.0), r)
    return found
