"""Whether the law of a part that is no leg reads where it stands: ``C dT``, or ``C dT + D q dT``.

A spindle moved by a quill grows alike wherever that is; a screw is measured where its nut stands, and grows by what is
between. Which it is, is told by runs left out.
"""

from __future__ import annotations

import numpy as np

from hexathermal.learn.choice import CONFIDENCE
from hexathermal.poses import FloatArray

LEAST_STROKE = 1e-3
"""A part whose places differ by less has no stroke to speak of [m]."""

LEAST_LESS = 0.05
"""Part of the error on runs left out, their geometric mean, that reading q takes away at least.

Of 120 simulated parts whose drift goes as ``(c0 + c1 q) dT``, effects hidden in most of them, two fell short; of 80
whose drift does not, one had 9 % less, within the spread between runs, and no other as much as this.
"""


def reads_place(without: FloatArray, with_q: FloatArray) -> bool:
    """Return whether reading q makes less of the error on runs left out, beyond doubt.

    Logarithms are compared, since runs differ in how much they warm: one run alone would else decide.

    Parameters
    ----------
    without, with_q : array, shape (R,) [m^2]
        Mean square errors on each run, fitted without it, of the law that does not read q and of the one that does.

    Examples
    --------
    >>> errors = np.array([4.0, 90.0, 1.0, 9.0])
    >>> reads_place(errors, errors / np.array([3.0, 9.0, 2.0, 5.0]))
    True
    >>> reads_place(errors, errors * np.array([0.98, 1.01, 1.0, 0.99]))
    False
    """
    from scipy.special import stdtrit

    R = len(without)
    if R < 2 or not np.isfinite([without, with_q]).all() or not (without > 0.0).all():
        return False
    less = 0.5 * np.log(without / np.maximum(with_q, np.finfo(float).tiny))
    mean, spread = float(less.mean()), float(less.std(ddof=1) / np.sqrt(R))
    return bool(mean > max(-np.log(1.0 - LEAST_LESS), float(stdtrit(R - 1, CONFIDENCE)) * spread))
