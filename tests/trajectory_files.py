"""Files of poses and temperatures that many tests write and read."""

from __future__ import annotations

import contextlib
import csv
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from hexathermal.predict.trajectory import POSE_COLUMNS

EXACT_MM = 1e-9
POSES = ",".join(POSE_COLUMNS)
SENSORS = ",".join(f"leg{i}_T1_degC" for i in range(1, 7))
POSE, HEAT = "1,2,3,0.1,0.2,0.3", "20,21,22,23,24,25"
ONE_TEMPS = f"{SENSORS}\n{HEAT}\n"


def left(folder: Path) -> list[str]:
    """Return the files in a folder besides the two that were read."""
    return sorted(file.name for file in folder.iterdir() if file.name not in ("p.csv", "t.csv"))


def text_of(names: str, rows: np.ndarray) -> str:
    return names + "\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows.tolist())


def columns(file: Path, *names: str) -> np.ndarray:
    with file.open(encoding="utf-8", newline="") as lines:
        rows = list(csv.DictReader(lines))
    return np.array([[float(row[name]) for name in names] for row in rows])


def lengths(file: Path) -> np.ndarray:
    return columns(file, *(f"leg{i}_length_mm" for i in range(1, 7)))


def draw(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    six = rng.uniform(-1, 1, (count, 6)) * [40, 40, 40, 4, 4, 4]
    return six, rng.uniform(15, 30, (count, 6))


@contextlib.contextmanager
def fresh_folder() -> Iterator[Path]:
    """Give a folder of its own to each example of a property."""
    with tempfile.TemporaryDirectory() as name:
        yield Path(name)


def correct_arguments(folder: Path) -> list[str]:
    """Write two poses and one row of temperatures; return the arguments of a command that corrects them."""
    (folder / "p.csv").write_text(f"{POSES}\n{POSE}\n{POSE}\n")
    (folder / "t.csv").write_text(ONE_TEMPS)
    paths = {"--poses": "p.csv", "--temps": "t.csv", "--out": "o.csv"}
    return ["correct", "--machine", "reference", *(x for k, v in paths.items() for x in (k, str(folder / v)))]
