"""Hidden effects drawn for this run of the tests, diagnosed from files: one set, which all test processes share out."""

from __future__ import annotations

import hashlib
import json
import os
import secrets
import time
from pathlib import Path

import pytest

from benchmarks.hidden_effects import Outcome, outcome_of, plan

DRAWS = 60
PATIENCE_S = 900.0
"""A process waits so long for a draw that another one has taken."""


@pytest.fixture(scope="session")
def entropy() -> int:
    """A seed nobody has tried; the same in all processes of a run."""
    run = os.environ.get("PYTEST_XDIST_TESTRUNUID")
    return secrets.randbits(48) if run is None else int(hashlib.sha256(run.encode()).hexdigest()[:12], 16)


@pytest.fixture(scope="session")
def outcomes(entropy: int, tmp_path_factory: pytest.TempPathFactory) -> list[Outcome]:
    """What the diagnosis said of fresh draws: causes, strengths, noise and bias drawn, all benches in turn."""
    base = tmp_path_factory.getbasetemp()
    place = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / f"hidden-{entropy}"
    place.mkdir(exist_ok=True)
    draws = plan(DRAWS, entropy)
    for k, draw in enumerate(draws):
        if _taken(place / f"{k}.taken"):
            part = place / f"{k}.part"
            part.write_text(json.dumps(outcome_of(*draw).to_dict()), encoding="utf-8")
            part.rename(place / f"{k}.json")
    return [_awaited(place / f"{k}.json") for k in range(DRAWS)]


def _taken(mark: Path) -> bool:
    """Return whether this process is the first to take a draw."""
    try:
        mark.mkdir()
    except FileExistsError:
        return False
    return True


def _awaited(file: Path) -> Outcome:
    """Return an outcome that this or another process writes."""
    end = time.monotonic() + PATIENCE_S
    while not file.exists():
        assert time.monotonic() < end, f"{file} was never written: its process failed"
        time.sleep(0.2)
    return Outcome(**json.loads(file.read_text(encoding="utf-8")))
