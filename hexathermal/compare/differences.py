"""What was named and what could not be: estimates with intervals, limits of detection, and what is confused."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp, inf, log, log1p, sqrt

import numpy as np

from hexathermal.compare.bench_runs import CONTACT_ERROR
from hexathermal.compare.evidence import CONTACT_FREE, CONTACT_SD
from hexathermal.compare.parameters import FREE, NAMES, PARAMETERS, SENSOR_EXPERIMENT, TOLERANCES, half_interval
from hexathermal.compare.steps import PROBABILITY, Calibration
from hexathermal.poses import FloatArray

ALIKE = 0.95
"""Two numbers whose marks are alike by more than this (correlation) cannot be separated by the data."""

SENSOR = "sensor-reads-air"

LARGEST_LOG = log(100.0)
"""Factors beyond 100 count as never found."""


@dataclass(frozen=True)
class Difference:
    """A number of the bench that differs.

    Attributes
    ----------
    name : str
        Of the parameter, or ``"sensor-reads-air"``.
    target : str
        The thermocouple, where it is one.
    words : str
    meaning : str
        What the change may stand for.
    value, low, high : float
        Factor on the bench's number; of a thermocouple, the part by which it follows the air. 95 % interval.
    log_evidence : float
        Above the bench without it, natural logarithm.
    probability : float
    runs_better : tuple of (int, int)
        Runs left out that are foretold better, and all of them.
    equivalent : tuple of (str, float)
        What these data cannot tell from it, with the value that it would have instead.
    experiment : str
        What would decide.
    """

    name: str
    target: str
    words: str
    meaning: str
    value: float
    low: float
    high: float
    log_evidence: float
    probability: float
    runs_better: tuple[int, int]
    equivalent: tuple[tuple[str, float], ...]
    experiment: str

    @property
    def sentence(self) -> str:
        """The difference in words."""
        other = (
            f" (or, not told apart: {', '.join(name for name, _value in self.equivalent)})" if self.equivalent else ""
        )
        if self.target:
            return (
                f"{self.target}, which follows the air by {100.0 * self.value:.0f} % ({100.0 * self.low:.0f} to "
                f"{100.0 * self.high:.0f} %) instead of {100.0 * CONTACT_ERROR:.0f} %{other}"
            )
        return f"{self.words}: {self.value:.2f} times the bench's ({self.low:.2f} to {self.high:.2f}){other}"


LEAST_SAID = -1.0
"""Log evidence of a thermocouple's part of the air from which on it is told."""


@dataclass(frozen=True)
class ParameterFound:
    """One of all numbers that were looked for.

    Attributes
    ----------
    name, target : str
    words : str
    value, low, high : float
        Estimate were this one free (besides those named), and its 95 % interval; factor, or part of the air.
    named : bool
    log_evidence : float
        Above the final bench; 0 for what was named.
    limit_low, limit_high : float
        Below and above these it would have been named; 0 and infinite where the data never show it.
    alike : tuple of (str, float)
        Of what was not named: others whose marks correlate with its own by more than `ALIKE`. What these data do not
        tell from a named one is its `Difference.equivalent`.
    experiment : str
        What would show it apart.
    """

    name: str
    target: str
    words: str
    value: float
    low: float
    high: float
    named: bool
    log_evidence: float
    limit_low: float
    limit_high: float
    alike: tuple[tuple[str, float], ...]
    experiment: str

    @property
    def speaks(self) -> bool:
        """Whether it is one of the bench, was named, or is a thermocouple's of which the data say something."""
        return not self.target or self.named or self.log_evidence > LEAST_SAID

    @property
    def needless(self) -> bool:
        """Whether it was not named although it lies where it would have been by itself: what was named does instead."""
        return not self.named and not self.limit_low <= self.value <= self.limit_high


def label(place: int, sensors: Sequence[str]) -> str:
    """Return the name of a candidate, a thermocouple's with its target."""
    return NAMES[place] if place < len(NAMES) else f"{SENSOR} {sensors[place - len(NAMES)]}"


def _value(place: int, x: float) -> float:
    """Return a factor, or the part by which a thermocouple follows the air."""
    return exp(x) if place < len(NAMES) else CONTACT_ERROR + x


def named_values(calibration: Calibration) -> tuple[dict[str, float], dict[int, float]]:
    """Return what was named: logarithms of factors by name, and parts of the air by thermocouple."""
    x = calibration.last.x
    named = calibration.named
    logs = {NAMES[j]: float(x[j]) for j in named if j < len(NAMES)}
    return logs, {j - len(NAMES): _value(j, float(x[j])) for j in named if j >= len(NAMES)}


def differences(calibration: Calibration, sensors: Sequence[str]) -> tuple[Difference, ...]:
    """Return what was named."""
    last = calibration.last
    found = []
    for step in calibration.steps:
        if not step.accepted:
            continue
        j = step.candidate
        x, half = float(last.x[j]), half_interval(j, float(last.covariance[j, j]))
        same = tuple((label(other, sensors), _value(other, value)) for other, value in step.equivalent)
        parameter = PARAMETERS[j] if j < len(NAMES) else None
        if parameter is None:
            name, target = SENSOR, sensors[j - len(NAMES)]
            words, meaning, experiment = (
                f"{target} reads the air",
                "it came loose, or sits in a draught",
                SENSOR_EXPERIMENT,
            )
        else:
            name, target, words, experiment = parameter.name, "", parameter.words, parameter.experiment
            meaning = parameter.more if x > 0.0 else parameter.less
        better = (int((step.left_out > 0.0).sum()), len(step.left_out) if len(step.left_out) > 1 else 0)
        found.append(Difference(name, target, words, meaning, _value(j, x), _value(j, x - half), _value(j, x + half),
                                step.gain, step.probability, better, same, experiment))  # fmt: skip
    return tuple(found)


def parameters_found(calibration: Calibration, sensors: Sequence[str]) -> tuple[ParameterFound, ...]:
    """Return all numbers that were looked for."""
    last = calibration.last
    count = len(NAMES) + len(sensors)
    alike = _alike(calibration, count)
    found = []
    for j in range(count):
        free = last.free if j in last.free else (*last.free, j)
        precision = last.sums.precision(free)
        x, covariance = last.sums.estimate(precision)
        own, half = float(x[j]), half_interval(j, float(covariance[j, j]))
        limit = _limit(float(last.sums.information((j,), last.sums.precision(last.free))[0, 0]), j, count)
        parameter = PARAMETERS[j] if j < len(NAMES) else None
        target = "" if parameter else sensors[j - len(NAMES)]
        edges = (0.0, inf) if parameter and limit > LARGEST_LOG else (_value(j, -limit), _value(j, limit))
        found.append(ParameterFound(
            parameter.name if parameter else SENSOR, target,
            parameter.words if parameter else f"{target} reads the air",
            _value(j, own), _value(j, own - half), _value(j, own + half), j in last.free,
            0.0 if j in last.free else float(calibration.gains[j]), edges[0], edges[1],
            () if j in last.free else _same(j, alike, sensors),
            parameter.experiment if parameter else SENSOR_EXPERIMENT,
        ))  # fmt: skip
    return tuple(found)


def _same(j: int, alike: FloatArray, sensors: Sequence[str]) -> tuple[tuple[str, float], ...]:
    """Return the names of those whose marks are like those of number j, and how alike."""
    return tuple(
        (label(int(k), sensors), float(alike[j, k])) for k in np.flatnonzero(np.abs(alike[j]) > ALIKE) if k != j
    )


def _alike(calibration: Calibration, count: int) -> FloatArray:
    """Return how alike the marks of all numbers are, -1 to 1; all others within their prior."""
    last = calibration.last
    precision = last.sums.precision(last.free)
    found = np.eye(count)
    for i in range(len(NAMES)):
        for j in range(i):
            own = last.sums.information((i, j), precision)
            found[i, j] = found[j, i] = own[0, 1] / sqrt(max(float(own[0, 0] * own[1, 1]), 1e-300))
    return found


def _limit(information: float, place: int, count: int) -> float:
    """Return how far a number must be off for its expected log-evidence to name it.

    With estimate ``x``, variance ``v`` of the data alone, prior ``a^2`` (tolerance) and ``b^2`` (free):
    ``log Z_b - log Z_a = x^2/2 (1/(a^2 + v) - 1/(b^2 + v)) - 1/2 log((b^2 + v)/(a^2 + v))``.
    """
    tolerance, free = (TOLERANCES[place], FREE) if place < len(NAMES) else (CONTACT_SD, CONTACT_FREE)
    v = 1.0 / max(information, 1e-12)
    a, b = tolerance**2 + v, free**2 + v
    needed = log(count * PROBABILITY / (1.0 - PROBABILITY))
    return sqrt(2.0 * (needed + 0.5 * log1p(b / a - 1.0)) / max(1.0 / a - 1.0 / b, 1e-300))
