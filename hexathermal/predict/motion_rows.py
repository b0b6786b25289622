"""Rows of a motion in the order of time: those of poses, and readings between them, while the legs stay."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hexathermal.poses import FloatArray


@dataclass(frozen=True, eq=False)
class MotionRows:
    """The rows of n poses, and of readings that no pose meets, m in all.

    Attributes
    ----------
    time : array, shape (m,) [s]
    hot : array, shape (m, s) [degC]
    stand : array of int, shape (m,)
        The pose that the legs stand at; -1 before the first.
    own : array of int, shape (n,)
        The row of each pose.
    """

    time: FloatArray
    hot: FloatArray
    stand: npt.NDArray[np.int64]
    own: npt.NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.own)

    @property
    def alone(self) -> bool:
        """Whether each row is that of a pose."""
        return len(self.own) == len(self.time)

    def part(self, first: int, last: int) -> MotionRows:
        """Return the rows of some poses, with those behind the pose before."""
        begin = 0 if first == 0 else int(self.own[first - 1]) + 1
        end = len(self.time) if last == len(self) else int(self.own[last - 1]) + 1
        rows = slice(begin, end)
        return MotionRows(self.time[rows], self.hot[rows], self.stand[rows] - first, self.own[first:last] - begin)


def motion_rows(time: FloatArray, hot: FloatArray, between: tuple[FloatArray, FloatArray] | None = None) -> MotionRows:
    """Return rows of poses, and of readings between them, in the order of time.

    Parameters
    ----------
    time : array, shape (n,) [s]
        Of poses, never decreasing.
    hot : array, shape (n, s) [degC]
    between : arrays, shape (u,) [s] and (u, s) [degC], optional
        Readings that no pose meets.

    Examples
    --------
    Two poses, a reading before the first and one between them:

    >>> import numpy as np
    >>> rows = motion_rows(np.array([1.0, 3.0]), np.zeros((2, 1)), (np.array([0.0, 2.0]), np.ones((2, 1))))
    >>> rows.time.tolist(), rows.stand.tolist(), rows.own.tolist()
    ([0.0, 1.0, 2.0, 3.0], [-1, 0, 0, 1], [1, 3])
    """
    n = len(time)
    if between is None or not len(between[0]):
        return MotionRows(time, hot, np.arange(n), np.arange(n))
    order = np.argsort(np.concatenate([between[0], time]), kind="stable")
    posed = order >= len(between[0])
    return MotionRows(
        np.concatenate([between[0], time])[order], np.concatenate([between[1], hot])[order],
        np.cumsum(posed) - 1, np.flatnonzero(posed),
    )  # fmt: skip
