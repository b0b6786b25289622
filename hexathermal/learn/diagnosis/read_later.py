"""Temperatures that are read at another time than they were logged: what a clock that is off asks many times."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hexathermal.learn.diagnosis.view import View
from hexathermal.machine.leg_repairs import zero_row
from hexathermal.poses import FloatArray


def read_later(view: View, tables: Sequence[FloatArray], offset: float, gains: float = 0.0) -> FloatArray:
    """Return rows' values read `offset` seconds later, in windows, less those of the zero, shape (n, k).

    Parameters
    ----------
    view : View
    tables : sequence of array, shape (rows, k)
        Of each run. Before its first row and after its last one values are held.
    offset : float [s]
    gains : float [s/h]
        By how much more with each hour of a run.
    """
    later, zeros = [], view.once(("zero rows",), lambda: [zero_row(rows.signals.dT) for rows in view.runs])
    for rows, table, zero in zip(view.runs, tables, zeros, strict=True):
        moved = _at(rows.signals.time, table, offset + gains * rows.signals.time / 3600.0)
        # as the repair has it: a zero that is a row of this run is read later too
        later.append(moved if zero is None or view.zeroed_by_run else moved - (moved[zero] - table[zero]))
    return view.windows_zeroed(later)


def _at(time: FloatArray, table: FloatArray, offset: FloatArray) -> FloatArray:
    """Return the rows of a table, shape (n, k), `offset` seconds later, linear between rows."""
    return rows_at(table, np.interp(time + offset, time, np.arange(len(time), dtype=np.float64)))


def rows_at(table: FloatArray, place: FloatArray) -> FloatArray:
    """Return rows of a table, shape (n, k), at places between its rows; beyond its ends the first or the last."""
    place = np.clip(place, 0.0, len(table) - 1.0)
    first = place.astype(np.int64)
    low = table[first]
    return np.asarray(low + (place - first)[:, None] * (table[np.minimum(first + 1, len(table) - 1)] - low))
