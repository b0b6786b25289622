"""Evidence of candidates over identical data, amplitudes integrated over priors of a grid of sizes.

With S and ``g = Z' y`` of a candidate's columns after everything else was integrated out (`tables`), and amplitudes
``N(mean, f^2 diag(scale^2))``::

    log B(f) = mean' g - 1/2 mean' S mean + 1/2 h' (S + D^-1 / f^2)^-1 h - 1/2 log det(1 + f^2 D S),   h = g - S mean

(O'Hagan and Forster, Kendall's Advanced Theory of Statistics 2B, 2004, 11.27).  Sizes f are those at which the visible
effect has `STRENGTHS` times the noise; all are as likely before, so a candidate pays for parameters that it does not
need.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import TypeAlias

import numpy as np

from hexathermal.learn.machine_diagnosis.candidate import Candidate
from hexathermal.learn.machine_diagnosis.tables import Levels, Tables, backward, eliminated, forward
from hexathermal.poses import FloatArray

STRENGTHS = np.array([0.05, 0.1, 0.2, 0.4, 0.8, 1.6, 3.2, 6.4, 12.8])
"""Prior sizes of the visible effect, RMS over the noise."""

LEVEL_GRID = (0.1, 0.2, 0.4, 0.8, 1.6, 3.2, 6.4, 12.8, 50.0, 200.0, 1000.0)
PRIOR_OF_LEVEL = {"campaign": 0.02, "frame": 0.5, "slow": 0.5, "leg": 0.5}
"""Chance that a disturbance of a kind is there at all, before anything is seen: measured poses are given in the
machine's frame, so an offset of all runs alike is the least likely."""

SWEEPS = 2

Adopted: TypeAlias = tuple[slice, FloatArray, FloatArray]
"""Columns that are there, with mean and standard deviation of their amplitudes."""


@dataclass(frozen=True, eq=False)
class Scored:
    """A candidate, or two together, with the log evidence over none.

    Attributes
    ----------
    which : tuple of int
        Numbers of the candidates.
    value : float
        Log evidence, over the grid of sizes.
    paid : float
        What the grid of sizes costs: the value less that at the best size.
    size : float
        The best f.
    strength : float
        RMS of what was found, visible, over the noise.
    """

    which: tuple[int, ...]
    value: float
    paid: float
    size: float
    strength: float


def log_bayes(S: FloatArray, g: FloatArray, mean: FloatArray, sd: FloatArray) -> tuple[float, FloatArray]:
    """Return the log evidence of columns over none, amplitudes ``N(mean, sd^2)``, and the amplitudes found."""
    h = g - S @ mean
    M = S * np.outer(sd, sd)
    M[np.diag_indices_from(M)] += 1.0
    factor = np.linalg.cholesky(M)
    z = forward(factor, sd * h)
    found = mean + sd * backward(factor, z)
    value = float(mean @ g - 0.5 * mean @ S @ mean + 0.5 * z @ z - np.log(np.diagonal(factor)).sum())
    return value, found


def sizes_for(S: FloatArray, scale: FloatArray, rows: int) -> FloatArray:
    """Return the sizes f at which the visible effect is `STRENGTHS` times the noise; empty where nothing is visible."""
    whole = float((np.diagonal(S) * scale**2).sum())
    if not whole > 0.0:
        return np.zeros(0)
    return np.asarray(STRENGTHS * np.sqrt(6.0 * rows / whole))


def scored(S: FloatArray, g: FloatArray, one: Candidate, rows: int, which: int) -> Scored | None:
    """Return a candidate's evidence; None where these rows see nothing of it.

    Parameters
    ----------
    S, g : array, shape (k, k), (k,)
        Of its own columns.
    one : Candidate
    rows : int
    which : int
        Its number.
    """
    sizes = sizes_for(S, one.scale, rows)
    if one.mean.any():
        sizes = np.ones(1)
    if not sizes.size or not np.diagonal(S).any():
        return None
    values = values_at(S, g, one, sizes)
    values *= one.trust
    best = int(np.argmax(values))
    found = log_bayes(S, g, one.mean, sizes[best] * one.scale)[1]
    strength = float(np.sqrt(max(float(found @ S @ found), 0.0) / (6.0 * rows)))
    value = float(np.logaddexp.reduce(values)) - float(np.log(len(values)))
    return Scored((which,), value, value - float(values[best]), float(sizes[best]), strength)


def values_at(S: FloatArray, g: FloatArray, one: Candidate, sizes: FloatArray) -> FloatArray:
    """Return the log evidence of a candidate at sizes of its prior; one rotation serves all of them."""
    if one.mean.any():
        return np.array([log_bayes(S, g, one.mean, f * one.scale)[0] for f in sizes])
    w, vectors = np.linalg.eigh(S * np.outer(one.scale, one.scale))
    w, b = np.maximum(w, 0.0), np.square(vectors.T @ (one.scale * g))
    f = np.square(sizes)[:, None]
    return np.asarray(0.5 * ((f / (1.0 + f * w)) @ b) - 0.5 * np.log1p(f * w).sum(axis=1))


def screened(S: FloatArray, tables: Tables, candidates: Sequence[Candidate]) -> list[Scored]:
    """Return all candidates that rows see with their evidence.

    Parameters
    ----------
    S : array
        Of all candidates' columns and the residual, all else eliminated.
    tables : Tables
    candidates : sequence of Candidate
    """
    found, at = [], tables.base
    for k, (one, own) in enumerate(zip(candidates, tables.places, strict=True)):
        place = slice(own.start - at, own.stop - at)
        item = scored(S[place, place], S[place, -1], one, tables.rows, k)
        if item is not None:
            found.append(item)
    return found


def prior_of(levels: Levels) -> float:
    """Return the log prior of levels: each kind is there or not, and where it is, all sizes are as likely."""
    total = 0.0
    for name, there in PRIOR_OF_LEVEL.items():
        total += np.log(1.0 - there if getattr(levels, name) == 0.0 else there / len(LEVEL_GRID))
    return float(total)


def hypothesis(tables: Tables, levels: Levels, adopted: Sequence[Adopted]) -> tuple[float, FloatArray, FloatArray]:
    """Return the log evidence of the rows under law, disturbances and adopted candidates, up to a constant.

    Parameters
    ----------
    tables : Tables
    levels : Levels
    adopted : sequence of (slice, mean, sd)
        Columns with the priors of their amplitudes.

    Returns
    -------
    value : float
    mean, covariance : array, shape (m,), (m, m)
        Of the adopted amplitudes.
    """
    own = np.concatenate([np.arange(part.start, part.stop) for part, _m, _s in adopted] or [np.zeros(0, dtype=int)])
    which = np.concatenate([np.arange(tables.base), own, [tables.count]]).astype(np.int64)
    S, cost = tables.reduced(levels, which)
    S, more = eliminated(S, tables.sizes(levels))
    value = -0.5 * (cost + more) + prior_of(levels) - 0.5 * float(S[-1, -1])
    if not len(own):
        return value, np.zeros(0), np.zeros((0, 0))
    mean = np.concatenate([m for _p, m, _s in adopted])
    sd = np.concatenate([s for _p, _m, s in adopted])
    gained, found = log_bayes(S[:-1, :-1], S[:-1, -1], mean, sd)
    M = S[:-1, :-1] * np.outer(sd, sd) + np.eye(len(sd))
    return value + gained, found, np.asarray(np.linalg.inv(M) * np.outer(sd, sd))


def fitted_levels(tables: Tables, adopted: Sequence[Adopted], begin: Levels | None = None) -> tuple[Levels, float]:
    """Return the levels at which a hypothesis explains the rows best, and its log evidence there.

    One level after the other is tried on a grid, in two sweeps.
    """
    best = Levels() if begin is None else begin
    value = hypothesis(tables, best, adopted)[0]
    for _sweep in range(SWEEPS):
        before = value
        for name in PRIOR_OF_LEVEL:
            for size in (0.0, *LEVEL_GRID):
                trial = replace(best, **{name: size})
                if trial == best:
                    continue
                now = hypothesis(tables, trial, adopted)[0]
                if now > value:
                    best, value = trial, now
                elif size > getattr(best, name) and now < value - 20.0:
                    break
        if value - before < 0.1:
            break
    return best, value


def averaged(tables: Tables, levels: Levels, adopted: Sequence[Adopted]) -> tuple[FloatArray, FloatArray]:
    """Return mean and covariance of adopted amplitudes over levels about the best, each by its evidence.

    A level that is not quite known makes amplitudes less certain than the best level says.

    Returns
    -------
    mean, covariance : array, shape (m,), (m, m)
    """
    axes = [_neighbours(getattr(levels, name)) for name in ("frame", "slow", "leg")]
    found = [hypothesis(tables, replace(levels, frame=f, slow=s, leg=g), adopted) for f, s, g in product(*axes)]
    values = np.array([value for value, _mean, _covariance in found])
    weight = np.exp(values - values.max())
    weight /= weight.sum()
    means = np.array([mean for _value, mean, _covariance in found])
    mean = weight @ means
    spread = (means - mean).T * weight @ (means - mean)
    return mean, np.asarray(sum(w * one[2] for w, one in zip(weight, found, strict=True)) + spread)


def posterior(tables: Tables, levels: Levels, adopted: Sequence[Adopted]) -> tuple[FloatArray, FloatArray]:
    """Return mean and covariance of the amplitudes of law and campaign frame, and of those adopted behind them.

    Returns
    -------
    mean, covariance : array, shape (base + m,), (base + m, base + m)
    """
    own = [np.arange(part.start, part.stop) for part, _mean, _sd in adopted]
    which = np.concatenate([np.arange(tables.base), *own, [tables.count]]).astype(np.int64)
    S = tables.reduced(levels, which)[0]
    sd = np.concatenate([tables.sizes(levels), *(sd for _part, _mean, sd in adopted)])
    mean = np.concatenate([np.zeros(tables.base), *(mean for _part, mean, _sd in adopted)])
    inverse = np.linalg.inv(S[:-1, :-1] * np.outer(sd, sd) + np.eye(len(sd)))
    covariance = inverse * np.outer(sd, sd)
    return mean + covariance @ (S[:-1, -1] - S[:-1, :-1] @ mean), np.asarray(covariance)


def _neighbours(level: float) -> tuple[float, ...]:
    """Return a level of the grid with those beside it."""
    grid = (0.0, *LEVEL_GRID)
    k = grid.index(level)
    return grid[max(k - 1, 0) : k + 3]
