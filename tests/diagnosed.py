"""The command ``diagnose``, run once with every option that writes."""

from __future__ import annotations

import contextlib
import io
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hexathermal.cli import main


@dataclass(frozen=True)
class Ran:
    """Where campaign and files of a run of the command are, and what it said."""

    campaign: Path
    files: Path
    out: str
    err: str
    facts: dict[str, Any]


def diagnosed(campaign: Path, place: Path, extended: str, *more: str) -> Ran:
    """Run the command on a campaign; its report, extension (by name) and JSON come into a folder."""
    words = ["diagnose", str(campaign), *more]
    for option, name in (("--report", "report"), ("--extend", extended), ("--json", "a.json")):
        words += [option, str(place / name)]
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        assert main(words) == 0
    return Ran(campaign, place, out.getvalue(), err.getvalue(), json.loads((place / "a.json").read_text()))
