"""The region about home that is known to hold no singular pose."""

from __future__ import annotations

import numpy as np

from hexathermal.poses import FloatArray

SCALES = tuple(0.05 * k for k in range(1, 21))
"""Shifts as parts of the machine's size, and turns in rad, that are looked at."""

DIRECTIONS = 240
"""Directions of shift and turn at each scale."""

MARGIN = 0.1
"""Smallest determinant in the region, as a part of home's."""


def regular_region(
    p: FloatArray, b: FloatArray, R: FloatArray, t: FloatArray, size: float, arm: float
) -> tuple[float, float]:
    """Return squared shift [m^2] and cosine of half the turn within which no singular pose is met on the way from home.

    Shifts of `SCALES` of the size, and as many radian, in directions spread evenly: the largest up to which the
    determinant of unit rows stays above `MARGIN` of home's everywhere.  A straight move of an origin `arm` away takes
    the centroid off its line by up to ``arm turn^2 / 8``, which is left free.
    """
    rng = np.random.default_rng(0)
    shifts, turns = rng.normal(size=(2, DIRECTIONS, 3))
    shifts, turns = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (shifts, turns))
    shifts[: DIRECTIONS // 8], turns[DIRECTIONS // 8 : DIRECTIONS // 4] = 0.0, 0.0
    own = unit_determinants(p, b, R[None], t[None])[0]
    good = 0.0
    for scale in SCALES:
        spun = _turned(scale * turns) @ R
        if not (unit_determinants(p, b, spun, t + scale * size * shifts) / own > MARGIN).all():
            break
        good = scale
    turn = min(good, float(np.sqrt(4.0 * good * size / arm)) if arm > 0.0 else good)
    shift = good * size - arm * turn**2 / 8.0
    return shift**2, float(np.cos(0.5 * turn))


def unit_determinants(p: FloatArray, b: FloatArray, R: FloatArray, t: FloatArray) -> FloatArray:
    """Return determinants of rows ``[u, s x u]`` with unit vectors ``u`` along the legs, poses (n, 3, 3) and (n, 3)."""
    s = p @ np.swapaxes(R, -1, -2)
    d = s + t[:, None] - b
    with np.errstate(all="ignore"):
        u = d / np.linalg.norm(d, axis=-1, keepdims=True)
    return np.asarray(np.linalg.det(np.concatenate([u, np.cross(s, u)], axis=-1)))


def _turned(v: FloatArray) -> FloatArray:
    """Return rotation matrices of rotation vectors (n, 3), by Rodrigues' formula."""
    angle = np.linalg.norm(v, axis=1)
    k = v / np.where(angle > 0.0, angle, 1.0)[:, None]
    K = np.zeros((len(v), 3, 3))
    K[:, 0, 1], K[:, 0, 2], K[:, 1, 2] = -k[:, 2], k[:, 1], -k[:, 0]
    K -= np.swapaxes(K, 1, 2)
    return np.asarray(np.eye(3) + np.sin(angle)[:, None, None] * K + (1.0 - np.cos(angle))[:, None, None] * (K @ K))
