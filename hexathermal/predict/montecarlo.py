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
from hexathermal.predict.budget_inputs import View, refuse_singular, situation
from hexathermal.predict.budget_rates import TOO_FAR, chord_errors, pose_numbers
from hexathermal.predict.budget_view import look
from hexathermal.predict.montecarlo_draws import Drawn, Sample, percent
from hexathermal.predict.sources import Source

MOST_DRAWS = 20_000_000

LEAST_TOLERANCE = 1e-15
"""Tolerance of an axis [m, rad] that nothing makes uncertain: rounding of kinematics."""

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
    lost : int
        Draws too far off for the branch of the pose to be certain. They count as outside every interval; mean,
        uncertainty and covariance are those of the others.
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
    lost: int
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

    @property
    def note(self) -> str:
        """What is to be known of lost draws; empty where there are none."""
        if not self.lost:
            return ""
        return (
            f"{self.lost} of {self.draws} draws ({percent(self.lost / self.draws)}) {TOO_FAR}; they count as outside "
            "every interval, mean, standard uncertainty and covariance are those of the others"
        )

    def as_dict(self) -> dict[str, Any]:
        """Return the simulation as plain values, um and urad; the budget is not in it."""
        return {
            "draws": self.draws, "sequences": self.sequences, "seed": self.seed,
            "lost_draws": self.lost, "note": self.note, "probability": self.probability,
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
    most_lost: float | None = None,
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
    most_lost : float, optional
        Largest part of draws too far off to be certain, below ``1 - p``. Default: 0.1 %, or ``(1 - p) / 10`` if less.
    seed : int
    progress : callable, optional, called as ``progress(done, most)``

    Raises
    ------
    NotConvergedError
        More draws are lost than may be.
    ArgumentError, HexathermalError
        Senseless tolerance, digits, numbers of draws or part that may be lost; as `error_budget`.

    Examples
    --------
    >>> import hexathermal as ht
    >>> hexapod = ht.load_hexapod("reference")
    >>> few = [Source("residual", "length", 0.35e-6)]
    >>> monte_carlo(hexapod, hexapod.home, [25.0] * 6, few).linear_may_be_used
    True
    """
    sample = Sample(checked_probability(probability), most_lost)
    counts = _draws(least_draws, most_draws, sample.length)
    generator = np.random.default_rng(_seed(seed))
    here, chosen = situation(hexapod, pose, temps, **view), checked_sources(hexapod, sources, view.get("plates"))
    budget = budget_of(here, chosen)
    delta = _tolerance(tolerance, digits, budget.uncertainty)
    _until_stable(Drawn(here, chosen), generator, sample, delta, counts, progress or (lambda _done, _most: None))
    return _simulation(budget, sample, delta, seed)


def _until_stable(
    draw: Drawn,
    generator: np.random.Generator,
    sample: Sample,
    delta: FloatArray,
    counts: tuple[int, int],
    progress: Callable[[int, int], None],
) -> None:
    """Add sequences until their results are stable; `counts`: least and most draws."""
    least, most = counts
    while True:
        sample.add(draw(sample.length, generator), least)
        progress(sample.draws, most)
        stable = bool((sample.scatter <= STABLE_PART * delta).all())
        if sample.draws + sample.length > most or (stable and sample.draws >= least):
            sample.refuse_lost(sample.draws)
            return


def _simulation(budget: Budget, sample: Sample, delta: FloatArray, seed: int) -> Simulation:
    """Return what all draws say, held against the linear budget."""
    mean, uncertainty, low, high = sample.whole()
    expanded, scatter = budget.expanded(sample.probability), sample.scatter
    covariance = np.cov(np.concatenate(sample.errors).T)
    differences = np.abs(np.array([budget.remaining - expanded - low, budget.remaining + expanded - high]))
    return Simulation(
        budget, sample.draws, len(sample.found), seed, sample.lost, sample.probability, frozen(mean),
        frozen(uncertainty), frozen(covariance), frozen(low), frozen(high), frozen(delta), frozen(scatter),
        bool((scatter <= STABLE_PART * delta).all()), frozen(differences),
    )  # fmt: skip


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
    seen = look(frame, frames, at_tool)
    numbers = pose_numbers(hexapod, wanted[None], seen.axes(wanted)[None], seen.arm)
    return chord_errors(numbers[0], told, np.empty((0, 36)))


def _tolerance(given: npt.ArrayLike | None, digits: int | None, u: FloatArray) -> FloatArray:
    """Return the numerical tolerance of each axis."""
    if given is not None and digits is not None:
        raise ArgumentError("give either tolerance or digits")
    if digits is not None:
        if digits not in (1, 2, 3):
            raise ArgumentError(f"digits must be 1, 2 or 3 (1 or 2 are usual), found {digits!r}")
        # 9.96 with two digits is 10 x 10^0: rounded first
        exponents = [int(f"{value:.{digits - 1}e}".partition("e")[2]) - (digits - 1) for value in u]
        return np.where(u > 0.0, 0.5 * 10.0 ** np.array(exponents, dtype=np.float64), LEAST_TOLERANCE)
    if given is None:
        return np.asarray(np.maximum(0.05 * u, LEAST_TOLERANCE))
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
