"""Hidden effects drawn for this run of the tests, diagnosed from files: one set for all tests."""

from __future__ import annotations

import secrets

import pytest

from benchmarks.hidden_effects import Outcome, outcome_of, plan

DRAWS = 60


@pytest.fixture(scope="session")
def entropy() -> int:
    """A seed nobody has tried."""
    return secrets.randbits(48)


@pytest.fixture(scope="session")
def outcomes(entropy: int) -> list[Outcome]:
    """What the diagnosis said of fresh draws: causes, strengths, noise and bias drawn, all benches in turn."""
    return [outcome_of(bench, seed) for bench, seed in plan(DRAWS, entropy)]
