"""The machine as a closed-loop mechanism in Pinocchio: universal, prismatic, spherical joints; six closures.

It gives joint angles, margins, distances between legs, leg forces and the drawing at a pose, and it is the
independent oracle of `hexathermal.kinematics`, whose formulas it does not use: a pose is reached when
Pinocchio's own forward kinematics of the six legs meets the platform.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from hexathermal.errors import (
    ArgumentError,
    JointConeError,
    KinematicsError,
    NotConvergedError,
    OtherBranchError,
    SingularPoseError,
)
from hexathermal.machine import pinocchio_collisions as collisions
from hexathermal.machine import pinocchio_loads as loads
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.pinocchio_collisions import Clearance, JointAngles, Margins, Solid
from hexathermal.machine.thermal import frozen
from hexathermal.poses import FloatArray, PoseLike, finite_array, pose_array

STANDARD_GRAVITY = (0.0, 0.0, -9.80665)
"""Acceleration of fall for a machine that stands upright, base frame [m/s^2]."""

CLOSURE_TOLERANCE_M, CLOSURE_TOLERANCE_RAD = 1e-13, 1e-13
"""How near each leg's end must come to its platform joint; see `PinocchioMachine.configuration`."""

LARGEST_STEP_PER_LENGTH, LARGEST_STEP_RAD, STEPS = 0.1, 0.25, 100
"""Longest Newton step of the platform, a tenth of the mean home length and 0.25 rad; most steps."""

LEAST_COSINE = 1e-6
"""Smallest cosine of a universal joint's second angle: beyond it the first angle is not defined."""


@dataclass(frozen=True, eq=False)
class _State:
    """A configuration, seen through its loops.

    ``error_i = log6(c1Mc2_i)``; with the closures' Jacobian cut into ``J_leg,i`` and ``J_platform,i``:
    ``step_i = J_leg,i^-1 error_i`` and ``response_i = J_leg,i^-1 J_platform,i``.  Leg joints that move by
    ``step - response dx`` close the loops while the platform moves by ``dx`` (its own axes).
    """

    q_pin: FloatArray
    error: FloatArray
    step: FloatArray
    response: FloatArray

    @property
    def closing(self) -> FloatArray:
        """``dL/dx`` (6, 6), `dx` in the platform's axes: the prismatic rows."""
        return -self.response[:, 2, :]


class PinocchioMachine:
    """A `Hexapod` as a Pinocchio model with closed loops, payload and gravity.

    Each leg is universal -> prismatic -> spherical; the platform is a free-flyer; closure ``i`` holds the
    frame after the spherical joint to the platform (6-D, so that the ball's angles are coordinates too).  The
    neutral configuration is home: ``pinocchio.neutral(machine.model)`` closes all loops.

    Parameters
    ----------
    hexapod : Hexapod
        Without `bodies`, sizes and masses are derived in steel: `pinocchio_loads.default_bodies`.
    payload_mass : float [kg]
        Point mass on the platform.
    payload_centre : array, shape (3,) [m]
        Where it stands in the platform frame.
    gravity : array, shape (3,) [m/s^2]
        Acceleration of fall, base frame.

    Attributes
    ----------
    model, closures : pinocchio.Model, vector of pinocchio.RigidConstraintModel
        nq 49, nv 42: legs first (6 velocities each), platform last.  For statics: the balls have no mass.
    collision_model, visual_model : pinocchio.GeometryModel
        Capsules; cylinders and spheres for `pinocchio.visualize`.
    shapes : Shapes
        Sizes and masses in use.
    home_lengths : array, shape (6,) [m]

    Raises
    ------
    ArgumentError
        Not a Hexapod; a mass below 0; a vector not finite or not of three.

    Notes
    -----
    One pose at a time.  Stroke and cones are not enforced: `margins` measures them.  A machine holds
    Pinocchio's work space, so each thread needs its own.

    Examples
    --------
    >>> import hexathermal as ht
    >>> machine = PinocchioMachine(ht.load_hexapod("reference"))
    >>> pose = ht.pose_from_coordinates([5, 0, 12, 0, 1.5, 0], hexapod=machine.hexapod)
    >>> bool(abs(machine.forward(machine.leg_lengths(pose)) - pose).max() < 1e-11)
    True
    """

    def __init__(
        self,
        hexapod: Hexapod,
        payload_mass: float = 0.0,
        payload_centre: npt.ArrayLike = (0.0, 0.0, 0.0),
        gravity: npt.ArrayLike = STANDARD_GRAVITY,
    ) -> None:
        if not isinstance(hexapod, Hexapod):
            raise ArgumentError(f"hexapod must be a Hexapod, found {hexapod!r}; load_hexapod(name) gives one")
        self.hexapod = hexapod
        self.payload_mass, self.payload_centre = loads.checked_payload(payload_mass, payload_centre)
        self.shapes = loads.machine_shapes(hexapod)
        self.home_lengths = frozen(loads.home_lengths(hexapod))
        self.model = pin.Model()
        self.model.name = hexapod.name or "hexapod"
        self.model.gravity.linear = loads.checked_vector(gravity, "gravity")
        frames, limits = loads.leg_frames(hexapod), np.transpose(hexapod.length_limits)
        self._legs = tuple(
            loads.add_leg(self.model, self.shapes, leg, frame, float(self.home_lengths[leg]), limits[leg])
            for leg, frame in enumerate(frames)
        )
        self._home = pin.SE3(hexapod.home)
        self._platform = int(self.model.addJoint(0, pin.JointModelFreeFlyer(), self._home, "platform"))
        inertia = loads.platform_inertia(self.shapes, self.payload_mass, self.payload_centre)
        self.model.appendBodyToJoint(self._platform, inertia, pin.SE3.Identity())
        self._close_loops(frames)
        bodies = (hexapod, self.shapes, self._legs, self.home_lengths)
        self.collision_model = collisions.collision_model(*bodies)
        self.visual_model = collisions.visual_model(*bodies, self._platform)
        self._data = self.model.createData()
        self._capsules = pin.GeometryData(self.collision_model)
        self._drawn = pin.GeometryData(self.visual_model)

    def _close_loops(self, frames: tuple[pin.SE3, ...]) -> None:
        """Hold the end of each leg to the platform, where it stands at home."""
        self.closures = pin.StdVec_RigidConstraintModel()
        self._found = pin.StdVec_RigidConstraintData()
        six, still = pin.ContactType.CONTACT_6D, pin.SE3.Identity()
        for leg, joint in enumerate(self._legs):
            end = pin.SE3(np.eye(3), np.array([0.0, 0.0, self.home_lengths[leg]]))
            there = self._home.actInv(frames[leg] * end)
            closure = pin.RigidConstraintModel(six, self.model, joint.spherical, still, self._platform, there)
            closure.name = f"leg{leg + 1}"
            self.closures.append(closure)
            self._found.append(closure.createData())
        self._loops = tuple(zip(self._legs, self.closures, self._found, strict=True))
        joints = np.abs([self.hexapod.base_joints, self.hexapod.platform_joints])
        self._tolerance = max(CLOSURE_TOLERANCE_M, 8.0 * float(np.finfo(float).eps * joints.max()))

    def configuration(self, pose: PoseLike) -> FloatArray:
        """Return the configuration of all joints at a pose, its loops closed by Newton's method.

        Each universal joint is first pointed at its platform joint; then the leg joints follow
        ``J_leg,i dq_i = log6(c1Mc2_i)`` until ``|c1Mc2_i| <= max(1e-13, 8 eps s) m`` and ``<= 1e-13 rad``,
        where ``s`` is the largest coordinate of a joint from the base's or the platform's origin.

        Parameters
        ----------
        pose : SE3 or array, shape (4, 4) [m]

        Returns
        -------
        q_pin : array, shape (49,)
            Each leg ``[rad, rad, m, quaternion xyzw]``, then the platform from home ``[m, quaternion xyzw]``.

        Raises
        ------
        JointConeError
            A leg lies within 1e-6 rad of the first axis of its universal joint, 90 degrees from home.
        KinematicsError
            A leg has length 0.
        NotConvergedError
            The loops did not close.
        """
        return self._at(pose).q_pin

    def leg_lengths(self, pose: PoseLike) -> FloatArray:
        """Return the lengths at a pose [m], shape (6,), by the prismatic joints: ``L_home + travel``."""
        return np.asarray(self.home_lengths + _legs_of(self.configuration(pose))[:, 2])

    def forward(self, lengths: npt.ArrayLike, guess: PoseLike | None = None) -> FloatArray:
        """Return the pose at which legs of these lengths close the loops, on the branch of the guess.

        The prismatic joints move to the lengths while Newton's method on the closures finds all other joints;
        where that fails they move in 16 equal stretches.

        Parameters
        ----------
        lengths : array, shape (6,) [m]
        guess : SE3 or array, shape (4, 4) [m], optional
            Start; home by default.

        Returns
        -------
        pose : array, shape (4, 4) [m]
            Platform in base.

        Raises
        ------
        NotConvergedError
            Open by more than `configuration` allows: perhaps these legs do not meet, or not near the guess.
        OtherBranchError
            The sign of ``det J`` differs from that at the guess (most other postures show so, not all).
        SingularPoseError
            A Newton step met a singular pose.
        """
        wanted = finite_array(lengths, (6,), "lengths")
        if wanted.shape != (6,):
            raise ArgumentError(f"lengths has shape {wanted.shape}; expected (6,), one set at a time")
        if not (wanted > 0.0).all():
            leg, length = int(wanted.argmin()) + 1, float(wanted.min())
            message = f"leg {leg} is {length:g} m long; lengths must be above 0 m, are these strokes?"
            raise KinematicsError(message, leg=leg, value=length, lower=0.0)
        start = self._at(self.hexapod.home if guess is None else guess)
        first, travel = _legs_of(start.q_pin)[:, 2], wanted - self.home_lengths
        try:
            end = self._follow(start, travel)
        except NotConvergedError:
            end = start
            for share in np.arange(1, 17) / 16.0:
                end = self._follow(end, first + share * (travel - first))
        if np.linalg.det(start.closing) * np.linalg.det(end.closing) <= 0.0:
            raise OtherBranchError("the lengths were met in another posture than the guess's; guess nearer")
        return self._pose_of(end.q_pin)

    def jacobian(self, pose: PoseLike) -> FloatArray:
        """Return ``dL/dx`` from the closures' Jacobian: rows ``[u, (R p) x u]``.

        ``u`` points from base to platform joint; ``dL = J dx`` with ``dx`` = [velocity of the platform's
        origin, angular velocity], both in base axes.

        Returns
        -------
        array, shape (6, 6) [1, m/rad]
        """
        state = self._at(pose)
        return np.asarray(state.closing @ np.kron(np.eye(2), self._pose_of(state.q_pin)[:3, :3].T))

    def joint_angles(self, pose: PoseLike) -> JointAngles:
        """Return where all joints stand at a pose, and how far each leg leans from its direction at home."""
        return collisions.joint_angles(_legs_of(self.configuration(pose)))

    def margins(self, pose: PoseLike) -> Margins:
        """Return what is left to stroke and joint cones, and between the legs, at a pose."""
        q_pin = self.configuration(pose)
        angles = collisions.joint_angles(_legs_of(q_pin))
        lengths = self.home_lengths + angles.travel
        return collisions.margins(self.hexapod, self.shapes, lengths, angles, self._clearance(q_pin))

    def distances(self, pose: PoseLike) -> Clearance:
        """Return the distances between the legs at a pose: a capsule for each body and one for each rod.

        Plates are not asked.  `pinocchio_collisions.capsule_ends` states the capsules, `hinged_pairs` those
        left out; where a rod is out of its body (`Margins.rod_overlap` below 0) the gap is not covered.
        """
        return self._clearance(self.configuration(pose))

    def leg_forces(self, pose: PoseLike) -> FloatArray:
        """Return the axial force of each leg under the weight of legs, platform and payload.

        ``f_i = + dV / dL_i`` with V the potential energy of the closed loop: compression is positive.  It is
        the push of the actuator between body and rod; without mass in the legs ``J^T f = -wrench``.

        Returns
        -------
        array, shape (6,) [N]

        Raises
        ------
        SingularPoseError
            ``1 / cond <= 1e-9`` for the Jacobian with rotations scaled by the platform's joint radius.
        """
        state = self._at(pose)
        gravity = pin.computeGeneralizedGravity(self.model, self._data, state.q_pin)
        return loads.axial_forces(state.response, gravity, self.shapes.platform)

    def potential_energy(self, pose: PoseLike) -> float:
        """Return the energy of legs, platform and payload in gravity [J], 0 at the base's origin."""
        return float(pin.computePotentialEnergy(self.model, self._data, self.configuration(pose)))

    def geometry(self, pose: PoseLike) -> list[Solid]:
        """Return the drawing: plates, joints, bodies and rods, meshes [m] made anew at each call."""
        q_pin = self.configuration(pose)
        pin.updateGeometryPlacements(self.model, self._data, self.visual_model, self._drawn, q_pin)
        return collisions.solids(self.visual_model, self._drawn)

    def _clearance(self, q_pin: FloatArray) -> Clearance:
        """Return the distances between the legs at a configuration."""
        pin.computeDistances(self.model, self._data, self.collision_model, self._capsules, q_pin)
        return collisions.clearance(self.collision_model, self._capsules)

    def _at(self, pose: PoseLike) -> _State:
        """Return the closed configuration at a pose; see `configuration`."""
        array = pose_array(pose)
        if array.shape != (4, 4):
            raise ArgumentError(f"pose has shape {array.shape}; expected (4, 4) or an SE3, one at a time")
        q_pin = pin.neutral(self.model)
        q_pin[-7:] = pin.SE3ToXYZQUAT(self._home.actInv(pin.SE3(array)))
        q_pin[-4:] /= np.linalg.norm(q_pin[-4:])
        self._aim(q_pin)
        state = self._linearise(q_pin)
        for _ in range(STEPS):
            if self._closed(state):
                return state
            step = np.concatenate([state.step.ravel(), np.zeros(6)])
            state = self._linearise(pin.integrate(self.model, state.q_pin, step))
        raise self._open(state, "the pose")

    def _aim(self, q_pin: FloatArray) -> None:
        """Point each leg at its platform joint and turn its ball onto the platform."""
        legs, frames = _legs_of(q_pin), self._data.oMi
        pin.forwardKinematics(self.model, self._data, q_pin)
        for leg, (joint, closure, _) in enumerate(self._loops):
            target = frames[self._platform].act(closure.joint2_placement.translation)
            x, y, z = frames[joint.universal].actInv(target)
            length, across = float(np.sqrt(x * x + y * y + z * z)), float(np.hypot(y, z))
            if not length > 1e-9 * self.home_lengths[leg]:
                message = f"leg {leg + 1} has length 0 at this pose: its joints coincide"
                raise KinematicsError(message, leg=leg + 1, value=length, lower=0.0)
            if not across > LEAST_COSINE * length:
                message = f"leg {leg + 1} lies along its universal joint's first axis, 90 degrees from home: "
                message += "that joint's first angle is not defined there; turn the pose"
                right = np.pi / 2.0
                raise JointConeError(message, leg=leg + 1, value=right, upper=right - LEAST_COSINE)
            legs[leg, :3] = np.arctan2(-y, z), np.arctan2(x, across), length - self.home_lengths[leg]
        pin.forwardKinematics(self.model, self._data, q_pin)
        for leg, (joint, closure, _) in enumerate(self._loops):
            ball = frames[joint.spherical].actInv(frames[self._platform] * closure.joint2_placement)
            legs[leg, 3:] = pin.Quaternion(ball.rotation).coeffs()

    def _linearise(self, q_pin: FloatArray) -> _State:
        """Return errors and Jacobians of the closures (`calc` first: stale data give a wrong Jacobian)."""
        pin.computeJointJacobians(self.model, self._data, q_pin)
        for _, closure, found in self._loops:
            closure.calc(self.model, self._data, found)
        rows = pin.getConstraintsJacobian(self.model, self._data, self.closures, self._found)
        error = np.array([pin.log6(found.c1Mc2).vector for found in self._found])
        legs = rows[:, :36].reshape(6, 6, 6, 6)[np.arange(6), :, np.arange(6), :]
        sides = np.concatenate([error[:, :, None], rows[:, 36:].reshape(6, 6, 6)], axis=2)
        try:
            solved = np.linalg.solve(legs, sides)
        except np.linalg.LinAlgError:
            message = "a leg's own joints are singular here: no length, or 90 degrees from home"
            raise SingularPoseError(message) from None
        return _State(q_pin, error, solved[:, :, 0], solved[:, :, 1:])

    def _closed(self, state: _State) -> bool:
        """Whether all loops are closed within the tolerances of `configuration`."""
        off, turned = np.linalg.norm(state.error.reshape(6, 2, 3), axis=2).max(axis=0)
        return bool(off <= self._tolerance and turned <= CLOSURE_TOLERANCE_RAD)

    def _follow(self, state: _State, travel: FloatArray) -> _State:
        """Return the closed state with the prismatic joints at `travel`, by Newton steps from `state`."""
        longest = LARGEST_STEP_PER_LENGTH * float(self.home_lengths.mean())
        for _ in range(STEPS):
            missing = travel - _legs_of(state.q_pin)[:, 2]
            if not missing.any() and self._closed(state):
                return state
            try:
                dx = np.linalg.solve(state.closing, missing - state.step[:, 2])
            except np.linalg.LinAlgError:
                raise SingularPoseError("a Newton step met a singular pose; give another guess") from None
            shift = np.linalg.norm(dx[:3] + np.cross(dx[3:], self.shapes.platform.centre))
            over = max(shift / longest, np.linalg.norm(dx[3:]) / LARGEST_STEP_RAD, 1.0)
            step = np.concatenate([(state.step - state.response @ dx).ravel(), dx]) / over
            q_pin = pin.integrate(self.model, state.q_pin, step)
            if over == 1.0:
                _legs_of(q_pin)[:, 2] = travel
            if not np.isfinite(q_pin).all():
                break
            state = self._linearise(q_pin)
        raise self._open(state, "these lengths")

    def _open(self, state: _State, what: str) -> NotConvergedError:
        """Return the error of loops that do not close."""
        gaps = np.linalg.norm(state.error[:, :3], axis=1)
        leg, gap = int(gaps.argmax()) + 1, float(gaps.max())
        message = f"the loops do not close at {what}: leg {leg} ends {gap:.3g} m off its platform joint "
        message += f"after {STEPS} Newton steps, tolerance {self._tolerance:.3g} m; guess nearer, or check it"
        return NotConvergedError(message, leg=leg, value=gap, upper=self._tolerance)

    def _pose_of(self, q_pin: FloatArray) -> FloatArray:
        """Return the platform in the base, (4, 4)."""
        return np.array((self._home * pin.XYZQUATToSE3(q_pin[-7:])).homogeneous)


def _legs_of(q_pin: FloatArray) -> FloatArray:
    """Return the six rows ``[2 universal, prismatic, 4 quaternion]``, a view."""
    return q_pin[:42].reshape(6, 7)
