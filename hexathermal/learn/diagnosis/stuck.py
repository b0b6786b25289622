"""What sticks the more, the longer the rod has rested, without a name: each move leaves it behind, later ones less."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hexathermal.learn.diagnosis.view import View
from hexathermal.machine.leg_signals import Memory
from hexathermal.poses import FloatArray

RESTED_S, MOVES = (150.0, 600.0, 2400.0), (1.5, 4.0)
"""Rests after which it sticks nearly as much as it ever does, and numbers of moves that wear it off."""

LEAST_MOVE_M = 2e-5
"""What is shorter is a correction of the place, and no move that sets anything free."""

ALIKE = 0.9
"""Correlation with what rests without an end would make from which on all rests are alike: reversals tell no more."""


def stuck(view: View) -> Iterator[tuple[float, FloatArray]]:
    """Give rests [s] with what they make of each move, one column each, shape (n, 1).

    ``f <- f exp(-1 / N) + sign(move) (1 - exp(-rest / tau))`` at each move: static friction grows with the time at rest
    (Rabinowicz, Proc. Physical Society 71 (1958) 668).
    """
    each = [_rests(one.time, one.q) for one in view.signals]

    def column(moves: float, rest: float | None) -> FloatArray:
        """Return what is left, in windows; `rest` None: as if each rest had no end."""
        return view.windows_zeroed([own.left(moves, rest) for own in each])[:, 0]

    for moves in MOVES:
        whole = column(moves, None)
        for rest in RESTED_S:
            own = column(moves, rest)
            size = float(own.std() * whole.std())
            if size > 0.0 and abs(np.cov(own, whole, bias=True)[0, 1]) < ALIKE * size:
                yield rest, own[:, None]


@dataclass(frozen=True, eq=False)
class _Rests:
    """Moves of a run of some rows: where each begins, its direction, and how long the rod had rested before [s]."""

    rows: int
    begins: npt.NDArray[np.intp]
    way: FloatArray
    rested: FloatArray

    def left(self, moves: float, rest: float | None) -> FloatArray:
        """Return what they have left in each row, shape (rows,)."""
        kicks = self.way if rest is None else self.way * -np.expm1(-self.rested / rest)
        now, places = 0.0, [0.0]
        for kick in kicks.tolist():
            now = now * np.exp(-1.0 / moves) + kick
            places.append(now)
        return np.repeat(places, np.diff(self.begins, prepend=0, append=self.rows))


def _rests(time: FloatArray, q: FloatArray) -> _Rests:
    """Return the moves of a run: each is rows in which the rod goes one way."""
    steps = Memory().moves(q)
    way = np.sign(np.where(np.abs(steps) > LEAST_MOVE_M, steps, 0.0))
    goes, rim = way != 0.0, np.zeros(1)
    begins = np.flatnonzero(goes & (way != np.concatenate([rim, way[:-1]])))
    ends = np.flatnonzero(goes & (way != np.concatenate([way[1:], rim])))
    stopped = np.concatenate([time[:1], time[ends[:-1]]])[: len(begins)]
    return _Rests(len(q), begins, way[begins], time[begins - 1] - stopped)
