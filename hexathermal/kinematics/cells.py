"""Boxes that halve: how much of one lies above a plane, which ones share a face, and which hang together."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import numpy.typing as npt

from hexathermal.poses import FloatArray

DEEPEST = 18
"""Times a box can be halved: its three integer coordinates share one 64-bit key with the level."""

FLATTEST = 1e-3
"""Smallest slope along an axis, as a part of the largest, that the formula of a cut takes; flatter ones are bounded."""

Bools = npt.NDArray[np.bool_]
Ints = npt.NDArray[np.int64]


def cut_bounds(low: FloatArray, high: FloatArray, slopes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return bounds for the part of a box where a function is positive that lies between two planes.

    The planes are ``low + g . x`` and ``high + g . x`` in the box ``|x_j| <= e_j``, ``slopes = |g_j| e_j``.  With
    ``w`` the slopes, the part of the box above the plane ``a`` is
    ``sum over signs s of s1 s2 s3 max(a + s . w, 0)^3 / (48 w1 w2 w3)``.

    Parameters
    ----------
    low, high : array, shape (N,)
    slopes : array, shape (N, 3)

    Returns
    -------
    least, most : array, shape (N,)
        Within [0, 1].
    """
    w = np.maximum(slopes, FLATTEST * slopes.max(axis=1, keepdims=True, initial=0.0))
    slack = (w - slopes).sum(axis=1)
    return _above(low - slack, w), _above(high + slack, w)


def _above(a: FloatArray, w: FloatArray) -> FloatArray:
    """Return the part of a box above a plane; see `cut_bounds`."""
    reach = w.sum(axis=1)
    volume = np.zeros_like(a)
    for signs in product((-1.0, 1.0), repeat=3):
        volume += np.prod(signs) * np.maximum(a + w @ np.array(signs), 0.0) ** 3
    with np.errstate(divide="ignore", invalid="ignore"):
        part = volume / (48.0 * w.prod(axis=1))
    part = np.where(np.abs(a) < reach, part, a >= reach)
    return np.asarray(np.clip(np.nan_to_num(part), 0.0, 1.0))


@dataclass(frozen=True, eq=False)
class Cells:
    """Boxes of one root box: the box ``place`` of ``2^level`` a side, and what is known of each.

    Attributes
    ----------
    level : array, shape (N,), int
    place : array, shape (N, 3), int
    clear : array, shape (N,), bool
        The whole box is on home's side of the singular surface.
    least, most : array, shape (N,)
        Bounds of the part of the box that can be reached.
    """

    level: Ints
    place: Ints
    clear: Bools
    least: FloatArray
    most: FloatArray

    def __getitem__(self, which: Bools | Ints) -> Cells:
        return Cells(*(array[which] for array in self._arrays()))

    def __len__(self) -> int:
        return len(self.level)

    def _arrays(self) -> tuple[Any, ...]:
        return self.level, self.place, self.clear, self.least, self.most

    def boxes(self, low: FloatArray, size: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return centres and half edges (N, 3) in a root box from `low`, edges `size`."""
        half = 0.5 * size / 2.0 ** self.level[:, None]
        return low + (2 * self.place + 1) * half, half

    def halved(self) -> Cells:
        """Return the eight halves of every box; what a box was known to be, its halves are."""
        corners = np.array(list(product((0, 1), repeat=3)))
        place = (2 * self.place[:, None] + corners).reshape(-1, 3)
        known: tuple[Any, ...] = (self.clear, self.least, self.most)
        return Cells(np.repeat(self.level + 1, 8), place, *(np.repeat(array, 8) for array in known))

    def joined(self, other: Cells) -> Cells:
        """Return both."""
        return Cells(*(np.concatenate(pair) for pair in zip(self._arrays(), other._arrays(), strict=True)))


def root() -> Cells:
    """Return the root box, nothing known of it."""
    place = np.zeros((1, 3), np.int64)
    return Cells(place[:, 0], place, np.zeros(1, np.bool_), np.zeros(1), np.ones(1))


def _keys(level: Ints, place: Ints) -> Ints:
    """Return one number for each box."""
    return (level << 57) | (place[:, 0] << 38) | (place[:, 1] << 19) | place[:, 2]


def neighbours(cells: Cells) -> tuple[Ints, Ints]:
    """Return all pairs of boxes that share a face, each box asking for one of its own size or larger."""
    keys = _keys(cells.level, cells.place)
    order = np.argsort(keys)
    known = keys[order]
    first, second = [np.empty(0, np.int64)], [np.empty(0, np.int64)]
    for axis, step in product(range(3), (-1, 1)):
        place = cells.place.copy()
        place[:, axis] += step
        asking = np.flatnonzero((place[:, axis] >= 0) & (place[:, axis] < 1 << cells.level))
        place, level = place[asking], cells.level[asking]
        while len(asking):
            wanted = _keys(level, place)
            at = np.minimum(np.searchsorted(known, wanted), len(known) - 1)
            found = known[at] == wanted
            first.append(asking[found])
            second.append(order[at[found]])
            left = ~found & (level > 0)
            asking, place, level = asking[left], place[left] >> 1, level[left] - 1
    return np.concatenate(first), np.concatenate(second)


def connected(cells: Cells, pairs: tuple[Ints, Ints], among: Bools, seed: int) -> Bools:
    """Return the boxes of `among` that are reached from box `seed` through shared faces of such boxes."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    a, b = pairs
    both = among[a] & among[b]
    graph = coo_array((np.ones(int(both.sum()), np.bool_), (a[both], b[both])), shape=(len(cells), len(cells)))
    _count, label = connected_components(graph, directed=False)
    return np.asarray((label == label[seed]) & among)
