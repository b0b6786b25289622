"""Coefficients of Gaussian priors, integrated out of whitened data: evidence, means and covariances."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import linalg

from hexathermal.poses import FloatArray


def sums_without(parts: Sequence[FloatArray]) -> FloatArray:
    """Return for each of some arrays the sum of all others: nothing is taken away again, so that nothing is lost."""
    none = np.zeros((1, *parts[0].shape))
    if len(parts) == 1:
        return none
    before = np.cumsum(np.concatenate([none, parts[:-1]]), axis=0)
    after = np.cumsum(np.concatenate([none, parts[:0:-1]]), axis=0)[::-1]
    return np.asarray(before + after)


def solution(products: FloatArray) -> tuple[float, FloatArray, FloatArray]:
    """Return the log evidence, the means of coefficients of prior N(0, 1), and the lower factor; of products of data.

    `products` are those of whitened data and columns, as the compiled `integrated` takes them.
    """
    from hexathermal.learn.diagnosis.whitening_loops import integrated

    value, factor, z = integrated(products)
    return float(value), np.asarray(linalg.solve_triangular(factor, z, lower=True, trans=1)), factor


def expected(r: FloatArray, X: FloatArray, sd: FloatArray) -> tuple[float, FloatArray]:
    """Return the log evidence of whitened data with coefficients integrated, and their means."""
    table = sized(r, X, sd)
    value, mean, _ = solution(table.T @ table)
    return value, sd * mean


def marginal(r: FloatArray, X: FloatArray, sd: FloatArray) -> tuple[float, FloatArray, FloatArray]:
    """Return `expected`, and the covariance of the coefficients."""
    table = sized(r, X, sd)
    value, mean, factor = solution(table.T @ table)
    inverse = linalg.cho_solve((factor, True), np.eye(len(sd)))
    return value, sd * mean, inverse * np.outer(sd, sd)


def sized(r: FloatArray, X: FloatArray, sd: FloatArray) -> FloatArray:
    """Return data and columns times the sizes of their priors, row by row."""
    table = np.empty((len(r), 1 + X.shape[1]))
    table[:, 0] = r
    np.multiply(X, sd, out=table[:, 1:])
    return table
