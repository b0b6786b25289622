"""Loops over sets of leg lengths: the pose of the platform, fast from home and carefully from anywhere.

From home: two chord steps with the inverse matrix of home (third-order accurate, no elimination), then Newton on the
squared lengths until the step is below `STEP_TOLERANCE`.  A result is accepted when the first Newton step was a
contraction, the determinant keeps home's sign with a margin, the pose is in the region about home that holds no
singular pose, and the lengths come back; all else is `UNSURE` and goes to the careful solver of `careful_loops`.
"""

from __future__ import annotations

import numpy as np

from hexathermal.kinematics.compiled import formula, loop, typed_loop
from hexathermal.kinematics.formulas import (
    chord_step,
    dot,
    leg_length,
    leg_vector,
    moved,
    newton_step,
    rotate,
    rotation_of,
    six_joints,
    step_size,
    thirty_six,
    triple,
)
from hexathermal.kinematics.layout import (
    BAD_SHAPE,
    BASE,
    BLOCK,
    CONTRACTION,
    DETERMINANT_RATIO,
    F_BASE,
    F_BASE_AXES,
    F_BASE_COSINES,
    F_CENTRE,
    F_COSINE,
    F_DETERMINANT,
    F_INVERSE,
    F_INVERSE_SIZE,
    F_ORDER,
    F_ORIGIN,
    F_PLATFORM,
    F_PLATFORM_AXES,
    F_PLATFORM_COSINES,
    F_Q,
    F_SHIFT,
    F_T,
    HAS_CONES,
    LONGEST,
    MACHINE_LENGTH,
    OK,
    OUT_OF_CONE,
    OUT_OF_STROKE,
    PLATFORM,
    SHORTEST,
    STEP_TOLERANCE,
    UNSURE,
)
from hexathermal.kinematics.lengths_loops import bad_cone

MOST_STEPS = 12
"""Newton steps of the fast loop; four are usual."""

RESIDUAL = 1e-14
"""Largest length error of an accepted pose, as a part of the machine's size."""


@formula
def predicted(f, P, B, L, K):
    """Return the pose after two chord steps from home."""
    t = triple(f, F_T)
    q = (f[F_Q], f[F_Q + 1], f[F_Q + 2], f[F_Q + 3])
    t, q = moved(t, q, chord_step(rotation_of(q[0], q[1], q[2], q[3]), t, P, B, L, K))
    return moved(t, q, chord_step(rotation_of(q[0], q[1], q[2], q[3]), t, P, B, L, K))


@formula
def worst_error(R, t, P, B, L):
    """Return the largest difference between wanted and actual lengths."""
    e0 = abs(leg_length(R, t, P[0], B[0]) - L[0])
    e1 = abs(leg_length(R, t, P[1], B[1]) - L[1])
    e2 = abs(leg_length(R, t, P[2], B[2]) - L[2])
    e3 = abs(leg_length(R, t, P[3], B[3]) - L[3])
    e4 = abs(leg_length(R, t, P[4], B[4]) - L[4])
    e5 = abs(leg_length(R, t, P[5], B[5]) - L[5])
    return max(max(max(e0, e1), max(e2, e3)), max(e4, e5))


@formula
def written(R, t, out):
    """Write a pose as a 4 x 4 matrix."""
    out[0, 0], out[0, 1], out[0, 2], out[0, 3] = R[0], R[1], R[2], t[0]
    out[1, 0], out[1, 1], out[1, 2], out[1, 3] = R[3], R[4], R[5], t[1]
    out[2, 0], out[2, 1], out[2, 2], out[2, 3] = R[6], R[7], R[8], t[2]
    out[3, 0], out[3, 1], out[3, 2], out[3, 3] = 0.0, 0.0, 0.0, 1.0


@formula
def from_centre(f, R, t):
    """Return the position of the platform's own origin in the base, given that of one centroid from the other."""
    s = rotate(R, triple(f, F_CENTRE))
    o = triple(f, F_ORIGIN)
    return ((t[0] - s[0]) + o[0], (t[1] - s[1]) + o[1], (t[2] - s[2]) + o[2])


@formula
def near_home(f, t, q):
    """Return whether a pose is in the region about home that is known to hold no singular pose."""
    h = triple(f, F_T)
    d = (t[0] - h[0], t[1] - h[1], t[2] - h[2])
    cosine = q[0] * f[F_Q] + q[1] * f[F_Q + 1] + q[2] * f[F_Q + 2] + q[3] * f[F_Q + 3]
    return (dot(d, d) <= f[F_SHIFT]) & (abs(cosine) >= f[F_COSINE])


@formula
def stroke_and_cones(c, R, t, L):
    """Return the code of the first limit that a pose breaks; `L` in the machine's order of legs."""
    code = OK
    for i in range(6):
        if not ((L[i] >= c[SHORTEST + i]) & (L[i] <= c[LONGEST + i])):
            return OUT_OF_STROKE
        _s, d = leg_vector(R, t, triple(c, PLATFORM + 3 * i), triple(c, BASE + 3 * i))
        if c[HAS_CONES] != 0.0 and bad_cone(c, R, i, d, L[i]):
            code = OUT_OF_CONE
    return code


@formula
def ordered(f, L):
    """Return six lengths in the order of elimination."""
    o = F_ORDER
    return (
        L[int(f[o])], L[int(f[o + 1])], L[int(f[o + 2])], L[int(f[o + 3])], L[int(f[o + 4])], L[int(f[o + 5])]
    )  # fmt: skip


@typed_loop("int64(f8[::1], f8[::1], f8[:,::1])")
def forward_one(both, lengths, out):
    """Pose of one set of lengths from home; returns `OK`, or `UNSURE` for all that needs another look.

    `both`: machine and forward constants in one array, since each argument costs a call some 70 ns.
    """
    c, f = both[:MACHINE_LENGTH], both[MACHINE_LENGTH:]
    if lengths.shape[0] != 6:
        return BAD_SHAPE
    P, B, K = six_joints(f, F_PLATFORM), six_joints(f, F_BASE), thirty_six(f, F_INVERSE)
    L = ordered(f, lengths)
    t, q = predicted(f, P, B, L, K)
    size, ratio, steps, sure = 1.0, 0.0, 0, True
    while steps < MOST_STEPS and not (size < STEP_TOLERANCE):
        x, determinant = newton_step(rotation_of(q[0], q[1], q[2], q[3]), t, P, B, L)
        size = step_size(x, f[F_INVERSE_SIZE])
        if steps == 0:
            sure = size < CONTRACTION
        t, q = moved(t, q, x)
        ratio = determinant / f[F_DETERMINANT]
        steps += 1
    R = rotation_of(q[0], q[1], q[2], q[3])
    good = sure & (ratio > DETERMINANT_RATIO) & (size < STEP_TOLERANCE) & near_home(f, t, q)
    most = RESIDUAL / f[F_INVERSE_SIZE]
    for k in range(6):
        i = int(f[F_ORDER + k])
        length = lengths[i]
        _s, d = leg_vector(R, t, triple(f, F_PLATFORM + 3 * k), triple(f, F_BASE + 3 * k))
        good &= abs(np.sqrt(dot(d, d)) - length) < most
        good &= (length >= c[SHORTEST + i]) & (length <= c[LONGEST + i])
        if c[HAS_CONES] != 0.0:
            good &= not bad_cone(c, R, i, d, length)
    written(R, from_centre(f, R, t), out)
    return OK if good else UNSURE


# rows of a block: position 0-2, quaternion 3-6, lengths 7-12, then these
RATIO, FIRST_STEP, ROTATION, WORST, CODE, ROWS = 13, 24, 14, 23, 25, 26


@formula
def block_pose(s, j):
    """Return the finished pose `j` of a block as ``(R, t)``."""
    R = (
        s[ROTATION * BLOCK + j], s[15 * BLOCK + j], s[16 * BLOCK + j],
        s[17 * BLOCK + j], s[18 * BLOCK + j], s[19 * BLOCK + j],
        s[20 * BLOCK + j], s[21 * BLOCK + j], s[22 * BLOCK + j],
    )  # fmt: skip
    return R, (s[j], s[BLOCK + j], s[2 * BLOCK + j])


@formula
def loaded(s, j):
    """Return position, quaternion and lengths of pose `j` of a block."""
    return (
        (s[j], s[BLOCK + j], s[2 * BLOCK + j]),
        (s[3 * BLOCK + j], s[4 * BLOCK + j], s[5 * BLOCK + j], s[6 * BLOCK + j]),
        (s[7 * BLOCK + j], s[8 * BLOCK + j], s[9 * BLOCK + j], s[10 * BLOCK + j], s[11 * BLOCK + j], s[12 * BLOCK + j]),
    )


@formula
def stored(s, j, t, q):
    """Write position and quaternion of pose `j` of a block."""
    s[j], s[BLOCK + j], s[2 * BLOCK + j] = t
    s[3 * BLOCK + j], s[4 * BLOCK + j], s[5 * BLOCK + j], s[6 * BLOCK + j] = q


@loop
def start_block(f, s):
    """Set a whole block to its prediction from home."""
    P, B, K = six_joints(f, F_PLATFORM), six_joints(f, F_BASE), thirty_six(f, F_INVERSE)
    for j in range(BLOCK):
        _t, _q, L = loaded(s, j)
        t, q = predicted(f, P, B, L, K)
        stored(s, j, t, q)


@loop
def step_block(f, s, first):
    """Move a whole block by one Newton step; returns how many poses have not converged."""
    P, B = six_joints(f, F_PLATFORM), six_joints(f, F_BASE)
    inverse_size, inverse_determinant = f[F_INVERSE_SIZE], 1.0 / f[F_DETERMINANT]
    moving = 0
    for j in range(BLOCK):
        t, q, L = loaded(s, j)
        x, determinant = newton_step(rotation_of(q[0], q[1], q[2], q[3]), t, P, B, L)
        size = step_size(x, inverse_size)
        t, q = moved(t, q, x)
        stored(s, j, t, q)
        s[RATIO * BLOCK + j] = determinant * inverse_determinant
        s[FIRST_STEP * BLOCK + j] = size if first else s[FIRST_STEP * BLOCK + j]
        moving += 0 if size < STEP_TOLERANCE else 1
    return moving


@loop
def finish_block(c, f, s):
    """Turn a block's quaternions into rotations and judge each pose: `CODE` is `OK`, `OUT_OF_STROKE` or `UNSURE`."""
    P, B = six_joints(f, F_PLATFORM), six_joints(f, F_BASE)
    low, high = ordered(f, c[SHORTEST : SHORTEST + 6]), ordered(f, c[LONGEST : LONGEST + 6])
    most = RESIDUAL / f[F_INVERSE_SIZE]
    for j in range(BLOCK):
        t, q, L = loaded(s, j)
        R = rotation_of(q[0], q[1], q[2], q[3])
        s[ROTATION * BLOCK + j], s[15 * BLOCK + j], s[16 * BLOCK + j] = R[0], R[1], R[2]
        s[17 * BLOCK + j], s[18 * BLOCK + j], s[19 * BLOCK + j] = R[3], R[4], R[5]
        s[20 * BLOCK + j], s[21 * BLOCK + j], s[22 * BLOCK + j] = R[6], R[7], R[8]
        worst = worst_error(R, t, P, B, L)
        s[WORST * BLOCK + j] = worst
        sure = (s[FIRST_STEP * BLOCK + j] < CONTRACTION) & (s[RATIO * BLOCK + j] > DETERMINANT_RATIO) & (worst < most)
        sure &= near_home(f, t, q)
        inside = (L[0] >= low[0]) & (L[1] >= low[1]) & (L[2] >= low[2])
        inside &= (L[3] >= low[3]) & (L[4] >= low[4]) & (L[5] >= low[5])
        inside &= (L[0] <= high[0]) & (L[1] <= high[1]) & (L[2] <= high[2])
        inside &= (L[3] <= high[3]) & (L[4] <= high[4]) & (L[5] <= high[5])
        s[CODE * BLOCK + j] = (OK if sure else UNSURE) if inside else OUT_OF_STROKE


@formula
def leans_too_far(R, t, p, b, base_axis, base_cosine, platform_axis, platform_cosine, L):
    """Return whether a leg of length `L` leans out of one of its joints' cones."""
    _s, d = leg_vector(R, t, p, b)
    return (dot(base_axis, d) < base_cosine * L) | (dot(rotate(R, platform_axis), d) < platform_cosine * L)


@loop
def cones_block(f, s):
    """Set the code of poses that are good but for a joint's cone."""
    P, B = six_joints(f, F_PLATFORM), six_joints(f, F_BASE)
    U, V = six_joints(f, F_BASE_AXES), six_joints(f, F_PLATFORM_AXES)
    g, h = six_numbers(f, F_BASE_COSINES), six_numbers(f, F_PLATFORM_COSINES)
    for j in range(BLOCK):
        t, q, L = loaded(s, j)
        R = rotation_of(q[0], q[1], q[2], q[3])
        bad = leans_too_far(R, t, P[0], B[0], U[0], g[0], V[0], h[0], L[0])
        bad |= leans_too_far(R, t, P[1], B[1], U[1], g[1], V[1], h[1], L[1])
        bad |= leans_too_far(R, t, P[2], B[2], U[2], g[2], V[2], h[2], L[2])
        bad |= leans_too_far(R, t, P[3], B[3], U[3], g[3], V[3], h[3], L[3])
        bad |= leans_too_far(R, t, P[4], B[4], U[4], g[4], V[4], h[4], L[4])
        bad |= leans_too_far(R, t, P[5], B[5], U[5], g[5], V[5], h[5], L[5])
        s[CODE * BLOCK + j] = OUT_OF_CONE if bad & (s[CODE * BLOCK + j] == OK) else s[CODE * BLOCK + j]


@formula
def six_numbers(c, k):
    """Return six numbers of an array."""
    return (c[k], c[k + 1], c[k + 2], c[k + 3], c[k + 4], c[k + 5])


@formula
def lengths_into_block(f, lengths, first, width, s):
    """Copy lengths into a block, legs in elimination order; a short block is filled up with its first pose."""
    o = (
        int(f[F_ORDER]),
        int(f[F_ORDER + 1]),
        int(f[F_ORDER + 2]),
        int(f[F_ORDER + 3]),
        int(f[F_ORDER + 4]),
        int(f[F_ORDER + 5]),
    )
    for j in range(BLOCK):
        L = lengths[first + (j if j < width else 0)]
        s[7 * BLOCK + j], s[8 * BLOCK + j], s[9 * BLOCK + j] = L[o[0]], L[o[1]], L[o[2]]
        s[10 * BLOCK + j], s[11 * BLOCK + j], s[12 * BLOCK + j] = L[o[3]], L[o[4]], L[o[5]]


@loop
def forward_many(c, f, lengths, out, codes, info):
    """Poses of many sets of lengths from home; `info` is (N, 3) or empty; returns how many are not `OK`."""
    n = lengths.shape[0]
    s = np.zeros(ROWS * BLOCK)
    not_ok = 0
    for first in range(0, n, BLOCK):
        width = min(BLOCK, n - first)
        lengths_into_block(f, lengths, first, width, s)
        start_block(f, s)
        steps = 1
        moving = step_block(f, s, True)
        while moving and steps < MOST_STEPS:
            moving = step_block(f, s, False)
            steps += 1
        finish_block(c, f, s)
        if c[HAS_CONES] != 0.0:
            cones_block(f, s)
        for j in range(width):
            k = first + j
            R, t = block_pose(s, j)
            t = from_centre(f, R, t)
            written(R, t, out[k])
            codes[k] = int(s[CODE * BLOCK + j])
            not_ok += 0 if codes[k] == OK else 1
        if info.shape[0]:
            for j in range(width):
                info[first + j, 0] = steps + 2.0
                info[first + j, 1] = s[WORST * BLOCK + j]
                info[first + j, 2] = s[RATIO * BLOCK + j]
    return not_ok
