"""The machines of the mechanism's tests."""

from __future__ import annotations

import pytest

from hexathermal.machine.pinocchio_model import PinocchioMachine
from tests.machine.mechanisms import (
    MACHINES,
    plain,
)


@pytest.fixture(params=MACHINES, scope="module")
def machine(request: pytest.FixtureRequest) -> PinocchioMachine:
    return PinocchioMachine(MACHINES[request.param]())


@pytest.fixture(scope="module")
def plain_machine() -> PinocchioMachine:
    return PinocchioMachine(plain(), payload_mass=25.0, payload_centre=[0.05, -0.02, 0.15])
