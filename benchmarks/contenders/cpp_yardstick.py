"""The C++ yardstick: the same equations on vectors of 8, 4 or 2 doubles, compiled here for this processor.

It checks nothing and refuses nothing: what is left when everything but the arithmetic and the memory is taken away.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import shutil
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.case import Case, FloatArray, Quantity, poses_of
from benchmarks.contender import Job, Unavailable, first

FOLDER = Path(__file__).parents[1]
SOURCES = FOLDER / "yardstick"
FLAGS = (
    "-std=c++17", "-O3", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=fast", "-shared", "-fPIC",
)  # fmt: skip
NATIVE = "-march=native"

SAME_JOB = "same job"
WARM = "same job, result reused"
COLUMNS = "limit: columns, result reused"
LOOP = "loop inside C++"


def built(architecture: str = NATIVE) -> Path:
    """Return the compiled library, made again when its sources, its flags or the processor have changed."""
    compiler = shutil.which("g++")
    if compiler is None:
        raise Unavailable("g++ is not installed: the C++ yardstick cannot be compiled")
    target = subprocess.run(
        [compiler, architecture, "-Q", "--help=target"], capture_output=True, text=True, check=False
    ).stdout
    text = "".join(path.read_text() for path in sorted(SOURCES.glob("*.?pp")))
    digest = hashlib.sha256((text + target + " ".join(FLAGS)).encode()).hexdigest()[:16]
    library = FOLDER / "build" / f"yardstick-{digest}.so"
    if not library.exists():
        library.parent.mkdir(exist_ok=True)
        unfinished = library.with_suffix(f".{os.getpid()}")
        command = [compiler, *FLAGS, architecture, str(SOURCES / "batches.cpp"), "-o", str(unfinished)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise Unavailable(f"g++ could not compile the C++ yardstick: {done.stderr.strip().splitlines()[-1:]}")
        unfinished.replace(library)
    return library


def _address(array: FloatArray) -> ctypes.c_void_p:
    if not array.flags.c_contiguous or array.dtype != np.float64:
        raise ValueError("the yardstick reads contiguous doubles only")
    return array.ctypes.data_as(ctypes.c_void_p)


class CppYardstick:
    """The compiled yardstick for one machine."""

    def __init__(self, case: Case, library: Path) -> None:
        self.library = ctypes.CDLL(str(library))
        self.library.machine_made.restype = ctypes.c_void_p
        hexapod = case.hexapod
        numbers = (hexapod.platform_joints, hexapod.base_joints, hexapod.home, case.law)
        self.machine = ctypes.c_void_p(self.library.machine_made(*map(_address, numbers)))
        if not self.machine:
            raise Unavailable(f"home of {hexapod.name!r} is singular: the yardstick starts there")
        self.name = "C++ yardstick"
        self.note = f"vectors of {self.library.lanes()} doubles, one thread, no checks of any kind"

    def __del__(self) -> None:
        if getattr(self, "machine", None):
            self.library.machine_freed(self.machine)

    def jobs(self, case: Case) -> list[Job]:
        """Return jobs on the public methods' own arrays, with new and with reused results, and on columns."""
        arrays: dict[Quantity, tuple[str, tuple[FloatArray, ...], tuple[int, ...]]] = {
            Quantity.LENGTHS: ("lengths", (case.poses,), (6,)),
            Quantity.CORRECTED: ("corrected", (case.poses, case.temps), (6,)),
            Quantity.POSES: ("forward", (case.lengths,), (4, 4)),
            Quantity.JACOBIANS: ("jacobian", (case.poses,), (6, 6)),
        }
        jobs = []
        for quantity, (name, given, shape) in arrays.items():
            few = tuple(array[:1000] for array in given)
            one = self._reusing(f"{name}_single", few, (len(few[0]), *shape))
            jobs.append(Job(quantity, False, one, [()], len(few[0]), first, LOOP))
            whole = (len(case), *shape)
            jobs.append(
                Job(quantity, True, self._allocating(f"{name}_rows", given, whole), [()], len(case), first, SAME_JOB)
            )
            jobs.append(Job(quantity, True, self._reusing(f"{name}_rows", given, whole), [()], len(case), first, WARM))
        return jobs + self._columns(case)

    def _columns(self, case: Case) -> list[Job]:
        """Return the jobs on one array a coordinate."""
        count = len(case) // 8 * 8
        motions, lengths = np.ascontiguousarray(case.motions[:count].T), np.ascontiguousarray(case.lengths[:count].T)
        ik = self._reusing("lengths_columns", (motions,), (6, count), count)
        fk = self._reusing("forward_columns", (lengths,), (7, count), count)
        return [
            Job(Quantity.LENGTHS, True, ik, [()], count, _lengths_read, COLUMNS),
            Job(Quantity.POSES, True, fk, [()], count, _motions_read, COLUMNS),
        ]

    def _allocating(self, name: str, given: tuple[FloatArray, ...], shape: tuple[int, ...]) -> Callable[[], FloatArray]:
        """Return a call that makes its result anew, as a public method must."""
        function, count = getattr(self.library, name), ctypes.c_long(shape[0])

        def call() -> FloatArray:
            out = np.empty(shape)
            function(self.machine, count, *map(_address, given), _address(out))
            return out

        return call

    def _reusing(
        self, name: str, given: tuple[FloatArray, ...], shape: tuple[int, ...], count: int | None = None
    ) -> Callable[[], FloatArray]:
        """Return a call that writes into one and the same result."""
        function, out = getattr(self.library, name), np.empty(shape)
        many = ctypes.c_long(shape[0] if count is None else count)
        addresses = [*map(_address, given), _address(out)]

        def call() -> FloatArray:
            function(self.machine, many, *addresses)
            return out

        return call


def _lengths_read(results: Sequence[Any]) -> FloatArray:
    """Return columns of lengths as rows."""
    return np.ascontiguousarray(results[0].T)


def _motions_read(results: Sequence[Any]) -> FloatArray:
    """Return columns of motions as poses."""
    return poses_of(results[0].T)


def enter(case: Case) -> CppYardstick:
    """Return the contender, compiled for this processor."""
    return CppYardstick(case, built())
