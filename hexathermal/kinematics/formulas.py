"""The equations of a leg: the only place where they stand.

Each equation is one small function of plain numbers and tuples, without loops over legs, so that the compiler
turns the same text into code for one pose and into vector code for blocks of poses.  The loops that run them over
poses are in `lengths_loops` and `forward_loops`.

Notation: ``T_base_platform`` is ``(R, t)``; leg ``i`` runs from base joint ``b`` to platform joint ``p``;
``s = R p`` and ``d = t + s - b``, so that the inter-articular length is ``L = |d|``.  Metres and radians.

The module is imported on first use, never by ``import hexathermal``: it needs the compiler.
"""

from __future__ import annotations

import numpy as np

from hexathermal.kinematics.compiled import formula
from hexathermal.kinematics.elimination import solved


# --- equations ----------------------------------------------------------------------------------------------
@formula
def rotate(R, v):
    """Return ``R v``; ``R`` is nine numbers, row by row."""
    return (
        R[0] * v[0] + R[1] * v[1] + R[2] * v[2],
        R[3] * v[0] + R[4] * v[1] + R[5] * v[2],
        R[6] * v[0] + R[7] * v[1] + R[8] * v[2],
    )


@formula
def cross(a, b):
    """Return ``a x b``."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@formula
def dot(a, b):
    """Return ``a . b``."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@formula
def leg_vector(R, t, p, b):
    """Return ``(s, d)`` with ``s = R p`` and ``d = t + s - b``: the leg from base joint to platform joint."""
    s = rotate(R, p)
    return s, ((t[0] - b[0]) + s[0], (t[1] - b[1]) + s[1], (t[2] - b[2]) + s[2])


@formula
def leg_length(R, t, p, b):
    """Return ``L = |t + R p - b|``, the inter-articular length (eq. 2: ``L = q0 + q``)."""
    _s, d = leg_vector(R, t, p, b)
    return np.sqrt(dot(d, d))


@formula
def jacobian_row(R, t, p, b):
    """Return ``[u, (R p) x u]``: the rate of a length for a twist (velocity of the platform's origin, rotation)."""
    s, d = leg_vector(R, t, p, b)
    i = 1.0 / np.sqrt(dot(d, d))
    u = (d[0] * i, d[1] * i, d[2] * i)
    m = cross(s, u)
    return (u[0], u[1], u[2], m[0], m[1], m[2])


@formula
def newton_row(R, t, p, b, L):
    """Return ``[d, s x d, (L^2 - d.d)/2]``: a row of Newton's system for the squared length (no root, no division)."""
    s, d = leg_vector(R, t, p, b)
    m = cross(s, d)
    return (d[0], d[1], d[2], m[0], m[1], m[2], 0.5 * (L * L - dot(d, d)))


@formula
def leg_drift(a, b, q0, q):
    """Return ``a q0 + b q`` with ``a = sum A_s dT_s``, ``b = sum B_s dT_s``: the drift of a leg (eqs. 3, 4, 8)."""
    return a * q0 + b * q


@formula
def true_length(a, b, q0, command):
    """Return ``command + drift(command - q0)``: how long a warm leg is that was told to be ``command`` long."""
    return command + leg_drift(a, b, q0, command - q0)


@formula
def commanded_length(a, b, q0, wanted):
    """Return the command whose warm length is ``wanted``: the exact inverse of `true_length`.

    ``command = q0 + (wanted - q0 - a q0) / (1 + b)``, since the drift depends on the commanded stroke.
    """
    return q0 + (wanted - q0 - a * q0) / (1.0 + b)


@formula
def expanded(v, e):
    """Return ``v (1 + e)``: a plate's joint after the expansion ``e = alpha dT`` about the plate's origin (eq. 1)."""
    k = 1.0 + e
    return (v[0] * k, v[1] * k, v[2] * k)


@formula
def rotation_of(x, y, z, w):
    """Return the rotation matrix of a unit quaternion, row by row."""
    x2 = x + x
    y2 = y + y
    z2 = z + z
    xx, yy, zz, xy, xz, yz, wx, wy, wz = x * x2, y * y2, z * z2, x * y2, x * z2, y * z2, w * x2, w * y2, w * z2
    return (1.0 - (yy + zz), xy - wz, xz + wy, xy + wz, 1.0 - (xx + zz), yz - wx, xz - wy, yz + wx, 1.0 - (xx + yy))


@formula
def moved(t, q, x):
    """Return the pose after the step ``x`` (translation, rotation vector), turned by Cayley's map: no trigonometry."""
    a, b, c = 0.5 * x[3], 0.5 * x[4], 0.5 * x[5]
    i, j, k, w = q
    n0 = i + a * w + b * k - c * j
    n1 = j + b * w + c * i - a * k
    n2 = k + c * w + a * j - b * i
    n3 = w - a * i - b * j - c * k
    r = 1.0 / np.sqrt(n0 * n0 + n1 * n1 + n2 * n2 + n3 * n3)
    return (t[0] + x[0], t[1] + x[1], t[2] + x[2]), (n0 * r, n1 * r, n2 * r, n3 * r)


@formula
def rotation_error(R):
    """Return the largest entry of ``|R^T R - I|``, infinite for a mirror; NaN goes through."""
    c0, c1, c2 = (R[0], R[3], R[6]), (R[1], R[4], R[7]), (R[2], R[5], R[8])
    e = abs(dot(c0, c0) - 1.0) + abs(dot(c1, c1) - 1.0) + abs(dot(c2, c2) - 1.0)
    e += abs(dot(c0, c1)) + abs(dot(c0, c2)) + abs(dot(c1, c2))
    return e if dot(cross(c0, c1), c2) > 0.0 else e + 4.0


@formula
def thirty_six(f, k):
    """Return 36 numbers of an array."""
    return (
        f[k], f[k + 1], f[k + 2], f[k + 3], f[k + 4], f[k + 5],
        f[k + 6], f[k + 7], f[k + 8], f[k + 9], f[k + 10], f[k + 11],
        f[k + 12], f[k + 13], f[k + 14], f[k + 15], f[k + 16], f[k + 17],
        f[k + 18], f[k + 19], f[k + 20], f[k + 21], f[k + 22], f[k + 23],
        f[k + 24], f[k + 25], f[k + 26], f[k + 27], f[k + 28], f[k + 29],
        f[k + 30], f[k + 31], f[k + 32], f[k + 33], f[k + 34], f[k + 35],
    )  # fmt: skip


@formula
def triple(c, k):
    """Return three numbers of an array."""
    return (c[k], c[k + 1], c[k + 2])


@formula
def six_joints(c, k):
    """Return six joints of an array as tuples, so that the compiler keeps them out of memory's way."""
    return (triple(c, k), triple(c, k + 3), triple(c, k + 6), triple(c, k + 9), triple(c, k + 12), triple(c, k + 15))


@formula
def pose_of(T):
    """Return ``(R, t)`` of a 4 x 4 array as tuples."""
    R = (T[0, 0], T[0, 1], T[0, 2], T[1, 0], T[1, 1], T[1, 2], T[2, 0], T[2, 1], T[2, 2])
    return R, (T[0, 3], T[1, 3], T[2, 3])


@formula
def newton_step(R, t, P, B, L):
    """Return one Newton step for six squared lengths, and the determinant of its rows ``[d, s x d]``."""
    return solved(
        newton_row(R, t, P[0], B[0], L[0]),
        newton_row(R, t, P[1], B[1], L[1]),
        newton_row(R, t, P[2], B[2], L[2]),
        newton_row(R, t, P[3], B[3], L[3]),
        newton_row(R, t, P[4], B[4], L[4]),
        newton_row(R, t, P[5], B[5], L[5]),
    )


@formula
def half_square_error(R, t, p, b, L):
    """Return ``(L^2 - d.d)/2``."""
    _s, d = leg_vector(R, t, p, b)
    return 0.5 * (L * L - dot(d, d))


@formula
def chord_step(R, t, P, B, L, K):
    """Return ``K r`` for the six errors ``r``: Newton's step with the inverse ``K`` of another pose."""
    r0 = half_square_error(R, t, P[0], B[0], L[0])
    r1 = half_square_error(R, t, P[1], B[1], L[1])
    r2 = half_square_error(R, t, P[2], B[2], L[2])
    r3 = half_square_error(R, t, P[3], B[3], L[3])
    r4 = half_square_error(R, t, P[4], B[4], L[4])
    r5 = half_square_error(R, t, P[5], B[5], L[5])
    return (
        K[0] * r0 + K[1] * r1 + K[2] * r2 + K[3] * r3 + K[4] * r4 + K[5] * r5,
        K[6] * r0 + K[7] * r1 + K[8] * r2 + K[9] * r3 + K[10] * r4 + K[11] * r5,
        K[12] * r0 + K[13] * r1 + K[14] * r2 + K[15] * r3 + K[16] * r4 + K[17] * r5,
        K[18] * r0 + K[19] * r1 + K[20] * r2 + K[21] * r3 + K[22] * r4 + K[23] * r5,
        K[24] * r0 + K[25] * r1 + K[26] * r2 + K[27] * r3 + K[28] * r4 + K[29] * r5,
        K[30] * r0 + K[31] * r1 + K[32] * r2 + K[33] * r3 + K[34] * r4 + K[35] * r5,
    )


@formula
def step_size(x, i):
    """Return the largest of the rotation [rad] and the translation times ``i`` (one over the machine's size)."""
    m = max(max(abs(x[0]), abs(x[1])), abs(x[2])) * i
    return max(m, max(max(abs(x[3]), abs(x[4])), abs(x[5])))
