"""One fit of a whole hexapod: coefficients from normal equations, and their covariance, checked between runs.

A model says which coefficients are free: ``b = fixed + C theta``. With the information ``S`` of all runs,

    theta = (C' S C)^-1 C' (z - S fixed),      cov_rows(theta) = f (C' S C)^-1,   f = max(1, chi2 / freedom)

holds where rows are independent.  Slow deviations (a thermometer's bias, heat that no thermometer sees) make rows of a
run deviate together; leaving out one run of R at a time shows it:

    cov_runs(theta) = (R - 1) / R  sum_r (theta_-r - mean) (theta_-r - mean)'

Each standard uncertainty is the larger of the two, correlations are those of the rows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hexathermal.errors import DataError
from hexathermal.learn.hexapod_model import HexapodEquations, RunEquations
from hexathermal.poses import FloatArray

LARGEST_CONDITION = 1e12
"""Of the information with unit diagonal: above, coefficients cannot be told apart."""


@dataclass(frozen=True, eq=False)
class HexapodModel:
    """Which coefficients are free.

    Attributes
    ----------
    name : str
    fixed : array, shape (p,)
    C : array, shape (p, k)
        ``b = fixed + C theta``.
    words : tuple of str
        What each theta is.
    """

    name: str
    fixed: FloatArray
    C: FloatArray
    words: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class HexapodFit:
    """A model fitted to runs.

    Attributes
    ----------
    model : HexapodModel
    theta, b : array, shape (k,), (p,)
    covariance : array, shape (k, k)
        Of theta; see the module.
    by_rows, by_runs : array, shape (k,)
        The two standard uncertainties; the latter NaN with fewer than two runs.
    chi2, freedom : float
        Weighted sum of squares, and rows' lengths less unknowns.
    left_out : array, shape (R,)
        Weighted mean square of each run under the coefficients found without it; NaN where that was not possible, or
        where the run's own frame takes all that it tells: a run of one row.
    left_out_b : array, shape (R, p)
        Those coefficients.
    """

    model: HexapodModel
    theta: FloatArray
    b: FloatArray
    covariance: FloatArray
    by_rows: FloatArray
    by_runs: FloatArray
    chi2: float
    freedom: float
    left_out: FloatArray
    left_out_b: FloatArray

    @property
    def full_covariance(self) -> FloatArray:
        """Covariance of b, shape (p, p)."""
        return np.asarray(self.model.C @ self.covariance @ self.model.C.T)


def model_of(
    name: str, sensors: tuple[str, ...], chosen: tuple[str, ...], *, common: bool,
    plates: tuple[float | None, float | None], legs: FloatArray | None = None, extra: tuple[str, ...] = (),
) -> HexapodModel:  # fmt: skip
    """Return a model of the coefficients of `hexathermal.learn.hexapod_model.coefficient_names`.

    Parameters
    ----------
    name : str
    sensors : tuple of str
        All that the coefficients stand for.
    chosen : tuple of str
        Those that the law reads; the others' coefficients are 0.
    common : bool
        One law for all legs.
    plates : (float or None, float or None) [1/K]
        Expansion of platform and base; None: free.
    legs : array, shape (6, 2, k), optional [1/K]
        A and B of the chosen sensors on each leg, where they are given and not free.
    extra : tuple of str
        Free motions of a frame that stand behind the coefficients.
    """
    s, k = len(sensors), len(chosen)
    p = 12 * s + 2
    fixed, C, words = np.zeros(p + len(extra)), list[FloatArray](), list[str]()
    at = [sensors.index(sensor) for sensor in chosen]

    def place(leg: int, symbol: int, sensor: int) -> int:
        """Return where a coefficient stands."""
        return 2 * s * leg + s * symbol + at[sensor]

    def free(places: list[int], word: str) -> None:
        """Let places share one free number."""
        column = np.zeros(len(fixed))
        column[places] = 1.0
        C.append(column)
        words.append(word)

    for symbol, letter in enumerate("AB"):
        for sensor in range(k):
            if legs is not None:
                for leg in range(6):
                    fixed[place(leg, symbol, sensor)] = legs[leg, symbol, sensor]
            elif common:
                free([place(leg, symbol, sensor) for leg in range(6)], f"{letter} {chosen[sensor]}")
    if legs is None and not common:
        for leg in range(6):
            for symbol, letter in enumerate("AB"):
                for sensor in range(k):
                    free([place(leg, symbol, sensor)], f"leg{leg + 1} {letter} {chosen[sensor]}")
    for part, (word, value) in enumerate(zip(("platform", "base"), plates, strict=True)):
        if value is None:
            free([12 * s + part], word)
        else:
            fixed[12 * s + part] = value
    for j, word in enumerate(extra):
        free([p + j], word)
    matrix = np.column_stack(C) if C else np.zeros((len(fixed), 0))
    return HexapodModel(name, fixed, matrix, tuple(words))


def solved(model: HexapodModel, S: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return theta, and the inverse of its information.

    Raises
    ------
    DataError
        A coefficient has no effect in these rows, or coefficients cannot be told apart; names them.
    """
    C = model.C
    if not C.shape[1]:
        return np.zeros(0), np.zeros((0, 0))
    M, right = C.T @ S @ C, C.T @ (z - S @ model.fixed)
    size = np.sqrt(np.diagonal(M))
    if not (size > 0.0).all():
        names = ", ".join(word for word, one in zip(model.words, size, strict=True) if not one > 0.0)
        raise DataError(
            f"{names}: nothing in these rows depends on it, its temperature never leaves its zero; leave the sensor "
            "out, or take plates from the machine (--plates known, or none)"
        )
    scaled = M / np.outer(size, size)
    values, vectors = np.linalg.eigh(scaled)
    if values[0] * LARGEST_CONDITION < values[-1]:
        weak = np.argsort(-np.abs(vectors[:, 0]))[:4]
        raise DataError(
            f"these rows cannot tell {', '.join(model.words[j] for j in weak)} apart; measure more different poses and "
            "temperatures (--propose), choose fewer sensors, or take plates from the machine (--plates known)"
        )
    inverse = (vectors / values) @ vectors.T / np.outer(size, size)
    return np.asarray(inverse @ right), np.asarray(inverse)


def without_frame(S: FloatArray, p: int) -> FloatArray:
    """Return the information of the first p coefficients, those behind them (a campaign's frame) eliminated."""
    if len(S) == p:
        return S
    return np.asarray(S[:p, :p] - S[:p, p:] @ np.linalg.solve(S[p:, p:], S[p:, :p]))


def fit_model(equations: HexapodEquations, model: HexapodModel) -> HexapodFit:
    """Return a model fitted to all runs, and to all but each.

    Parameters
    ----------
    equations : HexapodEquations
    model : HexapodModel

    Raises
    ------
    DataError
        As `solved`.
    """
    S, z, R = equations.S, equations.z, len(equations.runs)
    theta, inverse = solved(model, S, z)
    b = model.fixed + model.C @ theta
    chi2 = sum(run.square(b) for run in equations.runs)
    freedom = max(1.0, float(sum(run.freedom for run in equations.runs) - theta.size))
    without = [_without(model, S, z, run, R) for run in equations.runs]
    b_out = np.array([np.full(b.shape, np.nan) if one is None else model.fixed + model.C @ one for one in without])
    left_out = np.array([
        np.nan if one is None or not run.freedom else run.square(b_one) / run.freedom
        for run, one, b_one in zip(equations.runs, without, b_out, strict=True)
    ])  # fmt: skip
    by_rows = inverse * max(1.0, chi2 / freedom)
    sd_rows, sd_runs = np.sqrt(np.diagonal(by_rows)), np.full(theta.shape, np.nan)
    # a run that tells nothing is none of R: left out, it changes nothing
    some = np.array([one for run, one in zip(equations.runs, without, strict=True) if one is not None and run.freedom])
    if len(some) > 1 and theta.size:
        sd_runs = np.sqrt((len(some) - 1) / len(some) * ((some - some.mean(axis=0)) ** 2).sum(axis=0))
    larger = np.where(np.nan_to_num(sd_runs) > sd_rows, np.nan_to_num(sd_runs), sd_rows)
    scale = larger / np.where(sd_rows > 0.0, sd_rows, 1.0)
    return HexapodFit(
        model, theta, b, by_rows * np.outer(scale, scale), sd_rows, sd_runs, float(chi2), freedom, left_out, b_out
    )


def _without(
    model: HexapodModel, S: FloatArray, z: FloatArray, run: RunEquations, count: int
) -> FloatArray | None:  # fmt: skip
    """Return theta without a run; None where the others do not determine it."""
    if count < 2:
        return None
    try:
        return solved(model, S - run.S, z - run.z)[0]
    except DataError:
        return None
