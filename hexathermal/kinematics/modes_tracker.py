"""Compiled path tracker for the forty postures of a hexapod (numba, complex128).

Import this module only where it is used: importing it imports numba; each function compiles at its first
call and is then cached on disk.

The unknown is a point x = (e, h) of P^7: e the quaternion of the rotation R, h the vector part of the
translation t, with N = e.e (complex bilinear products throughout)::

    R p = vec(e p e*) / N,   t = vec(h e*) / N,   e.h = 0                               (Study quadric)

    q_i(x) = h.h + c_i e.e + 2 (p_i - b_i).A - 2 (p_i + b_i).C - 2 N b_i.R p_i = 0,   i = 1 .. 6
    A = e_0 h_v - h_0 e_v,   C = e_v x h_v,   c_i = p_i.p_i + b_i.b_i - L_i^2

q_i = N (|t + R p_i - b_i|^2 - L_i^2).  A leg is the row (c, p, b) of 7 numbers, a machine `legs` (6, 7).
Each q_i is linear in 17 quadratic features of x (`_features`), so the Taylor series of a solution path
along a straight line of machines costs one factorization and a convolution; the step is a fraction of the
series' radius of convergence, that is of the distance to the nearest point where two paths meet.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba
import numpy as np
import numpy.typing as npt

C128 = npt.NDArray[np.complex128]
F64 = npt.NDArray[np.float64]
I64 = npt.NDArray[np.int64]
_Function = TypeVar("_Function", bound=Callable[..., Any])

ORDER = 8  # of the Taylor predictor
FEATURES = 17
MOST_STEPS = 3000  # of one path; usual are 40 to 150
SMALLEST = 1e-20  # s at which a path that cannot arrive is left
REGULAR, SINGULAR, LOST = 0, 1, 2  # how a path ends


def _compiled(function: _Function) -> _Function:
    """Compile at the first call; keep the machine code on disk."""
    return cast(_Function, numba.njit(cache=True, nogil=True, error_model="numpy")(function))


@_compiled
def _add_products(row: C128, b: C128, p: C128) -> None:
    """Add the features of -2 N b.R p to a row of coefficients (bilinear in b and p)."""
    dot = b[0] * p[0] + b[1] * p[1] + b[2] * p[2]
    row[7] -= 2 * dot
    row[8] -= 4 * (p[1] * b[2] - p[2] * b[1])
    row[9] -= 4 * (p[2] * b[0] - p[0] * b[2])
    row[10] -= 4 * (p[0] * b[1] - p[1] * b[0])
    for i in range(3):
        row[11 + i] += 2 * dot - 4 * b[i] * p[i]
    row[14] -= 4 * (b[0] * p[1] + b[1] * p[0])
    row[15] -= 4 * (b[0] * p[2] + b[2] * p[0])
    row[16] -= 4 * (b[1] * p[2] + b[2] * p[1])


@_compiled
def _add_linear(row: C128, leg: C128) -> None:
    """Add the features of c e.e + 2 (p - b).A - 2 (p + b).C to a row of coefficients."""
    for i in range(3):
        row[1 + i] += 2 * (leg[1 + i] - leg[4 + i])
        row[4 + i] -= 2 * (leg[1 + i] + leg[4 + i])
        row[11 + i] += leg[0]
    row[7] += leg[0]


@_compiled
def path_coefficients(start: C128, target: C128) -> C128:
    """Return (3, 6, 17): the equations of target + s (start - target), a polynomial of degree 2 in s.

    The rows are combined (the same way for every s) so that the target's equations are triangular in the
    seven features that hold h: solutions far away, where e is small, keep their digits.
    """
    slope = start - target
    rows = np.zeros((3, 6, FEATURES), np.complex128)
    for i in range(6):
        rows[0, i, 0] = 1
        _add_linear(rows[0, i], target[i])
        _add_linear(rows[1, i], slope[i])
        _add_products(rows[0, i], target[i, 4:7], target[i, 1:4])
        _add_products(rows[1, i], target[i, 4:7], slope[i, 1:4])
        _add_products(rows[1, i], slope[i, 4:7], target[i, 1:4])
        _add_products(rows[2, i], slope[i, 4:7], slope[i, 1:4])
    for k in range(6):
        best, pivot, column = 1e-13, -1, -1
        for i in range(k, 6):
            for j in range(7):
                if (k > 0 or j == 0) and abs(rows[0, i, j]) > best:
                    best, pivot, column = abs(rows[0, i, j]), i, j
        if pivot < 0:
            rows[0, k:, :7] = 0
            break
        for d in range(3):
            for j in range(FEATURES):
                rows[d, k, j], rows[d, pivot, j] = rows[d, pivot, j], rows[d, k, j]
        for i in range(k + 1, 6):
            factor = rows[0, i, column] / rows[0, k, column]
            for d in range(3):
                for j in range(FEATURES):
                    rows[d, i, j] -= factor * rows[d, k, j]
            rows[0, i, column] = 0
    return rows


@_compiled
def _coefficients(path: C128, s: float, rows: C128) -> None:
    """Fill rows (3, 6, 17): the path's equations as a polynomial of degree 2 in d, at s - d."""
    for k in range(6):
        for j in range(FEATURES):
            rows[0, k, j] = path[0, k, j] + s * (path[1, k, j] + s * path[2, k, j])
            rows[1, k, j] = -path[1, k, j] - 2 * s * path[2, k, j]
            rows[2, k, j] = path[2, k, j]


@_compiled
def _add_features(x: C128, y: C128, weight: float, out: C128) -> None:
    """Add weight * w(x, y) to out (18,), w the symmetric bilinear form of the features and, last, of e.h."""
    half = 0.5 * weight
    out[0] += weight * (x[4] * y[4] + x[5] * y[5] + x[6] * y[6] + x[7] * y[7])
    for i in range(1, 4):
        out[i] += half * (x[0] * y[4 + i] - x[4] * y[i] + y[0] * x[4 + i] - y[4] * x[i])
        out[7 + i] += half * (x[0] * y[i] + x[i] * y[0])
        out[10 + i] += weight * x[i] * y[i]
    out[4] += half * (x[2] * y[7] - x[3] * y[6] + y[2] * x[7] - y[3] * x[6])
    out[5] += half * (x[3] * y[5] - x[1] * y[7] + y[3] * x[5] - y[1] * x[7])
    out[6] += half * (x[1] * y[6] - x[2] * y[5] + y[1] * x[6] - y[2] * x[5])
    out[7] += weight * x[0] * y[0]
    out[14] += half * (x[1] * y[2] + x[2] * y[1])
    out[15] += half * (x[1] * y[3] + x[3] * y[1])
    out[16] += half * (x[2] * y[3] + x[3] * y[2])
    for i in range(4):
        out[17] += half * (x[i] * y[4 + i] + y[i] * x[4 + i])


@_compiled
def _linearize(rows: C128, x: C128, patch: C128, matrix: C128, value: C128) -> None:
    """Fill the 8 x 8 Jacobian (6 legs, Study quadric, patch) and the equations' values at x."""
    e0, e1, e2, e3, h0, h1, h2, h3 = x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7]
    for k in range(6):
        f = rows[k]
        r = matrix[k]
        r[0] = f[1] * h1 + f[2] * h2 + f[3] * h3 + 2 * f[7] * e0 + f[8] * e1 + f[9] * e2 + f[10] * e3
        r[1] = h2 * f[6] - h3 * f[5] - h0 * f[1] + f[8] * e0 + 2 * f[11] * e1 + f[14] * e2 + f[15] * e3
        r[2] = h3 * f[4] - h1 * f[6] - h0 * f[2] + f[9] * e0 + 2 * f[12] * e2 + f[14] * e1 + f[16] * e3
        r[3] = h1 * f[5] - h2 * f[4] - h0 * f[3] + f[10] * e0 + 2 * f[13] * e3 + f[15] * e1 + f[16] * e2
        r[4] = 2 * f[0] * h0 - f[1] * e1 - f[2] * e2 - f[3] * e3
        r[5] = 2 * f[0] * h1 + f[1] * e0 + f[5] * e3 - f[6] * e2
        r[6] = 2 * f[0] * h2 + f[2] * e0 + f[6] * e1 - f[4] * e3
        r[7] = 2 * f[0] * h3 + f[3] * e0 + f[4] * e2 - f[5] * e1
    for i in range(4):
        matrix[6, i] = x[4 + i]
        matrix[6, 4 + i] = x[i]
    for k in range(7):
        total = 0j
        for i in range(8):
            total += matrix[k, i] * x[i]
        value[k] = 0.5 * total  # Euler: a quadratic form is half its gradient times x
    value[7] = 0
    for i in range(8):
        matrix[7, i] = patch[i]


@_compiled
def _factorize(matrix: C128, order: I64) -> None:
    """Replace an 8 x 8 matrix by its LU factors with partial pivoting; order (8,) the row exchanges."""
    for k in range(8):
        best, pivot = -1.0, k
        for i in range(k, 8):
            size = abs(matrix[i, k].real) + abs(matrix[i, k].imag)
            if size > best:
                best, pivot = size, i
        order[k] = pivot
        if pivot != k:
            for j in range(8):
                matrix[k, j], matrix[pivot, j] = matrix[pivot, j], matrix[k, j]
        if best == 0.0:
            matrix[k, k] = 1e-300
        inverse = 1 / matrix[k, k]
        for i in range(k + 1, 8):
            factor = matrix[i, k] * inverse
            matrix[i, k] = factor
            for j in range(k + 1, 8):
                matrix[i, j] -= factor * matrix[k, j]


@_compiled
def _solve(factors: C128, order: I64, right: C128) -> None:
    """Replace `right` (8,) by the solution of the factorized system."""
    for k in range(8):
        pivot = order[k]
        right[k], right[pivot] = right[pivot], right[k]
    for i in range(1, 8):
        for j in range(i):
            right[i] -= factors[i, j] * right[j]
    for i in range(7, -1, -1):
        for j in range(i + 1, 8):
            right[i] -= factors[i, j] * right[j]
        right[i] /= factors[i, i]


@_compiled
def _norm(x: C128) -> float:
    total = 0.0
    for i in range(8):
        total += x[i].real * x[i].real + x[i].imag * x[i].imag
    return float(np.sqrt(total))


@_compiled
def _normalize(x: C128, patch: C128) -> None:
    """Scale x to unit length and lay the patch conj(x).y = 1 through it."""
    size = 1 / _norm(x)
    for i in range(8):
        x[i] *= size
        patch[i] = np.conj(x[i])


@_compiled
def _expand(rows: C128, factors: C128, order: I64, series: C128, forms: C128) -> None:
    """Fill series[1:] with the Taylor coefficients of the path through series[0], the patch fixed."""
    forms[:] = 0
    _add_features(series[0], series[0], 1.0, forms[0])
    for n in range(1, ORDER + 1):
        for i in range(1, (n + 1) // 2):
            _add_features(series[i], series[n - i], 2.0, forms[n])
        if n % 2 == 0:
            _add_features(series[n // 2], series[n // 2], 1.0, forms[n])
        right = series[n]
        for k in range(6):
            total = 0j
            for j in range(FEATURES):
                total += rows[0, k, j] * forms[n, j]
            for j in range(1, FEATURES):
                total += rows[1, k, j] * forms[n - 1, j]
            if n > 1:
                for j in range(7, FEATURES):
                    total += rows[2, k, j] * forms[n - 2, j]
            right[k] = -total
        right[6] = -forms[n, 17]
        right[7] = 0
        _solve(factors, order, right)
        _add_features(series[0], right, 2.0, forms[n])


@_compiled
def _trusted_step(series: C128, fraction: float) -> float:
    """Return `fraction` of the radius of convergence, judged from ratios of the last coefficients."""
    last = _norm(series[ORDER])
    radius = 1e6
    for n in range(1, 4 if last > 1e-200 else 1):
        radius = min(radius, (_norm(series[ORDER - n]) / last) ** (1.0 / n))
    return fraction * radius


@_compiled
def refine(path: C128, x: C128, iterations: int) -> tuple[float, float]:
    """Improve a solution x (8,) of the target by full Newton steps, in place.

    Returns the length of the last step and the sensitivity |J^-1 (1, .., 1)|, which grows like the inverse of
    the distance to the nearest other solution.
    """
    rows = np.empty((3, 6, FEATURES), np.complex128)
    matrix, order = np.empty((8, 8), np.complex128), np.empty(8, np.int64)
    change, probe, patch = np.empty(8, np.complex128), np.empty(8, np.complex128), np.empty(8, np.complex128)
    _coefficients(path, 0.0, rows)
    size = sensitivity = np.inf
    for _ in range(iterations):
        _normalize(x, patch)
        _linearize(rows[0], x, patch, matrix, change)
        _factorize(matrix, order)
        _solve(matrix, order, change)
        probe[:] = 1
        _solve(matrix, order, probe)
        size, sensitivity = _norm(change), _norm(probe)
        if not size < 1.0:
            break
        for i in range(8):
            x[i] -= change[i]
    _normalize(x, patch)
    return size, sensitivity


@_compiled
def _correct(rows: C128, x: C128, patch: C128, matrix: C128, order: I64, change: C128) -> tuple[float, float]:
    """Improve x in place by one Newton step and one with the same factors; return both lengths."""
    _linearize(rows, x, patch, matrix, change)
    _factorize(matrix, order)
    _solve(matrix, order, change)
    first = _norm(change)
    for i in range(8):
        x[i] -= change[i]
    features = np.zeros(18, np.complex128)
    _add_features(x, x, 1.0, features)
    for k in range(6):
        total = 0j
        for j in range(FEATURES):
            total += rows[k, j] * features[j]
        change[k] = total
    change[6] = features[17]
    change[7] = 0
    _solve(matrix, order, change)
    second = _norm(change)
    for i in range(8):
        x[i] -= change[i]
    return first, second


@_compiled
def _judge(x: C128, s: float, marks: F64, report: F64) -> None:
    """Update report[:3] (see `track`); marks (2, 2): s and |e.e| at the last two decades of s."""
    unit = abs(x[0] * x[0] + x[1] * x[1] + x[2] * x[2] + x[3] * x[3]) / _norm(x) ** 2
    report[0], report[1] = s, unit
    if s > 0 and marks[0, 0] >= 10 * s and unit > 0:
        report[2] = np.log(marks[0, 1] / unit) / np.log(marks[0, 0] / s)
    if s < 0.1 * marks[1, 0]:
        marks[0] = marks[1]
        marks[1, 0], marks[1, 1] = s, unit


@_compiled
def track(path: C128, x: C128, fraction: float, report: F64) -> int:
    """Follow one solution, x (8,) in place, while s falls from 1 (start) to 0 (target).

    A step is kept when the second Newton step is below 2 % of the first (well inside the region of
    convergence) or at rounding.  Returns REGULAR (s = 0 reached), SINGULAR (s fell below SMALLEST: the
    equations become dependent) or LOST.  report[:4]: s reached, |e.e| / |x|^2 there, its logarithmic slope
    d log / d log s over the last one to two decades of s (0 if s spans less), steps.
    """
    rows = np.empty((3, 6, FEATURES), np.complex128)
    trial_rows = np.empty((3, 6, FEATURES), np.complex128)
    matrix, order = np.empty((8, 8), np.complex128), np.empty(8, np.int64)
    series, forms = np.empty((ORDER + 1, 8), np.complex128), np.empty((ORDER + 1, 18), np.complex128)
    trial, change, patch = np.empty(8, np.complex128), np.empty(8, np.complex128), np.empty(8, np.complex128)
    marks = np.ones((2, 2))
    s = 1.0
    _coefficients(path, s, rows)
    for step in range(MOST_STEPS):
        _normalize(x, patch)
        _linearize(rows[0], x, patch, matrix, change)
        _factorize(matrix, order)
        series[0] = x
        _expand(rows, matrix, order, series, forms)
        length = _trusted_step(series, fraction)
        kept = False
        for _ in range(8):
            left = max(0.0, s - length)
            length = s - left
            for i in range(8):
                total = series[ORDER, i]
                for n in range(ORDER - 1, -1, -1):
                    total = total * length + series[n, i]
                trial[i] = total
            _coefficients(path, left, trial_rows)
            first, second = _correct(trial_rows[0], trial, patch, matrix, order, change)
            kept = (first < 1e-9 and second < 1e-9) or (first < 0.1 and second < 0.02 * first)
            if kept:
                break
            length *= 0.5
        if not kept:
            return LOST
        s = left
        x[:] = trial
        rows, trial_rows = trial_rows, rows
        _judge(x, s, marks, report)
        report[3] = step + 1
        if s == 0.0:
            return REGULAR
        if s < SMALLEST:
            return SINGULAR
    return LOST


@_compiled
def track_all(start: C128, target: C128, solutions: C128, fraction: float) -> tuple[C128, I64, F64]:
    """Follow every row of solutions (n, 8); return the ends (n, 8), how each ended (n,), reports (n, 5).

    Steps are `fraction` of the radius of convergence.  reports[:, :4]: see `track`; reports[:, 4]: the
    sensitivity of a REGULAR end (see `refine`), else infinite.
    """
    ends = solutions.copy()
    states = np.empty(len(ends), np.int64)
    reports = np.zeros((len(ends), 5))
    path = path_coefficients(start, target)
    for i in range(len(ends)):
        states[i] = track(path, ends[i], fraction, reports[i])
        reports[i, 4] = np.inf
        if states[i] == REGULAR:
            refined = ends[i].copy()
            size, reports[i, 4] = refine(path, refined, 3)
            if size < 1e-9:
                ends[i] = refined
            else:
                states[i] = LOST
    return ends, states, reports
