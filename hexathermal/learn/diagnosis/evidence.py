"""Evidence of trials over identical data: ``log p(y | trial)`` with amplitudes integrated over their priors.

With whitened data r, nuisance columns X of prior covariance D and a trial's columns Z, scaled so that what stays
visible of them after X is refitted has the RMS of the noise, amplitudes are ``N(0, rho^2)``::

    log B(rho) = 1/2 g' (S + I / rho^2)^-1 g - 1/2 log det(I + rho^2 S),    g = Z' P r,  S = Z' P Z,
    P = I - X (X'X + D^-1)^-1 X'

and the evidence is the mean over a grid of rho and over the trials of a cause (O'Hagan and Forster, Kendall's Advanced
Theory of Statistics 2B, 2004, 7.37 ff.).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt
from scipy import linalg

from hexathermal.learn.diagnosis.channels import Channel, Levels, marginal
from hexathermal.learn.diagnosis.trials import Trial
from hexathermal.poses import FloatArray

RHO = np.array([0.25, 0.5, 1.0, 2.0, 4.0])
"""Prior sizes of what stays visible of an effect, over the noise."""

TOLERATED = 0.05
"""Misfit that the null tolerates in any shape, RMS over the noise: no model is exact, and many rows would tell."""


@dataclass(frozen=True, eq=False)
class Base:
    """The law that trials extend: its columns with those adopted before, and the sizes of their priors."""

    X: FloatArray
    sd: FloatArray
    plain: int
    """Columns of the law and of what joined it; errors of thermometers stand behind."""

    def extended(self, columns: FloatArray, sizes: FloatArray) -> Base:
        """Return the base with more columns behind."""
        return Base(np.column_stack([self.X, columns]), np.concatenate([self.sd, sizes]), self.plain)


@dataclass(frozen=True, eq=False)
class Scored:
    """A trial with its log evidence less that of the null, at the null's noise.

    Attributes
    ----------
    trial : Trial
    value : float
    visible : float
        Visible RMS of what was found, in the channel's unit.
    noise : float
        RMS of the noise that it was scored at.
    spread : float
        Standard uncertainty of `visible`; NaN where data are mended.
    rho : float
        The best size of the prior.
    size : array, shape (k,)
        Standard deviation of the prior of each column's amplitude at that size.
    """

    trial: Trial
    value: float
    visible: float
    noise: float
    spread: float
    rho: float
    size: FloatArray

    @property
    def seen(self) -> float:
        """What was found over the noise."""
        return self.visible / self.noise

    @property
    def gated(self) -> float:
        """The evidence against a null that tolerates a small misfit of the same shape."""
        return min(self.value, relevance(self.visible, self.noise, self.trial.feigned))


def tolerance(noise: float, feigned: float) -> float:
    """Return the misfit that the null tolerates in any shape, RMS: of the noise, and what thermometers feign."""
    return float(np.hypot(TOLERATED * noise, feigned))


def relevance(shown: float, noise: float, feigned: float) -> float:
    """Return the most that an effect of some visible size may say against a null that tolerates small misfit.

    The null's misfit is ``N(0, tolerance^2)`` in the effect's own shape: many rows cannot make it more certain than
    ``1/2 (shown / tolerance)^2``.
    """
    return 0.5 * (shown / tolerance(noise, feigned)) ** 2


def visible(columns: FloatArray, base: FloatArray) -> FloatArray:
    """Return the RMS of what stays of columns after the base is refitted, shape (m,)."""
    return np.asarray(np.sqrt((beside(columns, base) ** 2).mean(axis=0)))


def beside(columns: FloatArray, base: FloatArray) -> FloatArray:
    """Return what stays of columns after the base is refitted, shape (n, m)."""
    Q, R = linalg.qr(base / (np.sqrt((base**2).mean(axis=0)) + 1e-30), mode="economic")
    keep = np.abs(np.diag(R)) > 1e-9 * np.abs(np.diag(R)).max()
    return np.asarray(columns - Q[:, keep] @ (Q[:, keep].T @ columns))


def sizes_of(trial: Trial, left: FloatArray, noise: float, largest: float) -> FloatArray:
    """Return amplitudes at which a trial's visible part has the RMS of the noise, none above a largest effect."""
    rms = np.sqrt((trial.columns**2).mean(axis=0)) + 1e-30
    k = trial.columns.shape[1]
    wanted = noise / np.sqrt(k) / np.maximum(left, 1e-3 * rms)
    return np.asarray(np.minimum(wanted, largest / rms))


@dataclass(frozen=True, eq=False)
class Projection:
    """A channel, a base and trials' columns, whitened, with the base integrated out.

    Attributes
    ----------
    r, X, Z : array, shape (n,), (n, p), (n, m)
        Of the channel, the base and all columns, whitened.
    Xs : array, shape (n, p)
        X times the sizes of the priors.
    factor : array, shape (p, p)
        Lower Cholesky factor of ``Xs' Xs + I``.
    HZ : array, shape (p, m)
    left : array, shape (m,)
        RMS of what stays visible of each column.
    places : tuple of slice
        Columns of each trial.
    """

    r: FloatArray
    X: FloatArray
    Z: FloatArray
    Xs: FloatArray
    factor: FloatArray
    HZ: FloatArray
    left: FloatArray
    places: tuple[slice, ...]

    def scores(self, rows: FloatArray) -> FloatArray:
        """Return ``Z' P r`` of whitened data r, shape (n,) or (n, d)."""
        return np.asarray(self.Z.T @ (rows - self.Xs @ linalg.cho_solve((self.factor, True), self.Xs.T @ rows)))

    def information(self, own: slice) -> FloatArray:
        """Return ``S = Z' P Z`` of a trial's columns."""
        return np.asarray(self.Z[:, own].T @ self.Z[:, own] - self.HZ[:, own].T @ self.HZ[:, own])


def stacked_columns(channel: Channel, trials: Sequence[Trial]) -> FloatArray:
    """Return the columns of all trials beside each other, shape (n, m)."""
    return np.column_stack([trial.columns for trial in trials]) if trials else np.zeros((len(channel), 0))


def projected(channel: Channel, base: Base, levels: Levels, columns: FloatArray, trials: Sequence[Trial]) -> Projection:
    """Return the projection of trials whose columns stand in `columns`."""
    n = base.X.shape[1]
    table, _logdet = channel.whitened(np.column_stack([channel.y, base.X, columns]), levels)
    r, X, Z = table[:, 0], table[:, 1 : n + 1], table[:, n + 1 :]
    Xs = X * base.sd
    factor, _lower = linalg.cho_factor(Xs.T @ Xs + np.eye(n), lower=True)
    HZ = linalg.solve_triangular(factor, Xs.T, lower=True) @ Z
    edges = np.cumsum([0, *(trial.columns.shape[1] for trial in trials)]).tolist()
    places = tuple(slice(a, b) for a, b in pairwise(edges))
    return Projection(r, X, Z, Xs, factor, HZ, visible(columns, base.X), places)


def screened(channel: Channel, base: Base, levels: Levels, trials: list[Trial], largest: float) -> list[Scored]:
    """Return all trials with their evidence at one noise.

    Parameters
    ----------
    channel : Channel
    base : Base
    levels : Levels
        Of the null.
    trials : list of Trial
    largest : float
        RMS of the largest effect thought possible, in the channel's unit.
    """
    terms = [trial for trial in trials if trial.base is None]
    columns = stacked_columns(channel, terms)
    view = projected(channel, base, levels, columns, terms)
    g = view.scores(view.r)
    plain = visible(columns, base.X[:, : base.plain])
    found = []
    for stack in stacked(view, terms, g[:, None], levels.rms, largest):
        values = np.array([stack.log_bayes(rho)[:, 0] for rho in RHO])
        best = RHO[np.argmax(values, axis=0)]
        amplitudes, over = stack.found(best)
        for k, t in enumerate(stack.at.tolist()):
            trial, rho = terms[t], float(best[k])
            shown = float(np.sqrt(((amplitudes[k] * plain[view.places[t]]) ** 2).sum()))
            value = float(mean_log(values[:, k])) + trial.advantage
            spread = shown / max(float(over[k]), 1e-12)
            found.append(Scored(trial, value, shown, levels.rms, spread, rho, rho * stack.size[k]))
    null, before, _ = marginal(view.r, view.X, base.sd)
    for trial in trials:
        if trial.base is not None:
            X = changed_base(base, trial).X
            value, after, _ = channel.solved(X, base.sd, levels)
            shown = float(np.sqrt(((X @ after - base.X @ before) ** 2).mean()))
            found.append(Scored(trial, value - null + trial.advantage, shown, levels.rms, math.nan, 0.0, np.zeros(0)))
    return found


def changed_base(base: Base, trial: Trial) -> Base:
    """Return the base with a trial's columns of the law in place of its own."""
    if trial.base is None:
        return base
    p = trial.base.shape[1]
    return Base(np.column_stack([trial.base, base.X[:, p:]]), base.sd, base.plain)


@dataclass(frozen=True, eq=False)
class Stack:
    """Trials of equally many columns, each turned to where its columns are independent.

    Attributes
    ----------
    at : array of int, shape (t,)
        Which trials they are.
    size : array, shape (t, k)
        Amplitudes at which the visible part has the RMS of the noise.
    w : array, shape (t, k)
    turn : array, shape (t, k, k)
        Eigenvalues and eigenvectors of ``D S D``, D of the sizes.
    b : array, shape (t, k, d)
        ``turn' D g`` of d vectors of data.
    """

    at: npt.NDArray[np.int64]
    size: FloatArray
    w: FloatArray
    turn: FloatArray
    b: FloatArray

    def log_bayes(self, rho: float) -> FloatArray:
        """Return log B at one size of the prior, shape (t, d)."""
        share = 1.0 / (1.0 / rho**2 + self.w)
        log_det = np.log1p(rho**2 * self.w).sum(axis=1)
        return np.asarray(0.5 * np.einsum("tk,tkd->td", share, self.b**2) - 0.5 * log_det[:, None])

    def found(self, rho: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return amplitudes (t, k) of the first data, each trial at a size of its prior, and size over error (t,)."""
        b = self.b[:, :, 0]
        share = 1.0 / (1.0 / rho[:, None] ** 2 + self.w)
        return self.size * np.einsum("tik,tk->ti", self.turn, share * b), np.sqrt((share * b**2).sum(axis=1))


def stacked(view: Projection, terms: Sequence[Trial], G: FloatArray, noise: float, largest: float) -> Iterator[Stack]:
    """Give the trials of a projection, with scores G (m, d) of data, in stacks of equally many columns.

    `noise` and `largest` are the RMS that the priors of amplitudes are made from, as `sizes_of` wants them.
    """
    sizes = [sizes_of(trial, view.left[own], noise, largest) for trial, own in zip(terms, view.places, strict=True)]
    counts = np.array([len(size) for size in sizes])
    for count in np.unique(counts).tolist():
        at = np.flatnonzero(counts == count)
        size = np.array([sizes[t] for t in at])
        S = np.array([view.information(view.places[t]) for t in at]) * size[:, :, None] * size[:, None, :]
        w, turn = np.linalg.eigh(S)
        g = np.array([G[view.places[t]] for t in at]) * size[:, :, None]
        yield Stack(at, size, np.maximum(w, 0.0), turn, np.einsum("tik,tid->tkd", turn, g))


def mean_log(values: FloatArray) -> FloatArray:
    """Return the logarithm of the mean of exponentials over the first axis."""
    top = values.max(axis=0)
    return np.asarray(top + np.log(np.exp(values - top).mean(axis=0)))
