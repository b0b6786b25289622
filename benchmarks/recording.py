"""Draws of a benchmark, each a line of a file: a run that was stopped goes on where it stood, with the same seed."""

from __future__ import annotations

import json
import os
import secrets
from collections.abc import Callable, Iterator, Sequence
from multiprocessing import get_context
from pathlib import Path
from typing import Any, TypeVar

from rich.console import Console
from rich.progress import track

Job = TypeVar("Job")
Found = TypeVar("Found")


def recorded(file: Path) -> tuple[int | None, list[dict[str, Any]]]:
    """Return the seed of a records' file and its lines; a last line that was cut off is left out."""
    seed, found = None, []
    for line in file.read_text(encoding="utf-8").splitlines() if file.exists() else ():
        try:
            data = json.loads(line)
        except ValueError:
            continue
        if "seed_of_all" in data:
            seed = int(data["seed_of_all"])
        else:
            found.append(data)
    return seed, found


def opened(file: Path, asked: int | None, console: Console) -> tuple[int, list[dict[str, Any]]] | None:
    """Return the seed of all draws and what is recorded already; None, and a word, where another seed is asked for."""
    file.parent.mkdir(parents=True, exist_ok=True)
    known, found = recorded(file)
    seed = next(one for one in (asked, known, secrets.randbits(32)) if one is not None)
    if known is not None and seed != known:
        console.print(f"{file} holds draws of seed {known}: name another file, or take it away")
        return None
    if known is None:
        file.write_text(json.dumps({"seed_of_all": seed}) + "\n", encoding="utf-8")
    return seed, found


def judged(
    judge: Callable[[Job], Found], jobs: Sequence[Job], line: Callable[[Found], dict[str, Any]], processes: int,
    file: Path, console: Console,
) -> Iterator[Found]:  # fmt: skip
    """Judge jobs in processes of their own, writing each as it comes."""
    os.environ["OMP_NUM_THREADS"] = "1"
    with get_context("spawn").Pool(processes) as pool, file.open("a", encoding="utf-8") as log:
        for found in track(pool.imap_unordered(judge, jobs), "draws", len(jobs), console=console):
            log.write(json.dumps(line(found)) + "\n")
            log.flush()
            yield found
