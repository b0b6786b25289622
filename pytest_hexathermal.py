"""The pytest plugin of hexathermal: the fixture ``assert_pose_accuracy``. Nothing else is loaded until it is used."""

from __future__ import annotations

from typing import Any

import pytest


@pytest.fixture(scope="session")
def assert_pose_accuracy() -> Any:
    """Assert that measured visits of a pose keep limits: assert_pose_accuracy(measured, commanded, AP_um=9, u_um=1)."""
    from hexathermal.pytest_plugin import assert_pose_accuracy as function

    return function
