"""The careful solver: forward kinematics of one set of lengths from any pose, for any geometry near the machine's.

Newton with pivoting and a capped step; where its steps do not contract at once, the lengths are changed in small
parts from those of the start to the wanted ones (a homotopy), so that the branch of the start is followed.
"""

from __future__ import annotations

import numpy as np

from hexathermal.kinematics.compiled import formula, loop
from hexathermal.kinematics.formulas import (
    dot,
    expanded,
    leg_length,
    moved,
    newton_row,
    pose_of,
    rotate,
    rotation_of,
    step_size,
    triple,
)
from hexathermal.kinematics.forward_loops import stroke_and_cones
from hexathermal.kinematics.layout import (
    BASE,
    CONTRACTION,
    NEAR_SINGULAR,
    NOT_CONVERGED,
    OK,
    OTHER_BRANCH,
    OUT_OF_STROKE,
    PLATFORM,
    SINGULAR,
    SINGULAR_START,
    STEP_TOLERANCE,
    UNSURE,
)

MOST_STEPS = 60
CAP_TRANSLATION, CAP_ROTATION = 0.15, 0.25
"""Largest step of the capped Newton: parts of the machine's size, and rad."""

DOUBTFUL = 1e-4
"""Determinant of the unit rows, over the machine's size cubed, below which the condition number is looked at."""

SINGULAR_DETERMINANT = 1e-12
"""The same for a start: below it the sign is noise, and a start has no branch."""

FIRST_PART, SMALLEST_PART = 1.0 / 16.0, 1.0 / 4096.0
"""Parts of the way from the start's lengths to the wanted ones."""

WAY, NARROWINGS = 32, 16
"""Parts of the straight move at whose ends the determinant is taken; steps towards its least value between them."""

FAR_PIVOT = 5.0
"""Distance of the platform's origin from its joints, in sizes, from which on every straight move is checked."""

RESIDUAL = 2e-14
"""Largest length error of an accepted pose, as a part of the machine's size."""


@loop
def pivoted_step(t, q, joints, L, x):
    """Newton's step for six lengths with row pivoting; returns the determinant over the product of the lengths."""
    A = np.empty((6, 7))
    R = rotation_of(q[0], q[1], q[2], q[3])
    for i in range(6):
        row = newton_row(R, t, triple(joints, 3 * i), triple(joints, 18 + 3 * i), L[i])
        A[i, 0], A[i, 1], A[i, 2], A[i, 3], A[i, 4], A[i, 5], A[i, 6] = row
    determinant = 1.0
    for k in range(6):
        best = k
        for i in range(k + 1, 6):
            if abs(A[i, k]) > abs(A[best, k]):
                best = i
        if best != k:
            determinant = -determinant
            for j in range(7):
                A[k, j], A[best, j] = A[best, j], A[k, j]
        pivot = A[k, k]
        determinant *= pivot / L[k]
        if pivot == 0.0:
            return 0.0
        for i in range(k + 1, 6):
            factor = A[i, k] / pivot
            for j in range(k + 1, 7):
                A[i, j] -= factor * A[k, j]
    for k in range(5, -1, -1):
        value = A[k, 6]
        for j in range(k + 1, 6):
            value -= A[k, j] * x[j]
        x[k] = value / A[k, k]
    return determinant


@formula
def capped(x, size):
    """Shorten a step to the caps."""
    translation = max(max(abs(x[0]), abs(x[1])), abs(x[2])) / (CAP_TRANSLATION * size)
    rotation = max(max(abs(x[3]), abs(x[4])), abs(x[5])) / CAP_ROTATION
    most = max(translation, rotation)
    if most > 1.0:
        for k in range(6):
            x[k] /= most


@loop
def newton(t, q, joints, L, size, contraction):
    """Newton from a pose; returns pose, determinant, steps and whether it converged.

    With ``contraction > 0`` the first step must be below it and each further one below half of the one before;
    with 0 steps are capped, below 0 they are taken as they are, and any convergence counts.
    """
    x = np.zeros(6)
    before, determinant, steps = np.inf, 0.0, 0
    while steps < MOST_STEPS:
        determinant = pivoted_step(t, q, joints, L, x)
        step = step_size(x, 1.0 / size)
        if determinant == 0.0 or not np.isfinite(step):
            return t, q, determinant, steps, False
        steps += 1
        if contraction > 0.0:
            if step > contraction or (step > 0.5 * before and step > STEP_TOLERANCE):
                return t, q, determinant, steps, False
        elif contraction == 0.0:
            capped(x, size)
        t, q = moved(t, q, (x[0], x[1], x[2], x[3], x[4], x[5]))
        before = step
        if step < STEP_TOLERANCE:
            return t, q, determinant, steps, True
    return t, q, determinant, steps, False


@loop
def length_error(t, q, joints, L):
    """Largest difference between wanted and actual lengths."""
    R = rotation_of(q[0], q[1], q[2], q[3])
    worst = 0.0
    for i in range(6):
        worst = max(worst, abs(leg_length(R, t, triple(joints, 3 * i), triple(joints, 18 + 3 * i)) - L[i]))
    return worst


@loop
def followed(t, q, joints, L, size):
    """Follow the branch of the start along a straight line of squared lengths; returns pose, sign, steps, success.

    The determinant's sign must not change on the way.
    """
    R = rotation_of(q[0], q[1], q[2], q[3])
    start, target = np.empty(6), np.empty(6)
    for i in range(6):
        start[i] = leg_length(R, t, triple(joints, 3 * i), triple(joints, 18 + 3 * i))
    x = np.zeros(6)
    sign = np.sign(pivoted_step(t, q, joints, start, x))
    done, part, total = 0.0, FIRST_PART, 0
    while done < 1.0:
        ahead = min(1.0, done + part)
        for i in range(6):
            target[i] = np.sqrt((1.0 - ahead) * start[i] ** 2 + ahead * L[i] ** 2)
        t1, q1, determinant, steps, good = newton(t, q, joints, target, size, CONTRACTION)
        total += steps
        if good and determinant * sign > 0.0:
            t, q, done = t1, q1, ahead
            part = min(2.0 * part, 0.25)
        else:
            part *= 0.5
            if part < SMALLEST_PART:
                return t, q, total, False
    return t, q, total, True


@formula
def on_the_way(w, t0, q0, t1, q1, angle, c):
    """Pose at the part `w` of the straight move: the platform's origin runs along a line, the turn is even.

    Poses are of the joints' centroid, `c` from the platform's origin; `angle` is half the turn, ``q0 . q1 >= 0``.
    """
    v = 1.0 - w
    if angle > 1e-9:
        a, b = np.sin(v * angle) / np.sin(angle), np.sin(w * angle) / np.sin(angle)
    else:
        a, b = v, w
    q = (a * q0[0] + b * q1[0], a * q0[1] + b * q1[1], a * q0[2] + b * q1[2], a * q0[3] + b * q1[3])
    r0 = rotate(rotation_of(q0[0], q0[1], q0[2], q0[3]), c)
    r1 = rotate(rotation_of(q1[0], q1[1], q1[2], q1[3]), c)
    r = rotate(rotation_of(q[0], q[1], q[2], q[3]), c)
    t = (
        v * (t0[0] - r0[0]) + w * (t1[0] - r1[0]) + r[0],
        v * (t0[1] - r0[1]) + w * (t1[1] - r1[1]) + r[1],
        v * (t0[2] - r0[2]) + w * (t1[2] - r1[2]) + r[2],
    )
    return t, q


@loop
def straight_way_is_regular(t0, q0, t1, q1, joints, sign, c):
    """Whether the determinant keeps its sign on the straight move between two poses (that of `check_path`).

    The determinant is taken at 33 poses; about each of its smallest values the least one is looked for.
    """
    x, L, values = np.zeros(6), np.ones(6), np.empty(WAY + 1)
    cosine = q0[0] * q1[0] + q0[1] * q1[1] + q0[2] * q1[2] + q0[3] * q1[3]
    if cosine < 0.0:
        q1 = (-q1[0], -q1[1], -q1[2], -q1[3])
    angle = np.arccos(min(abs(cosine), 1.0))
    for k in range(WAY + 1):
        t, q = on_the_way(k / WAY, t0, q0, t1, q1, angle, c)
        values[k] = pivoted_step(t, q, joints, L, x) * sign
        if values[k] <= 0.0:
            return False
    for k in range(WAY + 1):
        before, after = max(k - 1, 0), min(k + 1, WAY)
        if values[k] <= values[before] and values[k] <= values[after]:
            low, high = before / WAY, after / WAY
            for _narrower in range(NARROWINGS):
                one, two = low + (high - low) * 0.382, low + (high - low) * 0.618
                t, q = on_the_way(one, t0, q0, t1, q1, angle, c)
                at_one = pivoted_step(t, q, joints, L, x) * sign
                t, q = on_the_way(two, t0, q0, t1, q1, angle, c)
                at_two = pivoted_step(t, q, joints, L, x) * sign
                if min(at_one, at_two) <= 0.0:
                    return False
                if at_one < at_two:
                    high = two
                else:
                    low = one
    return True


@loop
def quaternion_of(T):
    """Unit quaternion (x, y, z, w) of a pose, by the largest of its four numbers (Shepperd)."""
    R, _t = pose_of(T)
    trace = R[0] + R[4] + R[8]
    q = np.empty(4)
    if trace > max(max(R[0], R[4]), R[8]):
        q[0], q[1], q[2], q[3] = R[7] - R[5], R[2] - R[6], R[3] - R[1], 1.0 + trace
    elif R[0] >= R[4] and R[0] >= R[8]:
        q[0], q[1], q[2], q[3] = 1.0 + R[0] - R[4] - R[8], R[1] + R[3], R[2] + R[6], R[7] - R[5]
    elif R[4] >= R[8]:
        q[0], q[1], q[2], q[3] = R[1] + R[3], 1.0 + R[4] - R[0] - R[8], R[5] + R[7], R[2] - R[6]
    else:
        q[0], q[1], q[2], q[3] = R[2] + R[6], R[5] + R[7], 1.0 + R[8] - R[0] - R[4], R[3] - R[1]
    r = 1.0 / np.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    return (q[0] * r, q[1] * r, q[2] * r, q[3] * r)


@loop
def retried(t0, q0, t, q, joints, L, size, sign, c):
    """Newton from the start and from where the homotopy stopped, capped and plain; returns pose, steps and a code.

    A posture found so is taken only if the straight move to it is free of singular poses, and no other one is so.
    """
    best_t, best_q, code, steps = t, q, NOT_CONVERGED, 0
    for attempt in range(4):
        cap = 0.0 if attempt < 2 else -1.0
        if attempt % 2 == 0:
            t1, q1, _determinant, more, converged = newton(t0, q0, joints, L, size, cap)
        else:
            t1, q1, _determinant, more, converged = newton(t, q, joints, L, size, cap)
        steps += more
        if converged and length_error(t1, q1, joints, L) < RESIDUAL * size:
            if not straight_way_is_regular(t0, q0, t1, q1, joints, sign, c):
                if code == NOT_CONVERGED:
                    best_t, best_q, code = t1, q1, OTHER_BRANCH
            elif code != OK:
                best_t, best_q, code = t1, q1, OK
            elif apart(best_t, best_q, t1, q1, size):
                return best_t, best_q, steps, OTHER_BRANCH
    return best_t, best_q, steps, code


@formula
def apart(t0, q0, t1, q1, size):
    """Whether two postures differ by more than 1e-6 of the machine's size, or 1e-6 rad."""
    shift = max(max(abs(t0[0] - t1[0]), abs(t0[1] - t1[1])), abs(t0[2] - t1[2]))
    turn = abs(q0[0] * q1[0] + q0[1] * q1[1] + q0[2] * q1[2] + q0[3] * q1[3])
    return shift > 1e-6 * size or turn < 1.0 - 1e-12


@formula
def between_centres(T, centre, origin, way, out):
    """Write the pose between the joints' centroids for a pose of the platform (way 1), or the reverse (way -1)."""
    R, t = pose_of(T)
    s = rotate(R, (centre[0], centre[1], centre[2]))
    for i in range(3):
        out[i, 0], out[i, 1], out[i, 2] = R[3 * i], R[3 * i + 1], R[3 * i + 2]
        out[i, 3] = (t[i] - way * origin[i]) + way * s[i]
        out[3, i] = 0.0
    out[3, 3] = 1.0


@loop
def careful_one(joints, L, start, size, centre, out, info):
    """Pose of one set of lengths on the branch of `start`; returns a code; `info` takes steps, residual, determinant.

    `joints`: 36 numbers, platform then base; `start`: 4 x 4; `centre`: the joints' centroid from the platform's origin.
    """
    t0 = (start[0, 3], start[1, 3], start[2, 3])
    q0 = quaternion_of(start)
    c = (centre[0], centre[1], centre[2])
    x, own = np.zeros(6), np.empty(6)
    R = rotation_of(q0[0], q0[1], q0[2], q0[3])
    for i in range(6):
        own[i] = leg_length(R, t0, triple(joints, 3 * i), triple(joints, 18 + 3 * i))
    at_start = pivoted_step(t0, q0, joints, own, x)
    if not (abs(at_start) >= SINGULAR_DETERMINANT * size**3):
        for i in range(4):
            for j in range(4):
                out[i, j] = start[i, j]
        info[0], info[1], info[2] = 0, length_error(t0, q0, joints, L), at_start
        return SINGULAR_START
    sign = np.sign(at_start)
    t, q, determinant, steps, good = newton(t0, q0, joints, L, size, CONTRACTION)
    code = OK
    near = good
    if not good:
        t, q, more, good = followed(t0, q0, joints, L, size)
        steps += more
    if not good:
        t, q, more, code = retried(t0, q0, t, q, joints, L, size, sign, c)
        steps += more
    elif not (near and dot(c, c) < FAR_PIVOT**2 * size**2 and 0.5 < determinant / at_start < 2.0):
        code = OK if straight_way_is_regular(t0, q0, t, q, joints, sign, c) else OTHER_BRANCH
    determinant = pivoted_step(t, q, joints, L, x)
    worst = length_error(t, q, joints, L)
    R = rotation_of(q[0], q[1], q[2], q[3])
    for i in range(3):
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = R[3 * i], R[3 * i + 1], R[3 * i + 2], t[i]
        out[3, i] = 0.0
    out[3, 3] = 1.0
    info[0], info[1], info[2] = steps, worst, determinant
    if not (worst < RESIDUAL * size):
        return NOT_CONVERGED
    if code == OK and not (determinant * sign > 0.0):
        return SINGULAR if determinant * sign == 0.0 else OTHER_BRANCH
    return code


@loop
def careful_many(c, centre, origin, size, lengths, commands, starts, expansions, only_unsure, out, codes, info):
    """Careful solution of many sets of lengths; limits are held against `commands`; returns how many are not `OK`.

    `starts` (1 or N, 4, 4) and `expansions` (1 or N, 2: platform, base) serve all rows where there is one. With
    `only_unsure`, rows whose code is not `UNSURE` stay as they are.
    """
    joints = np.empty(36)
    start, found, row = np.empty((4, 4)), np.empty((4, 4)), np.empty(3)
    not_ok = 0
    for k in range(lengths.shape[0]):
        if not only_unsure or codes[k] == UNSURE:
            e = expansions[k if expansions.shape[0] > 1 else 0]
            for i in range(6):
                p = expanded(triple(c, PLATFORM + 3 * i), e[0])
                b = expanded(triple(c, BASE + 3 * i), e[1])
                for j in range(3):
                    joints[3 * i + j], joints[18 + 3 * i + j] = p[j] - centre[j], b[j] - origin[j]
            between_centres(starts[k if starts.shape[0] > 1 else 0], centre, origin, 1.0, start)
            code = careful_one(joints, lengths[k], start, size, centre, found, row)
            between_centres(found, centre, origin, -1.0, out[k])
            R, t = pose_of(out[k])
            limit = stroke_and_cones(c, R, t, commands[k])
            if code == OK or limit == OUT_OF_STROKE:
                code = limit
            if code == OK and abs(row[2]) < DOUBTFUL * size**3:
                code = NEAR_SINGULAR
            codes[k] = code
            if info.shape[0]:
                info[k, 0], info[k, 1], info[k, 2] = row[0], row[1], row[2]
        not_ok += 0 if codes[k] == OK else 1
    return not_ok
