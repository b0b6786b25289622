"""What drags behind the rod, without a name: it turns round over tens of millimetres after each reversal."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hexathermal.learn.diagnosis.view import View
from hexathermal.machine.leg_signals import Memory
from hexathermal.poses import FloatArray

WAYS_M = (0.03, 0.06, 0.12)
"""Ways in which it turns round: a cable, a hose or a cover that is drawn along, a wiper, a guide that is pushed aside.

Shorter ones are a nut's play or a preload that turns: backlash.
"""


def drags(view: View) -> Iterator[tuple[float, FloatArray]]:
    """Give ways in which a drag turns round [m], with its columns: as large everywhere, and larger farther out, (n, k).

    ``df = dq / w (1 - f sign(dq))`` (Dahl, A solid friction model, Aerospace Corporation TOR-0158, 1968).
    """
    at_zero = [signals.q - signals.q[0] for signals in view.signals]
    for way in WAYS_M:
        each = [_turned(signals.q, way) for signals in view.signals]
        farther = [own * q / np.ptp(view.q) for own, q in zip(each, at_zero, strict=True)]
        yield way, view.windows_zeroed([own[:, None] for own in each])
        yield way, view.windows_zeroed([np.column_stack(both) for both in zip(each, farther, strict=True)])


def _turned(q: FloatArray, way: float) -> FloatArray:
    """Return how far a drag has turned round, -1 to 1, in each row; in the middle at first, shape (n,)."""
    steps = Memory().moves(q)
    moving, now = np.flatnonzero(steps), 0.0
    places = [now]
    for step in (steps[moving] / way).tolist():
        towards = 1.0 if step > 0.0 else -1.0
        now = towards + (now - towards) * np.exp(-abs(step))
        places.append(now)
    return np.repeat(places, np.diff(moving, prepend=0, append=len(q)))
