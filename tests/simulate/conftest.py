"""Fresh entropy for tests of hidden effects, told when one fails; campaigns with nothing hidden, made from it."""

from __future__ import annotations

import secrets

import numpy as np
import pytest

from hexathermal.simulate.hidden import benches
from hexathermal.simulate.hidden.truth import CampaignTruth


@pytest.fixture(scope="module")
def seed() -> int:
    """A seed nobody has tried."""
    return secrets.randbits(32)


@pytest.fixture(autouse=True)
def said(request: pytest.FixtureRequest) -> None:
    """Let every failure of a test that rests on the seed tell it."""
    if "seed" in request.fixturenames:
        print(f"seed {request.getfixturevalue('seed')}")


@pytest.fixture
def generator(seed: int) -> np.random.Generator:
    """What draws parameters."""
    return np.random.default_rng([seed, 99])


@pytest.fixture(scope="module")
def leg(seed: int) -> CampaignTruth:
    """A leg with nothing hidden."""
    return benches.draw("quiet", np.random.default_rng(seed))


@pytest.fixture(scope="module")
def component(seed: int) -> CampaignTruth:
    """A part of a machine tool, whose drift counts from the campaign's first row."""
    k = 0
    while (truth := benches.draw("component", np.random.default_rng([seed, k]))).zero != "campaign":
        k += 1
    return truth
