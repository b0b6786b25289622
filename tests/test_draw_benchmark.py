"""The bar on draws: both sides find the same poses, and the bar says what was measured."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest

from benchmarks.case import drawn_case
from benchmarks.contender import Unavailable
from benchmarks.contenders.cpp_yardstick import CppYardstick, built
from benchmarks.draws import AT_MOST, DrawTimes, draw_bar
from hexathermal.predict.montecarlo import drawn_errors


def test_the_yardstick_finds_the_poses_that_we_find() -> None:
    """Chord Newton in C++ and `drawn_errors` agree to 1e-14 m for draws of 10 um around home."""
    case = drawn_case(8)
    try:
        cpp = CppYardstick(case, built())
    except Unavailable as reason:
        pytest.skip(str(reason))
    hexapod, rng = case.hexapod, np.random.default_rng(1)
    lengths = hexapod.home_lengths + rng.normal(0.0, 1e-5, (64, 6))
    columns, out = np.ascontiguousarray(lengths.T), np.empty((7, 64))
    cpp.library.draws_columns(
        cpp.machine, ctypes.c_long(64), *(array.ctypes.data_as(ctypes.c_void_p) for array in (columns, out))
    )
    errors = drawn_errors(hexapod, hexapod.home, lengths)
    assert np.abs(out[:3].T - hexapod.home[:3, 3] - errors[:, :3]).max() < 1e-14
    assert np.abs(2.0 * out[3:6].T - errors[:, 3:]).max() < 1e-13


@pytest.mark.parametrize(("ours", "yardstick", "passed"), [(0.3, 0.1, True), (0.31, 0.1, False), (0.3, None, None)])
def test_the_bar_is_three_times(ours: float, yardstick: float | None, passed: bool | None) -> None:
    """The bar is met up to three times the yardstick's time, and not measured without a yardstick."""
    bar = draw_bar(DrawTimes(1_000_000, ours, yardstick, 2.0, 1e-16, "no compiler"))
    assert bar.threshold == AT_MOST
    assert bar.passed is passed
