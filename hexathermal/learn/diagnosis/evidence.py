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
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy import linalg

from hexathermal.learn.diagnosis.channels import Channel, Levels
from hexathermal.learn.diagnosis.coefficients import expected
from hexathermal.learn.diagnosis.spans import orthonormal, products, products_beside, sizes_beside
from hexathermal.learn.diagnosis.steadied import steadied_price
from hexathermal.learn.diagnosis.trials import Trial
from hexathermal.poses import FloatArray

RHO = np.array([0.25, 0.5, 1.0, 2.0, 4.0])
"""Prior sizes of what stays visible of an effect, over the noise."""

LEAST = 4.5
"""Log evidence that a name needs in any campaign."""

START = 0.7
"""What had not come to rest before the runs, over what they themselves do: both are of one room."""

TABLE = 500_000
"""Numbers of a table of trials' columns."""

TOLERATED = 0.05
"""Misfit that the null tolerates in any shape, RMS over the noise of a usual window: no model is exact, and many of
them would tell."""

WANDERING = 0.5
"""Part of what wanders that must stay beside a trial for all that thermometers feign to count, as they wander too."""

LEAST_WANDERING = 0.2
"""What wanders, over all noise, from which on the part of it that stays is asked."""


@dataclass(frozen=True, eq=False)
class Base:
    """The law that trials extend: its columns with those adopted before, and the sizes of their priors."""

    X: FloatArray
    sd: FloatArray
    plain: int
    """Columns of the law and of what joined it; errors of thermometers stand behind."""
    little: tuple[int, ...] = ()
    """Columns whose priors are so small that they hide nothing: what they could take of a trial stays visible."""

    def extended(self, columns: FloatArray, sizes: FloatArray, *, little: bool = False) -> Base:
        """Return the base with more columns behind."""
        before, count = self.X.shape[1], columns.shape[1]
        known = (*self.little, *range(before, before + count)) if little else self.little
        return Base(np.column_stack([self.X, columns]), np.concatenate([self.sd, sizes]), self.plain, known)

    @property
    def hiding(self) -> FloatArray:
        """Columns that may hide a trial, those of the law first."""
        return self.believing.X

    @property
    def believing(self) -> Base:
        """The base without columns that hide nothing: thermometers share no error."""
        if not self.little:
            return self
        return Base(np.delete(self.X, self.little, axis=1), np.delete(self.sd, self.little), self.plain)


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
        RMS of the noise of a usual window that it was scored at.
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
    def gated(self) -> float:
        """The evidence against a null that tolerates a small misfit of the same shape."""
        return min(self.value - self.trial.doubt, relevance(self.visible, self.noise, self.trial.feigned))


def less_feigned(scored: Scored, left: float, slow: float, noise: float) -> Scored:
    """Return a trial of which thermometers feign the less, the less wanders beside it: `left` of `slow` of `noise`.

    Of what hardly wanders at all it tells nothing how much is left.
    """
    part = min(1.0, left / (WANDERING * slow)) if slow > LEAST_WANDERING * noise else 1.0
    return replace(scored, trial=replace(scored.trial, feigned=part * scored.trial.feigned)) if part < 1.0 else scored


def tolerance(noise: float, feigned: float) -> float:
    """Return the misfit that the null tolerates in any shape, RMS: of the noise, and what thermometers feign."""
    return float(np.hypot(TOLERATED * noise, feigned))


def relevance(shown: float, noise: float, feigned: float) -> float:
    """Return the most that an effect of some visible size may say against a null that tolerates small misfit.

    The null's misfit is ``N(0, tolerance^2)`` in the effect's own shape: many rows cannot make it more certain than
    ``1/2 (shown / tolerance)^2``.
    """
    return 0.5 * (shown / tolerance(noise, feigned)) ** 2


@dataclass(frozen=True, eq=False)
class Terms:
    """Trials that add equally many columns each to the law, as every noise meets them.

    Attributes
    ----------
    trials : tuple of Trial
        t of them.
    columns : array, shape (n, t k)
        Of all trials beside each other.
    rms : array, shape (t, k)
        Of the columns.
    left : array, shape (t, k)
        RMS of what stays visible of each after the base is refitted.
    shown : array, shape (t, k, k)
        Mean products of what stays visible of a trial's columns after the law, and what joined it, is refitted.
    shares : array, shape (k,)
        Of the RMS of what is visible in each column.
    """

    trials: tuple[Trial, ...]
    columns: FloatArray
    rms: FloatArray
    left: FloatArray
    shown: FloatArray
    shares: FloatArray

    def sizes(self, noise: float, largest: float) -> FloatArray:
        """Return amplitudes at which visible parts have the RMS of the noise, none above a largest effect, (t, k)."""
        rms = self.rms + 1e-30
        wanted = noise * self.shares / np.maximum(self.left, 1e-3 * rms)
        return np.asarray(np.minimum(wanted, largest / rms))


def terms_of(base: Base, trials: Iterable[Trial]) -> list[Terms]:
    """Return those of some trials that add columns, in tables that a processor keeps at hand."""
    Q, keep = orthonormal(base.hiding)
    plain, Q = int(keep[: base.plain].sum()), np.ascontiguousarray(Q[:, keep])
    groups: dict[tuple[int, int, float], list[Trial]] = {}
    for trial in trials:
        if trial.base is None:
            groups.setdefault((trial.carried, trial.starts, trial.started), []).append(trial)
    found = []
    for (carried, starts, started), group in sorted(groups.items()):
        count, own_size = carried + starts, START * started
        shares = np.repeat([1.0 / np.sqrt(max(carried, 1)), own_size / np.sqrt(max(starts, 1))], [carried, starts])
        most = max(1, TABLE // (len(base.X) * count))
        for first in range(0, len(group), most):
            own = tuple(group[first : first + most])
            columns = stacked_columns(len(base.X), own)
            along = Q.T @ columns
            rms, left = (size.reshape(-1, count) for size in sizes_beside(columns, Q, along))
            shown = products_beside(columns, Q[:, :plain], along[:plain], count) / len(columns)
            found.append(Terms(own, columns, rms, left, shown, shares))
    return found


@dataclass(frozen=True, eq=False)
class Null:
    """A channel and a base, whitened, with the base integrated out.

    Attributes
    ----------
    r, X : array, shape (n,), (n, p)
        Of the channel and the base, whitened.
    Xs : array, shape (n, p)
        X times the sizes of the priors.
    factor : array, shape (p, p)
        Lower Cholesky factor of ``Xs' Xs + I``.
    """

    r: FloatArray
    X: FloatArray
    Xs: FloatArray
    factor: FloatArray

    def left(self, rows: FloatArray) -> FloatArray:
        """Return ``P r`` of whitened data r, shape (n,) or (n, d)."""
        return np.asarray(rows - self.Xs @ linalg.cho_solve((self.factor, True), self.Xs.T @ rows))

    def information(self, Z: FloatArray, count: int) -> FloatArray:
        """Return ``S = Z' P Z`` of each `count` of whitened columns, shape (t, count, count)."""
        return products(Z, count) - products(self._half @ Z, count)

    @cached_property
    def _half(self) -> FloatArray:
        """The whitened base over its factor, shape (p, n): ``P = I - H' H``."""
        return np.asarray(linalg.solve_triangular(self.factor, self.Xs.T, lower=True))


def null_of(channel: Channel, base: Base, levels: Levels) -> Null:
    """Return the null at one noise."""
    table, _logdet = channel.whitened(np.column_stack([channel.y, base.X]), levels)
    r, X = table[:, 0], table[:, 1:]
    Xs = X * base.sd
    factor, _lower = linalg.cho_factor(Xs.T @ Xs + np.eye(len(base.sd)), lower=True)
    return Null(r, X, Xs, factor)


def stacked_columns(n: int, trials: Sequence[Trial]) -> FloatArray:
    """Return the columns of trials, of n rows each, beside each other, shape (n, m)."""
    if len(trials) == 1:
        return trials[0].columns
    return np.concatenate([trial.columns for trial in trials], axis=1) if trials else np.zeros((n, 0))


def screened(
    channel: Channel, base: Base, levels: Levels, trials: Sequence[Trial], largest: float,
    terms: Sequence[Terms] | None = None,
) -> list[Scored]:  # fmt: skip
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
    terms : sequence of Terms, optional
        Of these trials beside this base, where they were made before.
    """
    null = null_of(channel, base, levels)
    left = null.left(null.r)[:, None]
    found = []
    for own in terms_of(base, trials) if terms is None else terms:
        stack = stacked(channel, null, own, left, levels, largest)
        grid = np.array([stack.log_bayes(rho)[:, 0] for rho in RHO])
        best, values = RHO[np.argmax(grid, axis=0)], mean_log(grid)
        amplitudes, over = stack.found(best)
        shown = np.sqrt(np.maximum(np.einsum("ti,tij,tj->t", amplitudes, own.shown, amplitudes), 0.0))
        spread = shown / np.maximum(over, 1e-12)
        sizes = best[:, None] * stack.size
        rows = zip(own.trials, values.tolist(), shown.tolist(), spread.tolist(), best.tolist(), sizes, strict=True)
        for trial, value, size, error, rho, prior in rows:
            found.append(Scored(trial, value + trial.advantage, size, levels.usual, error, rho, prior))
    alone, before = expected(null.r, null.X, base.sd)
    for trial in trials:
        if trial.base is not None:
            X = changed_base(base, trial).X
            value, after = channel.solved(X, base.sd, levels)
            if trial.unlate is not None:
                unlate = channel.solved(changed_base(base, trial.unlate).X, base.sd, levels)[0]
                value -= steadied_price(value - alone, unlate - alone)
            shown = float(np.sqrt(((X @ after - base.X @ before) ** 2).mean()))
            said = min(value - alone, trial.most) + trial.advantage
            found.append(Scored(trial, said, shown, levels.usual, math.nan, 0.0, np.zeros(0)))
    return found


def changed_base(base: Base, trial: Trial) -> Base:
    """Return the base with a trial's columns of the law in place of its own."""
    if trial.base is None:
        return base
    p = trial.base.shape[1]
    return Base(np.column_stack([trial.base, base.X[:, p:]]), base.sd, base.plain, base.little)


@dataclass(frozen=True, eq=False)
class Stack:
    """Trials of equally many columns, each turned to where its columns are independent.

    Attributes
    ----------
    size : array, shape (t, k)
        Amplitudes at which the visible part has the RMS of the noise.
    w : array, shape (t, k)
    turn : array, shape (t, k, k)
        Eigenvalues and eigenvectors of ``D S D``, D of the sizes.
    b : array, shape (t, k, d)
        ``turn' D g`` of d vectors of data.
    """

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


def stacked(channel: Channel, null: Null, terms: Terms, left: FloatArray, levels: Levels, largest: float) -> Stack:
    """Return trials at one noise, for d vectors of data that the null leaves, `left` (n, d).

    `largest` is the RMS of the largest effect thought possible; amplitudes count in the RMS of the noise.
    """
    Z, _logdet = channel.whitened(terms.columns, levels)
    size = terms.sizes(levels.rms, largest)
    S = null.information(Z, size.shape[1]) * size[:, :, None] * size[:, None, :]
    w, turn = np.linalg.eigh(S)
    g = (Z.T @ left).reshape(*size.shape, -1) * size[:, :, None]
    return Stack(size, np.maximum(w, 0.0), turn, np.einsum("tik,tid->tkd", turn, g))


def mean_log(values: FloatArray) -> FloatArray:
    """Return the logarithm of the mean of exponentials over the first axis."""
    top = values.max(axis=0)
    return np.asarray(top + np.log(np.exp(values - top).mean(axis=0)))
