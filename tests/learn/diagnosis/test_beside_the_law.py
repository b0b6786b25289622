"""What of a fault the drift shows beside the law alone, where no doubt of a thermometer takes part of it."""

from __future__ import annotations

import numpy as np
import pytest

from hexathermal.learn.diagnosis.beside_the_law import BesideTheLaw
from hexathermal.learn.diagnosis.channels import Channel
from hexathermal.learn.diagnosis.spans import visible
from hexathermal.learn.diagnosis.trials import Trial
from hexathermal.poses import FloatArray
from tests.learn.diagnosis.noises import LEVELS, channel_like, noisy

A = 2.0


@pytest.fixture
def drift(rng: np.random.Generator) -> tuple[Channel, FloatArray, Trial]:
    """Noise of the drift, the law's columns for two thermometers, and a fault of the second that grows from the middle.

    It is like the law in part.
    """
    channel = noisy(channel_like(rng, runs=6), LEVELS, rng)
    X = rng.standard_normal((len(channel), 2)).cumsum(axis=0) / 10.0
    late = np.maximum(np.arange(len(channel)) / len(channel) - 0.5, 0.0)[:, None] * 20.0 + 0.3 * X[:, :1]
    return channel, X, Trial("sensor-detached", late, "T02")


@pytest.mark.parametrize("size", [-1.5, 0.4, 1.5])
def test_the_drift_shows_a_fault_as_large_as_it_is(drift: tuple[Channel, FloatArray, Trial], size: float) -> None:
    """Its size over the law's own A within four standard uncertainties; what is visible is what the law leaves of it.

    That is less than the truth by one standard uncertainty on average.
    """
    channel, X, trial = drift
    moved = channel.with_y(channel.y + X @ [1.0, A] + A * size * trial.columns[:, 0])
    law = BesideTheLaw(moved, X, np.full(2, 50.0), ("T01", "T02"))
    own, fault, spread = law.amplitude(trial)
    assert own == pytest.approx(A, abs=0.3)
    assert abs(fault - A * size) < 4.0 * spread
    assert law.error(trial) == pytest.approx(fault / own)
    left = float(visible(trial.columns, X)[0])
    assert law.visible(trial) == pytest.approx((abs(fault) - spread) * left)
    assert abs(law.visible(trial) - (abs(A * size) - spread) * left) < 4.0 * spread * left


def test_no_fault_is_hardly_visible(drift: tuple[Channel, FloatArray, Trial]) -> None:
    """Where there is none, at most three standard uncertainties of it; of a fault that adds no column, nothing."""
    channel, X, trial = drift
    law = BesideTheLaw(channel.with_y(channel.y + X @ [1.0, A]), X, np.full(2, 50.0), ("T01", "T02"))
    _own, _fault, spread = law.amplitude(trial)
    assert law.visible(trial) <= 3.0 * spread * float(visible(trial.columns, X)[0])
    assert law.visible(Trial("swapped-sensors", np.zeros((len(channel), 0)), "T02", base=X)) == 0.0
