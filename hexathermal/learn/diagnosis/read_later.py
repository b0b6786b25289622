"""Temperatures that are read at another time than they were logged: what a clock that is off asks many times."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hexathermal.learn.diagnosis.view import View
from hexathermal.poses import FloatArray


def read_later(view: View, tables: Sequence[FloatArray], offset: float) -> FloatArray:
    """Return rows' values read `offset` seconds later, in windows, less those of the zero, shape (n, k).

    Parameters
    ----------
    view : View
    tables : sequence of array, shape (rows, k)
        Of each run. Before its first row and after its last one values are held.
    offset : float [s]
    """
    later = [_at(signals.time, table, offset) for signals, table in zip(view.signals, tables, strict=True)]
    if not view.zeroed_by_run:  # all count from one zero, which is read later too
        first = view.pieces[0].used[0]
        moved = later[0][first] - tables[0][first]
        later = [table - moved for table in later]
    return view.windows_zeroed(later)


def _at(time: FloatArray, table: FloatArray, offset: float) -> FloatArray:
    """Return the rows of a table, shape (n, k), `offset` seconds later, linear between rows."""
    place = np.interp(time + offset, time, np.arange(len(time), dtype=np.float64))
    first = place.astype(np.int64)
    low = table[first]
    return np.asarray(low + (place - first)[:, None] * (table[np.minimum(first + 1, len(time) - 1)] - low))
