"""What reports are made of in tests: a budget's file, the numbers of a CSV."""

from __future__ import annotations

import csv
import io
import re
from pathlib import Path

from hexathermal.cli import main

PAPER = ("paper-figure-4", "paper-figure-6", "paper-figure-7", "paper-figure-8-run-04")


def silent(_done: int, _total: int, _label: str) -> None:
    """Show no progress."""


def budget_json(folder: Path, *more: str) -> Path:
    """Return the file of a budget of the reference machine."""
    file = folder / "budget.json"
    words = ["budget", "--machine", "reference", "--pose", "0", "0", "0", "0", "0", "0", "--temps", "25", *more]
    assert main([*words, "--json", str(file)]) == 0
    return file


def numbers_in(text: str) -> dict[str, list[float]]:
    """Return the columns of a CSV text, cells that hold nothing left out."""
    header, *rows = list(csv.reader(io.StringIO(text)))
    found: dict[str, list[float]] = {}
    for k, name in enumerate(header):
        cells = [row[k] for row in rows if row[k]]
        if name and cells and re.fullmatch(r"-?[\d.]+(e[+-]?\d+)?", cells[0]):
            found[name] = [float(cell) for cell in cells]
    return found
