"""Motion of a rod between rests: straight lines of position against time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hexathermal.poses import FloatArray


@dataclass(frozen=True, eq=False)
class Motion:
    """Moves of constant speed and the rests between them.

    Attributes
    ----------
    start : array, shape (m,) [s]
        When each move begins.
    end : array, shape (m,) [s]
        When it ends; the rest behind it lasts until the next begins.
    place : array, shape (m + 1,) [m]
        Where the rod rests before the first move and behind each.
    """

    start: FloatArray
    end: FloatArray
    place: FloatArray

    def at(self, time: FloatArray) -> FloatArray:
        """Return where the rod is [m]."""
        knots = np.column_stack([self.start, self.end]).ravel()
        places = np.repeat(self.place, 2)[1:-1]
        return np.interp(time, knots, places) if knots.size else np.full(time.shape, self.place[0])

    def rest(self, time: FloatArray) -> npt.NDArray[np.int64]:
        """Return the number of the rest that each time belongs to; a move belongs to the rest behind it."""
        return np.asarray(np.searchsorted(self.start, time, side="right"), dtype=np.int64)

    def settled(self, time: FloatArray, wait: float) -> npt.NDArray[np.bool_]:
        """Return whether the last move ended at least `wait` [s] ago."""
        ended = np.concatenate([[-np.inf], self.end])[self.rest(time)]
        return np.asarray(time >= ended + wait)

    def speed(self, step: float, count: int) -> tuple[FloatArray, FloatArray]:
        """Return mean speed [m/s] and mean position [m] within `count` steps of `step` [s]."""
        q = self.at(step * np.arange(count + 1, dtype=np.float64))
        return np.abs(np.diff(q)) / step, 0.5 * (q[1:] + q[:-1])


def carried_out(plan: Iterator[tuple[float, float, float]], first: float, pause: float, duration: float) -> Motion:
    """Return the motion of a plan, up to a duration.

    Parameters
    ----------
    plan : iterator of (target [m], speed [m/s], pause behind it [s])
    first : float [m]
        Where the rod rests at first.
    pause : float [s]
        How long.
    duration : float [s]
        Moves that would end behind it are not begun.
    """
    start, end, place, now = [], [], [first], pause
    for target, speed, rest in plan:
        if target == place[-1]:
            continue
        arrival = now + abs(target - place[-1]) / speed
        if arrival > duration:
            break
        start.append(now)
        end.append(arrival)
        place.append(target)
        now = arrival + rest
    return Motion(np.array(start), np.array(end), np.array(place))
