"""Gram matrices of every run, gathered in one pass: all that a regression on any set of sensors needs of the rows.

Columns of a row are ``dT_s`` for every sensor, ``(q - centre) dT_s`` where there is a stroke, and the drift.  The
products are summed run by run, so that fits on all runs but one cost nothing more, and memory does not grow with rows.

A row serves only where all sensors that are compared have a value: sets of sensors are compared on the same rows.
Rows are summed by the pattern of their missing values, and it is decided afterwards which sensors are left out.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from hexathermal.errors import ArgumentError, DataError
from hexathermal.learn.campaign import Block, LegDimensions
from hexathermal.poses import FloatArray

Rows: TypeAlias = Callable[[], Iterable[Block]]
"""A function that gives the blocks of all runs anew, each time from the first row of the first run."""

CHUNK_ROWS = 8192
"""Rows whose columns are made at a time: they stay in the processor's cache."""

MOST_PATTERNS = 512
"""Patterns of missing values that are kept apart in one run; rows of further ones are left out, and counted."""

MOST_MISSING = 0.1
"""A sensor that lacks more than this part of any run's rows is left out, so that the others keep those rows."""


@dataclass(frozen=True, eq=False)
class Columns:
    """What the regression's columns are made of.

    Parameters
    ----------
    sensors : tuple of str
    stroke : bool
        Whether the law reads a displacement q, and with it has a second coefficient for each sensor.
    centre : float [m]
        Displacement that is subtracted from q, which keeps the columns apart; coefficients do not depend on it.
    retracted_length : float [m]
        1 for a part that is no leg.
    """

    sensors: tuple[str, ...]
    stroke: bool
    centre: float = 0.0
    retracted_length: float = 1.0

    @property
    def count(self) -> int:
        """Number of columns without the drift."""
        return len(self.sensors) * (2 if self.stroke else 1)

    def of(self, sensors: npt.ArrayLike) -> npt.NDArray[np.int64]:
        """Return the columns of sets of sensors, shape (..., k) -> (..., k) or (..., 2 k)."""
        chosen = np.asarray(sensors, dtype=np.int64)
        return np.concatenate([chosen, chosen + len(self.sensors)], axis=-1) if self.stroke else chosen

    def made(self, dT: FloatArray, q: FloatArray | None) -> FloatArray:
        """Return the columns of rows."""
        if not self.stroke or q is None:
            return dT
        return np.concatenate([dT, dT * (q - self.centre)[:, None]], axis=1)

    def to_law(self, coefficients: FloatArray) -> FloatArray:
        """Return ``[A .. B ..]`` of coefficients of a set of sensors, shape (..., 2 k) or (..., k).

        ``a dT + b (q - centre) dT = A q0 dT + B q dT`` with ``B = b``, ``A = (a - b centre) / q0``.
        """
        return coefficients @ self.law_matrix(coefficients.shape[-1]).T

    def law_matrix(self, count: int) -> FloatArray:
        """Return the matrix that makes ``[A .. B ..]`` of coefficients."""
        if not self.stroke:
            return np.eye(count)
        one = np.eye(count // 2)
        return np.block([[one, -self.centre * one], [0.0 * one, self.retracted_length * one]]) / self.retracted_length


@dataclass(frozen=True, eq=False)
class Grams:
    """Products of the columns, run by run.

    Attributes
    ----------
    columns : Columns
    runs : tuple of str
    matrices : array, shape (r, m + 1, m + 1)
        Columns and drift; entries of sensors left out are zero.
    rows : array, shape (r,), int
        Rows summed.
    rows_left_out : array, shape (r,), int
        Rows left out because a sensor that is compared has no value there.
    left_out : dict of str to float
        Sensors left out, with the largest part of a run's rows that they lack.
    lacking_in : dict of str to str
        Of each sensor left out, the run in which it lacks that part.
    """

    columns: Columns
    runs: tuple[str, ...]
    matrices: FloatArray
    rows: npt.NDArray[np.int64]
    rows_left_out: npt.NDArray[np.int64]
    left_out: dict[str, float]
    lacking_in: dict[str, str] = field(default_factory=dict)

    @property
    def kept(self) -> tuple[int, ...]:
        """Numbers of the sensors that are compared."""
        return tuple(k for k, name in enumerate(self.columns.sensors) if name not in self.left_out)

    @property
    def kept_mask(self) -> npt.NDArray[np.bool_]:
        """Which sensors are compared."""
        return np.isin(np.arange(len(self.columns.sensors)), self.kept)


class _RunSum:
    """Sums of one run, one for each pattern of missing values, with the roundings carried along."""

    def __init__(self, size: int) -> None:
        self.size = size
        self.sums: dict[bytes, tuple[FloatArray, FloatArray]] = {}
        self.rows: dict[bytes, int] = {}
        self.lost = 0

    def add(self, pattern: bytes, gram: FloatArray, rows: int) -> None:
        """Add the products of some rows."""
        if pattern not in self.sums:
            if len(self.sums) >= MOST_PATTERNS:
                self.lost += rows
                return
            self.sums[pattern] = (np.zeros((self.size, self.size)), np.zeros((self.size, self.size)))
            self.rows[pattern] = 0
        total, rest = self.sums[pattern]
        moved = total + gram
        rest += np.where(np.abs(total) >= np.abs(gram), (total - moved) + gram, (gram - moved) + total)
        total[...] = moved
        self.rows[pattern] += rows


def gather(rows: Iterable[Block], columns: Columns, progress: Callable[[int], None] | None = None) -> Grams:
    """Return the Gram matrices of every run, in one pass over its rows.

    Parameters
    ----------
    rows : iterable of Block
        The blocks of a run follow each other.
    columns : Columns
    progress : function, optional
        Called with the number of rows done.

    Returns
    -------
    Grams

    Raises
    ------
    ArgumentError
        A block has other sensors.
    DataError
        A block has no displacement, a value is infinite, or no row is left.
    """
    runs: dict[str, _RunSum] = {}
    size = columns.count + 1
    buffer = np.empty((CHUNK_ROWS, size))
    done = 0
    for block in rows:
        _checked(block, columns)
        run = runs.setdefault(block.run.name, _RunSum(size))
        for i in range(0, len(block), CHUNK_ROWS):
            _add_chunk(run, block, slice(i, i + CHUNK_ROWS), columns, buffer)
        done += len(block)
        if progress is not None:
            progress(done)
    if not runs:
        raise DataError("there are no rows to learn from: no run for identification has a usable row")
    return _chosen(runs, columns)


def _checked(block: Block, columns: Columns) -> None:
    """Refuse a block that does not fit the columns."""
    if block.dT.shape != (len(block), len(columns.sensors)):
        raise ArgumentError(
            f"rows of run {block.run.name} have shape {block.dT.shape}; expected {len(columns.sensors)} sensors"
        )
    if columns.stroke and block.q is None:
        raise DataError(f"run {block.run.name} has no displacement q (column q_mm), which the law needs")


def _add_chunk(run: _RunSum, block: Block, part: slice, columns: Columns, buffer: FloatArray) -> None:
    """Add some rows of a block to the sums of its run."""
    dT, drift, s = block.dT[part], block.drift[part], len(columns.sensors)
    Z = buffer[: len(dT)]
    Z[:, :s] = dT
    if columns.stroke and block.q is not None:
        np.multiply(dT, (block.q[part] - columns.centre)[:, None], out=Z[:, s : 2 * s])
    Z[:, -1] = drift
    with np.errstate(invalid="ignore", over="ignore"):
        gram = Z.T @ Z
    if np.isfinite(np.diagonal(gram)).all():
        run.add(bytes(s), gram, len(Z))
        return
    if np.isinf(Z).any():
        raise DataError(f"run {block.run.name} holds an infinite value at {block.time[part][0]:g} s or soon after")
    good = np.isfinite(Z[:, -1]) & (np.isfinite(block.q[part]) if columns.stroke and block.q is not None else True)
    run.lost += int((~good).sum())
    Z = Z[good]
    missing = np.isnan(Z[:, :s])
    patterns, which = np.unique(missing, axis=0, return_inverse=True)
    for k, pattern in enumerate(patterns):
        chosen = Z[which.ravel() == k]
        gram = np.nan_to_num(chosen).T @ np.nan_to_num(chosen)
        run.add(pattern.astype(np.uint8).tobytes(), gram, len(chosen))


def _chosen(runs: dict[str, _RunSum], columns: Columns) -> Grams:
    """Return the sums over the rows in which all sensors have a value, but for sensors that lack too many."""
    s = len(columns.sensors)
    parts = np.zeros((len(runs), s))
    for part, run in zip(parts, runs.values(), strict=True):
        total = max(sum(run.rows.values()), 1)
        part[:] = sum((np.frombuffer(p, np.uint8) * float(n) for p, n in run.rows.items()), np.zeros(s)) / total
    lacking, worst_run = parts.max(axis=0, initial=0.0), [tuple(runs)[k] for k in parts.argmax(axis=0)]
    out = lacking > MOST_MISSING
    matrices, counts, lost = [], [], []
    for run in runs.values():
        sums = [np.zeros((run.size, run.size))]
        count, dropped = 0, run.lost
        for pattern, n in run.rows.items():
            if (np.frombuffer(pattern, np.uint8).astype(bool) & ~out).any():
                dropped += n
                continue
            count += n
            sums.append(run.sums[pattern][0] + run.sums[pattern][1])
        matrix = np.sum(sums, axis=0)
        gone = np.concatenate([np.tile(out, 2 if columns.stroke else 1), [False]])
        matrix[gone], matrix[:, gone] = 0.0, 0.0
        matrices.append(matrix)
        counts.append(count)
        lost.append(dropped)
    left_out = {columns.sensors[k]: float(lacking[k]) for k in np.flatnonzero(out)}
    lacking_in = {columns.sensors[k]: worst_run[k] for k in np.flatnonzero(out)}
    if len(left_out) == s:
        worst = ", ".join(f"{name} {100.0 * part:.0f} % in {lacking_in[name]}" for name, part in left_out.items())
        raise DataError(f"every sensor lacks more than {100.0 * MOST_MISSING:g} % of a run's rows: {worst}")
    empty = [name for name, n in zip(runs, counts, strict=True) if not n]
    if empty:
        raise DataError(
            f"run{'s' if len(empty) > 1 else ''} {', '.join(empty)} hold{'' if len(empty) > 1 else 's'} no row in "
            "which all compared sensors have a value; give another role, or leave the run out of campaign.toml"
        )
    return Grams(columns, tuple(runs), np.array(matrices), np.array(counts), np.array(lost), left_out, lacking_in)


def columns_for(sensors: Sequence[str], leg: LegDimensions | None) -> Columns:
    """Return the columns of a leg, or of a part whose law does not read q where `leg` is None."""
    if leg is None:
        return Columns(tuple(sensors), False)
    return Columns(tuple(sensors), True, 0.5 * (leg.stroke[0] + leg.stroke[1]), leg.retracted_length)
