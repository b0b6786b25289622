"""Compiled whitening by a Kalman filter: rows of several runs become independent with variance 1.

The noise of a window is ``wander (offset_run + slow(t)) + landing + white``; the filter's innovations over their
standard deviations are white, and the sum of the logarithms of those is half of log det V.  Linear in the number of
windows.
The evidence of a channel at one noise, which fits of the noise ask thousands of times, is made in one call, and so is
each fit: from outside, its simplex takes as long between the evidences as these do.

The module is imported on first use: it needs the compiler.
"""

from __future__ import annotations

import numpy as np

from hexathermal.kinematics.compiled import loop

LOWEST = 1e-3
"""Least level of a part of the noise, as a part of the whole."""

SPREAD = 1.5
"""Standard deviation of the prior of a level's logarithm about the channel's own scale: loose."""

OFFSET_SPREAD = 0.3
"""Standard deviation of the logarithm of a run's offset over the noise of its first row, which it is."""

LOGARITHM_EVERY = 8
"""Variances that are multiplied before their logarithm is taken: a logarithm takes as long as a window's algebra."""


CLOSE = 0.02
"""A fit ends where logarithms of levels, and their log posteriors, differ by less."""


@loop
def whiten(C, start, fresh, decay, wander, white, landing, slow, offset, walks, out):
    """Whiten the columns C (n, m) into out; return log det V.

    `start` marks the first window of a run, `fresh` that of a landing; `decay` (n,) is what stays of the slow process
    since the window before.
    `white` (n,) are variances of windows, `landing` that of landings; `slow` and `offset` variances of a run, of which
    a window shows `wander` (n,) times the deviation. Of what `walks` from each run's first row on, the offset takes
    away what the slow process is there.
    """
    n, m = C.shape
    x = np.zeros((3, m))
    p00 = p01 = p02 = p11 = p12 = p22 = 0.0
    total, product, a = 0.0, 1.0, 1.0
    for i in range(n):
        if start[i]:
            p00, p11, p22 = slow, landing, offset
            p01 = p12 = 0.0
            p02 = -min(slow, offset) if walks else 0.0
            x[:, :] = 0.0
            a = 1.0
        else:
            a = decay[i]
            p00 = a * a * p00 + slow * (1.0 - a * a)
            p01 *= a
            p02 *= a
            if fresh[i]:
                p01, p12, p11 = 0.0, 0.0, landing
                for c in range(m):
                    x[1, c] = 0.0
        g = wander[i]
        h0, h1, h2 = g * (p00 + p02) + p01, g * (p01 + p12) + p11, g * (p02 + p22) + p12
        s = g * (h0 + h2) + h1 + white[i]
        product *= s
        if i % LOGARITHM_EVERY == 0:
            total += np.log(product)
            product = 1.0
        inverse = 1.0 / s
        r = np.sqrt(inverse)
        k0, k1, k2 = h0 * inverse, h1 * inverse, h2 * inverse
        for c in range(m):
            before = a * x[0, c]
            e = C[i, c] - g * (before + x[2, c]) - x[1, c]
            out[i, c] = e * r
            x[0, c] = before + k0 * e
            x[1, c] += k1 * e
            x[2, c] += k2 * e
        p00 -= k0 * h0
        p01 -= k0 * h1
        p02 -= k0 * h2
        p11 -= k1 * h1
        p12 -= k1 * h2
        p22 -= k2 * h2
    return total + np.log(product)


@loop
def integrated(G):
    """Return ``1/2 b' M^-1 b - 1/2 log det M - 1/2 r'r``, the lower factor L of M, and ``L^-1 b``.

    G (1 + m, 1 + m) holds the products of whitened r and X, the columns times the sizes of their priors:  M = X'X + I,
    b = X'r.  It is the log evidence of r with coefficients of prior N(0, 1) integrated, constants left out.
    """
    m = G.shape[0] - 1
    M = G[1:, 1:].copy()
    for k in range(m):
        M[k, k] += 1.0
    L = np.linalg.cholesky(M)
    value = -0.5 * G[0, 0]
    z = np.empty(m)
    for k in range(m):
        e = G[1 + k, 0]
        for c in range(k):
            e -= L[k, c] * z[c]
        z[k] = e / L[k, k]
        value += 0.5 * z[k] * z[k] - np.log(L[k, k])
    return value, L, z


@loop
def log_evidence(C, start, fresh, decay, wander, white, landing, slow, offset, walks):
    """Return ``log p(y) + n/2 log 2 pi`` of a channel with the coefficients of columns `integrated`.

    C (n, 1 + m) holds y and the columns times the sizes of their priors; the noise is that of `whiten`.
    """
    out = np.empty_like(C)
    logdet = whiten(C, start, fresh, decay, wander, white, landing, slow, offset, walks, out)
    value, _L, _z = integrated(out.T @ out)
    return value - 0.5 * logdet


@loop
def levels_at(theta, scale, has_landings, walks):
    """Return white, landing, slow and offset of their logarithms: of a ratio to `scale`, the offset's to the others.

    Of what `walks` from each run's first row on the offset is the slow process there, and the noise of that row.
    """
    part = np.exp(np.minimum(np.maximum(theta, np.log(LOWEST)), -np.log(LOWEST)))
    white, landing, slow = scale * part[0], scale * part[1] * has_landings, scale * part[2]
    quick, wandered = white * white + landing * landing, slow * slow
    if walks:
        return white, landing, slow, np.sqrt(wandered + part[3] ** 2 * quick)
    return white, landing, slow, part[3] * np.sqrt(quick + wandered)


@loop
def logarithms(white, landing, slow, offset, scale, walks):
    """Return the logarithms that `levels_at` takes, shape (4,)."""
    quick, wandered = white * white + landing * landing, slow * slow
    if walks:
        own, beside = np.sqrt(max(offset * offset - wandered, 0.0)), np.sqrt(quick)
    else:
        own, beside = offset, np.sqrt(quick + wandered)
    ratios = np.array([white / scale, landing / scale, slow / scale, own / max(beside, 1e-30)])
    return np.log(np.maximum(ratios, LOWEST))


@loop
def log_prior(white, landing, slow, offset, scale, has_landings, tied, walks):
    """Return the log prior of levels: normal in their logarithms; an offset that is `tied` is the first row's noise."""
    theta = logarithms(white, landing, slow, offset, scale, walks) / SPREAD
    loose = theta[0] ** 2 + theta[2] ** 2 + (theta[1] ** 2 if has_landings else 0.0)
    if tied:
        return -0.125 * loose - 0.5 * (theta[3] * SPREAD / OFFSET_SPREAD) ** 2
    return -0.125 * loose - 0.125 * theta[3] ** 2


@loop
def log_posterior(theta, C, start, fresh, decay, wander, share, least, scale, has_landings, tied, walks):
    """Return `log_evidence` and `log_prior` at the levels of logarithms.

    `share` (n,) is 1 / rows of windows, `least` (n,) the variance that each has at least.
    """
    white, landing, slow, offset = levels_at(theta, scale, has_landings, walks)
    variances = white**2 * share + least, landing**2, slow**2
    evidence = log_evidence(C, start, fresh, decay, wander, *variances, offset**2, walks)
    return evidence + log_prior(white, landing, slow, offset, scale, has_landings, tied, walks)


@loop
def lost(point, axes, theta, C, start, fresh, decay, wander, share, least, scale, has_landings, tied, walks):
    """Return what `log_posterior` lacks with some axes of theta at a point; all where rounding leaves no noise."""
    for k in range(len(axes)):
        theta[axes[k]] = point[k]
    try:
        return -log_posterior(theta, C, start, fresh, decay, wander, share, least, scale, has_landings, tied, walks)
    except Exception:  # a matrix that is not positive: the compiler knows no kinds of errors
        return np.inf


@loop
def sort(losses, places):
    """Sort losses, shape (m,), and places, shape (m, n), the least lost first."""
    for k in range(1, len(losses)):
        for i in range(k, 0, -1):
            if losses[i] < losses[i - 1]:
                losses[i], losses[i - 1] = losses[i - 1], losses[i]
                for c in range(places.shape[1]):
                    places[i, c], places[i - 1, c] = places[i - 1, c], places[i, c]


@loop
def likeliest(theta, spread, most, C, start, fresh, decay, wander, share, least, scale, has_landings, tied, walks):
    """Move theta (4,), logarithms of levels, to the largest `log_posterior` nearby; return that.

    By the simplex of Nelder and Mead (Computer Journal 7 (1965) 308), as scipy.optimize has it, from theta and from
    there by `spread` along each axis, in so many evaluations and a few. Landings that do not scatter have no axis.
    """
    axes = np.array([0, 1, 2, 3]) if has_landings else np.array([0, 2, 3])
    own = C, start, fresh, decay, wander, share, least, scale, has_landings, tied, walks
    n, asked, unknown = len(axes), 0, 0
    places, losses, tried, mirrored = np.empty((n + 1, n)), np.empty(n + 1), np.empty(n), np.empty(n)
    for k in range(n + 1):
        for c in range(n):
            places[k, c] = theta[axes[c]] + spread * (c == k - 1)
    while True:
        for k in range(unknown, n + 1):
            losses[k] = lost(places[k], axes, theta, *own)
        asked += n + 1 - unknown
        sort(losses, places)
        apart = 0.0
        for k in range(1, n + 1):
            for c in range(n):
                apart = max(apart, abs(places[k, c] - places[0, c]))
        if asked >= most or (apart <= CLOSE and losses[n] - losses[0] <= CLOSE):
            break
        # the worst is mirrored; farther where that is best, half the way on this side or the other where it is bad
        way, loss, found = 1.0, np.inf, np.inf
        for again in range(2):
            for c in range(n):
                middle = places[:n, c].sum() / n
                tried[c] = (1.0 + way) * middle - way * places[n, c]
            found = lost(tried, axes, theta, *own)
            asked += 1
            if again or losses[0] <= found < losses[n - 1]:
                break
            mirrored[:], loss = tried, found
            way = 2.0 if found < losses[0] else (0.5 if found < losses[n] else -0.5)
        unknown = n + 1
        if way == 2.0 and found >= loss:
            places[n], losses[n] = mirrored, loss
        elif found <= min(loss, losses[n]) and (way > 0.0 or found < losses[n]):
            places[n], losses[n] = tried, found
        else:
            unknown = 1
            for k in range(1, n + 1):
                for c in range(n):
                    places[k, c] = 0.5 * (places[0, c] + places[k, c])
    for c in range(n):
        theta[axes[c]] = places[0, c]
    return -losses[0]
