"""The machine as a closed-loop mechanism in Pinocchio: universal, prismatic and spherical joints, six loop closures.

It gives joint angles, margins, distances between legs, leg forces and the drawing at a pose, and it is the
independent oracle of `hexathermal.kinematics`, whose formulas it does not use: a pose is reached when Pinocchio's own
forward kinematics of the six legs meets the platform.
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
"""Fall of a machine that stands upright, base frame [m/s^2]."""

CLOSURE_TOLERANCE_M = 1e-13
CLOSURE_TOLERANCE_RAD = 1e-13
"""Loops are closed when each leg's end is within these of its platform joint (see `PinocchioMachine.configuration`)."""

LARGEST_STEP_RAD = 0.25
LARGEST_STEP_PER_LENGTH = 0.1
"""Longest Newton step of the platform: 0.25 rad, and a tenth of the mean home length."""

STEPS = 100
LEAST_COSINE = 1e-6
"""Smallest cosine of a universal joint's second angle: nearer to 90 degrees the first angle is not defined."""


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


class PinocchioMachine:
    """A `Hexapod` as a Pinocchio model with closed loops, payload and gravity.

    Each leg is universal -> prismatic -> spherical; the platform is a free-flyer; closure ``i`` holds the frame after
    the spherical joint to the platform (6-D, so that the ball's angles are coordinates like the others).  The neutral
    configuration is home: ``pinocchio.neutral(machine.model)`` closes all loops, and ``q_pin[-7:]`` counts from there.

    Parameters
    ----------
    hexapod : Hexapod
        Without `bodies`, sizes and masses are derived in steel: `hexathermal.machine.pinocchio_loads.default_bodies`.
    payload_mass : float [kg]
        Point mass on the platform.
    payload_centre : array, shape (3,) [m]
        Where it stands in the platform frame.
    gravity : array, shape (3,) [m/s^2]
        Acceleration of fall, base frame.

    Attributes
    ----------
    model, closures : pinocchio.Model, list of pinocchio.RigidConstraintModel
        nq 49, nv 42; legs first (6 velocities each), platform last. For statics: the balls have no mass of their own.
    collision_model, visual_model : pinocchio.GeometryModel
        Capsules; cylinders and spheres for `pinocchio.visualize`.
    shapes : Shapes
        Sizes and masses in use.

    Notes
    -----
    One pose at a time.  Stroke and cones are not enforced: `margins` measures them.  A machine holds Pinocchio's
    work space, so each thread needs its own.

    Raises
    ------
    ArgumentError
        Not a Hexapod; mass negative; a vector not finite or not of three.
    """

    def __init__(
        self,
        hexapod: Hexapod,
        payload_mass: float = 0.0,
        payload_centre: npt.ArrayLike = (0.0, 0.0, 0.0),
        gravity: npt.ArrayLike = STANDARD_GRAVITY,
    ) -> None:
        if not isinstance(hexapod, Hexapod):
            raise ArgumentError(f"hexapod must be a Hexapod, found {type(hexapod).__name__}; load_hexapod(name) gives one")
        self.hexapod = hexapod
        self.payload_mass, self.payload_centre = loads.checked_payload(payload_mass, payload_centre)
        self.shapes = loads.machine_shapes(hexapod)
        self.home_lengths = frozen(loads.home_lengths(hexapod))
        self.model = pin.Model()
        self.model.name = hexapod.name or "hexapod"
        self.model.gravity.linear = loads.checked_vector(gravity, "gravity")
        frames = loads.leg_frames(hexapod)
        self._legs = tuple(
            loads.add_leg(self.model, self.shapes, leg, frame, float(self.home_lengths[leg]))
            for leg, frame in enumerate(frames)
        )
        self._home = pin.SE3(hexapod.home)
        self._platform = int(self.model.addJoint(0, pin.JointModelFreeFlyer(), self._home, "platform"))
        payload = loads.platform_inertia(self.shapes, self.payload_mass, self.payload_centre)
        self.model.appendBodyToJoint(self._platform, payload, pin.SE3.Identity())
        self._limit_stroke()
        self._close_loops(frames)
        self.collision_model = collisions.collision_model(hexapod, self.shapes, self._legs, self.home_lengths)
        self.visual_model = collisions.visual_model(
            hexapod, self.shapes, self._legs, self._platform, self.home_lengths
        )
        farthest = max(np.abs(hexapod.base_joints).max(), np.abs(hexapod.platform_joints).max())
        self._tolerance = max(CLOSURE_TOLERANCE_M, 8.0 * float(np.finfo(float).eps * farthest))
        self._data = self.model.createData()
        self._loops = tuple(zip(self.closures, self._closure_data, strict=True))
        self._capsules = pin.GeometryData(self.collision_model)
        self._drawn = pin.GeometryData(self.visual_model)

    def _limit_stroke(self) -> None:
        """Write the stroke into the limits of the prismatic joints."""
        lower, upper = self.hexapod.length_limits
        for leg, joint in enumerate(self._legs):
            place = self.model.joints[joint.prismatic].idx_q
            self.model.lowerPositionLimit[place] = lower[leg] - self.home_lengths[leg]
            self.model.upperPositionLimit[place] = upper[leg] - self.home_lengths[leg]

    def _close_loops(self, frames: tuple[pin.SE3, ...]) -> None:
        """Hold the end of each leg to the platform, where it stands at home."""
        self.closures = pin.StdVec_RigidConstraintModel()
        self._closure_data = pin.StdVec_RigidConstraintData()
        for leg, joint in enumerate(self._legs):
            end = pin.SE3(np.eye(3), np.array([0.0, 0.0, self.home_lengths[leg]]))
            placement = self._home.actInv(frames[leg] * end)
            closure = pin.RigidConstraintModel(
                pin.ContactType.CONTACT_6D, self.model, joint.spherical, pin.SE3.Identity(), self._platform, placement
            )
            closure.name = f"leg{leg + 1}"
            self.closures.append(closure)
            self._closure_data.append(closure.createData())

    def configuration(self, pose: PoseLike) -> FloatArray:
        """Return the configuration of all joints at a pose, its loops closed by Newton's method.

        Each universal joint is first pointed at its platform joint; then all leg joints follow
        ``J_leg,i dq_i = log6(c1Mc2_i)`` until ``|c1Mc2_i| <= max(1e-13, 8 eps s) m`` and ``<= 1e-13 rad``, where ``s``
        is the largest coordinate of a joint from the base's or the platform's origin.

        Parameters
        ----------
        pose : SE3 or array, shape (4, 4) [m]

        Returns
        -------
        q_pin : array, shape (49,) [rad, rad, m, quaternion xyzw for each leg; m, quaternion xyzw from home]

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
        """Return the inter-articular lengths [m], shape (6,), read from the prismatic joints: ``L_home + travel``."""
        return self.home_lengths + self._legs_of(self.configuration(pose))[:, 2]

    def forward(self, lengths: npt.ArrayLike, guess: PoseLike | None = None) -> FloatArray:
        """Return the pose at which legs of these lengths close the loops, on the branch of the guess.

        The prismatic joints are moved to the lengths while Newton's method on the closures finds all other joints;
        a step is shortened to 0.25 rad and a tenth of the mean home length.

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
            Residual above the tolerances of `configuration` after 100 steps: perhaps these legs do not meet.
        OtherBranchError
            The sign of ``det J`` differs from that at the guess.
        SingularPoseError
            A Newton step met a singular pose.
        """
        wanted = finite_array(lengths, (6,), "lengths")
        if wanted.shape != (6,):
            raise ArgumentError(f"lengths has shape {wanted.shape}; expected (6,), one set at a time")
        if not (wanted > 0.0).all():
            leg = int(wanted.argmin())
            raise KinematicsError(
                f"leg {leg + 1} is {wanted[leg]:g} m long; lengths must be above 0 m, are these strokes?",
                leg=leg + 1, value=float(wanted[leg]), lower=0.0,
            )  # fmt: skip
        state = self._at(self.hexapod.home if guess is None else guess)
        branch = np.sign(np.linalg.det(-state.response[:, 2, :]))
        state = self._follow(state, wanted - self.home_lengths)
        if np.sign(np.linalg.det(-state.response[:, 2, :])) != branch:
            raise OtherBranchError("the lengths were met in another posture than the guess's; give a nearer guess")
        return self._pose_of(state.q_pin)

    def jacobian(self, pose: PoseLike) -> FloatArray:
        """Return ``dL/dx`` from the closures' Jacobian: rows ``[u, (R p) x u]``, ``u`` from base to platform joint.

        ``dL = J dx`` with ``dx`` = [velocity of the platform's origin, angular velocity], both in base axes.

        Returns
        -------
        array, shape (6, 6) [1, m/rad]
        """
        state = self._at(pose)
        turn = self._pose_of(state.q_pin)[:3, :3].T
        return np.asarray(-state.response[:, 2, :] @ np.kron(np.eye(2), turn))

    def joint_angles(self, pose: PoseLike) -> JointAngles:
        """Return where all joints stand at a pose, and how far each leg leans from its direction at home."""
        legs = self._legs_of(self.configuration(pose))
        (s0, s1), (c0, c1) = np.sin(legs[:, :2]).T, np.cos(legs[:, :2]).T
        x, y, z, w = legs[:, 3:].T
        across = 2.0 * np.hypot(x, y) * np.hypot(z, w)  # |(0, 0, 1) x R z| of the unit quaternion
        return JointAngles(
            universal=legs[:, :2],
            travel=legs[:, 2],
            spherical=np.array([pin.log3(pin.Quaternion(ball).matrix()) for ball in legs[:, 3:]]),
            base_cone=np.arctan2(np.hypot(s1, s0 * c1), c0 * c1),
            platform_cone=np.arctan2(across, w**2 + z**2 - x**2 - y**2),
        )

    def margins(self, pose: PoseLike) -> Margins:
        """Return what is left to stroke, joint cones and between the legs at a pose."""
        angles = self.joint_angles(pose)
        lengths = self.home_lengths + angles.travel
        shortest, longest = self.hexapod.length_limits
        stroke = np.stack([lengths - shortest, longest - lengths], axis=1)
        if self.hexapod.stroke is None:
            stroke = np.full((6, 2), np.inf)
        cones = (self.hexapod.base_cone, self.hexapod.platform_cone)
        at_base, at_platform = (np.full(6, np.inf) if cone is None else cone for cone in cones)
        return Margins(
            stroke=stroke,
            base_cone=at_base - angles.base_cone,
            platform_cone=at_platform - angles.platform_cone,
            rod_overlap=self.shapes.body_lengths + self.shapes.rod_lengths - lengths,
            clearance=self.distances(pose),
        )

    def distances(self, pose: PoseLike) -> Clearance:
        """Return the distances between different legs at a pose, each leg a capsule of the body and one of the rod.

        Plates are not asked.  See `pinocchio_collisions.capsule_ends` for the capsules and `hinged_pairs` for those
        left out; where a rod is out of its body (`Margins.rod_overlap` below 0) the gap between them is not covered.
        """
        q_pin = self.configuration(pose)
        nearest = pin.computeDistances(self.model, self._data, self.collision_model, self._capsules, q_pin)
        return collisions.clearance(self.collision_model, self._capsules, int(nearest))

    def leg_forces(self, pose: PoseLike) -> FloatArray:
        """Return the axial force of each leg under the weight of legs, platform and payload; compression positive.

        ``f_i = + dV / dL_i``, V the potential energy of the closed loop (`potential_energy`): the push of the actuator
        between body and rod.  It balances ``J^T f = -wrench`` where legs have no mass.

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
        return loads.axial_forces(state.response, gravity, self.shapes.platform.radius)

    def potential_energy(self, pose: PoseLike) -> float:
        """Return the potential energy of legs, platform and payload in gravity [J], 0 at the base's origin."""
        return float(pin.computePotentialEnergy(self.model, self._data, self.configuration(pose)))

    def geometry(self, pose: PoseLike) -> list[Solid]:
        """Return the drawing: plates, joints, bodies and rods as `Solid`, meshes [m] made anew at each call."""
        q_pin = self.configuration(pose)
        pin.updateGeometryPlacements(self.model, self._data, self.visual_model, self._drawn, q_pin)
        return collisions.solids(self.visual_model, self._drawn)

    def _at(self, pose: PoseLike) -> _State:
        """Return the closed configuration at a pose; see `configuration`."""
        array = pose_array(pose)
        if array.shape != (4, 4):
            raise ArgumentError(f"pose has shape {array.shape}; expected (4, 4) or an SE3, one pose at a time")
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
        raise self._not_closed(state, "the pose")

    def _aim(self, q_pin: FloatArray) -> None:
        """Point each leg at its platform joint and turn its ball onto the platform, by Pinocchio's own frames."""
        legs = self._legs_of(q_pin)
        pin.forwardKinematics(self.model, self._data, q_pin)
        platform = self._data.oMi[self._platform]
        for leg, (joint, closure) in enumerate(zip(self._legs, self.closures, strict=True)):
            x, y, z = self._data.oMi[joint.universal].actInv(platform.act(closure.joint2_placement.translation))
            length = float(np.sqrt(x * x + y * y + z * z))
            if not length > 1e-9 * self.home_lengths[leg]:
                raise KinematicsError(
                    f"leg {leg + 1} has length 0 at this pose: its joints coincide",
                    leg=leg + 1, value=length, lower=0.0,
                )  # fmt: skip
            if not np.hypot(y, z) > LEAST_COSINE * length:
                raise JointConeError(
                    f"leg {leg + 1} lies along the first axis of its universal joint, 90 degrees from home: "
                    "that joint's first angle is not defined there; turn the pose",
                    leg=leg + 1, value=np.pi / 2.0, upper=np.pi / 2.0 - LEAST_COSINE,
                )  # fmt: skip
            legs[leg, :3] = np.arctan2(-y, z), np.arctan2(x, np.hypot(y, z)), length - self.home_lengths[leg]
        pin.forwardKinematics(self.model, self._data, q_pin)
        for leg, (joint, closure) in enumerate(zip(self._legs, self.closures, strict=True)):
            ball = self._data.oMi[joint.spherical].rotation.T @ platform.rotation @ closure.joint2_placement.rotation
            legs[leg, 3:] = pin.Quaternion(ball).coeffs()

    def _linearise(self, q_pin: FloatArray) -> _State:
        """Return closure errors and Jacobians at a configuration (`calc` first: stale data give a wrong Jacobian)."""
        pin.computeJointJacobians(self.model, self._data, q_pin)
        for closure, found in self._loops:
            closure.calc(self.model, self._data, found)
        J = pin.getConstraintsJacobian(self.model, self._data, self.closures, self._closure_data)
        error = np.array([pin.log6(found.c1Mc2).vector for _, found in self._loops])
        legs = J[:, :36].reshape(6, 6, 6, 6)[np.arange(6), :, np.arange(6), :]
        sides = np.concatenate([error[:, :, None], J[:, 36:].reshape(6, 6, 6)], axis=2)
        try:
            solved = np.linalg.solve(legs, sides)
        except np.linalg.LinAlgError:
            raise SingularPoseError("a leg's own joints are singular here: no length, or 90 degrees from home") from None
        return _State(q_pin, error, solved[:, :, 0], solved[:, :, 1:])

    def _closed(self, state: _State) -> bool:
        """Whether all loops are closed within the tolerances of `configuration`."""
        off, turned = np.linalg.norm(state.error.reshape(6, 2, 3), axis=2).max(axis=0)
        return bool(off <= self._tolerance and turned <= CLOSURE_TOLERANCE_RAD)

    def _follow(self, state: _State, travel: FloatArray) -> _State:
        """Return the closed state with the prismatic joints at `travel`, by Newton steps from `state`."""
        longest = LARGEST_STEP_PER_LENGTH * float(self.home_lengths.mean())
        for _ in range(STEPS):
            missing = travel - self._legs_of(state.q_pin)[:, 2]
            if not missing.any() and self._closed(state):
                return state
            try:
                dx = np.linalg.solve(state.response[:, 2, :], state.step[:, 2] - missing)
            except np.linalg.LinAlgError:
                raise SingularPoseError("a Newton step met a singular pose; give another guess") from None
            moved = dx[:3] + np.cross(dx[3:], self.shapes.platform.centre)
            reach = max(np.linalg.norm(moved) / longest, np.linalg.norm(dx[3:]) / LARGEST_STEP_RAD, 1.0)
            step = np.concatenate([(state.step - state.response @ dx).ravel(), dx]) / reach
            q_pin = pin.integrate(self.model, state.q_pin, step)
            if reach == 1.0:
                self._legs_of(q_pin)[:, 2] = travel
            if not np.isfinite(q_pin).all():
                break
            state = self._linearise(q_pin)
        raise self._not_closed(state, "these lengths")

    def _not_closed(self, state: _State, what: str) -> NotConvergedError:
        """Return the error of loops that stay open."""
        gaps = np.linalg.norm(state.error[:, :3], axis=1)
        leg = int(gaps.argmax())
        return NotConvergedError(
            f"the loops do not close at {what}: leg {leg + 1} is {gaps[leg]:.3g} m off its platform joint after "
            f"{STEPS} Newton steps, tolerance {self._tolerance:.3g} m; check the lengths, or give a nearer guess",
            leg=leg + 1, value=float(gaps[leg]), upper=self._tolerance,
        )  # fmt: skip

    def _legs_of(self, q_pin: FloatArray) -> FloatArray:
        """Return the six rows of leg coordinates [2 universal, prismatic, 4 quaternion], a view."""
        return q_pin[:42].reshape(6, 7)

    def _pose_of(self, q_pin: FloatArray) -> FloatArray:
        """Return the platform in the base, (4, 4)."""
        return np.array((self._home * pin.XYZQUATToSE3(q_pin[-7:])).homogeneous)
