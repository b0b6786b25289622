"""Cells along an axis: by how much those of one row overlap those of another."""

from __future__ import annotations

import numpy as np

from hexathermal.poses import FloatArray


def overlaps(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the lengths by which cells with these edges overlap, shape (a, b).

    Examples
    --------
    >>> overlaps(np.array([0.0, 1.0, 2.0]), np.array([0.5, 1.25]))
    array([[0.5 ],
           [0.25]])
    """
    upper = np.minimum(first[1:, None], second[None, 1:])
    lower = np.maximum(first[:-1, None], second[None, :-1])
    return np.asarray(np.maximum(upper - lower, 0.0))
