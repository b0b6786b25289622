"""Windows in which thermometers are compared with each other, and with what warms them: ten minutes each."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
import numpy.typing as npt

from hexathermal.learn.diagnosis.channels import Channel
from hexathermal.learn.diagnosis.view import View
from hexathermal.poses import FloatArray

PARITY_WINDOW_S = 600.0


class ParityWindows:
    """Means of rows' values over windows of all runs.

    Parameters
    ----------
    view : View
    """

    def __init__(self, view: View) -> None:
        self.view = view

    @cached_property
    def edges(self) -> list[npt.NDArray[np.int64]]:
        """Rows where windows begin, for each run."""
        found = []
        for signals in self.view.signals:
            piece = np.floor(signals.time / PARITY_WINDOW_S)
            found.append(np.flatnonzero(np.concatenate([[True], piece[1:] != piece[:-1]])))
        return found

    @cached_property
    def _rows(self) -> list[npt.NDArray[np.int64]]:
        """Rows of each window, for each run."""
        return [np.diff(np.append(edges, len(one))) for edges, one in zip(self.edges, self.view.signals, strict=True)]

    def means(self, values: Sequence[FloatArray]) -> FloatArray:
        """Return means over windows, run after run, of values in all rows of each, shape (n,) or (n, k)."""
        parts = [
            np.add.reduceat(value, edges, axis=0) / (count if value.ndim == 1 else count[:, None])
            for edges, count, value in zip(self.edges, self._rows, values, strict=True)
        ]
        return np.asarray(np.concatenate(parts))

    def channel(self, y: FloatArray) -> Channel:
        """Return a quantity in windows, shape (n,), as a channel without landings."""
        start = np.concatenate([np.arange(len(edges)) == 0 for edges in self.edges])
        time = self.means([signals.time for signals in self.view.signals])
        step = np.where(start, 0.0, np.diff(time, prepend=time[:1]))
        run = np.repeat(np.arange(len(self.edges)), [len(edges) for edges in self.edges])
        zeroed = self.view.zeroed_by_run
        return Channel(y, start, start, step, np.ones(len(start)), run, False, zeroed, zeroed)


def parity_windows(view: View) -> ParityWindows:
    """Return the windows of a view, made once."""
    return view.once(("parity windows",), lambda: ParityWindows(view), ())
