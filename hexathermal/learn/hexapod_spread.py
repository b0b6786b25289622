"""By how much the legs of a machine spread about one law for all: a variance between legs, from their own laws.

Of one coefficient the six legs' own estimates ``x`` have the covariance ``V`` and scatter about their mean by their
errors and by the spread ``tau`` of the legs:

    x ~ N(mu 1, V + tau^2 I),      p(tau | x) ~ |W|^(1/2) (1' W 1)^(-1/2) exp(-x' P x / 2),
    W = (V + tau^2 I)^-1,          P = W - W 1 1' W / (1' W 1)

with flat priors of mu and tau (Gelman, Bayesian Analysis 1 (2006) 515: with three groups or more a flat prior of the
standard deviation gives a proper posterior). The median of ``tau`` is what one law for all legs lacks of each leg:
never 0, since six legs that look alike may differ by what their uncertainties hide.
"""

from __future__ import annotations

import numpy as np

from hexathermal.poses import FloatArray

POINTS = 400
WIDEST = 20.0
"""The spread is looked for up to so many times the scatter of the estimates and their uncertainty."""


def leg_spread(x: FloatArray, V: FloatArray) -> float:
    """Return the median of ``tau``: the standard deviation of a coefficient between legs.

    Parameters
    ----------
    x : array, shape (n,)
        Estimates of the legs, three or more.
    V : array, shape (n, n)
        Their covariance.

    Examples
    --------
    Known exactly, it is what six numbers say of a normal distribution; known badly, what their doubt leaves open:

    >>> x = np.array([-1.0, -0.6, -0.2, 0.2, 0.6, 1.0])
    >>> round(leg_spread(x, 1e-6 * np.eye(6)), 2), round(leg_spread(0.0 * x, np.eye(6)), 2)
    (0.9, 0.36)
    """
    n = len(x)
    scale = float(np.sqrt(np.diagonal(V).max() + np.var(x)))
    if not scale > 0.0:
        return 0.0
    tau = np.linspace(0.0, WIDEST * scale, POINTS + 1) ** 2 / (WIDEST * scale)
    values, vectors = np.linalg.eigh(0.5 * (V + V.T))
    W = 1.0 / np.maximum(np.maximum(values, 0.0) + tau[:, None] ** 2, 1e-300)
    y, one = vectors.T @ x, vectors.T @ np.ones(n)
    whole = W @ one**2
    chi2 = W @ y**2 - (W @ (y * one)) ** 2 / whole
    logarithm = 0.5 * np.log(W).sum(axis=1) - 0.5 * np.log(whole) - 0.5 * chi2
    share = np.cumsum(np.exp(logarithm - logarithm.max()) * np.gradient(tau))
    return float(np.interp(0.5 * share[-1], share, tau))
