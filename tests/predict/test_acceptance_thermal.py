"""ISO 230-3: ranges in windows against brute force, irregular samples, gaps, and warm-up distortion."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hexathermal.errors import ArgumentError
from hexathermal.predict.acceptance import environmental_variation, warm_up_distortion
from hexathermal.predict.acceptance.environmental_variation import allowed_gap

STEPS = st.lists(st.integers(1, 50), min_size=1, max_size=40)


@given(STEPS, st.integers(0, 1000), st.integers(1, 400))
def test_every_window_is_looked_at(steps: list[int], seed: int, window: int) -> None:
    """With samples at any intervals, the value is the largest range over all closed windows, by brute force."""
    times = np.cumsum([0.0, *steps])
    x = np.random.default_rng(seed).normal(size=len(times))
    length = min(float(window), times[-1])
    found = environmental_variation(times, x, length, {"room": x})
    spans = [
        np.ptp(x[k : last + 1]) for k in range(len(x)) for last in range(k, len(x)) if times[last] - times[k] <= length
    ]
    assert found.value == pytest.approx(max(spans), abs=0.0)
    assert found.temperature_ranges == {"room": found.value}
    assert found.end - found.start <= length
    assert found.longest_gap == max(steps)


@given(STEPS, st.integers(0, 1000))
def test_longer_windows_hold_no_less(steps: list[int], seed: int) -> None:
    """The value grows with the window, up to the range of the whole record, which is the default."""
    times = np.cumsum([0.0, *steps])
    x = np.random.default_rng(seed).normal(size=len(times))
    values = [environmental_variation(times, x, part * times[-1]).value for part in (0.1, 0.4, 0.7, 1.0)]
    assert values == sorted(values)
    assert environmental_variation(times, x).value == values[-1] == np.ptp(x)


def test_a_sine_in_a_window_of_known_length() -> None:
    """sin(2 pi t / 24 h) in a window of 1 h ranges over 2 sin(pi / 24), about its steepest point."""
    hours = np.linspace(0.0, 24.0, 24 * 60 + 1)
    found = environmental_variation(hours * 3600.0, np.sin(2.0 * np.pi * hours / 24.0), 3600.0)
    assert found.value == pytest.approx(2.0 * np.sin(np.pi / 24.0), rel=1e-4)


def test_samples_at_the_ends_of_a_window_belong_to_it() -> None:
    """Windows are closed, also where the sum of times is not exact: 0.1, 0.2, 0.3 with a window of 0.1 and of 0.2."""
    times = np.array([0.1, 0.2, 0.3])
    assert environmental_variation(times, [0.0, 1.0, 3.0], 0.1).value == 2.0
    assert environmental_variation(times, [0.0, 1.0, 3.0], 0.2).value == 3.0
    late = 1e5 + times
    assert environmental_variation(late, [0.0, 1.0, 3.0], 0.1).value == 2.0


def test_temperatures_are_those_of_the_worst_window() -> None:
    """The range of temperature is told for the window of the value, not for the record."""
    found = environmental_variation(np.arange(6.0), [0, 0, 0, 0, 4, 4], 1.0, {"room": [0, 50, 0, 1, 3, 9]})
    assert (found.start, found.end) == (3.0, 4.0)
    assert found.temperature_ranges == {"room": 2.0}


@pytest.mark.parametrize(
    ("times", "values", "window", "words"),
    [
        ([0.0], [1.0], None, "two or more are needed"),
        ([0.0, 1.0], [1.0], None, "values has shape"),
        ([0.0, 1.0, 1.0], [1.0, 2.0, 3.0], None, "does not increase at index 2"),
        ([0.0, 1.0], [1.0, 2.0], 2.0, "longer than the record"),
        ([0.0, 1.0], [1.0, 2.0], 0.0, "expected above 0"),
        ([0.0, 1.0], [1.0, np.nan], None, "finite"),
    ],
)
def test_records_that_answer_nothing_are_refused(
    times: list[float], values: list[float], window: float | None, words: str
) -> None:
    """Too few samples, times that stand still and windows longer than the record are errors."""
    with pytest.raises(ArgumentError, match=words):
        environmental_variation(times, values, window)


def test_warm_up_of_a_first_order_machine() -> None:
    """x = 1 - exp(-t / 1 h): d_60 = 1 - 1/e between samples, d_t = 1 - e^-4, no matter when the clock started."""
    times = np.linspace(0.0, 4 * 3600.0, 1001) + 500.0
    x = 7.0 + 1.0 - np.exp(-(times - 500.0) / 3600.0)
    found = warm_up_distortion(times, x)
    assert found.d_60 == pytest.approx(1.0 - np.exp(-1.0), rel=1e-5)
    assert found.d_t == pytest.approx(1.0 - np.exp(-4.0), rel=1e-12)
    assert found.end == 4 * 3600.0


def test_cooling_is_left_out_where_the_end_of_warming_is_given() -> None:
    """Up by 4, then down: with the end of warming d_t = 4; ranges tell what changes do not."""
    times, x = [0.0, 1800.0, 7200.0, 9000.0], [0.0, -1.0, 4.0, 0.0]
    found = warm_up_distortion(times, x, end=7200.0)
    assert (found.d_t, found.range_t) == (4.0, 5.0)
    assert (found.d_60, found.range_60) == (pytest.approx(2.0 / 3.0), pytest.approx(5.0 / 3.0))
    assert warm_up_distortion(times, x).d_t == 0.0


@pytest.mark.parametrize(("end", "words"), [(1800.0, "at least 3600"), (9000.0, "the record after 7200"), (None, "")])
def test_warm_up_needs_an_hour(end: float | None, words: str) -> None:
    """An end before 60 minutes or behind the record is refused."""
    if not words:
        with pytest.raises(ArgumentError, match="at least 3600"):
            warm_up_distortion([0.0, 3599.0], [0.0, 1.0])
        return
    with pytest.raises(ArgumentError, match=words):
        warm_up_distortion([0.0, 7200.0], [0.0, 1.0], end)


def test_a_hole_in_the_record_is_longer_than_allowed() -> None:
    """One sample in 10 s for a day, with a hole of 20 minutes: more than 5 % of an hour; without it, not."""
    whole = np.arange(0.0, 86_400.0, 10.0)
    holed = whole[(whole < 40_000.0) | (whole > 41_200.0)]
    for times, decided in ((whole, True), (holed, False)):
        found = environmental_variation(times, np.zeros(len(times)), 3600.0)
        assert (found.longest_gap <= allowed_gap(times, 3600.0)) is decided
    assert allowed_gap(np.arange(0.0, 36_000.0, 600.0), 3600.0) == 1800.0
