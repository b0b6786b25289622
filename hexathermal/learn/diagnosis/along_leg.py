"""Values along a leg, foretold at a place by those of the places nearby."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hexathermal.poses import FloatArray

NEAREST = 5


def smooth_along(
    x: FloatArray, values: FloatArray, rest: npt.NDArray[np.int64], at: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return values foretold at places by a parabola through the five nearest of the rest, and their spread.

    Parameters
    ----------
    x : array, shape (s,)
        Places.
    values : array, shape (s, c)
        Of c quantities there.
    rest : array of int
        Places that may be looked at.
    at : array, shape (m,)

    Returns
    -------
    told : array, shape (m, c)
    spread : array, shape (c,)
        Of the rest, each foretold by the others.
    """

    def told(place: float, among: npt.NDArray[np.int64]) -> FloatArray:
        near = among[np.argsort(np.abs(x[among] - place))[:NEAREST]]
        scale = max(float(np.ptp(x[near])), 1e-9)
        design = np.vander((x[near] - place) / scale, 3, increasing=True)
        return np.asarray(np.linalg.lstsq(design, values[near], rcond=None)[0][0])

    left = np.array([values[k] - told(x[k], rest[rest != k]) for k in rest])
    spread = 1.48 * np.median(np.abs(left), axis=0) + 1e-3 * np.ptp(values, axis=0) + 1e-12
    return np.array([told(place, rest) for place in at]), spread
