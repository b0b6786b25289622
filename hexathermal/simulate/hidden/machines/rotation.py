"""Rotations as quaternions ``(w, x, y, z)``, arrays of shape (..., 4)."""

from __future__ import annotations

import numpy as np

from hexathermal.poses import FloatArray


def product(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the rotation by `b` followed by that by `a`."""
    w, v = a[..., :1], a[..., 1:]
    s, u = b[..., :1], b[..., 1:]
    return np.concatenate([w * s - (v * u).sum(-1, keepdims=True), w * u + s * v + np.cross(v, u)], axis=-1)


def turned(turn: FloatArray, points: FloatArray) -> FloatArray:
    """Return points (..., 3) turned by unit quaternions."""
    w, v = turn[..., :1], turn[..., 1:]
    across = np.cross(v, points)
    return np.asarray(points + 2.0 * (w * across + np.cross(v, across)))


def from_vector(vector: FloatArray) -> FloatArray:
    """Return the rotation about a vector (..., 3) by its length [rad]."""
    half = 0.5 * np.linalg.norm(vector, axis=-1, keepdims=True)
    return np.concatenate([np.cos(half), 0.5 * np.sinc(half / np.pi) * vector], axis=-1)


def from_angles(angles: FloatArray) -> FloatArray:
    """Return the rotation by rx, ry, rz about the fixed axes x, y, z, in this order, of angles (..., 3) [rad]."""
    x, y, z = (from_vector(angles[..., k, None] * axis) for k, axis in enumerate(np.eye(3)))
    return product(z, product(y, x))


def angles_of(turn: FloatArray) -> FloatArray:
    """Return rx, ry, rz (..., 3) [rad] of unit quaternions, ry between -90 and 90 degrees.

    Examples
    --------
    >>> angles_of(from_angles(np.array([0.1, -0.2, 0.3]))).round(12).tolist()
    [0.1, -0.2, 0.3]
    """
    w, x, y, z = np.moveaxis(turn, -1, 0)
    rx = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    ry = np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0))
    rz = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return np.stack([rx, ry, rz], axis=-1)
