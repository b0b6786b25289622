"""What sticks the more, the longer the rod has rested, without a name: each move leaves it behind, later ones less."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

from hexathermal.learn.diagnosis.view import View
from hexathermal.machine.leg_signals import Memory
from hexathermal.poses import FloatArray

RESTED_S, MOVES = (150.0, 600.0, 2400.0), (1.5, 4.0)
"""Rests after which it sticks nearly as much as it ever does, and numbers of moves that wear it off."""

LIKE_REVERSALS = 0.9
"""Correlation with the direction of the last move from which on all rests are alike, and it is backlash."""


def stuck(view: View) -> Iterator[tuple[float, FloatArray]]:
    """Give rests [s] with what they make of each move, one column each, shape (n, 1).

    ``f <- f exp(-1 / N) + sign(move) (1 - exp(-rest / tau))`` at each move: static friction grows with the time at rest
    (Rabinowicz, Proc. Physical Society 71 (1958) 668).
    """
    turned = view.windows_zeroed([Memory().direction(signals.q) for signals in view.signals])[:, 0]
    for rest, moves in product(RESTED_S, MOVES):
        column = view.windows_zeroed([_left(one.time, one.q, rest, moves) for one in view.signals])[:, 0]
        if abs(column @ turned) < LIKE_REVERSALS * np.linalg.norm(column) * np.linalg.norm(turned):
            yield rest, column[:, None]


def _left(time: FloatArray, q: FloatArray, rest: float, moves: float) -> FloatArray:
    """Return what moves have left in each row, shape (n,); a move is rows in which the rod goes one way."""
    way = np.sign(Memory().moves(q))
    begins = np.flatnonzero((way != 0.0) & (way != np.concatenate([[0.0], way[:-1]])))
    ended, now, places = float(time[0]), 0.0, [0.0]
    for first in begins.tolist():
        rests = float(time[first - 1]) - ended
        now = now * np.exp(-1.0 / moves) + way[first] * -np.expm1(-rests / rest)
        places.append(now)
        after = np.flatnonzero(way[first:] != way[first])
        ended = float(time[first + int(after[0]) - 1]) if len(after) else float(time[-1])
    return np.repeat(places, np.diff(begins, prepend=0, append=len(q)))
