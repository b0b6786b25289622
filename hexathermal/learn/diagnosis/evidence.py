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
from dataclasses import dataclass

import numpy as np
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


def relevance(shown: float, noise: float, feigned: float) -> float:
    """Return the most that an effect of some visible size may say against a null that tolerates small misfit.

    The null's misfit is ``N(0, tolerance^2)`` in the effect's own shape, `TOLERATED` of the noise and what thermometers
    feign: many rows cannot make it more certain than ``1/2 (shown / tolerance)^2``.
    """
    return 0.5 * (shown / float(np.hypot(TOLERATED * noise, feigned))) ** 2


def visible(columns: FloatArray, base: FloatArray) -> FloatArray:
    """Return the RMS of what stays of columns after the base is refitted, shape (m,)."""
    N = base
    Q, R = linalg.qr(N / (np.sqrt((N**2).mean(axis=0)) + 1e-30), mode="economic")
    keep = np.abs(np.diag(R)) > 1e-9 * np.abs(np.diag(R)).max()
    left = columns - Q[:, keep] @ (Q[:, keep].T @ columns)
    return np.asarray(np.sqrt((left**2).mean(axis=0)))


def sizes_of(trial: Trial, left: FloatArray, noise: float, largest: float) -> FloatArray:
    """Return amplitudes at which a trial's visible part has the RMS of the noise, none above a largest effect."""
    rms = np.sqrt((trial.columns**2).mean(axis=0)) + 1e-30
    k = trial.columns.shape[1]
    wanted = noise / np.sqrt(k) / np.maximum(left, 1e-3 * rms)
    return np.asarray(np.minimum(wanted, largest / rms))


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
    n = base.X.shape[1]
    terms = [trial for trial in trials if trial.base is None]
    columns = np.column_stack([trial.columns for trial in terms]) if terms else np.zeros((len(channel), 0))
    table, _logdet = channel.whitened(np.column_stack([channel.y, base.X, columns]), levels)
    r, X, Z = table[:, 0], table[:, 1 : n + 1], table[:, n + 1 :]
    Xs = X * base.sd
    factor = linalg.cho_factor(Xs.T @ Xs + np.eye(n), lower=True)
    half = linalg.solve_triangular(factor[0], Xs.T, lower=True)
    rp = r - Xs @ linalg.cho_solve(factor, Xs.T @ r)
    HZ = half @ Z
    g = Z.T @ rp
    left = visible(columns, base.X)
    plain = visible(columns, base.X[:, : base.plain])
    found, at = [], 0
    for trial in terms:
        k = trial.columns.shape[1]
        own = slice(at, at + k)
        at += k
        size = sizes_of(trial, left[own], levels.rms, largest)
        S = Z[:, own].T @ Z[:, own] - HZ[:, own].T @ HZ[:, own]
        parts = [_log_bayes(S, g[own], rho * size) for rho in RHO]
        values = np.array([value for value, _mean, _size in parts])
        best = int(np.argmax(values))
        shown = float(np.sqrt(((parts[best][1] * plain[own]) ** 2).sum()))
        spread, rho = shown / max(parts[best][2], 1e-12), float(RHO[best])
        found.append(Scored(trial, mean_log(values) + trial.advantage, shown, levels.rms, spread, rho, rho * size))
    null, before, _ = marginal(r, X, base.sd)
    for trial in trials:
        if trial.base is not None:
            value, after = _changed(channel, base, levels, trial)
            moved = changed_base(base, trial).X @ after - base.X @ before
            shown = float(np.sqrt((moved**2).mean()))
            found.append(Scored(trial, value - null + trial.advantage, shown, levels.rms, math.nan, 0.0, np.zeros(0)))
    return found


def _changed(channel: Channel, base: Base, levels: Levels, trial: Trial) -> tuple[float, FloatArray]:
    """Return the log evidence, log det V apart, with the base's first columns changed by a trial, and coefficients."""
    X = changed_base(base, trial).X
    table, _ = channel.whitened(np.column_stack([channel.y, X]), levels)
    value, mean, _ = marginal(table[:, 0], table[:, 1:], base.sd)
    return value, mean


def changed_base(base: Base, trial: Trial) -> Base:
    """Return the base with a trial's columns of the law in place of its own."""
    if trial.base is None:
        return base
    p = trial.base.shape[1]
    return Base(np.column_stack([trial.base, base.X[:, p:]]), base.sd, base.plain)


def _log_bayes(S: FloatArray, g: FloatArray, sd: FloatArray) -> tuple[float, FloatArray, float]:
    """Return ``1/2 g' (S + D^-1)^-1 g - 1/2 log det(I + D S)``, D = diag(sd^2), amplitudes, their size over error."""
    if len(g) == 1:
        s, v = float(sd[0] ** 2 * S[0, 0]), float(sd[0] * g[0])
        size = abs(v) / math.sqrt(1.0 + s)
        return 0.5 * size**2 - 0.5 * math.log1p(s), sd * v / (1.0 + s), size
    M = S * np.outer(sd, sd)
    M[np.diag_indices_from(M)] += 1.0
    factor = linalg.cho_factor(M, lower=True, check_finite=False)
    b = sd * g
    z = linalg.cho_solve(factor, b, check_finite=False)
    size = math.sqrt(max(float(b @ z), 0.0))
    return 0.5 * size**2 - float(np.log(np.diag(factor[0])).sum()), sd * z, size


def mean_log(values: FloatArray) -> float:
    """Return the logarithm of the mean of exponentials."""
    top = float(np.max(values))
    return top + float(np.log(np.mean(np.exp(values - top))))
