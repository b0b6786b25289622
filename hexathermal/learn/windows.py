"""Windows: means over short pieces of a landing, the independent view of a run that uncertainty is taken from.

Rows are far from independent: those of a landing share its scatter, and a slow process joins landings. A run is
therefore reduced to windows (pieces of one landing, at most `LONGEST_S` long), with the number of rows in each. Means
of the regression's columns stay exact. Where a run has too many windows, neighbours are merged in pairs.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hexathermal.learn.campaign import Block
from hexathermal.learn.gram import Columns
from hexathermal.learn.merged_sums import MergedSums, paired
from hexathermal.poses import FloatArray

LONGEST_S = 300.0
"""Longest window [s]: short against the slow processes of a bench."""

MOST_WINDOWS = 240
"""Windows of a run after merging; a fit works with matrices of this size."""

HELD_WINDOWS = 4096
"""Windows of a run that are held while it is read; then neighbours are merged."""

FEWEST_DIFFERENCES = 30
"""Second differences that a noise is taken from; with fewer it is taken as part of the landings' scatter."""


@dataclass(frozen=True, eq=False)
class Windows:
    """The windows of one run.

    Attributes
    ----------
    run : str
    time : array, shape (w,) [s]
        Mean, since the run's first row.
    X : array, shape (w, m)
        Means of the columns: ``dT`` of every sensor, then ``(q - centre) dT``.
    drift : array, shape (w,) [m]
    q : array, shape (w,) [m]
    rows, landings : array, shape (w,)
        Rows, and landings, that a window is the mean of.
    """

    run: str
    time: FloatArray
    X: FloatArray
    drift: FloatArray
    q: FloatArray
    rows: FloatArray
    landings: FloatArray

    def __len__(self) -> int:
        return len(self.time)


@dataclass(frozen=True, eq=False)
class WindowSet:
    """The windows of several runs, and the noise of single rows.

    Attributes
    ----------
    columns : Columns
    runs : tuple of Windows
    sensor_noise : array, shape (s,) [K]
        Standard deviation of one reading, from second differences within windows; zero where there are too few.
    drift_noise : float [m]
    lowest_dT, highest_dT : array, shape (s,) [K]
    lowest_q, highest_q : float [m]
        What was met in the rows.
    """

    columns: Columns
    runs: tuple[Windows, ...]
    sensor_noise: FloatArray
    drift_noise: float
    lowest_dT: FloatArray
    highest_dT: FloatArray
    lowest_q: float
    highest_q: float


class WindowCollector:
    """Makes windows of blocks as they pass.

    Parameters
    ----------
    columns : Columns
    kept : array of bool, shape (s,)
        Sensors that must have a value in a row that is used; the others count as zero.

    Attributes
    ----------
    placed : bool
        Whether all blocks so far told the displacement.
    """

    def __init__(self, columns: Columns, kept: npt.NDArray[np.bool_]) -> None:
        self.columns, self.kept, self.placed = columns, kept, True
        self._runs: dict[str, MergedSums] = {}
        self._last: dict[str, int] = {}
        self._open: tuple[str, int, float, int] = ("", -1, 0.0, -1)
        s = len(columns.sensors)
        self._squares, self._differences = np.zeros(s + 1), 0
        self._low, self._high = np.full(s + 1, np.inf), np.full(s + 1, -np.inf)

    def passing(self, blocks: Iterable[Block]) -> Iterator[Block]:
        """Give blocks on after adding them."""
        for block in blocks:
            self.add(block)
            yield block

    def add(self, block: Block) -> None:
        """Add the rows of a block."""
        dT = block.dT if self.kept.all() else np.where(self.kept, block.dT, 0.0)
        q = np.zeros(len(block)) if block.q is None else block.q
        self.placed &= block.q is not None
        good = np.isfinite(block.drift) & np.isfinite(dT).all(axis=1) & np.isfinite(q)
        if not good.any():
            return
        dT, q, time, landing, drift = dT[good], q[good], block.time[good], block.landing[good], block.drift[good]
        seen = np.column_stack([dT, q])
        self._low, self._high = np.minimum(self._low, seen.min(axis=0)), np.maximum(self._high, seen.max(axis=0))
        name, last, start, number = self._open
        same = name == block.run.name
        first = np.flatnonzero(np.concatenate([[True], landing[1:] != landing[:-1]]))
        starts = time[first].copy()
        if same and landing[0] == last:
            starts[0] = start
        which = np.repeat(np.arange(len(first)), np.diff(np.append(first, len(time))))
        piece = np.floor((time - starts[which]) / LONGEST_S).astype(np.int64)
        change = (landing[1:] != landing[:-1]) | (piece[1:] != piece[:-1])
        self._noise(dT, drift, time, ~change)
        edges = np.flatnonzero(np.concatenate([[True], change]))
        X = self.columns.made(dT, q)
        table = np.column_stack([np.ones(len(time)), time, q, drift, X])
        sums = np.add.reduceat(table, edges, axis=0)
        begins = np.concatenate([[not (same and landing[0] == last)], landing[edges][1:] != landing[edges][:-1]])
        sums = np.column_stack([begins.astype(float), sums])
        goes_on = same and landing[0] == last and piece[0] == number
        numbers = self._last.get(block.run.name, -1) + np.arange(len(edges)) + (0 if goes_on else 1)
        self._runs.setdefault(block.run.name, MergedSums(sums.shape[1], HELD_WINDOWS)).add(numbers, sums)
        self._last[block.run.name] = int(numbers[-1])
        self._open = (block.run.name, int(landing[-1]), float(starts[-1]), int(piece[-1]))

    def _noise(self, dT: FloatArray, drift: FloatArray, time: FloatArray, together: npt.NDArray[np.bool_]) -> None:
        """Add squared second differences of rows that follow each other at even steps in one window."""
        step = np.diff(time)
        good = together[1:] & together[:-1] & (np.abs(np.diff(step)) <= 0.01 * step[1:])
        values = np.column_stack([dT, drift])
        second = (values[2:] - 2.0 * values[1:-1] + values[:-2])[good]
        self._squares += (second**2).sum(axis=0) / 6.0
        self._differences += int(good.sum())

    def made(self) -> WindowSet:
        """Return the windows of all runs."""
        enough = self._differences >= FEWEST_DIFFERENCES
        noise = np.sqrt(self._squares / self._differences) if enough else np.zeros_like(self._squares)
        runs = []
        for name, sums in self._runs.items():
            held = sums.table
            while len(held) > MOST_WINDOWS:
                held = paired(held)
            n = held[:, 1]
            means = held[:, 2:] / n[:, None]
            landings = np.maximum(held[:, 0], 1.0)
            runs.append(Windows(name, means[:, 0], means[:, 3:], means[:, 2], means[:, 1], n, landings))
        low, high = self._low, self._high
        return WindowSet(
            self.columns,
            tuple(runs),
            noise[:-1],
            float(noise[-1]),
            low[:-1],
            high[:-1],
            float(low[-1]),
            float(high[-1]),
        )
