"""Which of many rows a report draws: evenly spread ones, and those between them that would be missed."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hexathermal.poses import FloatArray

MOST_POINTS = 1200
"""Points of a curve that are drawn; as many again where they stand out."""

SEEN = 0.01
"""A row is missed that lies farther off the line through its drawn neighbours than this share of the panel's height."""

Rows = npt.NDArray[np.int64]


def kept_of(count: int, most: int = MOST_POINTS, *panels: FloatArray) -> Rows:
    """Return which of many rows are drawn: every k-th, the last, and spikes between them.

    Parameters
    ----------
    count : int
    most : int
        So many are spread evenly; at most as many again stand out.
    panels : array, shape (count,) or (count, k)
        What is drawn on one axis each; NaN where there is nothing.

    Examples
    --------
    >>> kept_of(5, 3).tolist(), kept_of(3, 3).tolist()
    ([0, 2, 4], [0, 1, 2])
    >>> kept_of(9, 3, np.array([0.0, 0.0, 7.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])).tolist()
    [0, 2, 4, 8]
    """
    if count <= most:
        return np.arange(count)
    step = -(-(count - 1) // (most - 1))
    kept = np.arange(0, count, step)
    even: Rows = kept if kept[-1] == count - 1 else np.append(kept, count - 1)
    missed = [_missed(even, column, span) for panel in panels for span in [_span(panel)] if span > 0.0
              for column in panel.reshape(count, -1).T]  # fmt: skip
    if not missed:
        return even
    rows, sizes = (np.concatenate(parts) for parts in zip(*missed, strict=True))
    return np.union1d(even, rows[np.argsort(-sizes, kind="stable")[:most]])


def _span(panel: FloatArray) -> float:
    """Return the height of what is drawn on an axis; 0 where nothing is."""
    known = panel[np.isfinite(panel)]
    return float(np.ptp(known)) if known.size else 0.0


def _missed(even: Rows, column: FloatArray, span: float) -> tuple[Rows, FloatArray]:
    """Return the row of each gap that lies farthest off, where that is seen; and how far, as a share of the height."""
    known = np.flatnonzero(np.isfinite(column[even]))
    if not known.size:
        return np.zeros(0, dtype=np.int64), np.zeros(0)
    line = np.interp(np.arange(len(column)), even[known], column[even[known]])
    off = np.nan_to_num(np.abs(column - line) / span)
    rows = np.flatnonzero(off > SEEN)
    rows = rows[np.argsort(-off[rows], kind="stable")]
    _, first = np.unique(np.searchsorted(even, rows, side="right"), return_index=True)
    return rows[first], off[rows[first]]


def thinned_words(drawn: int, count: int) -> str:
    """Return what is to be said of a curve that was thinned; nothing where it was not."""
    return "" if drawn == count else f" {drawn} of {count} rows are drawn: evenly, and what stands out between."
