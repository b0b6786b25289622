"""Bodies and forces of the Pinocchio machine: sizes, masses, the links of a leg, axial forces.

What a `Hexapod` does not say about its bodies is derived here from its geometry, in steel.
Forces follow from the equilibrium of the closed loop (`axial_forces`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from hexathermal.errors import ArgumentError, SingularPoseError
from hexathermal.machine.bodies import Bodies
from hexathermal.machine.hexapod import Hexapod
from hexathermal.machine.thermal import frozen
from hexathermal.poses import FloatArray, finite_array

STEEL_DENSITY = 7850.0
"""Density of the bodies of a machine that states none [kg/m^3]."""

DIAMETER_PER_LENGTH = 1.0 / 12.0
"""Body diameter over mean home length, of a machine that states none."""

ROD_PER_BODY = 0.6
"""Rod diameter over body diameter, of a machine that states none."""

LENGTHS_WITHOUT_STROKE = (0.8, 1.2)
"""Shortest and longest leg over its home length, by which a machine without stroke is drawn."""

LEAST_RCOND = 1e-9
"""Smallest ``1 / cond`` of the scaled Jacobian at which leg forces are given."""


@dataclass(frozen=True)
class LegJoints:
    """Pinocchio's joint indices of a leg: the body hangs on the universal, the rod on the prismatic joint."""

    universal: int
    prismatic: int
    spherical: int


@dataclass(frozen=True, eq=False)
class Plate:
    """A disc through joints: centre (3,) [m], axes (3, 3) with the normal last, radius and thickness [m]."""

    centre: FloatArray
    axes: FloatArray
    radius: float
    thickness: float

    @property
    def placement(self) -> pin.SE3:
        """The disc's frame, z along its normal."""
        return pin.SE3(self.axes, self.centre)


@dataclass(frozen=True, eq=False)
class Shapes:
    """Sizes of all bodies of a machine [m], and their masses [kg] in `bodies`.

    Attributes
    ----------
    bodies : Bodies
        Diameters and masses, as stated or as `default_bodies` derives them.
    body_lengths, rod_lengths : array, shape (6,) [m]
        The tube starts at the base joint, the rod ends at the platform joint.
    rod_shown : array, shape (6,) [m]
        Length of the rod that stands out of the body at the longest leg.
    base, platform : Plate
        Discs through the joints, in the base and in the platform frame.
    """

    bodies: Bodies
    body_lengths: FloatArray
    rod_lengths: FloatArray
    rod_shown: FloatArray
    base: Plate
    platform: Plate


def home_lengths(hexapod: Hexapod) -> FloatArray:
    """Return the leg lengths at home [m], shape (6,)."""
    home = pin.SE3(hexapod.home)
    ends = np.array([home.act(joint) for joint in hexapod.platform_joints])
    return np.asarray(np.linalg.norm(ends - hexapod.base_joints, axis=1))


def leg_extremes(hexapod: Hexapod) -> tuple[FloatArray, FloatArray]:
    """Return shortest and longest leg that bodies are sized for [m]: by the stroke, or 0.8, 1.2 of home."""
    if hexapod.stroke is not None:
        return hexapod.length_limits
    at_home = home_lengths(hexapod)
    return LENGTHS_WITHOUT_STROKE[0] * at_home, LENGTHS_WITHOUT_STROKE[1] * at_home


def section_lengths(hexapod: Hexapod) -> FloatArray:
    """Return the length of body and rod [m], shape (6,): ``min(0.55 L_max, 0.95 L_min)``, the same for both.

    So they overlap by a tenth of ``L_max`` at full stretch, and the rod's end stays above the base joint.
    Where ``L_max > 1.9 L_min`` one stage is not enough: `Margins.rod_overlap` turns negative at full stretch.
    """
    shortest, longest = leg_extremes(hexapod)
    return np.minimum(0.55 * longest, 0.95 * shortest)


def joint_plate(joints: FloatArray, thickness: float) -> Plate:
    """Return the disc through six joints: about their centroid, in the plane that fits them best."""
    centre = joints.mean(axis=0)
    spread = joints - centre
    axes = np.linalg.svd(spread)[2].T
    axes[:, 0] *= np.sign(np.linalg.det(axes))
    radius = float(np.linalg.norm(spread, axis=1).mean())
    return Plate(frozen(centre), frozen(axes), radius, thickness if thickness > 0.0 else 0.05 * radius)


def default_bodies(hexapod: Hexapod) -> Bodies:
    """Return bodies for a machine that states none: a guess in steel, for first drawings and loads.

    Density 7850 kg/m^3; body diameter = mean home length / 12; rod = 0.6 of it, solid; body = tube around
    the rod; both plates are discs through the joints, half a body diameter thick; lengths: the mean of
    `section_lengths`.
    """
    outer = DIAMETER_PER_LENGTH * float(home_lengths(hexapod).mean())
    inner = ROD_PER_BODY * outer
    length = float(section_lengths(hexapod).mean())
    radius = joint_plate(hexapod.platform_joints, outer).radius
    rod_area = np.pi / 4.0 * inner**2
    return Bodies(
        leg_body_diameter=outer,
        leg_rod_diameter=inner,
        leg_body_mass=float(STEEL_DENSITY * length * (np.pi / 4.0 * outer**2 - rod_area)),
        leg_rod_mass=float(STEEL_DENSITY * length * rod_area),
        platform_mass=float(STEEL_DENSITY * np.pi * radius**2 * outer / 2.0),
        platform_thickness=outer / 2.0,
        base_thickness=outer / 2.0,
    )


def machine_shapes(hexapod: Hexapod) -> Shapes:
    """Return the sizes of all bodies: `hexapod.bodies` or else `default_bodies`, and `section_lengths`."""
    bodies = default_bodies(hexapod) if hexapod.bodies is None else hexapod.bodies
    sections = section_lengths(hexapod)
    return Shapes(
        bodies=bodies,
        body_lengths=frozen(sections),
        rod_lengths=frozen(sections),
        rod_shown=frozen(np.minimum(sections, leg_extremes(hexapod)[1] - sections)),
        base=joint_plate(hexapod.base_joints, bodies.base_thickness),
        platform=joint_plate(hexapod.platform_joints, bodies.platform_thickness),
    )


def cylinder_inertia(mass: float, outer: float, inner: float, length: float, middle: float) -> pin.Inertia:
    """Return the inertia of a tube of the given diameters [m] along z, its middle at height `middle` [m]."""
    square = (outer**2 + inner**2) / 4.0
    across = mass * (3.0 * square + length**2) / 12.0
    return pin.Inertia(mass, np.array([0.0, 0.0, middle]), np.diag([across, across, mass * square / 2.0]))


def leg_inertias(shapes: Shapes, leg: int, home_length: float) -> tuple[pin.Inertia, pin.Inertia]:
    """Return the inertias of body and rod in the leg's frame at the base joint; the rod stands as at home."""
    bodies, body, rod = shapes.bodies, shapes.body_lengths[leg], shapes.rod_lengths[leg]
    bore = bodies.leg_rod_diameter if bodies.leg_rod_diameter < bodies.leg_body_diameter else 0.0
    return (
        cylinder_inertia(bodies.leg_body_mass, bodies.leg_body_diameter, bore, body, 0.5 * body),
        cylinder_inertia(bodies.leg_rod_mass, bodies.leg_rod_diameter, 0.0, rod, home_length - 0.5 * rod),
    )


def leg_frames(hexapod: Hexapod) -> tuple[pin.SE3, ...]:
    """Return a frame at each base joint: z along the leg at home, x across the leg and the base's z.

    A leg that is upright at home, ``|z_base x u| < 1e-6``, takes x from the base.
    """
    home, frames = pin.SE3(hexapod.home), []
    for start, joint in zip(hexapod.base_joints, hexapod.platform_joints, strict=True):
        z = home.act(joint) - start
        z /= np.linalg.norm(z)
        x = np.cross([0.0, 0.0, 1.0], z)
        if np.linalg.norm(x) < 1e-6:
            x = np.array([1.0, 0.0, 0.0]) - z[0] * z
        x /= np.linalg.norm(x)
        frames.append(pin.SE3(np.column_stack([x, np.cross(z, x), z]), start))
    return tuple(frames)


def add_leg(
    model: pin.Model, shapes: Shapes, leg: int, frame: pin.SE3, home_length: float, limits: FloatArray
) -> LegJoints:
    """Add universal, prismatic and spherical joint of a leg, and their links; `limits` are lengths [m]."""
    label, still = f"leg{leg + 1}", pin.SE3.Identity()
    body, rod = leg_inertias(shapes, leg, home_length)
    across = pin.JointModelUniversal(np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
    universal = model.addJoint(0, across, frame, f"{label}_universal")
    model.appendBodyToJoint(universal, body, still)
    prismatic = model.addJoint(universal, pin.JointModelPZ(), still, f"{label}_prismatic")
    model.appendBodyToJoint(prismatic, rod, still)
    place = model.joints[prismatic].idx_q
    model.lowerPositionLimit[place], model.upperPositionLimit[place] = limits - home_length
    end = pin.SE3(np.eye(3), np.array([0.0, 0.0, home_length]))
    spherical = model.addJoint(prismatic, pin.JointModelSpherical(), end, f"{label}_spherical")
    return LegJoints(int(universal), int(prismatic), int(spherical))


def platform_inertia(shapes: Shapes, payload_mass: float, payload_centre: FloatArray) -> pin.Inertia:
    """Return the inertia of the platform's disc and of the payload, a point mass, in the platform frame."""
    plate = shapes.platform
    disc = cylinder_inertia(shapes.bodies.platform_mass, 2.0 * plate.radius, 0.0, plate.thickness, 0.0)
    payload = pin.Inertia(payload_mass, payload_centre, np.zeros((3, 3)))
    if shapes.bodies.platform_mass == 0.0:
        return payload
    return plate.placement.act(disc) + payload


def checked_payload(mass: float, centre: object) -> tuple[float, FloatArray]:
    """Return mass [kg] and centre [m] of the payload after checking them."""
    weight = finite_array(mass, (), "payload_mass")
    if weight.shape != () or weight < 0.0:
        raise ArgumentError(f"payload_mass must be one number >= 0 kg, found {mass!r}")
    return float(weight), checked_vector(centre, "payload_centre")


def checked_vector(value: object, what: str) -> FloatArray:
    """Return a finite vector of three."""
    vector = finite_array(value, (3,), what)
    if vector.shape != (3,):
        raise ArgumentError(f"{what} has shape {vector.shape}; expected (3,)")
    return vector


def axial_forces(response: FloatArray, gravity: FloatArray, platform: Plate) -> FloatArray:
    """Return the axial force of each leg at which the closed loop stands still.

    Equilibrium of tree and loops is ``g = S^T f + J^T w``: generalised gravity ``g``, actuators ``S``, forces
    ``w`` of the six closures; passive joints carry no torque.  With ``Y_i = J_leg,i^-1 J_platform,i`` the
    legs' rows give ``w_i``, and the platform's rows ``sum_i -Y_i[2]^T f_i = g_platform - sum_i Y_i^T g_i``.

    Parameters
    ----------
    response : array, shape (6, 6, 6)
        ``Y``: joint rates of each leg are ``-Y`` times the platform's; row 2 is the prismatic joint.
    gravity : array, shape (42,) [N m or N]
        Generalised forces that hold the tree: six a leg, then the platform's, in its axes.
    platform : Plate
        The test for singularity counts motions at its centre, rotations times its radius.

    Returns
    -------
    array, shape (6,) [N]

    Raises
    ------
    SingularPoseError
        ``1 / cond <= 1e-9`` for the Jacobian so scaled.
    """
    jacobian = -response[:, 2, :]
    turning = jacobian[:, 3:] - np.cross(platform.centre, jacobian[:, :3])
    singular = np.linalg.svd(np.hstack([jacobian[:, :3], turning / platform.radius]), compute_uv=False)
    rcond = float(singular[-1] / singular[0])
    if not rcond > LEAST_RCOND:
        raise SingularPoseError(
            f"leg forces are not defined here: the legs do not hold the platform, 1 / cond = {rcond:.3g}, "
            f"must be above {LEAST_RCOND:g}; move away from the singular pose",
            value=rcond,
            lower=LEAST_RCOND,
        )
    of_legs = np.einsum("iab,ia->b", response, gravity[:36].reshape(6, 6))
    return np.asarray(np.linalg.solve(jacobian.T, gravity[36:] - of_legs))
