"""Timing, side by side: all jobs of one kind take turns, so that a busy machine slows all of them alike."""

from __future__ import annotations

import contextlib
import gc
import os
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from statistics import median

import numpy as np

from benchmarks.case import Case, FloatArray, Quantity
from benchmarks.contender import Contender, Job

SHORTEST_TURN_S = 0.03
"""A turn repeats its calls until it lasts this long: clocks tick finely, but interrupts do not."""

PATIENCE_S = 3.0
"""Time that all turns of one job may take together; three turns are taken in any case."""

MOST_TURNS = 15


@dataclass(frozen=True)
class Measurement:
    """What was measured for one job.

    Attributes
    ----------
    seconds, best_seconds : float
        Time for one pose: median and smallest of all turns. Processor time of one core, or time by the clock on the
        wall where all processors worked.
    turns : int
    poses : int
        Poses of one call.
    errors : tuple of float
        Largest differences to the true answer: metres for lengths; metres and entries of the rotation for poses;
        entries for Jacobians.
    """

    contender: str
    quantity: Quantity
    batch: bool
    variant: str
    all_cores: bool
    seconds: float
    best_seconds: float
    turns: int
    poses: int
    errors: tuple[float, ...]


def errors(case: Case, quantity: Quantity, answers: FloatArray) -> tuple[float, ...]:
    """Return the largest errors of the first rows of a case; NaN where an answer is missing."""
    wrong = np.abs(answers - case.answers(quantity)[: len(answers)])
    if quantity is Quantity.POSES:
        return float(wrong[:, :3, 3].max()), float(wrong[:, :3, :3].max())
    return (float(wrong.max()),)


def answered(job: Job) -> FloatArray:
    """Return the answers of a job: also its warm-up."""
    return job.read([job.function(*arguments) for arguments in job.inputs])


@contextlib.contextmanager
def one_processor() -> Iterator[None]:
    """Keep this process on one processor, where the system lets it."""
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    allowed = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(allowed)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, allowed)


def _turn(job: Job, repeats: int, clock: Callable[[], float]) -> float:
    """Return the seconds that one pose takes, over `repeats` rounds of the job's inputs."""
    function, inputs = job.function, job.inputs
    start = clock()
    for _ in range(repeats):
        for arguments in inputs:
            function(*arguments)
    return (clock() - start) / (repeats * len(inputs) * job.poses)


def _timed(jobs: Sequence[Job], clock: Callable[[], float]) -> list[list[float]]:
    """Return the turns of each job, taken one after the other."""
    repeats, turns = [], []
    for job in jobs:
        a_round = _turn(job, 1, clock) * len(job.inputs) * job.poses
        repeats.append(max(1, int(np.ceil(SHORTEST_TURN_S / max(a_round, 1e-9)))))
        turns.append(int(np.clip(PATIENCE_S / max(a_round * repeats[-1], SHORTEST_TURN_S), 3, MOST_TURNS)))
    taken: list[list[float]] = [[] for _ in jobs]
    gc.collect()
    gc.disable()
    try:
        for turn in range(max(turns)):
            for k, job in enumerate(jobs):
                if turn < turns[k]:
                    taken[k].append(_turn(job, repeats[k], clock))
    finally:
        gc.enable()
    return taken


def measured(
    case: Case, contenders: Sequence[Contender], progress: Callable[[str], None] = lambda _text: None
) -> list[Measurement]:
    """Return all measurements of all contenders."""
    named = [(contender.name, job) for contender in contenders for job in contender.jobs(case)]
    out = []
    for quantity in Quantity:
        for batch in (False, True):
            progress(f"{quantity.value}, {'batch' if batch else 'one pose'}")
            for all_cores in (False, True):
                group = [
                    (name, job) for name, job in named
                    if (job.quantity, job.batch, job.all_cores) == (quantity, batch, all_cores)
                ]  # fmt: skip
                out.extend(_group(case, group, all_cores))
    return out


def _group(case: Case, group: list[tuple[str, Job]], all_cores: bool) -> list[Measurement]:
    """Return the measurements of jobs of one kind."""
    if not group:
        return []
    jobs = [job for _name, job in group]
    with contextlib.nullcontext() if all_cores else one_processor():
        wrong = [errors(case, job.quantity, answered(job)) for job in jobs]
        taken = _timed(jobs, time.perf_counter if all_cores else time.process_time)
    return [
        Measurement(
            contender=name,
            quantity=job.quantity,
            batch=job.batch,
            variant=job.variant,
            all_cores=all_cores,
            seconds=median(turns),
            best_seconds=min(turns),
            turns=len(turns),
            poses=job.poses,
            errors=error,
        )
        for (name, job), turns, error in zip(group, taken, wrong, strict=True)
    ]
