"""What follows the last move, without a name: how long it was, or how long ago."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hexathermal.learn.diagnosis.view import View
from hexathermal.machine.leg_signals import Memory
from hexathermal.poses import FloatArray

SATURATING_M = (0.005, 0.02, 0.06)
"""Ways from which on a longer move does no more."""

SINCE_S, STEPS = (45.0, 5400.0), 7
"""Times since a move, evenly in their logarithm, at which something may let go or settle."""


def last_moves(view: View) -> Iterator[FloatArray]:
    """Give columns of what follows the length of the last move, whatever its direction, and the time since, (n, k).

    Each run by itself, also where it goes on: before its first move it has rested for long.
    """
    long, since = [], []
    for signals in view.signals:
        lengths = np.abs(Memory().lengths(signals.q))
        last = np.maximum.accumulate(np.where(lengths > 0.0, np.arange(len(lengths)), -1))
        long.append(np.where(last < 0, 0.0, lengths[last]))
        since.append(np.where(last < 0, np.inf, signals.time - signals.time[last]))
    for way in SATURATING_M:
        yield view.windows_zeroed([-np.expm1(-own / way) for own in long])
    times = np.geomspace(*SINCE_S, STEPS)
    yield view.windows_zeroed([(own[:, None] >= times).astype(float) for own in since])
