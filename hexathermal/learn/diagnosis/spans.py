"""What stays of columns beside others that are refitted: their sizes and products, of many columns at once."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy import linalg

from hexathermal.poses import FloatArray

FEW = 2
"""Up to so many columns of each, products of many are sums over rows, all at once."""

LOST = 1e-4
"""A difference that is a smaller part of two numbers nearly alike would be one of their rounding."""


def visible(columns: FloatArray, base: FloatArray) -> FloatArray:
    """Return the RMS of what stays of columns after the base is refitted, shape (m,)."""
    return np.asarray(np.sqrt(squares(beside(columns, base)) / len(columns)))


def beside(columns: FloatArray, base: FloatArray) -> FloatArray:
    """Return what stays of columns after the base is refitted, shape (n, m)."""
    Q, keep = orthonormal(base)
    return without(columns, Q[:, keep])


def orthonormal(base: FloatArray) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
    """Return orthonormal columns, those of the first k a basis of the first k of the base, and which to keep."""
    Q, R = linalg.qr(base / (np.sqrt((base**2).mean(axis=0)) + 1e-30), mode="economic")
    return Q, np.abs(np.diag(R)) > 1e-9 * np.abs(np.diag(R)).max()


def without(columns: FloatArray, Q: FloatArray) -> FloatArray:
    """Return columns (n, m) less their parts along orthonormal ones (n, p)."""
    return np.asarray(columns - Q @ (Q.T @ columns))


def squares(columns: FloatArray) -> FloatArray:
    """Return the sum of squares of each of columns (n, m), shape (m,)."""
    return np.asarray(np.einsum("nm,nm->m", columns, columns))


def sizes_beside(columns: FloatArray, Q: FloatArray, along: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the RMS of columns (n, m), and of what stays of them beside Q (n, p); `along` (p, m) is ``Q' columns``."""
    whole = squares(columns)
    left = whole - squares(along)
    little = left < LOST * whole
    left[little] = squares(without(columns[:, little], Q))
    return np.sqrt(whole / len(columns)), np.sqrt(left / len(columns))


def products_beside(columns: FloatArray, Q: FloatArray, along: FloatArray, count: int) -> FloatArray:
    """Return `products` of what stays of columns (n, m) beside Q (n, p); `along` (p, m) is ``Q' columns``.

    Each is right to `LOST` of itself, so that the smallest eigenvalue may be a little below 0.
    """
    whole = products(columns, count)
    left = whole - products(along, count)
    stays, before = (np.diagonal(own, axis1=1, axis2=2) for own in (left, whole))
    little = (stays < LOST * before).any(axis=1)
    left[little] = products(without(columns[:, np.repeat(little, count)], Q), count)
    return left


def products(table: FloatArray, count: int) -> FloatArray:
    """Return the products of each `count` columns of a table with themselves, shape (t, count, count)."""
    if count > FEW:
        parts = table.reshape(len(table), table.shape[1] // count, count)
        return np.asarray(parts.transpose(1, 2, 0) @ parts.transpose(1, 0, 2))
    S = np.empty((table.shape[1] // count, count, count))
    for i in range(count):
        for j in range(i + 1):
            S[:, i, j] = S[:, j, i] = np.einsum("nt,nt->t", table[:, i::count], table[:, j::count])
    return S
