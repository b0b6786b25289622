"""What a contender is: a name and jobs; each job is a function, its inputs, and how its answers are read."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from benchmarks.case import Case, FloatArray, Quantity

ONE_BY_ONE = 200
"""Different poses that a job for one pose goes through, so that no branch is learnt by heart."""

LOOPED = 1000
"""Poses of a batch where a library has no batches and Python must loop."""


class Unavailable(Exception):  # noqa: N818 - a reason, not an error
    """A contender cannot take part here; the text says why."""


def stacked(results: Sequence[Any]) -> FloatArray:
    """Return one answer a row."""
    return np.stack([np.asarray(result) for result in results])


def first(results: Sequence[Any]) -> FloatArray:
    """Return the answers of a batch."""
    return np.asarray(results[0])


@dataclass(frozen=True, eq=False)
class Job:
    """One timed job.

    Attributes
    ----------
    quantity : Quantity
    batch : bool
        A batch, or one pose at a time.
    function, inputs
        ``function(*arguments)`` is timed for every entry of `inputs`.
    poses : int
        Poses that one call works on.
    read : callable
        Turns the results of all calls into rows of the case's answers, its first rows first.
    variant : str
        How this job differs from the contender's others of the same kind.
    all_cores : bool
        Timed on all processors, by the clock on the wall; else on one, by processor time.
    """

    quantity: Quantity
    batch: bool
    function: Callable[..., Any]
    inputs: Sequence[tuple[Any, ...]]
    poses: int
    read: Callable[[Sequence[Any]], FloatArray]
    variant: str = ""
    all_cores: bool = False


class Contender(Protocol):
    """One way of doing the work."""

    name: str
    note: str

    def jobs(self, case: Case) -> list[Job]:
        """Return the jobs that this contender can do, ready to run."""
        ...


def single(
    quantity: Quantity,
    function: Callable[..., Any],
    inputs: Sequence[tuple[Any, ...]],
    variant: str = "",
    read: Callable[[Sequence[Any]], FloatArray] = stacked,
) -> Job:
    """Return a job that does one pose a call."""
    return Job(quantity, False, function, inputs, 1, read, variant)


def rows(array: FloatArray, count: int = ONE_BY_ONE) -> list[FloatArray]:
    """Return the first rows as arrays of their own."""
    return [row.copy() for row in array[:count]]
