"""Draws around one pose: what the error budget's Monte Carlo asks of the kinematics, against chord Newton in C++.

Both sides find the pose of a million sets of leg lengths near home's, one core each, in one run.  Ours is the public
`drawn_errors`: rows in, errors of a point in a frame out, every draw checked; the yardstick works on columns and checks
nothing.  Drawing the numbers is in neither; what a whole Monte Carlo costs is measured beside it.
"""

from __future__ import annotations

import ctypes
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from benchmarks.bars import Bar
from benchmarks.case import Case
from benchmarks.contender import Unavailable
from benchmarks.contenders.cpp_yardstick import CppYardstick, built
from benchmarks.measuring import one_processor
from hexathermal.predict.budget_defaults import default_sources
from hexathermal.predict.budget_inputs import situation
from hexathermal.predict.montecarlo import drawn_errors
from hexathermal.predict.montecarlo_draws import Drawn

SPREAD_M = 1e-5
TURNS = 7
AT_MOST = 3.0


@dataclass(frozen=True)
class DrawTimes:
    """Seconds of processor time for `draws` draws, best of several turns, and the largest length error [m].

    `whole` is a Monte Carlo with the default sources: drawing, laws, plates, joints of its own for every draw.
    """

    draws: int
    ours: float
    yardstick: float | None
    whole: float
    largest_error: float
    reason: str = ""


def _best(calls: list[Callable[[], object]]) -> list[float]:
    """Return the best time of each call; they take turns."""
    taken: list[list[float]] = [[] for _ in calls]
    for call in calls:
        call()
    for _ in range(TURNS):
        for k, call in enumerate(calls):
            start = time.process_time()
            call()
            taken[k].append(time.process_time() - start)
    return [min(times) for times in taken]


def draw_times(case: Case, draws: int) -> DrawTimes:
    """Return what draws cost on both sides."""
    hexapod, rng = case.hexapod, np.random.default_rng(5)
    count = draws // 8 * 8
    lengths = hexapod.home_lengths + rng.normal(0.0, SPREAD_M, (count, 6))
    columns, out = np.ascontiguousarray(lengths.T), np.empty((7, count))
    calls: list[Callable[[], object]] = [lambda: drawn_errors(hexapod, hexapod.home, lengths)]
    reason = ""
    try:
        cpp = CppYardstick(case, built())

        def address(array: npt.NDArray[np.float64]) -> ctypes.c_void_p:
            return array.ctypes.data_as(ctypes.c_void_p)

        calls.append(
            lambda: cpp.library.draws_columns(cpp.machine, ctypes.c_long(count), address(columns), address(out))
        )
    except Unavailable as error:
        reason = str(error)
    here = situation(hexapod, hexapod.home, np.full(6, 25.0))
    drawn = Drawn(here, default_sources(hexapod))
    with one_processor():
        times = _best(calls)
        start = time.process_time()
        drawn(draws // 10, rng)
        whole = 10.0 * (time.process_time() - start)
    errors = drawn_errors(hexapod, hexapod.home, lengths[:1000])
    moved = np.repeat(hexapod.home[None], 1000, axis=0)
    from scipy.spatial.transform import Rotation

    moved[:, :3, 3] += errors[:, :3]
    moved[:, :3, :3] = Rotation.from_rotvec(errors[:, 3:]).as_matrix() @ hexapod.home[:3, :3]
    worst = float(np.abs(hexapod.inverse_kinematics(moved) - lengths[:1000]).max())
    return DrawTimes(count, times[0], times[1] if len(times) > 1 else None, whole, worst, reason)


def draw_bar(times: DrawTimes) -> Bar:
    """Return the bar on draws through exact kinematics."""
    ratio = None if times.yardstick is None else times.ours / times.yardstick
    count = f"{times.draws:.0e}".replace("e+0", "e")
    return Bar(f"{count} draws around a pose: time over that of chord Newton in C++", ratio, AT_MOST, False,
               reason=times.reason)  # fmt: skip
