"""Whether a beam that stepped at a movement is still off where the rod is back: a lost count is, tilt is not.

Within `MARGIN` rows before and behind a step at row s of size z, the beam k against the others, ``a``, is

    a(row) = tilt(place) + creep row + h [row >= s] + sum_o h_o [row >= s_o] + noise

with a tilt for each place, a tenth of the movement wide (`SAME_PLACE`), and a jump at each other step o that may be a
lost count. Least absolute deviations give h, since codes and spikes may still be there (weights ``1 / |residual|``,
anew `ROUNDS` times: Schlossmacher, Journal of the American Statistical Association 68 (1973) 857); it must be z to a
quarter (`OTHERS`). Of a step that goes back at another one, as tilt does, there is no h_o. Where no place is there both
before and behind nothing tells h.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from hexathermal.learn.cleaning_beam_scales import span_at
from hexathermal.learn.cleaning_rules import MARGIN
from hexathermal.poses import FloatArray

OTHERS = 0.25
"""Share of a step by which the other beams may move with it, and by which it may differ when the rod is back."""

SAME_PLACE, FAR_LARGER = 0.1, 20.0
"""Share of a movement's reach that counts as one place; and how many times what beams part by there no tilt reaches,
where the rod does not come back."""

TELLING = 1.0
"""Rows, each as good as any, that the step must be told by."""

ROUNDS, LEAST = 12, 0.02
"""Times that weights are made anew; a residual counts as this part of the step at least."""


def stays(
    q: FloatArray, apart: FloatArray, step: tuple[int, int, float], usual: float,
    others: Iterable[tuple[int, int, float]] = (),
) -> bool:  # fmt: skip
    """Return whether a beam is as far off as it stepped where the rod is back at a place.

    Where nothing tells, no tilt is thought to be `FAR_LARGER` than what beams part by.

    Parameters
    ----------
    q : array, shape (n,) [m]
        Displacement.
    apart : array, shape (n, 3) [m]
        Each beam against the others.
    step : (int, int, float)
        Its first row, its beam, and its size [m].
    usual : float [m]
        What beams part by at such a movement.
    others : iterable of (int, int, float)
        Steps that may be lost counts as well.

    Examples
    --------
    >>> q = np.repeat([0.0, 0.1, 0.0, 0.1], 8)
    >>> tilt, lost = np.zeros((32, 3)), np.zeros((32, 3))
    >>> tilt[:, 0], lost[8:, 0] = 3e-5 * q, 3e-6
    >>> stays(q, tilt, (8, 0, 3e-6), 1e-6), stays(q, lost, (8, 0, 3e-6), 1e-6)
    (False, True)
    """
    row, beam, size = step
    rows = np.arange(max(0, row - MARGIN), min(len(q), row + MARGIN))
    rows = rows[np.isfinite(apart[rows, beam]) & np.isfinite(q[rows]) & (np.abs(rows - row + 0.5) > 0.5)]
    at = [other for other, k, z in others if other != row and not (k == beam and abs(z + size) <= OTHERS * abs(size))]
    jumps = rows[:, None] >= np.unique([other for other in at if rows[:1] < other <= rows[-1:]] or [-1])
    width = max(SAME_PLACE * span_at(q, row), np.finfo(float).tiny)
    places = np.round(q[rows] / width)
    nuisance = np.column_stack([places[:, None] == np.unique(places), jumps, (rows - row) / MARGIN]).astype(np.float64)
    stepped = (rows >= row).astype(np.float64)
    left = stepped - nuisance @ np.linalg.lstsq(nuisance, stepped, rcond=None)[0]
    if left @ left < TELLING:
        return abs(size) > FAR_LARGER * usual
    both, read, weight = np.column_stack([stepped, nuisance]), apart[rows, beam] / size, np.ones(len(rows))
    for _round in range(ROUNDS):
        found = np.linalg.lstsq(both * weight[:, None], read * weight, rcond=None)[0]
        weight = 1.0 / np.sqrt(np.maximum(np.abs(read - both @ found), LEAST))
    return abs(float(found[0]) - 1.0) <= OTHERS
