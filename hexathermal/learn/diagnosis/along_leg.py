"""Values along a leg, foretold at a place by those of the places nearby."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from hexathermal.poses import FloatArray

NEAREST = 5

NEIGHBOURS, LEAST_PART = 6, 0.1
"""Places nearby whose misfit is the spread at a place, and the least part of the usual misfit that counts."""


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
    spread : array, shape (m, c)
        RMS misfit of the places nearby, each foretold by the others: smooth along a body, not where two meet.
    """

    def told(place: float, among: npt.NDArray[np.int64]) -> FloatArray:
        near, weights = _parabola(tuple(x[among].tolist()), float(place))
        return np.asarray(weights @ values[among[near]])

    left = np.array([values[k] - told(x[k], rest[rest != k]) for k in rest])
    usual = 1.48 * np.median(np.abs(left), axis=0) + 1e-3 * np.ptp(values, axis=0) + 1e-12
    near = [np.argsort(np.abs(x[rest] - place))[:NEIGHBOURS] for place in at]
    spread = np.array([np.sqrt((left[own] ** 2).mean(axis=0)) for own in near]) + LEAST_PART * usual
    return np.array([told(place, rest) for place in at]), spread


@lru_cache(maxsize=4096)
def _parabola(x: tuple[float, ...], place: float) -> tuple[npt.NDArray[np.int64], FloatArray]:
    """Return the nearest of places x, and the weights of their values in what a parabola has at a place."""
    apart = np.array(x) - place
    near = np.argsort(np.abs(apart))[:NEAREST]
    scale = max(float(np.ptp(apart[near])), 1e-9)
    design = np.vander(apart[near] / scale, 3, increasing=True)
    return near, np.linalg.lstsq(design, np.eye(len(near)), rcond=None)[0][0]


def parts_along(places: Mapping[str, float], length: float) -> dict[str, float]:
    """Return the part of a length that each place is the nearest of, without places that are the nearest of nothing.

    >>> parts_along({"low": 0.1, "high": 0.5}, 1.0)
    {'low': 0.3, 'high': 0.7}
    """
    order = sorted(places, key=lambda name: places[name])
    x = np.clip([places[name] for name in order], 0.0, length)
    edges = np.concatenate([[0.0], 0.5 * (x[1:] + x[:-1]), [length]])
    parts = (np.diff(edges) / length).tolist() if order else []
    return {name: part for name, part in zip(order, parts, strict=True) if part > 0.0}
