"""What follows the last move, without a name: how long it was, how long ago, or that it ended some time ago."""

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

AFTER_S, FINER_STEPS = (30.0, 1200.0), 14
"""The same of one step: a brake that closes, a current that is cut when nothing has moved for a while."""


def last_moves(view: View) -> Iterator[FloatArray]:
    """Give columns of what follows the length of the last move, whatever its direction, and the time since, (n, k)."""
    lengths, since = _kept(view)
    for way in SATURATING_M:
        yield view.windows_zeroed([-np.expm1(-own / way) for own in lengths])
    yield _rested(view, since, np.geomspace(*SINCE_S, STEPS))


def steps_at_rest(view: View) -> Iterator[tuple[float, FloatArray]]:
    """Give times since the last move [s] at which something steps, and its one column, shape (n, 1).

    That is no decay: creep, which wide windows make alike, must be ahead of it. A step that no rest after a move is
    long enough for would be one at each run's first move.
    """
    _, since = _kept(view)
    longest = max((float(own[np.isfinite(own)].max(initial=0.0)) for own in since), default=0.0)
    times = np.geomspace(*AFTER_S, FINER_STEPS)
    times = times[times <= longest]
    steps = _rested(view, since, times)
    for k, time in enumerate(times.tolist()):
        if k == 0 or np.ptp(steps[:, k] - steps[:, k - 1]) > 0.0:  # rows may be too far apart to tell them
            yield time, steps[:, [k]]


def _kept(view: View) -> tuple[list[FloatArray], list[FloatArray]]:
    """Return what `_last` does, made once."""
    return view.once(("the last move",), lambda: _last(view), ())


def _last(view: View) -> tuple[list[FloatArray], list[FloatArray]]:
    """Return the length of the last move [m] and the time since [s] in all rows of each run.

    Each run by itself, also where it goes on: before its first move it has rested for long.
    """
    found, since = [], []
    for signals in view.signals:
        lengths = np.abs(Memory().lengths(signals.q))
        last = np.maximum.accumulate(np.where(lengths > 0.0, np.arange(len(lengths)), -1))
        found.append(np.where(last < 0, 0.0, lengths[last]))
        since.append(np.where(last < 0, np.inf, signals.time - signals.time[last]))
    return found, since


def _rested(view: View, since: list[FloatArray], times: FloatArray) -> FloatArray:
    """Return the share of each window in which nothing has moved for some times, shape (n, k)."""
    return view.windows_zeroed([(own[:, None] >= times).astype(float) for own in since])
