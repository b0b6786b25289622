"""Loops of the thermal correction: commanded lengths for wanted poses, true lengths of commanded legs."""

from __future__ import annotations

import numpy as np

from hexathermal.kinematics.compiled import formula, loop, typed_loop
from hexathermal.kinematics.formulas import (
    commanded_length,
    dot,
    expanded,
    leg_vector,
    pose_of,
    rotate,
    rotation_error,
    triple,
    true_length,
)
from hexathermal.kinematics.layout import (
    BAD_POSE,
    BAD_SHAPE,
    BAD_TEMPERATURE,
    BASE,
    BASE_AXES,
    BASE_COSINES,
    BASE_PART,
    BLOCK,
    FIRST_SENSOR,
    HAS_CONES,
    LARGEST_LENGTH,
    LAST_SENSOR,
    LAW_A,
    LAW_B,
    LAW_HIGHEST,
    LAW_LOWEST,
    LAW_REFERENCE,
    LONGEST,
    OK,
    OUT_OF_CONE,
    OUT_OF_STROKE,
    PLATFORM,
    PLATFORM_AXES,
    PLATFORM_COSINES,
    PLATFORM_PART,
    Q0,
    ROTATION_TOLERANCE,
    SENSORS,
    SHORTEST,
)
from hexathermal.kinematics.lengths_loops import bad_bottom, bad_cone, entry, gathered, lane


@formula
def first_sensor(c, part):
    """Return the first column of a part's sensors: legs 0-5, platform, base."""
    return int(c[FIRST_SENSOR + part])


@formula
def last_sensor(c, part):
    """Return the column after a part's sensors."""
    return int(c[LAST_SENSOR + part])


@formula
def weighted(law, row, temps, first, last):
    """Return ``sum_s law[row, s] dT_s`` over a part's sensors."""
    total = 0.0
    for k in range(first, last):
        total += law[row, k] * (temps[k] - law[LAW_REFERENCE, k])
    return total


@formula
def plate_expansion(c, law, temps, part):
    """Return ``alpha dT`` of a plate, 0 where it has no sensor."""
    return weighted(law, LAW_A, temps, first_sensor(c, part), last_sensor(c, part))


@formula
def leg_coefficients(c, law, temps, i):
    """Return ``a = sum A_s dT_s`` and ``b = sum B_s dT_s`` of a leg."""
    first, last = first_sensor(c, i), last_sensor(c, i)
    return weighted(law, LAW_A, temps, first, last), weighted(law, LAW_B, temps, first, last)


@typed_loop("int64(f8[:,::1], f8[:,::1], f8[::1], f8[::1])")
def corrected_one(both, T, temps, out):
    """Commanded lengths of one pose at one set of temperatures; returns a code, `out` holds what was reached.

    `both`: the machine's constants, filled up, and below them the rows of the law, since each argument costs a call
    some 70 ns.
    """
    c, law = both[0], both[1:]
    n = int(c[SENSORS])
    if T.shape[0] != 4 or T.shape[1] != 4 or temps.shape[0] != n:
        return BAD_SHAPE
    R, t = pose_of(T)
    if not (rotation_error(R) + bad_bottom(T) < ROTATION_TOLERANCE):
        return BAD_POSE
    for k in range(n):
        if not ((temps[k] >= law[LAW_LOWEST, k]) & (temps[k] <= law[LAW_HIGHEST, k])):
            return BAD_TEMPERATURE
    ep, eb = plate_expansion(c, law, temps, PLATFORM_PART), plate_expansion(c, law, temps, BASE_PART)
    code = OK
    for i in range(6):
        a, b = leg_coefficients(c, law, temps, i)
        p = expanded(triple(c, PLATFORM + 3 * i), ep)
        _s, d = leg_vector(R, t, p, expanded(triple(c, BASE + 3 * i), eb))
        wanted = np.sqrt(dot(d, d))
        out[i] = commanded_length(a, b, c[Q0 + i], wanted)
        if not (wanted <= c[LARGEST_LENGTH]):
            return BAD_POSE
        if not ((out[i] >= c[SHORTEST + i]) & (out[i] <= c[LONGEST + i])):
            code = OUT_OF_STROKE
        elif c[HAS_CONES] != 0.0 and code == OK and bad_cone(c, R, i, d, wanted):
            code = OUT_OF_CONE
    return code


@loop
def block_coefficients(c, law, t, w, error):
    """Effective coefficients of a block from its temperatures (row a sensor): rows a, b of the legs, platform, base.

    `error` becomes 1 where a temperature is not a number or out of range.
    """
    for j in range(BLOCK):
        error[j] = 0.0
    for part in range(8):
        row_a, row_b = (2 * part) * BLOCK, (2 * part + 1) * BLOCK
        for j in range(BLOCK):
            w[row_a + j], w[row_b + j] = 0.0, 0.0
        for k in range(first_sensor(c, part), last_sensor(c, part)):
            A, B, reference = law[LAW_A, k], law[LAW_B, k], law[LAW_REFERENCE, k]
            low, high = law[LAW_LOWEST, k], law[LAW_HIGHEST, k]
            for j in range(BLOCK):
                value = t[k * BLOCK + j]
                w[row_a + j] += A * (value - reference)
                w[row_b + j] += B * (value - reference)
                error[j] = error[j] if (value >= low) & (value <= high) else 1.0


@loop
def corrected_leg(c, i, s, w, error, o):
    """Commanded lengths of leg `i` for a block; `error` grows where a length or a cone is not allowed."""
    p0, b0, q0 = triple(c, PLATFORM + 3 * i), triple(c, BASE + 3 * i), c[Q0 + i]
    low, high, reach = c[SHORTEST + i], c[LONGEST + i], c[LARGEST_LENGTH]
    u, v = triple(c, BASE_AXES + 3 * i), triple(c, PLATFORM_AXES + 3 * i)
    base_cosine, platform_cosine = c[BASE_COSINES + i], c[PLATFORM_COSINES + i]
    row_a, row_b, row_o = 2 * i * BLOCK, (2 * i + 1) * BLOCK, i * BLOCK
    for j in range(BLOCK):
        R, t = lane(s, j)
        p = expanded(p0, w[2 * PLATFORM_PART * BLOCK + j])
        _s, d = leg_vector(R, t, p, expanded(b0, w[2 * BASE_PART * BLOCK + j]))
        wanted = np.sqrt(dot(d, d))
        told = commanded_length(w[row_a + j], w[row_b + j], q0, wanted)
        o[row_o + j] = told
        good = (wanted <= reach) & (told >= low) & (told <= high) & (dot(u, d) >= base_cosine * wanted)
        good &= dot(rotate(R, v), d) >= platform_cosine * wanted
        error[j] += 0.0 if good else 1.0


@loop
def check_rotations(s, error):
    """Let `error` grow where a pose of a block is no rigid motion."""
    for j in range(BLOCK):
        R, _t = lane(s, j)
        error[j] += 0.0 if rotation_error(R) + s[12 * BLOCK + j] < ROTATION_TOLERANCE else 1.0


@loop
def corrected_many(both, T, temps, which_pose, which_temps, out):
    """Commanded lengths of many poses; returns the index of the first bad result or -1.

    Result ``k`` joins pose ``which_pose[k]`` and temperatures ``which_temps[k]``, see `entry`.
    """
    c, law = both[0], both[1:]
    n = int(c[SENSORS])
    s, w, o, error = np.zeros(13 * BLOCK), np.zeros(16 * BLOCK), np.zeros(6 * BLOCK), np.zeros(BLOCK)
    t = np.zeros(n * BLOCK)
    for first in range(0, out.shape[0], BLOCK):
        width = min(BLOCK, out.shape[0] - first)
        gathered(T, which_pose, first, width, s)
        for j in range(width):
            row = temps[entry(which_temps, first + j, temps.shape[0])]
            for k in range(n):
                t[k * BLOCK + j] = row[k]
        block_coefficients(c, law, t, w, error)
        for i in range(6):
            corrected_leg(c, i, s, w, error, o)
        check_rotations(s, error)
        for j in range(width):
            if not (error[j] < 0.5):
                return first + j
        for j in range(width):
            for i in range(6):
                out[first + j, i] = o[i * BLOCK + j]
    return -1


@loop
def warm_many(both, told, temps, which_told, which_temps, out, expansions):
    """True lengths of commanded legs, and the expansions of platform and base, at many temperatures."""
    c, law = both[0], both[1:]
    for k in range(out.shape[0]):
        n, m = entry(which_told, k, told.shape[0]), entry(which_temps, k, temps.shape[0])
        expansions[k, 0] = plate_expansion(c, law, temps[m], PLATFORM_PART)
        expansions[k, 1] = plate_expansion(c, law, temps[m], BASE_PART)
        for i in range(6):
            a, b = leg_coefficients(c, law, temps[m], i)
            out[k, i] = true_length(a, b, c[Q0 + i], told[n, i])
