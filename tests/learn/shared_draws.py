"""Outcomes of fresh draws that all processes of a run of the tests share out among them."""

from __future__ import annotations

import hashlib
import os
import secrets
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

import pytest

Draw = TypeVar("Draw")

PATIENCE_S = 900.0
"""A process waits so long for a draw that another one has taken."""


def fresh_entropy() -> int:
    """Return a seed nobody has tried; the same in all processes of a run."""
    run = os.environ.get("PYTEST_XDIST_TESTRUNUID")
    return secrets.randbits(48) if run is None else int(hashlib.sha256(run.encode()).hexdigest()[:12], 16)


def shared(factory: pytest.TempPathFactory, name: str, draws: Sequence[Draw], made: Callable[[Draw], str]) -> list[str]:
    """Return a text of each draw: made by the process that takes it first, read by the others."""
    base = factory.getbasetemp()
    place = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / name
    place.mkdir(exist_ok=True)
    for k, draw in enumerate(draws):
        if _taken(place / f"{k}.taken"):
            part = place / f"{k}.part"
            part.write_text(made(draw), encoding="utf-8")
            part.rename(place / f"{k}.json")
    return [_awaited(place / f"{k}.json") for k in range(len(draws))]


def _taken(mark: Path) -> bool:
    """Return whether this process is the first to take a draw."""
    try:
        mark.mkdir()
    except FileExistsError:
        return False
    return True


def _awaited(file: Path) -> str:
    """Return what this or another process writes."""
    end = time.monotonic() + PATIENCE_S
    while not file.exists():
        assert time.monotonic() < end, f"{file} was never written: its process failed"
        time.sleep(0.2)
    return file.read_text(encoding="utf-8")
