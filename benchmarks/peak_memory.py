"""Peak memory of one batch call, for a process of its own: ``python -m benchmarks.peak_memory METHOD POSES``.

Linux resets its high-water mark of resident memory on request (``/proc/self/clear_refs``), so that imports, compiled
loops and the making of the inputs do not count.
"""

from __future__ import annotations

import dataclasses
import gc
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.case import FloatArray, drawn_case

SEED_POSES = 500


def _status_bytes(key: str) -> int:
    """Return one entry of this process's status."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(key + ":"):
            return int(line.split()[1]) * 1024
    raise KeyError(key)


def _size(result: Any) -> int:
    """Return the bytes of an answer: an array, or a result made of arrays."""
    if isinstance(result, np.ndarray):
        return result.nbytes
    return sum(_size(getattr(result, field.name)) for field in dataclasses.fields(result))


def _inputs(method: str, poses: int) -> tuple[Any, list[FloatArray]]:
    """Return the bound method and its arrays."""
    case = drawn_case(SEED_POSES)
    times = -(-poses // SEED_POSES)
    given = {
        "inverse_kinematics": (case.poses,),
        "jacobian": (case.poses,),
        "forward_kinematics": (case.lengths,),
        "solve_forward": (case.lengths,),
        "corrected_leg_lengths": (case.poses, case.temps),
        "corrected_pose": (case.poses, case.temps),
        "predicted_pose": (case.lengths, case.temps),
    }[method]
    repeated = [np.tile(array, (times, *[1] * (array.ndim - 1)))[:poses] for array in given]
    return getattr(case.hexapod, method), repeated


def main(method: str, poses: int) -> None:
    """Print the bytes of inputs and result, and those that the call added to resident memory at its peak."""
    function, given = _inputs(method, poses)
    function(*(array[:100] for array in given))
    gc.collect()
    Path("/proc/self/clear_refs").write_text("5")
    before = _status_bytes("VmRSS")
    result = function(*given)
    added = _status_bytes("VmHWM") - before
    sizes = {"input_bytes": sum(array.nbytes for array in given), "output_bytes": _size(result), "added_bytes": added}
    print(json.dumps(sizes))


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
