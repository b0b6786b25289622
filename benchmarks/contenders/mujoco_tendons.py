"""MuJoCo: a free platform on six spatial tendons; Newton on the tendons' Jacobian for forward kinematics.

The pose is handed over as MuJoCo wants it (position and quaternion in ``qpos``): no conversion is timed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from scipy.linalg.lapack import dgesv

from benchmarks.case import Case, FloatArray, Quantity, motions_of, poses_of
from benchmarks.contender import LOOPED, Job, Unavailable, rows, single, stacked

RESIDUAL = 1e-12
"""Newton stops when no tendon is off by more [m]."""

MOST_STEPS = 30
LENGTHS_ONLY = "kinematics, tendon"
WITH_JACOBIAN = "kinematics, comPos, tendon"
NUMPY, LAPACK = "np.linalg.solve", "LAPACK dgesv called directly"


class MujocoTendons:
    """A model of one machine."""

    def __init__(self, case: Case) -> None:
        try:
            import mujoco
        except ImportError as error:
            raise Unavailable("MuJoCo is not installed: pip install -e '.[bench]'") from error
        self.name = "MuJoCo"
        self.note = f"version {mujoco.__version__}: qpos written, the named mj_ calls, ten_length copied"
        self.case = case
        spec = mujoco.MjSpec()
        platform = spec.worldbody.add_body(name="platform")
        platform.add_freejoint()
        platform.mass, platform.inertia, platform.explicitinertial = 1.0, [1.0, 1.0, 1.0], True
        for i, (base, joint) in enumerate(zip(case.hexapod.base_joints, case.hexapod.platform_joints, strict=True)):
            spec.worldbody.add_site(name=f"base{i}", pos=base)
            platform.add_site(name=f"platform{i}", pos=joint)
            tendon = spec.add_tendon(name=f"leg{i}")
            tendon.wrap_site(f"base{i}")
            tendon.wrap_site(f"platform{i}")
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.mujoco = mujoco
        if self.data.ten_J.size != 36:
            raise Unavailable(f"MuJoCo {mujoco.__version__} does not give the tendons' whole Jacobian")
        self.home = self._native(motions_of(case.hexapod.home[None]))[0]

    @staticmethod
    def _native(motions: FloatArray) -> FloatArray:
        """Return ``x, y, z, qw, qx, qy, qz``."""
        return np.ascontiguousarray(motions[..., [0, 1, 2, 6, 3, 4, 5]])

    def jobs(self, case: Case) -> list[Job]:
        """Return jobs for one pose, and the same in a loop where a batch is asked for."""
        poses, lengths = rows(self._native(case.motions)), rows(case.lengths)
        temps, law = rows(case.temps), case.law
        tendons, jacobian = self._tendons(False), self._jacobian()
        full, newton, quick = self._tendons(True), self._newton(np.linalg.solve), self._newton(_lapack)

        def corrected(pose: FloatArray, temps: FloatArray) -> FloatArray:
            A, B, q0, reference = law
            dT = temps - reference
            return np.asarray(q0 + (tendons(pose) - q0 - A * dT * q0) / (1.0 + B * dT))

        many = self._native(case.motions[:LOOPED])
        return [
            single(Quantity.LENGTHS, tendons, [(pose,) for pose in poses], LENGTHS_ONLY),
            single(Quantity.LENGTHS, full, [(pose,) for pose in poses], WITH_JACOBIAN),
            single(Quantity.CORRECTED, corrected, list(zip(poses, temps, strict=True)), "tendons, law in NumPy"),
            single(Quantity.POSES, newton, [(row,) for row in lengths], NUMPY, _poses_read),
            single(Quantity.POSES, quick, [(row,) for row in lengths], LAPACK, _poses_read),
            single(Quantity.JACOBIANS, jacobian, [(pose,) for pose in poses], read=self._jacobians_read),
            _looped(Quantity.LENGTHS, tendons, many),
            _looped(Quantity.POSES, newton, case.lengths[:LOOPED], _poses_read),
        ]

    def _tendons(self, with_jacobian: bool) -> Callable[[FloatArray], FloatArray]:
        """Return ``qpos -> lengths``; ``mj_comPos`` is needed for the tendons' Jacobian only."""
        kinematics, centres, tendon = self.mujoco.mj_kinematics, self.mujoco.mj_comPos, self.mujoco.mj_tendon
        model, data, qpos, length = self.model, self.data, self.data.qpos, self.data.ten_length

        def short(pose: FloatArray) -> FloatArray:
            qpos[:] = pose
            kinematics(model, data)
            tendon(model, data)
            return np.asarray(length.copy())

        def full(pose: FloatArray) -> FloatArray:
            qpos[:] = pose
            kinematics(model, data)
            centres(model, data)
            tendon(model, data)
            return np.asarray(length.copy())

        return full if with_jacobian else short

    def _jacobian(self) -> Callable[[FloatArray], FloatArray]:
        """Return ``qpos -> ten_J``: velocities in base axes, rotations in platform axes."""
        full, J = self._tendons(True), self.data.ten_J.reshape(6, 6)

        def jacobian(pose: FloatArray) -> FloatArray:
            full(pose)
            return np.asarray(J.copy())

        return jacobian

    def _newton(self, solve: Callable[..., Any]) -> Callable[[FloatArray], FloatArray]:
        """Return ``lengths -> qpos``, from home; NaN where it does not converge."""
        kinematics, centres, tendon = self.mujoco.mj_kinematics, self.mujoco.mj_comPos, self.mujoco.mj_tendon
        integrate, model, data, home = self.mujoco.mj_integratePos, self.model, self.data, self.home
        qpos, length, J = data.qpos, data.ten_length, data.ten_J.reshape(6, 6)

        def pose(wanted: FloatArray) -> FloatArray:
            qpos[:] = home
            for _ in range(MOST_STEPS):
                kinematics(model, data)
                centres(model, data)
                tendon(model, data)
                error = wanted - length
                if abs(error).max() < RESIDUAL:
                    return np.asarray(qpos.copy())
                integrate(model, qpos, solve(J, error), 1.0)
            return np.full(7, np.nan)

        return pose

    def _jacobians_read(self, results: Sequence[Any]) -> FloatArray:
        """Return Jacobians with rotations in base axes: ``w_platform = R^T w_base``."""
        J = np.stack(results)
        R = self.case.poses[: len(J), :3, :3]
        return np.concatenate([J[..., :3], J[..., 3:] @ np.swapaxes(R, -1, -2)], axis=-1)


def _lapack(A: FloatArray, b: FloatArray) -> FloatArray:
    return dgesv(A, b)[2]  # type: ignore[no-any-return]


def _poses_read(results: Sequence[Any]) -> FloatArray:
    """Return poses of MuJoCo's ``qpos``."""
    return poses_of(np.stack(results)[:, [0, 1, 2, 4, 5, 6, 3]])


def _looped(
    quantity: Quantity,
    function: Callable[[FloatArray], FloatArray],
    inputs: FloatArray,
    read: Callable[[Sequence[Any]], FloatArray] = stacked,
) -> Job:
    """Return a job that does a batch one by one."""

    def loop() -> FloatArray:
        return stacked([function(row) for row in inputs])

    return Job(quantity, True, loop, [()], len(inputs), lambda results: read(list(results[0])), "Python loop")


def enter(case: Case) -> MujocoTendons:
    """Return the contender."""
    return MujocoTendons(case)
