"""What sticks the more, the longer the rod has rested, without a name: each move leaves it behind, later ones less."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

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
    for moves in MOVES:
        whole = view.windows_zeroed([_left(one.time, one.q, 0.0, moves) for one in view.signals])[:, 0]
        for rest in RESTED_S:
            column = view.windows_zeroed([_left(one.time, one.q, rest, moves) for one in view.signals])[:, 0]
            size = float(column.std() * whole.std())
            if size > 0.0 and abs(np.cov(column, whole, bias=True)[0, 1]) < ALIKE * size:
                yield rest, column[:, None]


def _left(time: FloatArray, q: FloatArray, rest: float, moves: float) -> FloatArray:
    """Return what moves have left in each row, shape (n,); a move is rows in which the rod goes one way.

    With a rest of 0 that is what rests without an end would leave.
    """
    steps = Memory().moves(q)
    way = np.sign(np.where(np.abs(steps) > LEAST_MOVE_M, steps, 0.0))
    begins = np.flatnonzero((way != 0.0) & (way != np.concatenate([[0.0], way[:-1]])))
    ended, now, places = float(time[0]), 0.0, [0.0]
    for first in begins.tolist():
        rested = float(time[first - 1]) - ended
        share = 1.0 if rest <= 0.0 else -np.expm1(-rested / rest)
        now = now * np.exp(-1.0 / moves) + way[first] * share
        places.append(now)
        after = np.flatnonzero(way[first:] != way[first])
        ended = float(time[first + int(after[0]) - 1]) if len(after) else float(time[-1])
    return np.repeat(places, np.diff(begins, prepend=0, append=len(q)))
