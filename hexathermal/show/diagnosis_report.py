"""The report of a diagnosis: a folder with one page, its pictures, and the numbers."""

from __future__ import annotations
from pathlib import Path
from typing import Any
from hexathermal.show.commands import Progress
from hexathermal.learn.diagnosis.result import Diagnosis


def write_report(found: Diagnosis, facts: dict[str, Any], folder: Path, progress: Progress) -> list[Path]:
    """Write the report."""
    return []
