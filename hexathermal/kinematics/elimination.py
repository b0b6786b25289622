"""Gauss elimination of six equations as straight-line code, for the formulas' vector form.

No pivoting: the order of the rows is chosen once for each machine, at home, and every solution is verified.
"""

from __future__ import annotations

from hexathermal.kinematics.compiled import formula


@formula
def _less6(r, k, i):
    f = r[0] * i
    return (r[1] - f * k[1], r[2] - f * k[2], r[3] - f * k[3], r[4] - f * k[4], r[5] - f * k[5], r[6] - f * k[6])


@formula
def _less5(r, k, i):
    f = r[0] * i
    return (r[1] - f * k[1], r[2] - f * k[2], r[3] - f * k[3], r[4] - f * k[4], r[5] - f * k[5])


@formula
def _less4(r, k, i):
    f = r[0] * i
    return (r[1] - f * k[1], r[2] - f * k[2], r[3] - f * k[3], r[4] - f * k[4])


@formula
def _less3(r, k, i):
    f = r[0] * i
    return (r[1] - f * k[1], r[2] - f * k[2], r[3] - f * k[3])


@formula
def _less2(r, k, i):
    f = r[0] * i
    return (r[1] - f * k[1], r[2] - f * k[2])


@formula
def solved(a, b, c, d, e, f):
    """Return the solution of six rows ``[A | r]`` and ``det A``."""
    i0 = 1.0 / a[0]
    b, c, d, e, f = _less6(b, a, i0), _less6(c, a, i0), _less6(d, a, i0), _less6(e, a, i0), _less6(f, a, i0)
    i1 = 1.0 / b[0]
    c, d, e, f = _less5(c, b, i1), _less5(d, b, i1), _less5(e, b, i1), _less5(f, b, i1)
    i2 = 1.0 / c[0]
    d, e, f = _less4(d, c, i2), _less4(e, c, i2), _less4(f, c, i2)
    i3 = 1.0 / d[0]
    e, f = _less3(e, d, i3), _less3(f, d, i3)
    i4 = 1.0 / e[0]
    f = _less2(f, e, i4)
    x5 = f[1] / f[0]
    x4 = (e[2] - e[1] * x5) * i4
    x3 = (d[3] - d[1] * x4 - d[2] * x5) * i3
    x2 = (c[4] - c[1] * x3 - c[2] * x4 - c[3] * x5) * i2
    x1 = (b[5] - b[1] * x2 - b[2] * x3 - b[3] * x4 - b[4] * x5) * i1
    x0 = (a[6] - a[1] * x1 - a[2] * x2 - a[3] * x3 - a[4] * x4 - a[5] * x5) * i0
    return (x0, x1, x2, x3, x4, x5), a[0] * b[0] * c[0] * d[0] * e[0] * f[0]
