"""Sums of consecutive pieces of a run in constant memory: where there are too many, neighbours are merged in pairs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from hexathermal.poses import FloatArray


class MergedSums:
    """Sums of numbered pieces; piece k goes to row ``k // size``, and `size` doubles when `most` rows are full.

    What is held depends on the pieces alone, not on the portions in which they come.

    Parameters
    ----------
    columns : int
        Sums of a piece.
    most : int
        Rows that are held at most; even.
    largest : sequence of int
        Columns that hold the largest value in place of the sum; 0 or more.

    Examples
    --------
    >>> sums = MergedSums(2, 4, largest=(1,))
    >>> sums.add([0, 1, 2], [[1.0, 5.0], [1.0, 6.0], [1.0, 7.0]])
    >>> sums.add([2, 3, 4], [[1.0, 9.0], [1.0, 1.0], [1.0, 2.0]])
    >>> sums.size, sums.table.tolist()
    (2, [[2.0, 6.0], [3.0, 9.0], [1.0, 2.0]])
    """

    def __init__(self, columns: int, most: int, largest: Sequence[int] = ()) -> None:
        self.table: FloatArray = np.empty((0, columns))
        self.size, self.most = 1, most
        self._largest = np.array(largest, dtype=np.int64)
        self._summed = np.setdiff1d(np.arange(columns), self._largest)

    def add(self, pieces: npt.ArrayLike, sums: npt.ArrayLike) -> None:
        """Add the sums, shape (k, columns), of pieces, shape (k,), int, in their order; a piece may come again."""
        number, values = np.asarray(pieces, dtype=np.int64), np.asarray(sums, dtype=np.float64)
        if not len(number):
            return
        while number[-1] // self.size >= self.most:
            self.table = paired(self.table, self._largest)
            self.size *= 2
        row = number // self.size
        missing = int(row[-1]) + 1 - len(self.table)
        if missing > 0:
            self.table = np.concatenate([self.table, np.zeros((missing, self.table.shape[1]))])
        edges = np.flatnonzero(np.diff(row, prepend=row[0] - 1))
        where = row[edges]
        self.table[where[:, None], self._summed] += np.add.reduceat(values[:, self._summed], edges, axis=0)
        if len(self._largest):
            highest = np.maximum.reduceat(values[:, self._largest], edges, axis=0)
            self.table[where[:, None], self._largest] = np.maximum(self.table[where[:, None], self._largest], highest)


def paired(table: FloatArray, largest: npt.ArrayLike = ()) -> FloatArray:
    """Return the sums of neighbours, two by two; of the columns `largest` the larger value."""
    even = np.concatenate([table, np.zeros((len(table) % 2, table.shape[1]))])
    pairs: FloatArray = even[::2] + even[1::2]
    columns = np.asarray(largest, dtype=np.int64)
    pairs[:, columns] = np.maximum(even[::2, columns], even[1::2, columns])
    return pairs
