"""Linear least squares to the last digit: columns scaled, QR, and refinement with residuals of higher precision.

Sets of sensors are compared by their Gram matrices (`hexathermal.learn.gram`); this is the path for one fit whose
columns may be nearly dependent, and the yardstick against which the other is tested.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError
from hexathermal.poses import FloatArray

LARGEST_CONDITION = 1e14
"""Largest condition number of the scaled columns: above, double precision cannot tell the coefficients apart."""

MOST_STEPS = 20


@dataclass(frozen=True, eq=False)
class Fit:
    """A linear least-squares fit.

    Attributes
    ----------
    coefficients : array, shape (p,)
    covariance : array, shape (p, p)
        ``residual_sd**2 (X' X)^-1``: for independent rows of one variance.
    residual_sd : float
        ``sqrt(sum of squares / (n - p))``; NaN where n = p.
    condition : float
        Condition number of the columns, each scaled to length 1.
    """

    coefficients: FloatArray
    covariance: FloatArray
    residual_sd: float
    condition: float


def least_squares(X: npt.ArrayLike, y: npt.ArrayLike) -> Fit:
    """Return the coefficients b that make ``|y - X b|`` smallest.

    QR with scaled columns gives the first answer; the augmented system ``r + X b = y, X' r = 0`` is then refined with
    residuals of higher precision (extended; exact where X holds `fractions.Fraction`) until nothing changes.

    Parameters
    ----------
    X : array, shape (n, p)
        Doubles, long doubles, or an object array of fractions.
    y : array, shape (n,)

    Raises
    ------
    ArgumentError
        Shapes do not fit, a value is not finite, fewer rows than columns, or columns depend on each other: their
        condition number exceeds `LARGEST_CONDITION`.

    Examples
    --------
    >>> fit = least_squares([[1.0, 0.0], [1.0, 1.0], [1.0, 2.0]], [1.0, 3.0, 5.0])
    >>> fit.coefficients.round(12).tolist()
    [1.0, 2.0]
    """
    wide_X, wide_y = _wide(X), _wide(y)
    if wide_X.dtype == object or wide_y.dtype == object:
        wide_X, wide_y = (_exact(array) for array in (wide_X, wide_y))
    if wide_X.ndim != 2 or wide_y.shape != (len(wide_X),):
        raise ArgumentError(f"X has shape {wide_X.shape} and y {wide_y.shape}; expected (n, p) and (n,)")
    n, p = wide_X.shape
    if p == 0 or n < p:
        raise ArgumentError(f"{n} rows cannot determine {p} coefficients")
    plain = wide_X.astype(np.float64)
    if not (np.isfinite(plain).all() and np.isfinite(wide_y.astype(np.float64)).all()):
        raise ArgumentError("X or y holds a value that is not finite")
    scale = np.sqrt((plain**2).sum(axis=0))
    if not scale.all():
        raise ArgumentError(f"column {int(np.argmin(scale)) + 1} of X is zero: its coefficient cannot be told")
    # powers of two: scaling then rounds nothing
    scale = np.exp2(np.round(np.log2(scale)))
    Q, R = np.linalg.qr(plain / scale)
    sizes = np.linalg.svd(R / np.sqrt((R**2).sum(axis=0)), compute_uv=False)
    condition = float(sizes[0] / sizes[-1]) if sizes[-1] > 0.0 else np.inf
    if condition > LARGEST_CONDITION:
        raise ArgumentError(
            f"the columns depend on each other (condition number {condition:.1e}, allowed {LARGEST_CONDITION:g}): "
            "their coefficients cannot be told apart; leave a column out"
        )
    right = np.concatenate([wide_y[:, None], _like(wide_X, np.zeros((n, p)))], axis=1)
    lower = _like(wide_X, np.concatenate([np.zeros((p, 1)), -np.eye(p)], axis=1))
    residual, solution = _refined(wide_X, scale, Q, R, right, lower)
    r = residual[:, 0]
    variance = float(r @ r) / (n - p) if n > p else np.nan
    inverse = solution[:, 1:].astype(np.float64)
    covariance = 0.5 * (inverse + inverse.T) * variance
    return Fit(solution[:, 0].astype(np.float64), covariance, float(np.sqrt(variance)), condition)


def _wide(values: npt.ArrayLike) -> Any:
    """Return values in the arithmetic that residuals are taken in."""
    array = np.asarray(values)
    return array if array.dtype == object else array.astype(np.longdouble)


def _exact(array: Any) -> Any:
    """Return numbers as fractions."""
    return np.array([Fraction(value) for value in array.ravel().tolist()], dtype=object).reshape(array.shape)


def _like(wide: Any, values: FloatArray) -> Any:
    """Return doubles in the arithmetic of `wide`; a fraction holds a double exactly."""
    if wide.dtype != object:
        return values.astype(wide.dtype)
    return np.array([Fraction(float(value)) for value in values.ravel()], dtype=object).reshape(values.shape)


def _refined(X: Any, scale: FloatArray, Q: FloatArray, R: FloatArray, f: Any, g: Any) -> tuple[Any, Any]:
    """Return ``r, b`` of ``r + X b = f, X' r = g`` for several right sides."""
    r, b = f * 0, g * 0
    last = np.inf
    for _step in range(MOST_STEPS):
        top = (f - r - X @ b).astype(np.float64)
        low = (g - X.T @ r).astype(np.float64) / scale[:, None]
        h = np.linalg.solve(R.T, low)
        d = Q.T @ top
        step = np.linalg.solve(R, d - h) / scale[:, None]
        r = r + _like(X, top - Q @ (d - h))
        b = b + _like(X, step)
        size = float(np.max(np.abs(step) / np.maximum(np.abs(b.astype(np.float64)), np.finfo(float).tiny)))
        if size < 1e-17 or size >= last:
            break
        last = size
    return r, b
