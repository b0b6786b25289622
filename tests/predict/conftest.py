"""Trajectories from file to file."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import hexathermal as ht
from hexathermal.predict.trajectory import TrajectorySummary, correct_trajectory
from tests.trajectory_files import ONE_TEMPS

Run = Callable[..., TrajectorySummary]


@pytest.fixture
def moved(reference: ht.Hexapod) -> ht.Hexapod:
    """The reference machine in a base frame that is turned and lies elsewhere: its home is not the identity."""
    G = ht.pose_from_coordinates([100, -200, 300, 10, 20, 30])
    return dataclasses.replace(reference, base_joints=reference.base_joints @ G[:3, :3].T + G[:3, 3], home=G)


@pytest.fixture
def run(tmp_path: Path, moved: ht.Hexapod) -> Run:
    """Correct texts (or bytes) as files p.csv and t.csv into o.csv."""

    def work(poses: str | bytes, temps: str | bytes = ONE_TEMPS, **options: Any) -> TrajectorySummary:
        for name, text in (("p.csv", poses), ("t.csv", temps)):
            (tmp_path / name).write_bytes(text if isinstance(text, bytes) else text.encode())
        machine = options.pop("machine", moved)
        return correct_trajectory(machine, tmp_path / "p.csv", tmp_path / "t.csv", tmp_path / "o.csv", **options)

    return work
