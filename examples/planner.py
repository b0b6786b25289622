"""A planner at 1 kHz: corrected leg lengths while the machine warms up, and by a law that remembers."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

import hexathermal as ht

CYCLE_S = 1e-3
BLOCK = 100
"""Cycles that are planned ahead in one call where the law remembers."""


def timed(work: Callable[[slice], object], count: int, cycles: int) -> None:
    """Print what a call takes, `cycles` cycles in each, against the time that they leave."""
    taken = np.empty(count // cycles)
    for k in range(len(taken)):
        begin = time.perf_counter()
        work(slice(k * cycles, (k + 1) * cycles))
        taken[k] = time.perf_counter() - begin
    allowed = cycles * CYCLE_S
    median, most, almost = np.percentile(taken[1:], [50.0, 99.0, 99.9]) * 1e6  # the first call prepares
    print(f"  {len(taken)} calls of {cycles} cycle(s): median {median:.1f} us, 99 % below {most:.1f}, 99.9 % below "
          f"{almost:.1f}; allowed {allowed * 1e6:.0f} us")  # fmt: skip
    print(f"  {100.0 * (taken[1:] < allowed).mean():.2f} % in time, {median / (allowed * 1e4):.2f} % of the time used")


def main() -> None:
    """Correct a trajectory at 1 kHz in one call, cycle by cycle, and by a law with a thermal lag."""
    hexapod = ht.load_hexapod("reference")
    seconds = np.arange(0.0, 60.0, CYCLE_S)
    coordinates = np.zeros((len(seconds), 6))  # mm, deg, relative to home
    coordinates[:, 0] = 40.0 * np.sin(0.5 * seconds)
    coordinates[:, 2] = 20.0 * np.cos(0.3 * seconds)
    coordinates[:, 4] = 2.0 * np.sin(0.7 * seconds)
    poses = ht.pose_from_coordinates(coordinates, hexapod=hexapod)
    temps = 21.0 + np.linspace(0.0, 0.2, len(seconds))[:, None] + 0.1 * np.arange(6)

    hexapod.corrected_leg_lengths(poses[0], temps[0])  # compiled code is loaded, or made (once)
    begin = time.perf_counter()
    lengths = hexapod.corrected_leg_lengths(poses, temps)
    per_pose = (time.perf_counter() - begin) / len(seconds) * 1e6
    correction = (lengths - hexapod.inverse_kinematics(poses)) * 1e6
    print(f"{len(seconds)} poses in one call, {per_pose:.2f} us each; corrections from {correction.min():.2f} to "
          f"{correction.max():.2f} um")  # fmt: skip

    print("cycle by cycle, as a controller asks:")
    timed(lambda now: hexapod.corrected_leg_lengths(poses[now.start], temps[now.start]), len(seconds), 1)

    # a leg whose thermometer leads its metal by a quarter of an hour: the law remembers the temperatures before
    assert hexapod.thermal is not None
    law = hexapod.thermal.legs[0]
    shape = {"sensor": law.sensors[0], "ratio": 0.5, "time_constant_s": 900.0}
    lag = ht.LegTerm("thermal-lag", "lag", shape, np.array([1e-6]))
    legs = (ht.LegLaw(law.sensors, law.A, law.B, terms=[lag]),) * 6
    lagging = replace(hexapod, thermal=replace(hexapod.thermal, legs=legs))

    print("with memory, row by row (some milliseconds each: good for 100 Hz, not for 1 kHz):")
    single = lagging.leg_controllers()
    timed(lambda now: single.corrected_leg_lengths(poses[now.start], temps[now.start], seconds[now.start]), 200, 1)
    print(f"with memory, {BLOCK} cycles planned ahead in a call (1 kHz is kept):")
    ahead = lagging.leg_controllers()
    timed(lambda now: ahead.corrected_leg_lengths(poses[now], temps[now], seconds[now]), 20_000, BLOCK)


if __name__ == "__main__":
    main()
