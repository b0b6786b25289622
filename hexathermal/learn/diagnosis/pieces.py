"""The windows of a run: pieces of its landings, the independent units of a diagnosis."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from hexathermal.learn.signals import RunRows
from hexathermal.machine.leg_signals import LegSignals
from hexathermal.poses import FloatArray

EDGES_S = (0.0, 60.0, 180.0, 420.0)
"""Windows of a landing begin so long after its first row; then every `LONGEST_S`: what relaxes, relaxes at first."""

LONGEST_S = 300.0

MOST_WINDOWS = 500
"""Windows of a run beyond one for each landing; longer runs, and those of more landings, take longer windows."""


def _means(usable: FloatArray, edges: npt.NDArray[np.int64], rows: FloatArray) -> FloatArray:
    """Return the means of usable rows over windows that begin at edges and have so many rows."""
    sums = np.add.reduceat(usable, edges, axis=0)
    return np.asarray(sums / rows.reshape((-1,) + (1,) * (usable.ndim - 1)))


@dataclass(frozen=True, eq=False)
class Pieces:
    """Windows of one run: which usable rows they are means of.

    Attributes
    ----------
    used : array of int, shape (u,)
        Usable rows.
    edges : array of int, shape (w,)
        Where windows begin among them.
    landing : array of int, shape (w,)
    """

    used: npt.NDArray[np.int64]
    edges: npt.NDArray[np.int64]
    landing: npt.NDArray[np.int64]

    @cached_property
    def rows(self) -> FloatArray:
        """Rows of each window."""
        return np.diff(np.append(self.edges, len(self.used))).astype(np.float64)

    def means(self, values: FloatArray) -> FloatArray:
        """Return the means of values, shape (n, ...), over windows."""
        return _means(values[self.used], self.edges, self.rows)


@dataclass(frozen=True, eq=False)
class Pooled:
    """The windows of several runs, whose rows lie behind each other: means of all runs are made at once.

    Attributes
    ----------
    used : array of int, shape (u,)
        Usable rows.
    edges : array of int, shape (w,)
        Where windows begin among them.
    rows : array, shape (w,)
        Rows of each window.
    zeros : array of int, shape (u,)
        The first usable row, among these, of the run of each.
    """

    used: npt.NDArray[np.int64]
    edges: npt.NDArray[np.int64]
    rows: FloatArray
    zeros: npt.NDArray[np.int64]

    def means(self, rows: FloatArray, *, zeroed: bool = False) -> FloatArray:
        """Return the means over windows of values in all rows, run after run, shape (n,) or (n, k) to (w, k).

        Where `zeroed`, less those of each run's zero: row by row, since what never changes is then 0 to the last bit,
        while a mean less the zero would be rounding, and rounding a signal.
        """
        from hexathermal.learn.diagnosis.window_loops import window_means

        table = np.ascontiguousarray(rows if rows.ndim == 2 else rows[:, None], dtype=np.float64)
        return np.asarray(window_means(table, self.used, self.edges, self.rows, self.zeros, zeroed))


def pooled(pieces: Sequence[Pieces], rows: Sequence[int]) -> Pooled:
    """Return the windows of runs of so many rows each."""
    counts = [len(piece.used) for piece in pieces]
    before, begins = np.cumsum([0, *rows[:-1]]), np.cumsum([0, *counts[:-1]])
    return Pooled(
        np.concatenate([piece.used + start for piece, start in zip(pieces, before, strict=True)]),
        np.concatenate([piece.edges + start for piece, start in zip(pieces, begins, strict=True)]),
        np.concatenate([piece.rows for piece in pieces]),
        np.repeat(begins, counts),
    )


def going_on(
    sums: Iterable[FloatArray], pieces: Sequence[Pieces], *, zeroed_by_run: bool
) -> tuple[FloatArray, FloatArray]:
    """Return sums over each run's rows that go on from run to run, in windows, and those at each window's zero.

    Parameters
    ----------
    sums : iterable of array, shape (rows,)
        Of each run by itself.
    pieces : sequence of Pieces
    zeroed_by_run : bool
        Whether each run counts from its own first usable row, else from the campaign's beginning.
    """
    means, zeros, gone = [], [], 0.0
    for own, piece in zip(sums, pieces, strict=True):
        total = gone + own
        means.append(piece.means(total))
        zeros.append(np.full(len(means[-1]), float(total[piece.used[0]]) if zeroed_by_run else 0.0))
        gone = float(total[-1])
    return np.concatenate(means), np.concatenate(zeros)


def pieces_of(rows: RunRows) -> Pieces:
    """Return the windows of a run."""
    used = np.flatnonzero(rows.settled)
    time, landing = rows.signals.time[used], rows.landing[used]
    first = np.flatnonzero(np.concatenate([[True], landing[1:] != landing[:-1]]))
    since = time - np.repeat(time[first], np.diff(np.append(first, len(used))))
    longest, begin = LONGEST_S, list(EDGES_S)

    def edges_of(longest: float) -> npt.NDArray[np.int64]:
        """Return where windows begin that are no longer than that, behind those at the begin of each landing."""
        piece = np.searchsorted(begin, since, side="right") + np.floor(np.maximum(since - begin[-1], 0.0) / longest)
        return np.flatnonzero(np.concatenate([[True], (landing[1:] != landing[:-1]) | (piece[1:] != piece[:-1])]))

    most = len(first) + MOST_WINDOWS
    while len(edges_of(np.inf)) > most:  # landings alone are many: fewer windows in each
        begin.pop()
    while len(edges := edges_of(longest)) > most:
        longest *= 2.0
    return Pieces(used, edges, landing[edges])


def mean_signals(signals: LegSignals, piece: Pieces, *, zeroed: bool = False) -> LegSignals:
    """Return signals as means over windows; where `zeroed`, behind those of the first usable row, the run's zero."""

    def mean(values: FloatArray) -> FloatArray:
        means = piece.means(values)
        return np.concatenate([values[piece.used[:1]], means]) if zeroed else means

    def known(values: FloatArray | None) -> FloatArray | None:
        return None if values is None else mean(values)

    return replace(
        signals,
        time=mean(signals.time),
        q=mean(signals.q),
        dT={name: mean(values) for name, values in signals.dT.items()},
        air=known(signals.air),
        index=known(signals.index),
        pressure_index=known(signals.pressure_index),
        tilt=known(signals.tilt),
        inputs={name: mean(values) for name, values in signals.inputs.items()},
        zero_row=None,
    )
