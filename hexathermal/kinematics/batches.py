"""Batches: leading shapes, threads for large ones, and the compiled loops on first use."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np

THREAD_FROM = 50_000
"""Results below this number are not worth a second thread."""


@cache
def loops() -> ModuleType:
    """Return the compiled loops of lengths and Jacobians; the first call loads the compiler."""
    from hexathermal.kinematics import lengths_loops

    return lengths_loops


@cache
def correctors() -> ModuleType:
    """Return the compiled loops of the thermal correction."""
    from hexathermal.kinematics import correction_loops

    return correction_loops


@cache
def solvers() -> tuple[ModuleType, ModuleType]:
    """Return the compiled forward loops, fast and careful."""
    from hexathermal.kinematics import careful_loops, forward_loops

    return forward_loops, careful_loops


def processors() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def in_chunks(count: int, work: Callable[[int, int], Any]) -> list[Any]:
    """Run ``work(first, last)`` over ``range(count)``, on all processors where it pays; results in order."""
    threads = processors() if count >= THREAD_FROM else 1
    if threads == 1:
        return [work(0, count)]
    edges = np.linspace(0, count, 4 * threads + 1).astype(int)
    with ThreadPoolExecutor(threads) as pool:
        return list(pool.map(work, edges[:-1], edges[1:]))


def slices(count: int, size: int = 8192) -> Iterator[slice]:
    """Return slices over ``range(count)``: array work in parts keeps its memory small."""
    return (slice(first, min(first + size, count)) for first in range(0, count, size))


def place(index: int, shape: tuple[int, ...]) -> tuple[int, ...]:
    """Return the place of a flat index in a batch; empty for a single one."""
    return tuple(int(k) for k in np.unravel_index(index, shape)) if shape else ()


def where(index: tuple[int, ...]) -> str:
    """Return ``" at index ..."``, or nothing for a single one."""
    return f" at index {index[0] if len(index) == 1 else index}" if index else ""
