"""Hidden effects drawn for this run of the tests, diagnosed from files: one set, which all test processes share out."""

from __future__ import annotations

import json

import pytest

from benchmarks.hidden_effects import TESTED, Outcome, outcome_of, plan
from tests.learn.shared_draws import fresh_entropy, shared

DRAWS = 52


@pytest.fixture(scope="session")
def entropy() -> int:
    """A seed nobody has tried; the same in all processes of a run."""
    return fresh_entropy()


@pytest.fixture(scope="session")
def outcomes(entropy: int, tmp_path_factory: pytest.TempPathFactory) -> list[Outcome]:
    """What the diagnosis said of fresh draws: causes, strengths, noise and bias drawn, three benches in turn."""
    texts = shared(tmp_path_factory, f"hidden-{entropy}", plan(DRAWS, entropy, TESTED),
                   lambda draw: json.dumps(outcome_of(*draw).to_dict()))  # fmt: skip
    return [Outcome(**json.loads(text)) for text in texts]
