"""What readings of thermometers tell of their own noise, of their zeros, and of exchanged plugs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hexathermal.learn.machine_diagnosis.case import case_of
from hexathermal.learn.machine_diagnosis.causes.swapped_legs import candidates
from hexathermal.learn.machine_diagnosis.course import searched
from hexathermal.learn.machine_diagnosis.law_columns import zero_errors
from hexathermal.learn.machine_diagnosis.readings import flickering
from hexathermal.learn.machine_diagnosis.settled import share_of
from hexathermal.learn.machine_diagnosis.view import machine_view
from tests.learn.machine_diagnosis.machines import Fault, drawn


def test_noise_of_readings_is_told_over_slow_and_over_fast_heat() -> None:
    """White noise of 0.02 K is told within 15 %, over a slow course by much of it, over a fast one by little."""
    rng = np.random.default_rng(3)
    t, run = np.arange(400) * 20.0, np.zeros(400, dtype=np.int64)
    course = np.column_stack([5.0 * np.sin(t / 3000.0), 5.0 * np.sin(t / 300.0)])
    seen = flickering(t, run, course + 0.02 * rng.standard_normal((400, 2)))
    np.testing.assert_allclose(seen.noise, 0.02, rtol=0.15)
    assert seen.own[200, 0] < seen.own[200, 1]
    assert not flickering(t[:8], run[:8], course[:8]).noise.any()


def test_the_error_of_a_zero_is_known_by_its_own_reading() -> None:
    """Of what temperatures are off, since the reading that they count from was, half of the variance is known."""
    rows, rng = drawn(14, runs=6, poses=60), np.random.default_rng(8)
    noise = 0.02 * rng.standard_normal(rows.dT.shape)
    read = np.tile(np.sin(np.arange(60) / 20.0), 6)[:, None, None] + noise
    first = np.repeat(np.arange(6) * 60, 60)
    view = case_of(replace(rows, dT=read - read[first])).view
    true = noise[first]
    assert (zero_errors(view, view.readings.flicker) - true).std() < 0.7 * true.std()


@pytest.mark.long
@pytest.mark.parametrize("swapped", [(0, 1), None])
def test_nearly_equal_legs_are_exchanged_where_what_is_left_says_so(swapped: tuple[int, int] | None) -> None:
    """Two legs three times a reading's noise apart are named exchanged where they are, with a share of 1 within three
    standard deviations; where they are not, nothing is named.
    """
    adopted = searched(case_of(drawn(16, Fault(swapped=swapped), runs=4, poses=120, apart=0.3, misread=0.1))).adopted
    assert [one.candidate.called for one in adopted] == ([] if swapped is None else ["swapped-legs of leg1+leg2"])
    for one in adopted:
        assert 0.3 < one.candidate.trust < 1.0
        share, variance = share_of(one)
        assert abs(share[0] - 1.0) < 3.0 * np.sqrt(variance[0, 0])


def test_equally_warm_legs_have_no_exchange() -> None:
    """Legs that differ by their readings' noise alone leave an exchange little to be told by."""
    near, far = (
        [one.trust for one in candidates(machine_view(drawn(17, runs=2, poses=80, apart=apart, misread=0.1)))]
        for apart in (0.0, 1.0)
    )
    assert np.mean(near) < 0.3
    assert far[0] > 0.95
