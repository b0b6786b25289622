"""Loops over poses: leg lengths and Jacobians, one pose or millions.

Poses come as ``(N, 4, 4)``.  Work is done in blocks of 64: a block is turned into arrays by coordinate, the straight
formulas run over it as vector code, and the result is turned back.  Every pose is checked on the way.
"""

from __future__ import annotations

import numpy as np

from hexathermal.kinematics.compiled import formula, loop, typed_loop
from hexathermal.kinematics.formulas import (
    dot,
    jacobian_row,
    leg_length,
    pose_of,
    rotate,
    rotation_error,
    six_joints,
    triple,
)
from hexathermal.kinematics.layout import (
    BAD_POSE,
    BAD_SHAPE,
    BASE,
    BASE_AXES,
    BASE_COSINES,
    BLOCK,
    LARGEST_LENGTH,
    OK,
    PLATFORM,
    PLATFORM_AXES,
    PLATFORM_COSINES,
    ROTATION_TOLERANCE,
)


@formula
def bad_bottom(T):
    """Return how far the last row of a pose is from ``[0, 0, 0, 1]``."""
    return abs(T[3, 0]) + abs(T[3, 1]) + abs(T[3, 2]) + abs(T[3, 3] - 1.0)


@formula
def bad_cone(c, R, i, d, length):
    """Return whether a leg leans further than the cones of its two joints allow."""
    lean = dot(triple(c, BASE_AXES + 3 * i), d)
    own = dot(rotate(R, triple(c, PLATFORM_AXES + 3 * i)), d)
    return lean < c[BASE_COSINES + i] * length or own < c[PLATFORM_COSINES + i] * length


@typed_loop("int64(f8[::1], f8[:,::1], f8[::1])")
def lengths_one(c, T, out):
    """Leg lengths of one pose; returns a code."""
    if T.shape[0] != 4 or T.shape[1] != 4:
        return BAD_SHAPE
    R, t = pose_of(T)
    if not (rotation_error(R) + bad_bottom(T) < ROTATION_TOLERANCE):
        return BAD_POSE
    good = True
    for i in range(6):
        out[i] = leg_length(R, t, triple(c, PLATFORM + 3 * i), triple(c, BASE + 3 * i))
        good &= out[i] <= c[LARGEST_LENGTH]
    return OK if good else BAD_POSE


@formula
def entry(which, k, count):
    """Return which entry result `k` takes: an index array, or `k` itself, or 0 where there is only one."""
    return which[k] if which.shape[0] else (k if count > 1 else 0)


@formula
def gathered(T, which, first, width, s):
    """Turn the poses behind a block of results into arrays by coordinate.

    Rows 0-11 hold the pose, row 12 the error of its last row; for `which` see `entry`.
    """
    for j in range(width):
        P = T[entry(which, first + j, T.shape[0])]
        s[j], s[BLOCK + j], s[2 * BLOCK + j], s[3 * BLOCK + j] = P[0, 0], P[0, 1], P[0, 2], P[0, 3]
        s[4 * BLOCK + j], s[5 * BLOCK + j], s[6 * BLOCK + j], s[7 * BLOCK + j] = P[1, 0], P[1, 1], P[1, 2], P[1, 3]
        s[8 * BLOCK + j], s[9 * BLOCK + j], s[10 * BLOCK + j], s[11 * BLOCK + j] = P[2, 0], P[2, 1], P[2, 2], P[2, 3]
        s[12 * BLOCK + j] = bad_bottom(P)


@formula
def lane(s, j):
    """Return pose ``j`` of a block as ``(R, t)``."""
    R = (
        s[j],
        s[BLOCK + j],
        s[2 * BLOCK + j],
        s[4 * BLOCK + j],
        s[5 * BLOCK + j],
        s[6 * BLOCK + j],
        s[8 * BLOCK + j],
        s[9 * BLOCK + j],
        s[10 * BLOCK + j],
    )
    return R, (s[3 * BLOCK + j], s[7 * BLOCK + j], s[11 * BLOCK + j])


@formula
def six_lengths(R, t, P, B):
    """Return the six leg lengths."""
    return (
        leg_length(R, t, P[0], B[0]), leg_length(R, t, P[1], B[1]), leg_length(R, t, P[2], B[2]),
        leg_length(R, t, P[3], B[3]), leg_length(R, t, P[4], B[4]), leg_length(R, t, P[5], B[5]),
    )  # fmt: skip


@loop
def lengths_many(c, T, out):
    """Leg lengths of many poses; returns the index of the first bad pose or -1."""
    n = T.shape[0]
    P, B, most = six_joints(c, PLATFORM), six_joints(c, BASE), c[LARGEST_LENGTH]
    s, o, error = np.zeros(13 * BLOCK), np.zeros(6 * BLOCK), np.zeros(BLOCK)
    in_step = np.empty(0, dtype=np.int64)
    for first in range(0, n, BLOCK):
        width = min(BLOCK, n - first)
        gathered(T, in_step, first, width, s)
        for j in range(BLOCK):
            R, t = lane(s, j)
            L = six_lengths(R, t, P, B)
            o[j], o[BLOCK + j], o[2 * BLOCK + j] = L[0], L[1], L[2]
            o[3 * BLOCK + j], o[4 * BLOCK + j], o[5 * BLOCK + j] = L[3], L[4], L[5]
            near = (L[0] <= most) & (L[1] <= most) & (L[2] <= most)
            near &= (L[3] <= most) & (L[4] <= most) & (L[5] <= most)
            error[j] = rotation_error(R) + s[12 * BLOCK + j] + (0.0 if near else 1.0)
        # a loop of its own: a count next to the formula would keep the compiler from vector code
        wrong = 0
        for j in range(width):
            wrong += 0 if error[j] < ROTATION_TOLERANCE else 1
        if wrong:
            for j in range(width):
                if not (error[j] < ROTATION_TOLERANCE):
                    return first + j
        for j in range(width):
            for i in range(6):
                out[first + j, i] = o[i * BLOCK + j]
    return -1


@typed_loop("int64(f8[::1], f8[:,::1], f8[:,::1])")
def jacobian_one(c, T, out):
    """Jacobian of one pose; returns a code."""
    if T.shape[0] != 4 or T.shape[1] != 4:
        return BAD_SHAPE
    R, t = pose_of(T)
    if not (rotation_error(R) + bad_bottom(T) < ROTATION_TOLERANCE):
        return BAD_POSE
    good = True
    for i in range(6):
        p, b = triple(c, PLATFORM + 3 * i), triple(c, BASE + 3 * i)
        row = jacobian_row(R, t, p, b)
        out[i, 0], out[i, 1], out[i, 2] = row[0], row[1], row[2]
        out[i, 3], out[i, 4], out[i, 5] = row[3], row[4], row[5]
        good &= (leg_length(R, t, p, b) <= c[LARGEST_LENGTH]) & np.isfinite(row[0])
    return OK if good else BAD_POSE


@loop
def jacobians_many(c, T, out):
    """Jacobians of many poses; returns the index of the first bad pose or -1."""
    for k in range(T.shape[0]):
        if jacobian_one(c, T[k], out[k]) != OK:
            return k
    return -1
