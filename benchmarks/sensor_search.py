"""The search for sensors: every single and pair, with runs left out, against one product of the rows and against one
least-squares fit for each model.

``python -m benchmarks.sensor_search`` measures it alone.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from benchmarks.bars import Bar
from benchmarks.measuring import one_processor
from hexathermal.learn.campaign import Block, LegDimensions, RunFile
from hexathermal.learn.gram import Columns, columns_for, gather
from hexathermal.learn.selection import SetFits, fit_sets, sets_of

FloatArray = npt.NDArray[np.float64]

SENSORS = tuple(f"T{k + 1:02d}" for k in range(17))
LEG = LegDimensions(0.6, (0.0, 0.25))
RUNS, ROWS, RAW_ROWS = 8, 1_000_000, 100_000
TURNS = 5
MOST_OF_ONE_READING, LEAST_FASTER, LARGEST_DIFFERENCE = 3.0, 100.0, 1e-9
SEED = 20260101


@dataclass(frozen=True)
class SearchTimes:
    """Best seconds of all turns, on one processor.

    Attributes
    ----------
    search : float
        153 models with every run left out, from the rows.
    product : float
        ``X' X`` of the same columns, held ready in memory.
    search_raw, each, each_left_out : float
        At `RAW_ROWS` rows: the same search; one least-squares fit on the rows for each of the 153 models; and those
        that give the search's own answers, each model with each run left out too.
    difference : float
        Largest difference between their coefficients, over the largest coefficient of the model.
    """

    search: float
    product: float
    search_raw: float
    each: float
    each_left_out: float
    difference: float


def drawn_rows(rows: int) -> list[Block]:
    """Return blocks, one a run, of a leg with smooth temperatures and noise."""
    rng = np.random.default_rng(SEED)
    n = rows // RUNS
    x = np.linspace(0.0, 1.0, len(SENSORS))
    blocks = []
    for r in range(RUNS):
        t = np.linspace(0.0, 1.0, n)
        heat = np.abs(np.cumsum(rng.normal(size=(n, 2)), axis=0)) / np.sqrt(n) * 4.0
        dT = heat @ np.stack([np.exp(-2.0 * x), 0.3 + x]) + 0.02 * rng.normal(size=(n, len(SENSORS)))
        q = 0.125 + 0.12 * np.sin(40.0 * t + r)
        drift = (2e-6 * LEG.retracted_length + 1.1e-6 * q) * dT[:, 6] + 1e-7 * rng.normal(size=n)
        run = RunFile(f"run-{r}", Path(f"run-{r}.csv"), "identification")
        blocks.append(Block(run, t, dT, drift, q, np.zeros(n, np.int64), np.zeros((n, 0)), np.full((n, 3), np.nan)))
    return blocks


def searched(blocks: list[Block], columns: Columns) -> list[SetFits]:
    """Return all singles and pairs, fitted to all runs and with each left out."""
    grams = gather(blocks, columns)
    return [fit_sets(grams, sets_of(grams.kept, size)) for size in (1, 2)]


def _best(job: Callable[[], object], turns: int = TURNS) -> float:
    """Return the shortest time of some turns."""
    taken = []
    for _ in range(turns):
        start = time.perf_counter()
        job()
        taken.append(time.perf_counter() - start)
    return min(taken)


def _designs(blocks: list[Block], columns: Columns) -> tuple[FloatArray, FloatArray]:
    """Return all columns and the drift of all rows."""
    X = np.concatenate([columns.made(block.dT, block.q) for block in blocks])
    return X, np.concatenate([block.drift for block in blocks])


def _fitted_one_by_one(X: FloatArray, y: FloatArray, columns: Columns, fits: list[SetFits]) -> list[list[FloatArray]]:
    """Return the least-squares fit of every model on the rows."""
    return [
        [np.asarray(np.linalg.lstsq(X[:, columns.of(one)], y, rcond=None)[0], np.float64) for one in fit.sets]
        for fit in fits
    ]


def measured_search(rows: int = ROWS, raw_rows: int = RAW_ROWS) -> SearchTimes:
    """Return the times; everything on one processor."""
    columns = columns_for(SENSORS, LEG)
    with one_processor():
        blocks = drawn_rows(rows)
        X, y = _designs(blocks, columns)
        Z = np.column_stack([X, y])
        del X, y
        search, product = np.inf, np.inf
        for _ in range(TURNS):
            product = min(product, _best(lambda: Z.T @ Z, 1))
            search = min(search, _best(lambda: searched(blocks, columns), 1))
        blocks = drawn_rows(raw_rows)
        X, y = _designs(blocks, columns)
        search_raw = _best(lambda: searched(blocks, columns))
        fits = searched(blocks, columns)
        start = time.perf_counter()
        own = _fitted_one_by_one(X, y, columns, fits)
        each = time.perf_counter() - start
        runs = np.repeat(np.arange(RUNS), raw_rows // RUNS)
        start = time.perf_counter()
        for r in range(RUNS):
            _fitted_one_by_one(X[runs != r], y[runs != r], columns, fits)
        all_of_them = each + time.perf_counter() - start
    difference = max(
        float(np.abs(b - fit.coefficients[0, k]).max() / np.abs(b).max())
        for fit, found in zip(fits, own, strict=True)
        for k, b in enumerate(found)
    )
    return SearchTimes(search, product, search_raw, each, all_of_them, difference)


def search_bars(times: SearchTimes) -> list[Bar]:
    """Return the bars on the search."""
    once = f"for each model once: {times.each / times.search_raw:.0f} times"
    return [
        Bar("search of 153 models with runs left out, 1e6 rows: time over that of one X' X",
            times.search / times.product, MOST_OF_ONE_READING, False),
        Bar("search of 153 models with runs left out, 1e5 rows: times faster than least squares on the rows for each "
            f"model and each run left out ({once})",
            times.each_left_out / times.search_raw, LEAST_FASTER, True),
        Bar("search of 153 models, 1e5 rows: largest relative difference to those fits",
            times.difference, LARGEST_DIFFERENCE, False),
    ]  # fmt: skip


if __name__ == "__main__":
    times = measured_search()
    print(times)
    for bar in search_bars(times):
        print(f"{bar.name}: {bar.ratio:.3g} (bar {bar.threshold:g}, {'met' if bar.passed else 'MISSED'})")
