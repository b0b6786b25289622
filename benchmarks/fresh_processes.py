"""What only a fresh process can tell: how long an import takes, and how much memory a batch needs."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from statistics import median

ROOT = Path(__file__).parents[1]
IMPORTS = 15

MEMORY_METHODS = (
    "inverse_kinematics",
    "corrected_leg_lengths",
    "forward_kinematics",
    "jacobian",
    "corrected_pose",
    "predicted_pose",
    "solve_forward",
)

IMPORT = """
import sys, time
start = time.perf_counter()
import {name}
print(time.perf_counter() - start, "numba" in sys.modules or "llvmlite" in sys.modules)
"""


@dataclass(frozen=True)
class ImportTimes:
    """Median and smallest seconds of ``import``, interpreter start not counted, and whether the compiler came along."""

    package: str
    seconds: float
    best_seconds: float
    imports: int
    compiler_loaded: bool


@dataclass(frozen=True)
class Memory:
    """Memory of one batch call.

    `ratio` is inputs plus everything that the call added at its peak (its result included), over inputs plus result.
    """

    method: str
    poses: int
    input_bytes: int
    output_bytes: int
    added_bytes: int

    @property
    def ratio(self) -> float:
        """How many times its input and output a batch needs."""
        return (self.input_bytes + self.added_bytes) / (self.input_bytes + self.output_bytes)


def _output(*arguments: str) -> str:
    """Return what a fresh interpreter prints."""
    done = subprocess.run([sys.executable, *arguments], cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"a measuring process failed: {done.stderr.strip()}")
    return done.stdout


def import_times(packages: tuple[str, ...] = ("hexathermal", "pinocchio"), count: int = IMPORTS) -> list[ImportTimes]:
    """Return import times, the packages taking turns; the first round warms the disk and is not counted."""
    seconds: dict[str, list[float]] = {package: [] for package in packages}
    compiler = dict.fromkeys(packages, False)
    for turn in range(count + 1):
        for package in packages:
            text, loaded = _output("-c", IMPORT.format(name=package)).split()
            compiler[package] |= loaded == "True"
            if turn:
                seconds[package].append(float(text))
    return [
        ImportTimes(package, median(seconds[package]), min(seconds[package]), count, compiler[package])
        for package in packages
    ]


def memory(method: str, poses: int) -> Memory:
    """Return the memory that one batch call needs, measured in a process of its own (Linux only)."""
    numbers = json.loads(_output("-m", "benchmarks.peak_memory", method, str(poses)))
    return Memory(method=method, poses=poses, **numbers)
