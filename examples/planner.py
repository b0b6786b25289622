"""A planner at 1 kHz: corrected leg lengths along a trajectory while the machine warms up."""

from __future__ import annotations

import time

import numpy as np

import hexathermal as ht


def main() -> None:
    """Correct one minute of a 1 kHz trajectory in one call, then pose by pose as a controller would."""
    hexapod = ht.load_hexapod("reference")
    seconds = np.arange(0.0, 60.0, 0.001)
    coordinates = np.zeros((len(seconds), 6))  # mm, deg, relative to home
    coordinates[:, 0] = 40.0 * np.sin(0.5 * seconds)
    coordinates[:, 2] = 20.0 * np.cos(0.3 * seconds)
    coordinates[:, 4] = 2.0 * np.sin(0.7 * seconds)
    poses = ht.pose_from_coordinates(coordinates, hexapod=hexapod)
    temps = 21.0 + np.linspace(0.0, 0.2, len(seconds))[:, None] + 0.1 * np.arange(6)

    lengths = hexapod.corrected_leg_lengths(poses, temps)
    correction = (lengths - hexapod.inverse_kinematics(poses)) * 1e6
    print(f"{len(seconds)} poses; corrections from {correction.min():.2f} to {correction.max():.2f} um")

    begin = time.perf_counter()
    for pose, temp in zip(poses, temps, strict=True):
        hexapod.corrected_leg_lengths(pose, temp)
    print(f"one by one: {(time.perf_counter() - begin) / len(seconds) * 1e6:.1f} us each, a 1 kHz cycle has 1000")


if __name__ == "__main__":
    main()
