"""The rate of a thermometer as motion explains it: what it shows late, and the speed of rows."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hexathermal.machine.leg_signals import Memory
from hexathermal.machine.leg_terms import term_columns
from tests.learn.extended_laws import drawn_signals


@given(seed=st.integers(0, 10**6))
def test_a_rate_as_motion_explains_it_undoes_a_late_thermometer(seed: int) -> None:
    """A reading that is heat of motion behind a low pass, and noise that motion knows nothing of."""
    signals = drawn_signals(seed, 400)
    memory, tau = Memory(), 700.0
    part = 300.0 * memory.low_pass("part", signals.time, memory.speed(signals.time, signals.q), tau, held=True)
    reading = memory.low_pass("reading", signals.time, part, tau)
    late = dataclasses.replace(signals, dT={**signals.dT, "T01": reading})
    own = {"sensor": "T01", "ratio": 0.4, "time_constant_s": tau, "heat_times_s": [tau], "once": [0.0],
           "twice": [300.0]}  # fmt: skip
    lacks = term_columns("lead-by-motion", late, own)[:, 0]
    np.testing.assert_allclose(lacks, (0.6 + 0.4 * signals.q) * (part - reading), atol=1e-12)
    # with another time constant as much more of it: a rate has none
    twice = term_columns("lead-by-motion", late, {**own, "time_constant_s": 2.0 * tau})[:, 0]
    np.testing.assert_allclose(twice, 2.0 * lacks, atol=1e-12)


def test_what_motion_does_not_explain_has_its_own_rate() -> None:
    """A reading that rises evenly lacks ``tau`` times its slope, once the low passes of its rate have come to it."""
    signals = dataclasses.replace(drawn_signals(4, 400), time=np.arange(0.0, 8000.0, 20.0))
    ramp = dataclasses.replace(signals, dT={**signals.dT, "T01": 2e-4 * signals.time})
    own = {"sensor": "T01", "ratio": 0.4, "time_constant_s": 500.0, "heat_times_s": [300.0], "once": [0.0],
           "twice": [0.0]}  # fmt: skip
    lacks = term_columns("lead-by-motion", ramp, own)[:, 0]
    assert lacks[-1] == pytest.approx((0.6 + 0.4 * signals.q[-1]) * 500.0 * 2e-4, rel=1e-4)
    assert lacks[0] == 0.0


def test_rows_at_one_time_are_as_fast_as_the_first_of_them() -> None:
    """A row asked for twice, in a block or by itself, has one speed: what depends on it does not jump."""
    time, q = np.array([0.0, 10.0, 10.0, 20.0, 20.0]), np.array([0.0, 0.01, 0.01, 0.03, 0.03])
    whole = Memory().speed(time, q)
    np.testing.assert_allclose(whole, [0.0, 1e-3, 1e-3, 2e-3, 2e-3])
    memory = Memory()
    np.testing.assert_array_equal(np.concatenate([memory.speed(time[k:][:1], q[k:][:1]) for k in range(5)]), whole)
