"""The error budget by simulation: propagation of distributions (GUM supplement 1, JCGM 101).

Every draw is a machine: its deviations are drawn from the sources' distributions, and its platform's error follows by
exact forward kinematics.  Draws come in sequences of equal length until the results of the sequences agree to a stated
tolerance (JCGM 101, 7.9); then the linear budget is held against them (clause 8).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError
from hexathermal.kinematics.forward import checked_lengths
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.thermal import TemperaturesLike, frozen, refreeze
from hexathermal.poses import FloatArray, Frames, PoseLike, finite_array, pose_array
from hexathermal.predict.budget import AXES, Budget, budget_of, checked_sources
from hexathermal.predict.budget_gum import checked_probability
from hexathermal.predict.budget_inputs import (
    Situation,
    View,
    axes_and_arm,
    chord_errors,
    pose_numbers,
    refuse_singular,
    situation,
)
from hexathermal.predict.sources import Source, Sources

SEQUENCE = 10_000
"""Draws of a sequence (JCGM 101, 7.9.4: at least 1e4, and 100 / (1 - p))."""

SLICE = 2_000
"""Draws that are worked on together: a row of deviations has some 100 numbers."""

MOST_DRAWS = 20_000_000

STABLE_PART = 0.2
"""Part of the tolerance to which the simulation must be stable to judge the linear budget (JCGM 101, 8.2)."""


@dataclass(frozen=True, eq=False)
class Simulation:
    """An error budget by simulation, and whether the linear one may be used.

    Attributes
    ----------
    budget : Budget
        The linear budget of the same situation and sources.
    draws, sequences, seed : int
    probability : float
    mean, uncertainty : array, shape (6,) [m, rad]
        Mean and standard deviation of the errors.
    covariance : array, shape (6, 6)
    low, high : array, shape (6,)
        Shortest coverage interval of each axis.
    tolerance : array, shape (6,)
        Within which the limits of the linear budget must agree; a fifth of it is what the simulation is stable to.
    scatter : array, shape (4, 6)
        Twice the standard deviation of the averages over the sequences: of mean, uncertainty, low and high.
    stable : bool
        Whether all of `scatter` is within a fifth of `tolerance`.
    differences : array, shape (2, 6)
        ``|y - U - low|`` and ``|y + U - high|`` of the linear budget.
    """

    budget: Budget
    draws: int
    sequences: int
    seed: int
    probability: float
    mean: FloatArray
    uncertainty: FloatArray
    covariance: FloatArray
    low: FloatArray
    high: FloatArray
    tolerance: FloatArray
    scatter: FloatArray
    stable: bool
    differences: FloatArray

    @property
    def agrees(self) -> npt.NDArray[np.bool_]:
        """For each axis, whether both limits of the linear budget agree within the tolerance (JCGM 101, 8.1)."""
        return np.asarray((self.differences <= self.tolerance).all(axis=0))

    @property
    def linear_may_be_used(self) -> bool | None:
        """Whether the linear budget may be used in place of this one; None where the simulation is not stable."""
        return bool(self.agrees.all()) if self.stable else None

    @property
    def verdict(self) -> str:
        """One sentence on whether the linear budget may be used."""
        if not self.stable:
            return (
                f"not decided: after {self.draws} draws it is not stable to a fifth of the tolerance; allow "
                "more draws or a larger tolerance"
            )
        if self.agrees.all():
            return "the linear budget may be used: both limits of every axis agree within the tolerance"
        bad = [axis for axis, good in zip(AXES, self.agrees, strict=True) if not good]
        return f"the linear budget may not be used for {', '.join(bad)}: a limit differs by more than the tolerance"

    def as_dict(self) -> dict[str, Any]:
        """Return the simulation as plain values, um and urad; the budget is not in it."""
        return {
            "draws": self.draws, "sequences": self.sequences, "seed": self.seed, "probability": self.probability,
            "axes": list(AXES), "units": ["um", "um", "um", "urad", "urad", "urad"],
            "mean": (self.mean * 1e6).tolist(), "standard_uncertainty": (self.uncertainty * 1e6).tolist(),
            "covariance": (self.covariance * 1e12).tolist(),
            "low": (self.low * 1e6).tolist(), "high": (self.high * 1e6).tolist(),
            "tolerance": (self.tolerance * 1e6).tolist(), "scatter": (self.scatter * 1e6).tolist(),
            "stable": self.stable, "differences": (self.differences * 1e6).tolist(),
            "agrees": self.agrees.tolist(), "linear_may_be_used": self.linear_may_be_used, "verdict": self.verdict,
        }  # fmt: skip

    def __setstate__(self, state: dict[str, Any]) -> None:
        refreeze(self, state)


def monte_carlo(
    hexapod: Hexapod,
    pose: PoseLike,
    temps: TemperaturesLike,
    sources: Iterable[Source] | None = None,
    *,
    probability: float = 0.95,
    tolerance: npt.ArrayLike | None = None,
    digits: int | None = None,
    least_draws: int = 100_000,
    most_draws: int = 4_000_000,
    seed: int = 1,
    progress: Callable[[int, int], None] | None = None,
    **view: Unpack[View],
) -> Simulation:
    """Return the error budget by simulation, with a verdict on the linear one.

    Sequences of draws are added until twice the standard deviation of the averages over the sequences, of mean,
    standard uncertainty and both limits of every axis, is within a fifth of the tolerance (JCGM 101, 7.9.4 and 8.2).

    Parameters
    ----------
    hexapod, pose, temps, sources, and keywords of `View`
        As in `hexathermal.predict.budget.error_budget`.
    probability : float
    tolerance : float or array, shape (6,), optional [m, rad]
        How far the limits of the linear budget may be off. Default: 5 % of each axis' standard uncertainty.
    digits : int, optional
        Instead of `tolerance`: significant digits of the standard uncertainty that count, ``u = c 10^l`` with `digits`
        digits in ``c`` gives ``10^l / 2`` (JCGM 101, 7.9.2).
    least_draws, most_draws : int
        Where the tolerance is not met after `most_draws`, `Simulation.stable` is False and the verdict says so.
    seed : int
    progress : callable, optional
        ``progress(done, most)``.

    Raises
    ------
    NotConvergedError
        A draw is too far off for the branch of the pose to be certain.
    ArgumentError, HexathermalError
        Senseless tolerance, digits or numbers of draws; as `error_budget`.

    Examples
    --------
    >>> import hexathermal as ht
    >>> hexapod = ht.load_hexapod("reference")
    >>> few = [Source("residual", "length", 0.35e-6)]
    >>> monte_carlo(hexapod, hexapod.home, [25.0] * 6, few).linear_may_be_used
    True
    """
    p = checked_probability(probability)
    length = max(SEQUENCE, int(np.ceil(100.0 / (1.0 - p))))
    least, most = _draws(least_draws, most_draws, length)
    generator = np.random.default_rng(_seed(seed))
    here, chosen = situation(hexapod, pose, temps, **view), checked_sources(hexapod, sources, view.get("plates"))
    budget = budget_of(here, chosen)
    delta = _tolerance(tolerance, digits, budget.uncertainty)
    told = progress or (lambda _done, _most: None)
    errors, found = _until_stable(Drawn(here, chosen), generator, p, delta, (length, least, most), told)
    return _simulation(budget, errors, found, delta, p, seed)


def _until_stable(
    draw: Drawn,
    generator: np.random.Generator,
    p: float,
    delta: FloatArray,
    counts: tuple[int, int, int],
    progress: Callable[[int, int], None],
) -> tuple[FloatArray, list[FloatArray]]:
    """Return drawn errors and the results of each sequence; `counts`: length of one, least and most draws."""
    length, least, most = counts
    errors: list[FloatArray] = []
    found: list[FloatArray] = []
    while True:
        errors.append(draw(length, generator))
        found.append(_summary(errors[-1], p))
        done = len(found) * length
        progress(done, most)
        stable = bool((_scatter(found) <= STABLE_PART * delta).all())
        if done + length > most or (stable and done >= least):
            return np.concatenate(errors), found


def _simulation(
    budget: Budget, errors: FloatArray, found: list[FloatArray], delta: FloatArray, p: float, seed: int
) -> Simulation:
    """Return what all draws say, held against the linear budget."""
    mean, uncertainty, low, high = _summary(errors, p)
    expanded, scatter = budget.expanded(p), _scatter(found)
    differences = np.abs(np.array([budget.remaining - expanded - low, budget.remaining + expanded - high]))
    return Simulation(
        budget, len(errors), len(found), seed, p, frozen(mean), frozen(uncertainty), frozen(np.cov(errors.T)),
        frozen(low), frozen(high), frozen(delta), frozen(scatter), bool((scatter <= STABLE_PART * delta).all()),
        frozen(differences),
    )  # fmt: skip


class Drawn:
    """Draws of the platform's error: ``drawn(count, generator)`` gives exact errors (count, 6)."""

    def __init__(self, here: Situation, sources: Sources) -> None:
        self.here, self.sources = here, sources
        self.factors = [here.factors(source)[0] for source in sources]

    def deviations(self, count: int, generator: np.random.Generator) -> FloatArray:
        """Return drawn deviations (size + 6, count), one row a number; the last six are the pose's own."""
        out = np.zeros((self.here.size + 6, count))
        for source, factors in zip(self.sources, self.factors, strict=True):
            rows = np.flatnonzero(factors.any(axis=1))
            if rows.size:
                z = variables(source, (factors.shape[1], count), generator)
                used = slice(rows[0], rows[-1] + 1)
                own = factors[used]
                if own.shape[0] == own.shape[1] and np.count_nonzero(own - np.diag(np.diag(own))) == 0:
                    z *= np.diag(own)[:, None]
                    out[used] += z
                else:
                    out[used] += own @ z
        return out

    def __call__(self, count: int, generator: np.random.Generator) -> FloatArray:
        """Return drawn errors (count, 6) [m, rad]."""
        out = np.empty((count, 6))
        for first in range(0, count, SLICE):
            x = self.deviations(min(SLICE, count - first), generator)
            own = self.here.size
            out[first : first + SLICE] = self.here.errors(np.ascontiguousarray(x[:own].T)) + x[own:].T
        return out


def drawn_errors(
    hexapod: Hexapod,
    pose: PoseLike,
    lengths: npt.ArrayLike,
    *,
    frame: str = "machine",
    frames: Frames | None = None,
    at_tool: npt.ArrayLike | None = None,
) -> FloatArray:
    """Return the exact errors of the platform for many sets of leg lengths near those of one pose.

    Chord steps with the inverse of Newton's matrix at the pose, until one is below 1e-11 (rad, or parts of the
    machine's size).  Neither a thermal law nor strokes are asked for.

    Parameters
    ----------
    hexapod, pose, frame, frames, at_tool
        As in `hexathermal.predict.budget.error_budget`.
    lengths : array, shape (N, 6) [m]
        True inter-articular lengths.

    Returns
    -------
    array, shape (N, 6) [m, m, m, rad, rad, rad]

    Raises
    ------
    SingularPoseError, NotConvergedError, ArgumentError, UnknownNameError
    """
    wanted, told = pose_array(pose), checked_lengths(lengths)
    if wanted.shape != (4, 4) or told.ndim != 2:
        raise ArgumentError(f"one pose (4, 4) and lengths (N, 6) are needed, found {wanted.shape} and {told.shape}")
    refuse_singular(hexapod, wanted)
    axes, arm = axes_and_arm(frame, frames, at_tool, wanted)
    return chord_errors(pose_numbers(hexapod, wanted, axes, arm), told, np.empty((0, 36)))


def variables(source: Source, shape: tuple[int, int], generator: np.random.Generator) -> FloatArray:
    """Return draws (r, count) of a source's own variables, in units of its standard uncertainty.

    Bounded distributions have unit variance; t is scaled, not standardized (JCGM 101, 6.4.9.2), and correlated numbers
    share one chi-square.
    """
    if source.distribution == "uniform":
        return generator.uniform(-(3.0**0.5), 3.0**0.5, shape)
    if source.distribution == "triangular":
        return generator.triangular(-(6.0**0.5), 0.0, 6.0**0.5, shape)
    if source.distribution == "arcsine":
        return np.asarray(2.0**0.5 * np.sin(generator.uniform(-np.pi, np.pi, shape)))
    z = generator.standard_normal(shape)
    if source.distribution == "t":
        own = (1, shape[1]) if source.joint else shape
        z /= np.sqrt(generator.chisquare(source.dof, own) / source.dof)
    return z


def shortest_interval(values: FloatArray, probability: float) -> tuple[FloatArray, FloatArray]:
    """Return the shortest intervals (JCGM 101, 7.7.4) that hold a part of values (n, k); one for each column.

    Among all intervals between sorted values with ``q = p n`` values inside, the narrowest; where `n` is so small that
    ``q`` is all of them, the whole range.

    Examples
    --------
    >>> low, high = shortest_interval(np.array([[0.0], [10.0], [11.0], [12.0], [13.0]]), 0.6)
    >>> low.item(), high.item()
    (10.0, 13.0)
    """
    ordered = np.sort(values, axis=0)
    q = min(int(probability * len(ordered) + 0.5), len(ordered) - 1)
    widths = ordered[q:] - ordered[: len(ordered) - q]
    first = widths.argmin(axis=0)
    columns = np.arange(ordered.shape[1])
    return ordered[first, columns], ordered[first + q, columns]


def _summary(errors: FloatArray, probability: float) -> FloatArray:
    """Return mean, standard deviation and shortest interval of errors, shape (4, 6)."""
    low, high = shortest_interval(errors, probability)
    return np.array([errors.mean(axis=0), errors.std(axis=0, ddof=1), low, high])


def _scatter(found: list[FloatArray]) -> FloatArray:
    """Return twice the standard deviation of the averages over sequences; infinite for a single one."""
    if len(found) < 2:
        return np.full((4, 6), np.inf)
    return np.asarray(2.0 * np.std(found, axis=0, ddof=1) / np.sqrt(len(found)))


def _tolerance(given: npt.ArrayLike | None, digits: int | None, u: FloatArray) -> FloatArray:
    """Return the numerical tolerance of each axis."""
    if given is not None and digits is not None:
        raise ArgumentError("give either tolerance or digits")
    if digits is not None:
        if digits not in (1, 2, 3):
            raise ArgumentError(f"digits must be 1, 2 or 3 (1 or 2 are usual), found {digits!r}")
        exponent = np.floor(np.log10(np.where(u > 0.0, u, 1.0))) - (digits - 1)
        return np.asarray(np.where(u > 0.0, 0.5 * 10.0**exponent, 1e-15))
    if given is None:
        return np.asarray(np.maximum(0.05 * u, 1e-15))
    array = finite_array(given, (), "tolerance")
    if array.shape not in ((), (6,)) or not (array > 0.0).all():
        raise ArgumentError(f"tolerance must be one number above 0, or six (m and rad), found {array.tolist()}")
    return np.array(np.broadcast_to(array, (6,)))


def _draws(least: int, most: int, length: int) -> tuple[int, int]:
    """Return checked numbers of draws."""
    for name, value in (("least_draws", least), ("most_draws", most)):
        if not isinstance(value, int | np.integer) or isinstance(value, bool) or value < 1:
            raise ArgumentError(f"{name} must be a whole number above 0, found {value!r}")
    if most < max(least, 2 * length):
        raise ArgumentError(
            f"most_draws is {most}; at least {max(least, 2 * length)} are needed (least_draws, and two sequences of "
            f"{length})"
        )
    if most > MOST_DRAWS:
        raise ArgumentError(f"most_draws is {most}, above {MOST_DRAWS}: their errors are kept in memory, 48 bytes each")
    return int(least), int(most)


def _seed(seed: int) -> int:
    """Return a checked seed."""
    if not isinstance(seed, int | np.integer) or isinstance(seed, bool) or seed < 0:
        raise ArgumentError(f"seed must be a whole number from 0 on, found {seed!r}")
    return int(seed)
