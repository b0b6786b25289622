"""Creep from the beginning of a run on: what was clamped or loaded for it gives way, whatever moves."""

from __future__ import annotations

import numpy as np
import pytest

from hexathermal.machine.leg_signals import LegSignals, Memory
from hexathermal.machine.leg_terms import term_columns

TIME = np.arange(0.0, 4.0 * 3600.0 + 1.0, 20.0)


def column(time: np.ndarray, memory: Memory | None = None, **settings: object) -> np.ndarray:
    """The term's column, of a rod that moves to and fro."""
    own = {"kick": "begin", "time_constant_s": 600.0, **settings}
    return term_columns("relaxation", LegSignals(time, {}, 0.1 + 0.05 * np.sin(time / 90.0)), own, memory)[:, 0]


def test_it_decays_from_the_first_row() -> None:
    """``exp(-t / tau) - 1`` of the time since the run's first row, wherever its clock stands."""
    assert column(TIME) == pytest.approx(np.exp(-TIME / 600.0) - 1.0)
    assert column(TIME + 5e4) == pytest.approx(column(TIME))


def test_over_decades_it_goes_with_the_logarithm_of_time() -> None:
    """Over three decades it is straight against log time within 2 % of its height, an exponential is not."""
    late = TIME > 120.0

    def off(values: np.ndarray) -> float:
        """What a straight line against log time leaves, over the whole height."""
        x = np.log(TIME[late])
        left = values[late] - np.polyval(np.polyfit(x, values[late], 1), x)
        return float(np.abs(left).max() / np.ptp(values))

    assert off(column(TIME, time_constant_s=30.0, decades=3.0)) < 0.02
    assert off(column(TIME)) > 0.1


def test_rows_that_come_one_by_one_are_a_run() -> None:
    """A controller that remembers the beginning goes on as a whole run does."""
    memory = Memory()
    parts = [column(rows, memory, decades=1.5) for rows in np.array_split(TIME, 7)]
    assert np.concatenate(parts) == pytest.approx(column(TIME, decades=1.5))
