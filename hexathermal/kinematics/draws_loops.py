# mypy: allow-untyped-defs, allow-untyped-calls, allow-incomplete-defs
"""Loops over deviations of one machine at one pose: true lengths and joints, and the platform's exact error.

A *deviation* is one row of numbers, what the machine truly is minus what it is taken for; `Deviation.blocks` of
`hexathermal.predict.budget_inputs` names its parts.  The error of the platform follows by chord steps from the
expected pose with the inverse of Newton's matrix there, on the squared lengths: exact, whatever the deviation.
"""

from __future__ import annotations

import numpy as np

from hexathermal.kinematics.compiled import formula, loop
from hexathermal.kinematics.correction_loops import first_sensor, last_sensor
from hexathermal.kinematics.formulas import (
    chord_step,
    cross,
    dot,
    expanded,
    moved,
    rotate,
    rotation_of,
    six_joints,
    step_size,
    thirty_six,
    triple,
    true_length,
)
from hexathermal.kinematics.layout import (
    BASE,
    BLOCK,
    CONTRACTION,
    LAW_A,
    LAW_B,
    NOT_CONVERGED,
    OK,
    PLATFORM,
    PLATFORM_PART,
    Q0,
    SENSORS,
)

# numbers of a pose: joints seen from the platform's centroid (base axes), the inverse of Newton's matrix, the arm to
# the point (base axes), the axes in which errors are told, one over the machine's size, the platform's rotation and
# the centroids that joints are counted from
D_PLATFORM, D_BASE, D_INVERSE, D_ARM, D_AXES, D_INVERSE_SIZE = 0, 18, 36, 72, 75, 84
D_ROTATION, D_CENTRE, D_ORIGIN, DRAW_LENGTH = 85, 94, 97, 100

MOST_STEPS = 40
SMALL_STEP = 1e-11
"""A chord step below this (rad, or parts of the size) is the last: what it leaves is its square over the machine."""

SMALL_TURN = 1e-4
"""Half the turn, squared, up to which four terms of the arc sine are exact."""


@formula
def warm_joint(v, alpha, dT, g):
    """Return a joint of a plate at ``dT`` at its origin and a gradient ``g``: free expansion, no stress.

    ``v (1 + e) + (h . v) v - |v|^2 h / 2`` with ``e = alpha dT`` (eq. 1) and ``h = alpha g``: the displacement whose
    strain is ``alpha (dT + g . v)`` in every direction, without turning the plate at its origin.
    """
    h = (alpha * g[0], alpha * g[1], alpha * g[2])
    w = expanded(v, alpha * dT)
    s, m = dot(h, v), 0.5 * dot(v, v)
    return (w[0] + s * v[0] - m * h[0], w[1] + s * v[1] - m * h[1], w[2] + s * v[2] - m * h[2])


@formula
def true_machine(c, law, told, dT, lag, plates, x, lengths, joints):
    """Write true lengths (6) and joints (36) of a machine that deviates by ``x``.

    ``dT`` and ``lag`` hold, for each sensor, reading minus reference and minus air; `plates` two rows of expansion,
    temperature (0 where a sensor tells it), gradient and the point that does not move.
    """
    n, m = int(c[SENSORS]), first_sensor(c, PLATFORM_PART)
    gain, contact, A, B = n, 2 * n, 3 * n, 3 * n + m
    growth = 3 * n + 2 * m
    length, scale, base, platform = growth + 6, growth + 12, growth + 18, growth + 36
    expansion, warmth, slope, reference = growth + 54, growth + 56, growth + 58, growth + 64
    for i in range(6):
        a, b, mean = 0.0, 0.0, 0.0
        first, last = first_sensor(c, i), last_sensor(c, i)
        for k in range(first, last):
            d = dT[k] * (1.0 + x[gain + k]) + x[contact + k] * lag[k] + x[k] - x[reference]
            a += (law[LAW_A, k] + x[A + k]) * d
            b += (law[LAW_B, k] + x[B + k]) * d
            mean += d / (last - first)
        q0 = c[Q0 + i]
        a += x[growth + i] * mean
        b += x[growth + i] * mean
        lengths[i] = true_length(a, b, q0, told[i]) + x[length + i] + x[scale + i] * (told[i] - q0)
    for part in range(2):
        k = first_sensor(c, PLATFORM_PART + part)
        d = plates[part, 1] + x[warmth + part] - x[reference]
        if last_sensor(c, PLATFORM_PART + part) > k:
            d += dT[k] * (1.0 + x[gain + k]) + x[contact + k] * lag[k] + x[k]
        alpha = plates[part, 0] + x[expansion + part]
        g = (
            plates[part, 2] + x[slope + 3 * part],
            plates[part, 3] + x[slope + 3 * part + 1],
            plates[part, 4] + x[slope + 3 * part + 2],
        )
        own, shift = (PLATFORM, platform) if part == 0 else (BASE, base)
        for i in range(6):
            j = 3 * i
            h = (plates[part, 5], plates[part, 6], plates[part, 7])
            v = triple(c, own + j)
            w = warm_joint((v[0] - h[0], v[1] - h[1], v[2] - h[2]), alpha, d, g)
            for r in range(3):
                joints[18 * part + j + r] = h[r] + w[r] + x[shift + j + r]


@loop
def deviated_many(both, told, dT, lag, plates, x, lengths, joints):
    """Write true lengths (N, 6) and joints (N, 36) for many deviations (N, K)."""
    c, law = both[0], both[1:]
    for k in range(x.shape[0]):
        true_machine(c, law, told, dT, lag, plates, x[k], lengths[k], joints[k])


@loop
def length_rates(both, told, dT, lag, plates, R, units, steps, out):
    """Write the rates (6, K) of leg lengths for each deviation at a pose with leg directions `units` (6, 3).

    ``dl_i - u_i . R dp_i + u_i . db_i``: how much longer the leg is, less what its moved joints ask for.  Lengths and
    joints are linear in each single deviation, so that the difference over a step of any size is the derivative.
    """
    c, law = both[0], both[1:]
    count = steps.shape[0]
    x = np.zeros(count)
    L0, J0, L, J = np.empty(6), np.empty(36), np.empty(6), np.empty(36)
    true_machine(c, law, told, dT, lag, plates, x, L0, J0)
    turn = (R[0, 0], R[0, 1], R[0, 2], R[1, 0], R[1, 1], R[1, 2], R[2, 0], R[2, 1], R[2, 2])
    for k in range(count):
        x[k] = steps[k]
        true_machine(c, law, told, dT, lag, plates, x, L, J)
        x[k] = 0.0
        for i in range(6):
            j = 3 * i
            u = (units[i, 0], units[i, 1], units[i, 2])
            dp = rotate(turn, (J[j] - J0[j], J[j + 1] - J0[j + 1], J[j + 2] - J0[j + 2]))
            db = (J[18 + j] - J0[18 + j], J[19 + j] - J0[19 + j], J[20 + j] - J0[20 + j])
            out[i, k] = (L[i] - L0[i] - dot(u, dp) + dot(u, db)) / steps[k]


@formula
def nine(f, k):
    """Return nine numbers of an array."""
    return (f[k], f[k + 1], f[k + 2], f[k + 3], f[k + 4], f[k + 5], f[k + 6], f[k + 7], f[k + 8])


# rows of a block: position 0-2, quaternion 3-6, lengths 7-12, size of the last step, error 14-19, joints 20-55
STEP, FIRST, ERROR, JOINTS, ROWS = 13, 56, 14, 20, 57


@formula
def six_lengths(s, j):
    """Return the lengths of draw `j` of a block."""
    return (
        s[7 * BLOCK + j], s[8 * BLOCK + j], s[9 * BLOCK + j], s[10 * BLOCK + j], s[11 * BLOCK + j], s[12 * BLOCK + j]
    )  # fmt: skip


@formula
def stepped(s, j, P, B, K, inverse_size):
    """Move draw `j` of a block by one chord step; returns its size."""
    t = (s[j], s[BLOCK + j], s[2 * BLOCK + j])
    q = (s[3 * BLOCK + j], s[4 * BLOCK + j], s[5 * BLOCK + j], s[6 * BLOCK + j])
    x = chord_step(rotation_of(q[0], q[1], q[2], q[3]), t, P, B, six_lengths(s, j), K)
    t, q = moved(t, q, x)
    s[j], s[BLOCK + j], s[2 * BLOCK + j] = t
    s[3 * BLOCK + j], s[4 * BLOCK + j], s[5 * BLOCK + j], s[6 * BLOCK + j] = q
    size = step_size(x, inverse_size)
    s[STEP * BLOCK + j] = size
    return size


@loop
def step_one_machine(f, s):
    """Move a block by one chord step, all draws with the same joints; returns the largest step."""
    P, B, K = six_joints(f, D_PLATFORM), six_joints(f, D_BASE), thirty_six(f, D_INVERSE)
    for j in range(BLOCK):
        stepped(s, j, P, B, K, f[D_INVERSE_SIZE])
    return largest(s)


@formula
def joint_of(s, k, j):
    """Return one joint of draw `j` of a block."""
    return (s[(JOINTS + k) * BLOCK + j], s[(JOINTS + k + 1) * BLOCK + j], s[(JOINTS + k + 2) * BLOCK + j])


@formula
def joints_of(s, k, j):
    """Return six joints of draw `j` of a block."""
    return (
        joint_of(s, k, j), joint_of(s, k + 3, j), joint_of(s, k + 6, j),
        joint_of(s, k + 9, j), joint_of(s, k + 12, j), joint_of(s, k + 15, j),
    )  # fmt: skip


@loop
def step_many_machines(f, s):
    """Move a block by one chord step, each draw with its own joints; returns the largest step."""
    K = thirty_six(f, D_INVERSE)
    for j in range(BLOCK):
        stepped(s, j, joints_of(s, 0, j), joints_of(s, 18, j), K, f[D_INVERSE_SIZE])
    return largest(s)


@formula
def largest(s):
    """Return the largest step of a block; NaN where one is not a number."""
    most = 0.0
    for j in range(BLOCK):
        most = most if most >= s[STEP * BLOCK + j] else s[STEP * BLOCK + j]
    return most


@formula
def joints_into_block(f, joints, k, s, j):
    """Copy the joints of one machine, seen from the centroids and in base axes."""
    R = nine(f, D_ROTATION)
    for i in range(0, 18, 3):
        v = (joints[k, i] - f[D_CENTRE], joints[k, i + 1] - f[D_CENTRE + 1], joints[k, i + 2] - f[D_CENTRE + 2])
        w = rotate(R, v)
        for r in range(3):
            s[(JOINTS + i + r) * BLOCK + j] = w[r]
            s[(JOINTS + 18 + i + r) * BLOCK + j] = joints[k, 18 + i + r] - f[D_ORIGIN + r]


@loop
def errors_of_block(f, s):
    """Turn a block's motions into errors: shift of the point and rotation vector, in the axes asked for."""
    arm = triple(f, D_ARM)
    F = nine(f, D_AXES)
    for j in range(BLOCK):
        v = (s[3 * BLOCK + j], s[4 * BLOCK + j], s[5 * BLOCK + j])
        w = 2.0 * s[6 * BLOCK + j]
        # R a - a = 2 w (v x a) + 2 v x (v x a): nothing cancels
        c = cross(v, arm)
        e = cross(v, c)
        shift = rotate(F, (
            s[j] + w * c[0] + 2.0 * e[0],
            s[BLOCK + j] + w * c[1] + 2.0 * e[1],
            s[2 * BLOCK + j] + w * c[2] + 2.0 * e[2],
        ))  # fmt: skip
        z = dot(v, v)
        k = 2.0 * (1.0 + z * (1.0 / 6.0 + z * (3.0 / 40.0 + z * (15.0 / 336.0))))
        turn = rotate(F, (k * v[0], k * v[1], k * v[2]))
        for r in range(3):
            s[(ERROR + r) * BLOCK + j] = shift[r]
            s[(ERROR + 3 + r) * BLOCK + j] = turn[r]


@loop
def turns_of_block(s):
    """Correct the rotation vectors of large turns of a block."""
    for j in range(BLOCK):
        x, y, z, w = s[3 * BLOCK + j], s[4 * BLOCK + j], s[5 * BLOCK + j], s[6 * BLOCK + j]
        v = x * x + y * y + z * z
        if v > SMALL_TURN:
            k = 2.0 * np.arctan2(np.sqrt(v), w) / np.sqrt(v)
            series = 2.0 * (1.0 + v * (1.0 / 6.0 + v * (3.0 / 40.0 + v * (15.0 / 336.0))))
            for r in range(3):
                s[(ERROR + 3 + r) * BLOCK + j] *= k / series


@loop
def draw_errors(f, lengths, joints, out, codes):
    """Errors (N, 6) of the platform for many true lengths (N, 6) and joints (N, 36; empty: those of `f`).

    Returns how many draws are not `OK`: their first step was no contraction, or they did not converge.
    """
    n, own = lengths.shape[0], joints.shape[0] > 0
    s = np.zeros(ROWS * BLOCK)
    bad = 0
    for first in range(0, n, BLOCK):
        width = min(BLOCK, n - first)
        for j in range(BLOCK):
            k = first + (j if j < width else 0)
            for i in range(6):
                s[i * BLOCK + j] = 0.0
                s[(7 + i) * BLOCK + j] = lengths[k, i]
            s[6 * BLOCK + j] = 1.0
            if own:
                joints_into_block(f, joints, k, s, j)
        steps, most = 0, 1.0
        while steps < MOST_STEPS and not (most < SMALL_STEP):
            most = step_many_machines(f, s) if own else step_one_machine(f, s)
            if steps == 0:
                for j in range(BLOCK):
                    s[FIRST * BLOCK + j] = s[STEP * BLOCK + j]
            steps += 1
        errors_of_block(f, s)
        turns_of_block(s)
        for j in range(width):
            good = (s[FIRST * BLOCK + j] < CONTRACTION) & (s[STEP * BLOCK + j] < SMALL_STEP)
            codes[first + j] = OK if good else NOT_CONVERGED
            bad += 0 if good else 1
            for i in range(6):
                out[first + j, i] = s[(ERROR + i) * BLOCK + j]
    return bad
