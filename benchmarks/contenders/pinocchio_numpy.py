"""Pinocchio's SE3 with NumPy, as one writes it in an afternoon: one pose at a time, Newton with ``exp6``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from benchmarks.case import Case, FloatArray, Quantity
from benchmarks.contender import LOOPED, Job, first, rows, single

STEP, MOST_STEPS = 1e-7, 30
"""Newton stops after a step below this [m, rad]: the error left is its square."""


class PinocchioNumpy:
    """SE3 and NumPy."""

    name = "Pinocchio SE3 + NumPy"
    note = f"version {pin.__version__}: SE3 in and out, six legs at once in NumPy, no checks"

    def __init__(self, case: Case) -> None:
        self.p, self.b = case.hexapod.platform_joints, case.hexapod.base_joints
        self.home = pin.SE3(case.hexapod.home)
        self.law = case.law

    def lengths(self, pose: pin.SE3) -> FloatArray:
        """Return leg lengths."""
        d = self.p @ pose.rotation.T + (pose.translation - self.b)
        return np.asarray(np.sqrt(np.einsum("ij,ij->i", d, d)))

    def corrected(self, pose: pin.SE3, temps: FloatArray) -> FloatArray:
        """Return commanded lengths."""
        A, B, q0, reference = self.law
        dT = temps - reference
        return np.asarray(q0 + (self.lengths(pose) - q0 - A * dT * q0) / (1.0 + B * dT))

    def jacobian(self, pose: pin.SE3) -> FloatArray:
        """Return rows ``[u, s x u]``."""
        s = self.p @ pose.rotation.T
        d = s + (pose.translation - self.b)
        d /= np.sqrt(np.einsum("ij,ij->i", d, d))[:, None]
        return np.hstack([d, np.cross(s, d)])

    def pose(self, wanted: FloatArray) -> pin.SE3:
        """Return the pose of six lengths, from home; in platform axes a leg's row is ``[v, p x v]``, ``v = R^T u``."""
        pose = self.home
        A = np.empty((6, 6))
        p, b = self.p, self.b
        for _ in range(MOST_STEPS):
            v = p + (pose.translation - b) @ pose.rotation
            length = np.sqrt(np.einsum("ij,ij->i", v, v))
            v /= length[:, None]
            A[:, :3] = v
            A[:, 3] = p[:, 1] * v[:, 2] - p[:, 2] * v[:, 1]
            A[:, 4] = p[:, 2] * v[:, 0] - p[:, 0] * v[:, 2]
            A[:, 5] = p[:, 0] * v[:, 1] - p[:, 1] * v[:, 0]
            step = np.linalg.solve(A, wanted - length)
            pose = pose * pin.exp6(step)
            if abs(step).max() < STEP:
                return pose
        return pin.SE3(np.full((4, 4), np.nan))

    def jobs(self, case: Case) -> list[Job]:
        """Return jobs for one pose, and the same in a loop where a batch is asked for."""
        poses = [pin.SE3(pose) for pose in case.poses[:LOOPED]]
        few, temps, lengths = poses[: len(rows(case.poses))], rows(case.temps), rows(case.lengths)
        return [
            single(Quantity.LENGTHS, self.lengths, [(pose,) for pose in few]),
            single(Quantity.CORRECTED, self.corrected, list(zip(few, temps, strict=True))),
            single(Quantity.POSES, self.pose, [(row,) for row in lengths], read=_poses_read),
            single(Quantity.JACOBIANS, self.jacobian, [(pose,) for pose in few]),
            _looped(Quantity.LENGTHS, self.lengths, poses, np.stack),
            _looped(Quantity.POSES, self.pose, list(case.lengths[:LOOPED]), _poses_read),
        ]


def _poses_read(results: Sequence[Any]) -> FloatArray:
    return np.stack([pose.homogeneous for pose in results])


def _looped(
    quantity: Quantity,
    function: Callable[[Any], Any],
    inputs: Sequence[Any],
    gathered: Callable[[Sequence[Any]], FloatArray],
) -> Job:
    """Return a job that does a batch one by one."""

    def loop() -> FloatArray:
        return gathered([function(entry) for entry in inputs])

    return Job(quantity, True, loop, [()], len(inputs), first, "Python loop")


def enter(case: Case) -> PinocchioNumpy:
    """Return the contender."""
    return PinocchioNumpy(case)
