"""The log evidence that chance alone reaches in this campaign: the threshold for a name.

Residuals are drawn from the fit, law, disturbances and noise and nothing else. All that candidates see of a draw is
``g = Z' y``, which is ``N(0, S)``: hundreds of campaigns cost one product.
"""

from __future__ import annotations

import numpy as np

from hexathermal.learn.machine_diagnosis.case import Case
from hexathermal.learn.machine_diagnosis.evidence import sizes_for
from hexathermal.poses import FloatArray

DRAWS = 500
FALSE_ALARMS = 0.003
"""Part of campaigns with nothing in them in which chance may reach the threshold."""

SEED = 20


def chance_threshold(case: Case, S: FloatArray) -> float:
    """Return the log posterior odds that the best candidate passes in `FALSE_ALARMS` of campaigns without a cause.

    The maxima of the draws follow Gumbel's law; its quantile is taken, since draws are few.

    Parameters
    ----------
    case : Case
    S : array, shape (m, m)
        Of all candidates' columns, all else eliminated.
    """
    asked = [k for k, one in enumerate(case.candidates) if case.named(k) and not one.mean.any()]
    places = [np.arange(case.tables.places[k].start, case.tables.places[k].stop) - case.tables.base for k in asked]
    which = np.concatenate(places or [np.zeros(0, dtype=np.int64)]).astype(np.int64)
    values, vectors = np.linalg.eigh(S[np.ix_(which, which)])
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    G = root @ np.random.default_rng(SEED).standard_normal((len(which), DRAWS))
    best, begin = np.full(DRAWS, -np.inf), 0
    for k, place in zip(asked, places, strict=True):
        own, begin = slice(begin, begin + len(place)), begin + len(place)
        found = _values(S[np.ix_(place, place)], G[own], case.candidates[k].scale, case.tables.rows)
        best = np.maximum(best, found + case.prior[k])
    if not np.isfinite(best).all():
        return 0.0
    scale = np.sqrt(6.0) / np.pi * float(best.std())
    return float(best.mean() - 0.5772 * scale - scale * np.log(-np.log(1.0 - FALSE_ALARMS)))


def _values(S: FloatArray, G: FloatArray, scale: FloatArray, rows: int) -> FloatArray:
    """Return the log evidence of one candidate in each draw, shape (d,)."""
    sizes = sizes_for(S, scale, rows)
    if not sizes.size:
        return np.full(G.shape[1], -np.inf)
    # one rotation serves all sizes
    w, vectors = np.linalg.eigh(S * np.outer(scale, scale))
    w = np.maximum(w, 0.0)
    b = np.square(vectors.T @ (scale[:, None] * G))
    found = [0.5 * ((f**2 / (1.0 + f**2 * w)) @ b) - 0.5 * float(np.log1p(f**2 * w).sum()) for f in sizes]
    return np.asarray(np.logaddexp.reduce(np.array(found), axis=0) - np.log(len(found)))
