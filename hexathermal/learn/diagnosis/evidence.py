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

import numpy as np
import numpy.typing as npt
from scipy import linalg

from hexathermal.learn.diagnosis.channels import Channel, Levels, marginal
from hexathermal.learn.diagnosis.trials import Trial
from hexathermal.poses import FloatArray

RHO = np.array([0.25, 0.5, 1.0, 2.0, 4.0])
"""Prior sizes of what stays visible of an effect, over the noise."""

FEW = 2
"""Up to so many columns of each, products of many trials are made at once."""

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
    return _rms(beside(columns, base))


def _rms(columns: FloatArray) -> FloatArray:
    """Return the RMS of each column, shape (m,)."""
    return np.asarray(np.sqrt(np.einsum("nm,nm->m", columns, columns) / len(columns)))


def beside(columns: FloatArray, base: FloatArray) -> FloatArray:
    """Return what stays of columns after the base is refitted, shape (n, m)."""
    Q, R = linalg.qr(base / (np.sqrt((base**2).mean(axis=0)) + 1e-30), mode="economic")
    keep = np.abs(np.diag(R)) > 1e-9 * np.abs(np.diag(R)).max()
    return np.asarray(columns - Q[:, keep] @ (Q[:, keep].T @ columns))


@dataclass(frozen=True, eq=False)
class Terms:
    """Trials that add columns to the law, as every noise meets them.

    Attributes
    ----------
    trials : tuple of Trial
    columns : array, shape (n, m)
        Of all trials beside each other.
    edges : array of int, shape (t + 1,)
        Where each trial's columns begin.
    rms : array, shape (m,)
        Of the columns.
    left, plain : array, shape (m,)
        RMS of what stays visible of each after the base is refitted, and after the law and what joined it.
    """

    trials: tuple[Trial, ...]
    columns: FloatArray
    edges: npt.NDArray[np.int64]
    rms: FloatArray
    left: FloatArray
    plain: FloatArray

    def sizes(self, at: npt.NDArray[np.int64], noise: float, largest: float) -> FloatArray:
        """Return amplitudes at which visible parts have the RMS of the noise, none above a largest effect.

        `at`, shape (t, k), are the columns of t trials of k columns each.
        """
        rms = self.rms[at] + 1e-30
        wanted = noise / np.sqrt(at.shape[1]) / np.maximum(self.left[at], 1e-3 * rms)
        return np.asarray(np.minimum(wanted, largest / rms))


def terms_of(base: Base, trials: Sequence[Trial]) -> Terms:
    """Return those of some trials that add columns."""
    terms = tuple(trial for trial in trials if trial.base is None)
    columns = stacked_columns(len(base.X), terms)
    edges = np.cumsum([0, *(trial.columns.shape[1] for trial in terms)])
    plain = visible(columns, base.X[:, : base.plain])
    left = plain if base.plain == base.X.shape[1] else visible(columns, base.X)
    return Terms(terms, columns, edges, _rms(columns), left, plain)


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
    terms : Terms
        Whose columns they are.
    """

    r: FloatArray
    X: FloatArray
    Z: FloatArray
    Xs: FloatArray
    factor: FloatArray
    HZ: FloatArray
    terms: Terms

    def scores(self, rows: FloatArray) -> FloatArray:
        """Return ``Z' P r`` of whitened data r, shape (n,) or (n, d)."""
        return np.asarray(self.Z.T @ (rows - self.Xs @ linalg.cho_solve((self.factor, True), self.Xs.T @ rows)))

    def information(self, at: npt.NDArray[np.int64]) -> FloatArray:
        """Return ``S = Z' P Z`` of trials whose columns are `at`, shape (t, k), k each: (t, k, k)."""
        count = at.shape[1]
        if count > FEW:
            parts = [(self.Z[:, own], self.HZ[:, own]) for own in (slice(row[0], row[-1] + 1) for row in at.tolist())]
            return np.array([z.T @ z - h.T @ h for z, h in parts])
        S = np.empty((len(at), count, count))
        for i in range(count):
            for j in range(i + 1):
                S[:, i, j] = S[:, j, i] = _products(self.Z, at[:, i], at[:, j]) - _products(self.HZ, at[:, i], at[:, j])
        return S


def _products(table: FloatArray, first: npt.NDArray[np.int64], second: npt.NDArray[np.int64]) -> FloatArray:
    """Return the sums over rows of the products of some columns with others, shape (t,)."""
    one = table[:, first]
    other = one if first is second else table[:, second]
    return np.asarray(np.einsum("nt,nt->t", one, other))


def stacked_columns(n: int, trials: Sequence[Trial]) -> FloatArray:
    """Return the columns of trials, of n rows each, beside each other, shape (n, m)."""
    return np.concatenate([trial.columns for trial in trials], axis=1) if trials else np.zeros((n, 0))


def projected(channel: Channel, base: Base, levels: Levels, terms: Terms) -> Projection:
    """Return the projection of trials at one noise."""
    table, _logdet = channel.whitened(np.column_stack([channel.y, base.X]), levels)
    r, X = table[:, 0], table[:, 1:]
    Z, _logdet = channel.whitened(terms.columns, levels)
    Xs = X * base.sd
    factor, _lower = linalg.cho_factor(Xs.T @ Xs + np.eye(len(base.sd)), lower=True)
    HZ = linalg.solve_triangular(factor, Xs.T, lower=True) @ Z
    return Projection(r, X, Z, Xs, factor, HZ, terms)


def screened(
    channel: Channel, base: Base, levels: Levels, trials: Sequence[Trial], largest: float, terms: Terms | None = None
) -> list[Scored]:
    """Return all trials with their evidence at one noise.

    Parameters
    ----------
    channel : Channel
    base : Base
    levels : Levels
        Of the null.
    trials : sequence of Trial
    largest : float
        RMS of the largest effect thought possible, in the channel's unit.
    terms : Terms, optional
        Of these trials beside this base, where they were made before.
    """
    terms = terms_of(base, trials) if terms is None else terms
    view = projected(channel, base, levels, terms)
    found = []
    for stack in stacked(view, view.scores(view.r)[:, None], levels.rms, largest):
        grid = np.array([stack.log_bayes(rho)[:, 0] for rho in RHO])
        best, values = RHO[np.argmax(grid, axis=0)], mean_log(grid)
        amplitudes, over = stack.found(best)
        shown = np.sqrt(((amplitudes * terms.plain[stack.at]) ** 2).sum(axis=1))
        spread = shown / np.maximum(over, 1e-12)
        sizes = best[:, None] * stack.size
        rows = zip(stack.trials, values.tolist(), shown.tolist(), spread.tolist(), best.tolist(), sizes, strict=True)
        for trial, value, size, error, rho, prior in rows:
            found.append(Scored(trial, value + trial.advantage, size, levels.rms, error, rho, prior))
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
    trials : list of Trial
    at : array of int, shape (t, k)
        Which columns they have.
    size : array, shape (t, k)
        Amplitudes at which the visible part has the RMS of the noise.
    w : array, shape (t, k)
    turn : array, shape (t, k, k)
        Eigenvalues and eigenvectors of ``D S D``, D of the sizes.
    b : array, shape (t, k, d)
        ``turn' D g`` of d vectors of data.
    """

    trials: list[Trial]
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


def stacked(view: Projection, G: FloatArray, noise: float, largest: float) -> Iterator[Stack]:
    """Give the trials of a projection, with scores G (m, d) of data, in stacks of equally many columns.

    `noise` and `largest` are the RMS that the priors of amplitudes are made from, as `Terms.sizes` wants them.
    """
    terms = view.terms
    counts = np.diff(terms.edges)
    for count in np.unique(counts).tolist():
        own = np.flatnonzero(counts == count)
        at = terms.edges[own][:, None] + np.arange(count)
        size = terms.sizes(at, noise, largest)
        S = view.information(at) * size[:, :, None] * size[:, None, :]
        w, turn = np.linalg.eigh(S)
        b = np.einsum("tik,tid->tkd", turn, G[at] * size[:, :, None])
        yield Stack([terms.trials[t] for t in own.tolist()], at, size, np.maximum(w, 0.0), turn, b)


def mean_log(values: FloatArray) -> FloatArray:
    """Return the logarithm of the mean of exponentials over the first axis."""
    top = values.max(axis=0)
    return np.asarray(top + np.log(np.exp(values - top).mean(axis=0)))
